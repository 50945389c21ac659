"""Jogs of real arms: as far as they can go and no farther, at the given speed, and refused where they can't go."""

from __future__ import annotations

from dataclasses import replace
from math import inf, tau

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.jog import SMALLEST_JOG, plan_cartesian_jog, plan_joint_jog
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.plan import Plan
from virtualrobot_kernel.motion.resolved_rate import SMALLEST_SINGULAR_VALUE

from .motions import FINE, arm_limits, kinematics

IIWA_READY = np.array([0.0, 0.5, 0.0, -1.4, 0.0, 1.2, 0.0])
PUMA_READY = np.array([0.1, -0.5, -0.5, 0.2, 0.9, 0.3])
READY = {"iiwa": IIWA_READY, "puma560": PUMA_READY}
X, Y, Z = np.eye(3)
STILL = np.zeros(3)
ONE = JointLimits(("joint",), np.array([-1.0]), np.array([1.5]), np.array([2.0]), np.array([10.0]), np.array([100.0]))


def weighted_singular_value(name: str, start: np.ndarray, q: np.ndarray) -> float:
    """Return the smallest singular value of the Jacobian, linear rows over the longest lever at the start."""
    chain = kinematics(name)
    first = chain.jacobian(start)
    lever = np.linalg.norm(first[:3], axis=0)[np.linalg.norm(first[3:], axis=0) > 1e-9].max()
    jacobian = chain.jacobian(q) / np.array([lever] * 3 + [1.0] * 3)[:, None]
    return float(np.linalg.svd(jacobian, compute_uv=False)[-1])


def assert_limits_are_kept(plan: Plan, limits: JointLimits) -> None:
    """At each tick and ten points between two; the positions to the last bit of rounding."""
    tau_ = np.append(np.arange(0.0, plan.duration, FINE), plan.duration)
    q, v, a, j = plan.derivatives(tau_)
    assert np.all((q >= limits.lower - 1e-9) & (q <= limits.upper + 1e-9))
    for values, limit in ((v, limits.velocity), (a, limits.acceleration), (j, limits.jerk)):
        assert np.all(np.abs(values) <= limit * (1.0 + 1e-6))


def test_a_joint_goes_to_its_limit_at_the_given_speed_and_takes_as_long_as_the_formula_says(
    rng: np.random.Generator,
) -> None:
    """T = s/v + 2 sqrt(v/j) for a double S that reaches v before a; Biagiotti, Melchiorri (2008), section 3.4."""
    q, velocity = float(rng.uniform(-0.5, 0.5)), float(rng.uniform(1.1, 1.9))
    for sign, limit in ((1.0, 1.5), (-1.0, -1.0)):
        plan, end = plan_joint_jog(q, sign * velocity, inf, ONE)
        assert end is None
        assert plan.kind == "jog"
        assert plan.goal[0] == limit
        assert_limits_are_kept(plan, ONE)
        slow = plan_joint_jog(q, 0.05 * sign, inf, ONE)[0]
        speeds = np.abs(slow.derivatives(np.linspace(0.0, slow.duration, 5001))[1])
        assert speeds.max() == pytest.approx(0.05, rel=1e-9)
        assert slow.duration == pytest.approx(abs(limit - q) / 0.05 + 2.0 * (0.05 / 100.0) ** 0.5, rel=1e-9)


def test_a_joint_goes_its_distance_and_a_limit_before_that_is_told() -> None:
    plan, end = plan_joint_jog(0.2, -0.5, 0.7, ONE)
    assert end is None
    assert plan.goal[0] == pytest.approx(-0.5, abs=1e-15)
    plan, end = plan_joint_jog(0.2, 0.5, 3.0, ONE)
    assert end is not None
    assert (end.wanted, end.kept) == (3.0, pytest.approx(1.3))
    assert "joint 'joint' reaches its upper limit 1.5" in end.reason
    assert plan.goal[0] == 1.5
    halved = plan_joint_jog(0.2, 0.5, 1.0, ONE, 0.5)[0]
    assert np.abs(halved.derivatives(np.linspace(0.0, halved.duration, 999))[1]).max() == pytest.approx(0.25)


def test_a_joint_jog_that_is_none_is_refused() -> None:
    with pytest.raises(LimitError, match=r"at most its limit 2 per second, not 2\.5") as fast:
        plan_joint_jog(0.0, 2.5, inf, ONE)
    assert fast.value.metadata["limit"] == "2.0"
    for nothing in (0.0, float("nan")):
        with pytest.raises(LimitError, match="velocity other than 0"):
            plan_joint_jog(0.0, nothing, inf, ONE)
    for nothing in (0.0, -1.0, float("nan")):
        with pytest.raises(KernelError, match="distance of a jog is above 0"):
            plan_joint_jog(0.0, 1.0, nothing, ONE)
    for at, velocity in ((1.5, 0.1), (1.5 - 5e-7, 0.1), (-1.0, -0.1), (1.6, 0.1)):
        with pytest.raises(LimitError, match="cannot move, it is at its end") as there:
            plan_joint_jog(at, velocity, inf, ONE)
        assert there.value.metadata["joint"] == "joint"
    assert plan_joint_jog(1.5, -0.1, 0.1, ONE)[0].goal[0] == pytest.approx(1.4)
    endless = replace(ONE, upper=np.array([inf]))
    with pytest.raises(KernelError, match="no limit that way, so its jog needs a distance"):
        plan_joint_jog(0.0, 0.1, inf, endless)
    assert plan_joint_jog(0.0, 2.0, 40.0, endless)[0].goal[0] == 40.0


