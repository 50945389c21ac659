"""Grasps from above on maps of heights: clouds of boxes on a floor, 2 mm between points, by formula, with noise."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.seeing.grasping.heights import DEEPEST, Floats, FromAbove, Heights, grasps_from_above
from virtualrobot_apps.seeing.grasping.jaw import Jaw

JAW = Jaw(0.056, wide=0.025, thick=0.01, long=0.06, tip=0.02)
EDGE, SIDE, FLOOR, SIGMA = 0.04, 0.14, 0.5, 0.001
"""Edge of a box, half the side of a bin, height of its bottom, deviation of a height (m)."""
Placed = tuple[float, float, float]


def found(rng: np.random.Generator, *boxes: Placed, height: float = EDGE, **options: float) -> list[FromAbove]:
    """Return grasps of boxes at x, y (m) and a turn (rad) between walls 0.1 m high."""
    marks = np.arange(-SIDE - 0.01, SIDE + 0.01, 0.002)
    places = np.dstack(np.meshgrid(marks, marks)).reshape(-1, 2)
    z = np.where((np.abs(places) > SIDE).any(axis=1), 0.1, 0.0)
    for x, y, turn in boxes:
        c, s = np.cos(turn), np.sin(turn)
        on_it = np.abs((places - (x, y)) @ np.array([[c, -s], [s, c]])).max(axis=1) < 0.5 * EDGE
        z = np.where(on_it, height, z)
    points = np.column_stack([places, FLOOR + z + rng.normal(0.0, SIGMA, len(z))])
    wall, inside = np.full(2, SIDE + 0.01), np.full(2, SIDE)
    heights = Heights.of(points, -wall, wall)
    return grasps_from_above(heights, JAW, FLOOR, -inside, inside, **options)


def closing(grasp: FromAbove) -> Floats:
    """Return the direction (2,) from one finger to the other."""
    return grasp.pose[:2, 1]


@pytest.mark.parametrize("turn", [0.0, 0.4, 0.8, 1.2])
def test_fingers_close_across_a_box_that_lies_as_it_likes(rng: np.random.Generator, turn: float) -> None:
    """To half a step of the directions (5.6°), in the middle to a cell, with the tips 30 mm below its top."""
    best, *_ = found(rng, (0.02, -0.03, turn))
    off = np.mod(np.arctan2(*closing(best)[::-1]) - turn, np.pi / 2)
    assert min(off, np.pi / 2 - off) < np.radians(11.3)
    assert abs((best.pose[:2, 3] - (0.02, -0.03)) @ closing(best)) < 0.006
    assert best.width == pytest.approx(EDGE, abs=0.008) and best.depth == pytest.approx(DEEPEST, abs=0.003)
    assert best.pose[2, 3] == pytest.approx(FLOOR + EDGE - DEEPEST + JAW.tip, abs=0.004)
    turned = best.pose[:3, :3]
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-12)
    assert turned[2, 2] == -1.0 and turned[1, 1] >= 0.0


def test_fingers_close_along_an_edge_that_is_free(rng: np.random.Generator) -> None:
    """Two boxes side by side along y, 5 mm apart, where no finger of 10 mm has room; and one at a wall."""
    for boxes in ([(0.0, 0.0, 0.0), (0.0, EDGE + 0.005, 0.0)], [(0.0, SIDE - 0.5 * EDGE - 0.004, 0.0)]):
        grasps = found(rng, *boxes)
        assert grasps and all(abs(closing(one)[0]) > 0.95 for one in grasps)


def test_what_has_no_room_is_gripped_where_fingers_may_push(rng: np.random.Generator) -> None:
    """Four boxes 14 mm away leave room for 10 mm and not for 2 mm on both sides of a finger, 8 mm from its box."""
    gap = EDGE + 0.016
    boxes = [(0.0, 0.0, 0.0), (gap, 0.0, 0.0), (-gap, 0.0, 0.0), (0.0, gap, 0.0), (0.0, -gap, 0.0)]
    tight = [one for one in found(rng, *boxes) if np.abs(one.pose[:2, 3]).max() < 0.5 * EDGE]
    pushing = [one for one in found(rng, *boxes, clear=-0.004) if np.abs(one.pose[:2, 3]).max() < 0.5 * EDGE]
    assert not tight and pushing


def test_what_is_low_is_left(rng: np.random.Generator) -> None:
    """Tips stay off the floor, so that of a plate 10 mm high nothing is between them."""
    assert found(rng, (0.0, 0.0, 0.0), height=0.01) == []


def test_a_scan_of_elsewhere_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="none of 5 echoes is between"):
        Heights.of(np.full((5, 3), 3.0), (-0.1, -0.1), (0.1, 0.1))
