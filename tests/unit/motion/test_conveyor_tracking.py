"""How an arm catches up with a frame and leaves it: laws of one variable, checked by differences."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.motion.conveyor_tracking import OVERSHOOT, ConveyorTracking, catch_up, leave


def tracking(rng: np.random.Generator) -> ConveyorTracking:
    velocity, acceleration, own = rng.uniform(0.05, 1.0), rng.uniform(0.2, 2.0), rng.uniform(0.2, 5.0)
    return ConveyorTracking((), 0.0, 0.0, 1.0, velocity, acceleration, own, own * rng.uniform(5.0, 20.0))


def test_the_gap_closes_within_the_limits(rng: np.random.Generator) -> None:
    for _ in range(50):
        one = tracking(rng)
        speed = float(rng.uniform(-1.0, 1.0)) * one.max_velocity
        gap = 0.05 * speed  # as after 50 ms of planning
        law = catch_up(one, gap, speed, 0.0)
        times = np.linspace(0.0, law.length, 2001)[:-1]
        value, first, second = np.array([law.state(t) for t in times]).T
        assert (value[0], first[0], second[0]) == pytest.approx((gap, speed, 0.0))
        assert law.state(law.length) == (0.0, 0.0, 0.0)
        step = times[1]
        assert np.abs(np.diff(value) - 0.5 * step * (first[1:] + first[:-1])).max() < one.own_jerk * step**3
        assert np.abs(np.diff(first) - 0.5 * step * (second[1:] + second[:-1])).max() < 1e-3 * step
        assert np.abs(second).max() <= one.own_acceleration * (1.0 + 1e-9)
        assert np.abs(np.diff(second) / step).max() <= one.own_jerk * 1.001
        assert np.abs(speed - first).max() <= OVERSHOOT * one.max_velocity * (1.0 + 1e-9)


def test_a_frame_that_accelerates_harder_than_arms_may_is_caught_up_with_in_seconds(rng: np.random.Generator) -> None:
    for _ in range(50):
        one = tracking(rng)
        slope = 1.5 * one.own_acceleration * float(rng.choice((-1.0, 1.0)))
        law = catch_up(one, 0.0, float(rng.uniform(-1.0, 1.0)) * one.max_velocity, slope)
        second = np.array([law.state(t)[2] for t in np.linspace(0.0, law.length, 2001)[:-1]])
        assert second[0] == pytest.approx(slope)
        assert np.abs(second).max() <= 1.1 * abs(slope)  # it can't be less than the slope it begins with
        assert law.length < 30.0


def test_nothing_to_catch_up_with_takes_no_time(rng: np.random.Generator) -> None:
    law = catch_up(tracking(rng), 0.0, 0.0, 0.0)
    assert law.length == 0.0
    assert law.state(0.0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("accelerates", [False, True])
def test_leaving_comes_to_rest_where_it_says_within_the_limits(accelerates: bool, rng: np.random.Generator) -> None:
    for _ in range(50):
        one = tracking(rng)
        speed = float(rng.uniform(-1.0, 1.0)) * OVERSHOOT * one.max_velocity
        slope = float(rng.uniform(-1.0, 1.0)) * one.max_acceleration if accelerates else 0.0
        law = leave(one, float(rng.normal()), speed, slope)
        times = np.linspace(0.0, law.length, 2001)
        place, first, second = np.array([law.state(t) for t in times]).T
        step = times[1]
        assert (place[0], first[0], second[0]) == pytest.approx((law.place, speed, slope))
        assert place[-1] == pytest.approx(law.end, abs=1e-12)
        assert law.state(2.0 * law.length) == (place[-1], 0.0, 0.0)
        assert np.abs(np.diff(place) - 0.5 * step * (first[1:] + first[:-1])).max() < one.own_jerk * step**3
        assert np.abs(np.diff(first) - 0.5 * step * (second[1:] + second[:-1])).max() < 1e-3 * step
        assert np.abs(second).max() <= max(abs(slope), one.own_acceleration + abs(slope) / 3.0) * 1.001
        assert np.abs(np.diff(second) / step).max() <= one.own_jerk * 1.001


def test_leaving_takes_as_long_as_its_speed_needs(rng: np.random.Generator) -> None:
    one = tracking(rng)
    lengths = [leave(one, 0.0, share * one.max_velocity, 0.0).length for share in (0.0, 0.01, 0.1, 1.0)]
    assert lengths == sorted(lengths) and lengths[0] == 0.01 and lengths[1] < 0.2 * lengths[3]
