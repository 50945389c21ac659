"""Odometry against the true way: whole counts, a wheel that is thought to be another one, and how sure it is."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.crafts.reckoning import reckoned
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.craft_data import Craft

from tests.unit.crafts.rover import DRIVES, rover, yard
from tests.unit.crafts.test_ways import BICYCLE, craft_of

TRACK, RADIUS = 0.24, 0.05
CRAFT = Craft("differential", {"track_meters": TRACK, "wheel_radius_meters": RADIUS}, DRIVES)


def square(craft: CraftAtWork, rows: int) -> np.ndarray:
    """Return where wheels are round a square of 2 m with turns on the spot, in so many rows a part."""
    parts = [[2.0, 0.0, 0.0], [0.0, 0.0, math.pi / 2.0]] * 4
    corners = np.vstack([np.zeros(2), craft.way(np.zeros(99), np.array(parts))[1::2]])
    lines = [np.linspace(a, b, rows + 1)[1:] for a, b in pairwise(corners)]
    return np.vstack([corners[:1], *lines])


def test_a_wheel_half_a_percent_larger_is_218_millimeters_and_8_point_6_degrees() -> None:
    """By hand: the left wheel rolls 8 m less a turn of 120 mm; half a percent of that by 240 mm is the heading."""
    wrong = {"wheel_radius_meters": 1.005 * RADIUS, "right_wheel_radius_meters": RADIUS}
    with yard(rover(CRAFT)) as course:
        true = craft_of(course)
        with course.crafts.believed(true.node.uid, wrong) as thought:
            poses, _ = reckoned(thought, np.zeros(3), square(true, 1), np.zeros((3, 3)), 0.0)
        assert np.linalg.norm(poses[-1, :2]) == pytest.approx(0.218, abs=0.001)
        off = math.tau - poses[-1, 2]
        assert math.degrees(off) == pytest.approx(8.6, abs=0.1)
        assert off == pytest.approx((8.0 - math.tau * TRACK / 2.0) * 0.005 / TRACK)


def test_the_covariance_is_that_of_the_text_book() -> None:
    """Siegwart and Nourbakhsh, equation 5.11: columns of the Jacobian by the ways of the right and the left wheel.

    It is that of a short step, for the heading in the middle of it.
    """
    k, step = 1e-3, np.array([0.02, 0.03])
    with yard(rover(CRAFT)) as course:
        craft, heading = craft_of(course), 0.7
        rows = np.array([np.zeros(2), step])
        _, spread = reckoned(craft, np.array([0.1, 0.2, heading]), rows, np.zeros((3, 3)), k)
        left, right = step * RADIUS
        far, turn = (left + right) / 2.0, (right - left) / TRACK
        sine, cosine = math.sin(heading + turn / 2.0), math.cos(heading + turn / 2.0)
        by_right = [cosine / 2 - far * sine / 2 / TRACK, sine / 2 + far * cosine / 2 / TRACK, 1.0 / TRACK]
        by_left = [cosine / 2 + far * sine / 2 / TRACK, sine / 2 - far * cosine / 2 / TRACK, -1.0 / TRACK]
        by = np.column_stack([by_left, by_right]) * RADIUS
        np.testing.assert_allclose(spread[1], by @ np.diag(k * step) @ by.T, rtol=1e-3, atol=1e-12)


@pytest.mark.long
def test_errors_drawn_at_random_spread_as_the_covariance_says(rng: np.random.Generator) -> None:
    """600 ways of 40 steps whose drives slip at random: within a fifth, four times what 600 draws leave open."""
    variance, steps = 4e-4, 40
    rows = np.cumsum(np.vstack([np.zeros(2), np.tile([0.35, 0.45], (steps, 1))]), axis=0)
    with yard(rover(CRAFT)) as course:
        craft = craft_of(course)
        _, told = reckoned(craft, np.zeros(3), rows, np.zeros((3, 3)), variance)
        change = np.diff(rows, axis=0)
        ends = []
        for _ in range(600):
            noisy = change + rng.normal(size=change.shape) * np.sqrt(variance * np.abs(change))
            poses, _ = reckoned(craft, np.zeros(3), np.vstack([np.zeros(2), np.cumsum(noisy, axis=0)]), np.eye(3), 0.0)
            ends.append(poses[-1])
        drawn = np.cov(np.array(ends).T)
    np.testing.assert_allclose(np.diag(drawn), np.diag(told[-1]), rtol=0.25)


def test_a_steered_craft_is_reckoned_by_its_steering_angle() -> None:
    with yard(rover(BICYCLE)) as course:
        rows = np.array([[0.3, 0.0], [0.3, 10.0]])
        poses, _ = reckoned(craft_of(course), np.zeros(3), rows, np.zeros((3, 3)), 0.0)
        assert poses[-1, 2] == pytest.approx(math.remainder(10.0 * 0.1 * math.tan(0.3) / 0.5, math.tau))


def test_settings_that_a_component_refuses_are_refused() -> None:
    with yard(rover(CRAFT)) as course, pytest.raises(KernelError, match="wheel_radius_meters"):
        with course.crafts.believed(craft_of(course).node.uid, {"wheel_radius_meters": -1.0}):
            pass
