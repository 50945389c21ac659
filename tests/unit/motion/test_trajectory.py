"""Timed joint trajectories: through every sample at its time, smooth, at rest at both ends; refused by name."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.path import smooth_path
from virtualrobot_kernel.motion.plan import plan_trajectory

from .motions import random_trajectory

ONES = np.ones(2)
LIMITS = JointLimits(("shoulder", "elbow"), -2.0 * ONES, 2.0 * ONES, 3.0 * ONES, 50.0 * ONES, 500.0 * ONES)
TIMES = np.array([0.0, 0.5, 1.0, 2.0])
POSITIONS = np.array([[0.0, 0.0], [0.2, -0.3], [0.5, -0.4], [0.7, 0.0]])


def test_every_sample_is_passed_at_its_time_and_the_ends_are_at_rest(rng: np.random.Generator) -> None:
    plan, times, positions = random_trajectory(rng)
    assert plan.duration == times[-1]
    q, v, a, _ = plan.derivatives(times)
    np.testing.assert_allclose(q, positions, atol=1e-12)
    np.testing.assert_allclose(v[[0, -1]], 0.0, atol=1e-10)
    np.testing.assert_allclose(a[[0, -1]], 0.0, atol=1e-9)
    # The velocities at the samples are those of the clamped cubic spline (scipy).
    np.testing.assert_allclose(v[1:-1], CubicSpline(times, positions, bc_type="clamped")(times[1:-1], 1), atol=1e-9)


def test_velocity_acceleration_and_jerk_are_continuous(rng: np.random.Generator) -> None:
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, 20))])
    path = smooth_path(times, rng.normal(size=(21, 3)), rng.normal(size=(21, 3)))
    before, after = path.states(np.nextafter(times[1:-1], 0.0), 3), path.states(times[1:-1], 3)
    for order in range(4):
        scale = max(1.0, float(np.abs(after[order]).max()))
        np.testing.assert_allclose(before[order] / scale, after[order] / scale, atol=1e-9)


def test_given_velocities_are_kept(rng: np.random.Generator) -> None:
    velocities = np.zeros((4, 2))
    velocities[1:-1] = rng.uniform(-0.5, 0.5, (2, 2))
    plan = plan_trajectory(POSITIONS[0], TIMES, POSITIONS, velocities, LIMITS)
    np.testing.assert_allclose(plan.derivatives(TIMES)[1], velocities, atol=1e-12)
    np.testing.assert_allclose(plan.derivatives(TIMES)[0], POSITIONS, atol=1e-12)


def test_two_samples_make_the_quintic_of_least_jerk(rng: np.random.Generator) -> None:
    # Flash, Hogan, The Coordination of Arm Movements (1985), equation (3): 10 x³ - 15 x⁴ + 6 x⁵.
    plan = plan_trajectory([0.0, 0.0], [0.0, 2.0], [[0.0, 0.0], [1.0, -1.0]], None, LIMITS)
    x = rng.uniform(0.0, 1.0, 50)
    share = 10 * x**3 - 15 * x**4 + 6 * x**5
    np.testing.assert_allclose(plan.derivatives(2.0 * x)[0], np.stack([share, -share], axis=1), atol=1e-12)


def test_the_start_is_that_of_the_joints_to_the_last_bit() -> None:
    current = POSITIONS[0] + 9e-7
    plan = plan_trajectory(current, TIMES, POSITIONS, None, LIMITS)
    np.testing.assert_array_equal(plan.start, current)
    with pytest.raises(KernelError, match=r"starts with joint 'elbow' at 0, but the joint is at 1\.1e-06"):
        plan_trajectory([0.0, 1.1e-6], TIMES, POSITIONS, None, LIMITS)


def test_a_position_limit_met_between_the_samples_is_refused_by_joint_and_time() -> None:
    # All samples are within 2 rad; between those at 1 and 2 s the elbow overshoots.
    positions = np.array([[0.0, 0.0], [0.0, 0.5], [0.0, 1.95], [0.0, 1.95], [0.0, 0.0]])
    with pytest.raises(LimitError, match=r"leaves the joint limits at .* joint 'elbow' would be at 2\.") as refusal:
        plan_trajectory([0.0, 0.0], [0.0, 0.5, 1.0, 2.0, 4.0], positions, None, LIMITS)
    assert 1.0 < float(refusal.value.metadata["time"]) < 2.0
    assert refusal.value.metadata["joint"] == "elbow"
    assert float(refusal.value.metadata["value"]) > 2.0


def test_a_velocity_limit_met_is_refused_by_joint_and_time() -> None:
    # The quintic over 1 s from -1.8 to 1.8 is fastest in the middle: 15/8 of the mean velocity 3.6.
    with pytest.raises(LimitError, match=r"joint 'shoulder' has velocity 6\.75, its limit is 3 per second") as refusal:
        plan_trajectory([-1.8, 0.0], [0.0, 1.0], [[-1.8, 0.0], [1.8, 0.0]], None, LIMITS)
    # It crosses 3 = 3.6 * 30 x² (1 - x)² where x (1 - x) = 1/6.
    assert float(refusal.value.metadata["time"]) == pytest.approx(0.5 - np.sqrt(1 / 4 - 1 / 6), abs=1e-6)
    assert refusal.value.reason is Reason.LIMIT_EXCEEDED


@pytest.mark.parametrize(
    ("times", "positions", "velocities", "message"),
    [
        ([0.0], POSITIONS[:1], None, "at least 2 times"),
        ([0.1, 0.5, 1.0, 2.0], POSITIONS, None, r"start at 0, not 0\.1 s"),
        ([0.0, 0.5, 0.5, 2.0], POSITIONS, None, r"strictly: times\[1\] is 0\.5 s, times\[2\] is 0\.5 s"),
        ([0.0, 1.0, 0.5, 2.0], POSITIONS, None, r"strictly: times\[1\] is 1 s, times\[2\] is 0\.5 s"),
        ([0.0, 0.5, np.nan, 2.0], POSITIONS, None, r"times\[2\] is not finite"),
        (TIMES, POSITIONS[:3], None, r"positions of shape \(4, 2\), not \(3, 2\)"),
        (TIMES, np.where(POSITIONS == -0.3, np.inf, POSITIONS), None, "position of joint 'elbow' at 0.5 s is inf"),
        (TIMES, POSITIONS, np.zeros((3, 2)), r"velocities of a trajectory have shape \(3, 2\)"),
        (TIMES, POSITIONS, np.full((4, 2), np.nan), "velocity of joint 'shoulder' at 0 s is nan"),
        (TIMES, POSITIONS, np.full((4, 2), 0.1), "rest, but joint 'shoulder' has velocity 0.1 at 0 s"),
        (TIMES, POSITIONS, np.array([[0, 0], [0, 0], [0, 0], [0, 0.2]]), "'elbow' has velocity 0.2 at 2 s"),
    ],
)
def test_impossible_samples_are_refused(
    times: list[float], positions: np.ndarray, velocities: np.ndarray | None, message: str
) -> None:
    with pytest.raises(KernelError, match=message):
        plan_trajectory(np.zeros(2), times, positions, velocities, LIMITS)