@pytest.mark.parametrize("name", READY)
@pytest.mark.parametrize("turns", [False, True])
def test_the_tcp_goes_until_something_ends_it_and_that_is_where_it_says(
    name: str, turns: bool, rng: np.random.Generator
) -> None:
    """Where it ends a joint is at its limit, or the Jacobian's smallest singular value at its threshold."""
    chain, limits = kinematics(name), arm_limits(name)
    start = READY[name] + rng.uniform(-0.1, 0.1, len(READY[name]))
    first = chain.forward(start)[-1]
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    way = (STILL, tau * direction) if turns else (2.0 * direction, STILL)
    plan, end = plan_cartesian_jog(chain, start, *way, limits, CartesianLimits())
    assert plan.kind == "jog"
    assert_limits_are_kept(plan, limits)
    for share in np.linspace(0.0, 1.0, 41):
        pose = chain.forward(plan.tracks[0].path.evaluate(share))[-1]
        kept = end.kept if end else float(np.linalg.norm(way))
        turn = Rotation.from_matrix(pose[:3, :3] @ first[:3, :3].T)
        expected = Rotation.from_rotvec(share * kept * direction * turns)
        assert (turn * expected.inv()).magnitude() < 1e-5
        np.testing.assert_allclose(pose[:3, 3], first[:3, 3] + share * kept * direction * (not turns), atol=1e-5)
    if end is None:
        return
    assert 0.0 < end.kept < end.wanted == pytest.approx(tau if turns else 2.0)
    room = np.minimum(limits.upper - plan.goal, plan.goal - limits.lower)
    # How fast joints go along the way, times what is left of it.
    rates = np.abs(plan.tracks[0].path.evaluate(1.0 - 1e-9, 1)) / end.kept
    if "joint limit" in end.reason:
        assert np.any(room <= 2.0 * SMALLEST_JOG * np.maximum(rates, 1.0) + 1e-6), (room, rates)
    elif "singularity" in end.reason:
        left = weighted_singular_value(name, start, plan.goal)
        assert SMALLEST_SINGULAR_VALUE <= left < SMALLEST_SINGULAR_VALUE + 1e-3
    else:
        assert "cannot follow" in end.reason


def test_a_stretched_arm_is_not_reached_and_a_jog_back_goes() -> None:
    """Straight out an iiwa ends before its elbow is straight; there it can't go on, but back."""
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    out, end = plan_cartesian_jog(chain, IIWA_READY, 2.0 * X, STILL, limits, CartesianLimits(velocity=0.1))
    assert end is not None
    assert "singularity" in end.reason
    assert abs(out.goal[3]) < 0.1
    assert_limits_are_kept(out, limits)
    with pytest.raises(KernelError, match=r"meets a singularity at 0\.0%") as refused:
        plan_cartesian_jog(chain, out.goal, 0.5 * X, STILL, limits, CartesianLimits())
    assert refused.value.reason is Reason.SINGULARITY
    back, end = plan_cartesian_jog(chain, out.goal, -0.1 * X, STILL, limits, CartesianLimits())
    assert end is None
    np.testing.assert_allclose(
        chain.forward(back.goal)[-1][:3, 3], chain.forward(out.goal)[-1][:3, 3] - 0.1 * X, atol=1e-9
    )


def test_a_jog_to_a_joint_limit_stays_within_it_and_comes_back() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    down, end = plan_cartesian_jog(chain, IIWA_READY, -2.0 * X, STILL, limits, CartesianLimits())
    assert end is not None
    assert f"joint {limits.names[3]!r}" in end.reason
    assert limits.lower[3] <= down.goal[3] < limits.lower[3] + 1e-4
    at_end = down.goal.copy()
    at_end[3] = limits.lower[3]
    with pytest.raises(LimitError, match="the jog cannot move"):
        plan_cartesian_jog(chain, at_end, -0.1 * X, STILL, limits, CartesianLimits())
    assert plan_cartesian_jog(chain, at_end, 0.1 * X, STILL, limits, CartesianLimits())[1] is None


def test_a_jog_turns_by_more_than_half_a_turn_the_way_it_is_told() -> None:
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    limits = replace(limits, lower=np.full(7, -20.0), upper=np.full(7, 20.0))
    first = chain.forward(IIWA_READY)[-1]
    axis = first[:3, 2]
    plan, end = plan_cartesian_jog(chain, IIWA_READY, STILL, 1.5 * tau * axis, limits, CartesianLimits())
    assert end is None
    turns = Rotation.from_matrix(
        [chain.forward(q)[-1][:3, :3] for q in plan.tracks[0].path.evaluate(np.linspace(0.0, 1.0, 101))]
    )
    steps = (turns[1:] * turns[:-1].inv()).as_rotvec()
    np.testing.assert_allclose(steps, np.tile(0.015 * tau * axis, (100, 1)), atol=1e-6)


def test_a_jog_that_is_alone_keeps_its_speed_and_its_length() -> None:
    """T = s/v + v/a + a/j, as of a line."""
    chain, limits = kinematics("iiwa"), arm_limits("iiwa")
    cartesian = CartesianLimits(velocity=0.1, acceleration=0.5, jerk=5.0)
    plan, end = plan_cartesian_jog(chain, IIWA_READY, 0.2 * Z, STILL, limits, cartesian)
    assert end is None
    assert plan.duration == pytest.approx(0.2 / 0.1 + 0.1 / 0.5 + 0.5 / 5.0, rel=1e-6)
