"""Point-to-point motions: straight in joint space, as fast as the limits allow, refused outside them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_ptp, plan_together

from .motions import FINE, random_limits, random_line, random_ptp
from .test_profile import double_s_duration


def test_joints_stay_on_the_straight_line_and_within_their_limits(rng: np.random.Generator) -> None:
    for _ in range(20):
        limits = random_limits(rng, 7)
        start, goal = rng.uniform(limits.lower, limits.upper, (2, 7))
        plan = plan_ptp(start, goal, limits)
        q, v, a, j = plan.derivatives(np.append(np.arange(0.0, plan.duration, FINE), plan.duration))
        direction = (goal - start) / np.linalg.norm(goal - start)
        along = (q - start) @ direction
        assert np.abs(q - start - along[:, None] * direction).max() < 1e-9
        assert np.all(np.diff(along) >= -1e-12)
        for values, limit in ((v, limits.velocity), (a, limits.acceleration), (j, limits.jerk)):
            assert np.all(np.abs(values) <= limit * (1.0 + 1e-9))
        np.testing.assert_allclose(q[[0, -1]], [start, goal], atol=1e-12)
        np.testing.assert_allclose(v[[0, -1]], 0.0, atol=1e-9)
        np.testing.assert_array_equal(plan.start, start)
        np.testing.assert_allclose(plan.goal, goal, atol=1e-12)


def test_derivatives_are_those_of_the_positions(rng: np.random.Generator) -> None:
    for plan in (random_ptp(rng), random_line(rng, "iiwa")[0]):
        # Central differences of the order below; kinks of the law are left out.
        h = 1e-6
        kinks = np.concatenate([track.time_law.breaks for track in plan.tracks])
        tau = rng.uniform(0.01, plan.duration - 0.01, 100)
        tau = tau[np.abs(tau[:, None] - kinks).min(axis=1) > 2 * h]
        states, before, after = (plan.derivatives(tau + shift) for shift in (0.0, -h, h))
        for order in range(3):
            difference = (after[order] - before[order]) / (2 * h)
            np.testing.assert_allclose(states[order + 1], difference, rtol=1e-5, atol=1e-4 * 10.0**order)


def test_the_duration_is_that_of_the_slowest_joint(rng: np.random.Generator) -> None:
    for _ in range(20):
        limits = random_limits(rng, 6)
        start, goal = rng.uniform(limits.lower, limits.upper, (2, 6))
        travel = np.abs(goal - start)
        # One law for all: each of its three limits is that of the joint which it binds most.
        bounds = [float((values / travel).min()) for values in (limits.velocity, limits.acceleration, limits.jerk)]
        assert plan_ptp(start, goal, limits).duration == pytest.approx(double_s_duration(1.0, *bounds), rel=1e-9)


def test_a_velocity_scale_scales_velocity_alone(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 6)
    start, goal = limits.lower + 0.1, limits.upper - 0.1
    scale = rng.uniform(0.05, 0.5)
    plan = plan_ptp(start, goal, limits, scale)
    velocity = np.abs(plan.derivatives(np.linspace(0.0, plan.duration, 2000))[1])
    assert np.all(velocity <= limits.velocity * scale * (1 + 1e-9))
    assert (velocity.max(axis=0) / limits.velocity).max() == pytest.approx(scale, rel=1e-3)
    travel = goal - start
    bounds = [float((values / travel).min()) for values in (limits.acceleration, limits.jerk)]
    expected = double_s_duration(1.0, scale * float((limits.velocity / travel).min()), *bounds)
    assert plan.duration == pytest.approx(expected, rel=1e-9)
    for bad in (0.0, -1.0, 1.5, math.nan):
        with pytest.raises(KernelError, match="velocity scale must be above 0 and at most 1"):
            plan_ptp(start, goal, limits, bad)


def test_where_the_joints_are_already_the_motion_takes_no_time(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 3)
    plan = plan_ptp(np.zeros(3), np.zeros(3), limits)
    assert plan.duration == 0.0
    np.testing.assert_array_equal(plan.goal, 0.0)


def test_tiny_and_huge_motions_are_planned() -> None:
    infinite = np.full(2, np.inf)
    limits = JointLimits(("a", "b"), -infinite, infinite, np.full(2, 1.0), np.full(2, 5.0), np.full(2, 50.0))
    for travel in (1e-12, 1e-9, 1e-6, 1e3, 1e5):
        plan = plan_ptp(np.zeros(2), np.array([travel, 0.0]), limits)
        assert plan.goal[0] == pytest.approx(travel, rel=1e-9)
        # Above 1e4 times the braking distance the law may take a ten-thousandth longer.
        assert plan.duration == pytest.approx(double_s_duration(travel, 1.0, 5.0, 50.0), rel=2e-4)


def test_joints_outside_their_limits_are_refused_by_name(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 4)
    goal = np.zeros(4)
    goal[2] = 9.0
    with pytest.raises(LimitError, match=r"goal .* joint 'joint_2' would be at 9") as refusal:
        plan_ptp(np.zeros(4), goal, limits)
    assert refusal.value.reason is Reason.LIMIT_EXCEEDED
    assert refusal.value.metadata["upper"] == str(limits.upper[2])
    with pytest.raises(LimitError, match="start"):
        plan_ptp(goal, np.zeros(4), limits)
    with pytest.raises(KernelError, match="4 joint values"):
        plan_ptp(np.zeros(4), np.zeros(3), limits)
    with pytest.raises(KernelError, match="nan for joint 2 of 4"):
        plan_ptp(np.zeros(4), [0.0, math.nan, 0.0, 0.0], limits)


def test_limits_that_make_no_sense_are_refused_by_name() -> None:
    one = np.ones(1)
    with pytest.raises(KernelError, match=r"'elbow' needs a finite jerk limit above 0 .* 0\.0"):
        JointLimits(("elbow",), -one, one, one, one, np.zeros(1))
    with pytest.raises(KernelError, match=r"'elbow' has lower limit 1\.0 above"):
        JointLimits(("elbow",), one, -one, one, one, one)


def test_robots_that_move_together_start_and_end_together(rng: np.random.Generator) -> None:
    plans = [random_ptp(rng, 6), random_line(rng, "panda")[0], random_ptp(rng, 2)]
    limits = random_limits(rng, 1)
    plans.append(plan_ptp([0.5], [0.5], limits))
    group = plan_together(plans)
    assert group.kind == "group"
    assert group.q_count == 6 + 7 + 2 + 1
    assert group.duration == max(plan.duration for plan in plans)
    shares = np.linspace(0.0, 1.0, 101)
    q = group.derivatives(shares * group.duration)[0]
    expected = np.concatenate([plan.derivatives(shares * plan.duration)[0] for plan in plans], axis=1)
    np.testing.assert_allclose(q, expected, atol=1e-9)
    _, v, a = group.sample(0.4 * group.duration, 0.5, 0.3)
    states = group.derivatives(np.array([0.4 * group.duration]))[:, 0]
    np.testing.assert_allclose(v, states[1] * 0.5, atol=1e-12)
    np.testing.assert_allclose(a, states[2] * 0.25 + states[1] * 0.3, atol=1e-11)
