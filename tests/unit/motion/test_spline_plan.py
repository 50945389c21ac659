"""Motions of real arms along splines: through each pose, within all limits; refused with the place and the goal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.circle import Center
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.plan import plan_circ, plan_spline
from virtualrobot_kernel.motion.spline import spline

from .motions import FINE, arm_limits, kinematics, random_spline

NAMES = ("iiwa", "panda", "xarm6", "puma560")
IIWA_READY = np.array([0.0, 0.5, 0.0, -1.4, 0.0, 1.2, 0.0])
X, Y, Z = np.eye(3)


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_each_pose_is_passed_and_all_limits_are_kept(name: str, rng: np.random.Generator) -> None:
    """At each tick and ten points between two; where the TCP is by forward kinematics."""
    chain, limits = kinematics(name), arm_limits(name)
    motion = random_spline(rng, name)
    plan, tool = motion.plan, motion.tool
    assert plan.kind == "spline"
    np.testing.assert_array_equal(plan.start, motion.start)
    tau = np.append(np.arange(0.0, plan.duration, FINE), plan.duration)
    q, v, a, j = plan.derivatives(tau)
    assert np.all((q >= limits.lower - 1e-6) & (q <= limits.upper + 1e-6))
    for values, limit in ((v, limits.velocity), (a, limits.acceleration), (j, limits.jerk)):
        assert np.all(np.abs(values) <= limit * (1.0 + 1e-6))
    tcp_path = spline(chain.forward(motion.start)[-1] @ tool, motion.goals)
    path = plan.tracks[0].path
    for u, goal in zip(tcp_path.u[1:], motion.goals, strict=True):
        np.testing.assert_allclose(chain.forward(path.evaluate(u))[-1] @ tool, goal, atol=1e-9)
    for u in rng.uniform(0.0, 1.0, 300):
        assert np.abs(tcp_path.deviation(u, chain.forward(path.evaluate(u))[-1] @ tool)).max() < 1e-6
    # Just before its end it moves by less than is rounded.
    assert np.all(np.diff(plan.tracks[0].time_law.evaluate(tau)[:, 0]) >= -1e-15)


@pytest.mark.parametrize("name", ["iiwa", "puma560"])
def test_the_tcp_keeps_its_limits_in_space(name: str, rng: np.random.Generator) -> None:
    """By differences of the TCP's positions and orientations, centripetal acceleration included."""
    chain = kinematics(name)
    motion = random_spline(rng, name)
    h = 1e-3
    q = motion.plan.derivatives(np.arange(0.0, motion.plan.duration + h, h))[0]
    poses = np.array([chain.forward(row)[-1] @ motion.tool for row in q])
    velocity = np.diff(poses[:, :3, 3], axis=0) / h
    turns = poses[1:, :3, :3] @ poses[:-1, :3, :3].transpose(0, 2, 1)
    spin = (
        0.5
        / h
        * np.stack(
            [turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]], axis=1
        )
    )  # the rotation vector of a small turn
    limits = motion.cartesian
    for rate, greatest, steepest in (
        (velocity, limits.velocity, limits.acceleration),
        (spin, limits.rotation_velocity, limits.rotation_acceleration),
    ):
        assert np.linalg.norm(rate, axis=1).max() <= greatest * (1.0 + 1e-4)
        # The path is exact to 1e-8 m, twice that by h² is noise.
        assert np.linalg.norm(np.diff(rate, axis=0), axis=1).max() / h <= steepest * (1.0 + 1e-3) + 0.04


def test_a_spline_through_poses_of_a_circle_takes_about_as_long_as_the_circle() -> None:
    """Both keep the same limits in space; 64 poses are within a micrometre of the circle."""
    chain, limits, cartesian = kinematics("iiwa"), arm_limits("iiwa"), CartesianLimits(0.25, 1.0, 10.0)
    start = chain.forward(IIWA_READY)[-1]
    center = start[:3, 3] - 0.1 * X
    goals = []
    for angle in np.linspace(0.0, 2.0 * np.pi, 65)[1:]:
        goal = start.copy()
        goal[:3, 3] = center + 0.1 * (np.cos(angle) * X + np.sin(angle) * Y)
        goals.append(goal)
    plan = plan_spline(chain, IIWA_READY, goals, limits, cartesian)
    round_trip = plan_circ(chain, IIWA_READY, Center(center, Z, 2.0 * np.pi), None, limits, cartesian)
    assert plan.duration < 1.1 * round_trip.duration
    for q in plan.derivatives(np.linspace(0.0, plan.duration, 300))[0]:
        position = chain.forward(q)[-1][:3, 3]
        assert abs(np.linalg.norm(position - center) - 0.1) < 1e-6


def test_refusals_name_the_goal_that_is_nearest() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    start = chain.forward(IIWA_READY)[-1]
    goals = [start.copy() for _ in range(4)]
    for number, goal in enumerate(goals):
        goal[:3, 3] += 0.1 * (number + 1) * Y
    upper = limits.upper.copy()
    free = plan_spline(chain, IIWA_READY, goals, limits)
    upper[0] = free.tracks[0].path.evaluate(0.7)[0]
    with pytest.raises(LimitError) as refused:
        plan_spline(chain, IIWA_READY, goals, replace(limits, upper=upper))
    assert refused.value.metadata["joint"] == limits.names[0]
    assert refused.value.metadata["goal"] == "2"
    assert float(refused.value.metadata["fraction"]) == pytest.approx(0.7, abs=1e-3)
    assert "nearest to goals[2]" in str(refused.value)
    far = start.copy()
    far[:3, 3] += 2.0 * X
    with pytest.raises(KernelError, match=r"goals\[4\] of the spline motion is out of reach") as out:
        plan_spline(chain, IIWA_READY, [*goals, far], limits)
    assert out.value.reason is Reason.UNREACHABLE
    with pytest.raises(LimitError):
        plan_spline(chain, limits.upper + 0.1, goals, limits)
