"""Lines that tell a motion of a tool: how many there are, by the sagitta of a circle, and how near they stay."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot import pose
from virtualrobot.geometry import Matrix
from virtualrobot_apps.languages.writers.polyline import BESIDE, CORNER, TURNED, polyline

RADIUS = 0.06


def round_(turn: float, spin: float, count: int = 1501) -> Matrix:
    """Return poses (count, 4, 4) on a circle, which turn about z by `spin` in all."""
    angles, spins = np.linspace(0.0, turn, count), np.linspace(0.0, spin, count)
    return np.array(
        [pose(RADIUS * np.cos(a), RADIUS * np.sin(a), yaw=s) for a, s in zip(angles, spins, strict=True)],
    )


@pytest.mark.parametrize("turn", [1.0, 2.0 * np.pi], ids=["arc", "circle"])
def test_a_circle_has_as_many_lines_as_its_sagitta_asks(turn: float) -> None:
    """A chord is r (1 - cos(angle / 2)) off; halving needs less than twice the fewest lines."""
    poses = round_(turn, 0.0)
    lines = polyline(poses, np.full(len(poses), 0.05))
    assert lines is not None
    widest = 2.0 * np.arccos(1.0 - BESIDE / RADIUS)
    assert np.diff(lines.rows).max() * turn / 1500 <= widest + 2.0 * turn / 1500
    assert np.ceil(turn / widest) <= len(lines.lengths) <= 2.0 * turn / widest + 1
    assert lines.rows[0] == 0 and lines.rows[-1] == 1500
    np.testing.assert_allclose(lines.lengths, 2.0 * RADIUS * np.sin(0.5 * np.diff(lines.rows) * turn / 1500), rtol=1e-9)
    np.testing.assert_allclose(lines.speeds, 0.05)


def test_a_straight_way_is_one_line_and_its_speed_the_greatest() -> None:
    at = 0.1 * np.linspace(0.0, 1.0, 50) ** 2
    speeds = np.concatenate([np.linspace(0.0, 0.2, 25), np.linspace(0.2, 0.0, 25)])
    lines = polyline(np.array([pose(x, yaw=2.0 * x) for x in at]), speeds)
    assert lines is not None and lines.rows.tolist() == [0, 49]
    assert lines.lengths == pytest.approx([0.1]) and lines.speeds == pytest.approx([0.2])
    assert lines.zone(0) is None


def test_a_tool_that_turns_otherwise_than_evenly_is_told_by_more_lines() -> None:
    """It turns by a parabola in x, which is 1/4 of its height off a chord in the middle: sqrt(height / 4 / TURNED)."""
    share = np.linspace(0.0, 1.0, 2001)
    lines = polyline(np.array([pose(0.1 * s, yaw=0.4 * s**2) for s in share]), np.ones(2001))
    assert lines is not None
    least = np.sqrt(0.4 / 4.0 / TURNED)
    assert least <= len(lines.lengths) <= 2.0 * least + 1


def test_zones_join_lines_and_the_last_one_ends() -> None:
    corner = np.array([pose(x, y) for x, y in [(0.0, 0.0), (0.05, 0.0), (0.1, 0.0), (0.1, 0.02), (0.1, 0.04)]])
    lines = polyline(corner, np.ones(5))
    assert lines is not None and lines.rows.tolist() == [0, 2, 4]
    zone = lines.zone(0)
    assert zone is not None and zone.meters == pytest.approx(CORNER * 0.04) and lines.zone(1) is None


def test_a_way_there_and_back_has_its_turning_point() -> None:
    """On one line, so that nothing is beside it: the way is what tells."""
    there = np.concatenate([np.linspace(0.0, 0.1, 30), np.linspace(0.1, 0.02, 25)[1:]])
    lines = polyline(np.array([pose(x) for x in there]), np.ones(len(there)))
    assert lines is not None and lines.rows.tolist() == [0, 29, len(there) - 1]


@pytest.mark.parametrize("spin", [0.0, 1.0], ids=["stands", "turns"])
def test_what_goes_nowhere_is_no_line(spin: float) -> None:
    assert polyline(np.array([pose(yaw=s) for s in np.linspace(0.0, spin, 20)]), np.zeros(20)) is None


def test_a_turn_on_the_spot_amid_a_way_is_no_line() -> None:
    poses = [pose(x) for x in np.linspace(0.0, 0.1, 10)]
    poses += [pose(0.1, yaw=s) for s in np.linspace(0.1, 1.0, 10)]
    poses += [pose(0.1, y, yaw=1.0) for y in np.linspace(0.01, 0.1, 10)]
    assert polyline(np.array(poses), np.ones(30)) is None
