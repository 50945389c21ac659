"""Chips by formula: a slot, a hole, a pocket whose passes overlap, a drill that comes out below."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from virtualrobot import pose
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot_apps.processes.effects.chips import Cutter, taken_off

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
    assert chips.left.volume == pytest.approx(block().volume - chips.volume) and chips.left.is_watertight


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


def test_what_cannot_be_told_is_refused() -> None:
    frames = line((-0.08, 0.0, 0.005), (0.08, 0.0, 0.005))
    with pytest.raises(InvalidArgumentError, match="a diameter and a length above 0"):
        taken_off(block(), [frames], Cutter(0.0, 0.03))
    frames[1] = frames[1] @ pose(pitch=0.1)
    with pytest.raises(InvalidArgumentError, match=r"axis turns by 5.72 degrees after frames\[0\]"):
        taken_off(block(), [frames], CUTTER)
