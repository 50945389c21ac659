"""Chips by formula: a slot, a hole, a pocket whose passes overlap, a drill that comes out below."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from virtualrobot import pose
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot_apps.processes.effects.chips import Cutter, taken_off

from tests.apps.processes.slow_chips import taken_off_slowly

CUTTER = Cutter(0.01, 0.03)
TOP = 0.02
"""Height (m) of the block's upper face."""


def block() -> trimesh.Trimesh:
    """Return a block of 100 x 60 x 40 mm about the origin."""
    return trimesh.creation.box((0.1, 0.06, 2.0 * TOP))


def line(*points: tuple[float, float, float]) -> Matrix:
    """Return frames that point downward at points, the last coordinate being the depth below the upper face."""
    return np.array([pose(x, y, TOP - depth, roll=np.pi) for x, y, depth in points])


def test_a_slot_is_as_wide_as_its_cutter() -> None:
    """Within the block from end to end: width times depth times length."""
    chips = taken_off(block(), [line((-0.08, 0.0, 0.005), (0.0, 0.0, 0.005), (0.08, 0.0, 0.005))], CUTTER)
    assert chips.volume == pytest.approx(0.01 * 0.005 * 0.1, rel=1e-3)


@pytest.mark.parametrize("depth", [0.015, 0.04, 0.06])
def test_a_hole_is_a_cylinder_and_ends_where_the_block_does(depth: float) -> None:
    """Blind, as deep as the block, and beyond: what a drill goes on below the block takes nothing off."""
    drill = Cutter(0.01, 0.1)
    chips = taken_off(block(), [line((0.0, 0.0, -0.01), (0.0, 0.0, depth))], drill)
    assert chips.volume == pytest.approx(np.pi * 0.005**2 * min(depth, 2.0 * TOP), rel=1e-3)


def test_a_pocket_is_what_its_passes_take_together() -> None:
    """Three passes 8 mm apart by a cutter of 10 mm: 26 mm wide."""
    rows = [line((-0.08, y, 0.004), (0.08, y, 0.004)) for y in (-0.008, 0.0, 0.008)]
    assert taken_off(block(), rows, CUTTER).volume == pytest.approx(0.026 * 0.004 * 0.1, rel=1e-3)


def test_a_cutter_in_the_air_takes_nothing() -> None:
    chips = taken_off(block(), [line((-0.08, 0.0, -0.01), (0.08, 0.0, -0.01))], CUTTER)
    assert chips.volume == pytest.approx(0.0, abs=1e-10)
    assert taken_off(block(), [], CUTTER).volume == 0.0


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_it_is_what_solids_cut_from_solids_leave(turn: float, rng: np.random.Generator) -> None:
    """Ramps and plunges that cross each other in a ball, along an axis that leans; the oracle is Manifold."""
    ball = trimesh.creation.icosphere(3, 0.03)
    about = pose(roll=turn, pitch=0.4 * turn)
    passes = []
    for _ in range(3):
        points = rng.uniform([-0.03, -0.03, 0.0], [0.03, 0.03, 0.02], (4, 3))
        passes.append(about @ line((*points[0, :2], -0.02), *map(tuple, points), (*points[-1, :2], -0.02)))
    found = taken_off(ball, passes, CUTTER)
    assert found.volume == pytest.approx(taken_off_slowly(ball, passes, CUTTER), rel=1e-3)
    assert not found.at_most


def test_holes_of_two_directions_that_cross_count_at_most() -> None:
    """Through a block of 40 mm from above, and through its 60 mm from the side."""
    down = line((0.0, 0.0, -0.01), (0.0, 0.0, 0.06))
    beside = np.array([pose(0.0, y, 0.0, roll=-0.5 * np.pi) for y in (-0.05, 0.05)])
    chips = taken_off(block(), [down, beside], Cutter(0.01, 0.2))
    assert chips.at_most
    assert chips.volume == pytest.approx(np.pi * 0.005**2 * 0.1, rel=1e-3)


def test_holes_far_apart_are_as_fine_as_one() -> None:
    """A part of 2 x 2 m, in whose corners holes are drilled."""
    part = trimesh.creation.box((2.0, 2.0, 0.01))
    holes = [[pose(x, y, z, roll=np.pi) for z in (0.01, -0.01)] for x in (-0.9, 0.9) for y in (-0.9, 0.9)]
    chips = taken_off(part, [np.array(one) for one in holes], CUTTER)
    assert chips.volume == pytest.approx(4.0 * np.pi * 0.005**2 * 0.01, rel=1e-3)


def test_what_cannot_be_told_is_refused() -> None:
    frames = line((-0.08, 0.0, 0.005), (0.08, 0.0, 0.005))
    with pytest.raises(InvalidArgumentError, match="a diameter and a length above 0"):
        taken_off(block(), [frames], Cutter(0.0, 0.03))
    frames[1] = frames[1] @ pose(pitch=0.1)
    with pytest.raises(InvalidArgumentError, match=r"axis turns by 5.72 degrees after frames\[0\]"):
        taken_off(block(), [frames], CUTTER)
    flat = line((-0.08, 0.0, 0.005), (0.08, 0.0, 0.005))
    with pytest.raises(InvalidArgumentError, match="the mesh is open"):
        taken_off(trimesh.Trimesh(block().vertices, block().faces[1:]), [flat], CUTTER)
