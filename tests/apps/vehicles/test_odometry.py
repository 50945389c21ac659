"""Odometry: exact on arcs, and its drift by what encoders leave out and by a wheel that is larger than it knows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot_apps.vehicles.odometry import Odometry, counted, reckoned

TRACK, RADIUS = 0.24, 0.05


def square(track: float = TRACK, radius: float = RADIUS, side: float = 2.0, steps: int = 50) -> np.ndarray:
    """Return the wheels' angles (n, 2) of a square driven to the left: four sides, each with a right angle after it."""
    way = np.linspace(0.0, side / radius, steps + 1)[1:]
    turn = np.linspace(0.0, math.pi / 4.0 * track / radius, steps + 1)[1:]
    angles = [np.zeros((1, 2))]
    for _ in range(4):
        angles.append(angles[-1][-1] + np.stack([way, way], axis=1))
        angles.append(angles[-1][-1] + np.stack([-turn, turn], axis=1))
    return np.vstack(angles)


def test_an_arc_is_exact_however_long_the_step() -> None:
    """It turns by omega t about a centre at v / omega to the left."""
    v, omega, seconds = 0.5, 1.0, 2.0
    rates = np.array([v - omega * TRACK / 2.0, v + omega * TRACK / 2.0]) / RADIUS
    for steps in (1, 7):
        angles = np.linspace(0.0, seconds, steps + 1)[:, None] * rates
        turned = omega * seconds
        expected = [v / omega * math.sin(turned), v / omega * (1.0 - math.cos(turned)), turned]
        np.testing.assert_allclose(reckoned(angles, TRACK, RADIUS)[-1], expected, atol=1e-12)


def test_more_counts_on_the_left_are_a_right_turn() -> None:
    """The document: a left wheel that reads 80 and a right one that reads 40 mean a right turn."""
    odometry = Odometry(0.116, 0.0325)
    odometry.update([0.0, 0.0])
    _, y, heading = odometry.update(np.array([80, 40]) * 2.0 * math.pi / 64)
    assert heading == pytest.approx(-40 * 2.0 * math.pi / 64 * 0.0325 / 0.116)
    assert y < 0.0
    assert odometry.distance == pytest.approx(60 * 2.0 * math.pi / 64 * 0.0325)


def test_true_angles_close_the_square_and_a_larger_wheel_does_not() -> None:
    """By the formulas 8 m with 0.5% more on the right turn it by 8 * 0.005 / track, turns on the spot by 0.25% more."""
    angles = square()
    np.testing.assert_allclose(reckoned(angles, TRACK, RADIUS)[-1], [0.0, 0.0, 2.0 * math.pi], atol=1e-12)
    told = reckoned(angles, TRACK, RADIUS, 1.005 * RADIUS)[-1]
    turned = 8.0 * 0.005 / TRACK + 2.0 * math.pi * 0.0025
    assert told[2] - 2.0 * math.pi == pytest.approx(turned, rel=1e-9)


@pytest.mark.parametrize(("counts", "off"), [(8, 0.138), (64, 0.0052), (360, 0.0003)])
def test_whole_counts_leave_out_what_the_formulas_say(counts: int, off: float) -> None:
    """docs/crafts.md has these distances, from a square that is driven in ticks of 4 ms."""
    angles = square(steps=1000)
    told = reckoned(counted(angles, counts), TRACK, RADIUS)[-1]
    assert np.linalg.norm(told[:2]) == pytest.approx(off, rel=0.15, abs=0.0003)


def test_what_is_no_pair_of_angles_is_refused() -> None:
    for angles in ([1.0], [1.0, 2.0, 3.0], [math.nan, 0.0]):
        with pytest.raises(ValueError, match="the angles of two wheels are two finite numbers, not"):
            Odometry(TRACK, RADIUS).update(angles)
