"""Time laws along paths: every limit of joints and tool centre points is kept, at ticks and at ten points between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.cartesian_plan import slowed_down
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.path import joint_line, quintic_hermite, smooth_path
from virtualrobot_kernel.motion.path_law import path_law
from virtualrobot_kernel.motion.plan import plan_lin, plan_ptp
from virtualrobot_kernel.motion.planned import Track
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics

from .motions import FINE, arm_limits, kinematics, random_limits, random_line


@pytest.mark.parametrize("name", ["iiwa", "ur5", "puma560"])
def test_joints_and_tool_centre_point_keep_their_limits(name: str, rng: np.random.Generator) -> None:
    plan, _, _, cartesian = random_line(rng, name)
    chain, limits, path = kinematics(name), arm_limits(name), plan.tracks[0].path
    slow = JointBound(0.3, 0.5, np.full(path.dimension, 0.4))
    tcp = TcpKinematics(chain, np.eye(4))
    bound = TcpBound(0.6, 1.0, slice(0, path.dimension), tcp, cartesian)
    track = Track(path, path_law(path, limits, [slow], [bound], TimeLaw.JERK_LIMITED))
    taus = np.arange(0.0, track.time_law.end, FINE)
    q, v, a, j = track.derivatives(taus)
    assert np.all(np.abs(v) <= limits.velocity)
    assert np.all(np.abs(a) <= limits.acceleration)
    assert np.all(np.abs(j) <= limits.jerk)
    u, u1, _, _ = track.time_law.states(taus, 3)[:, :, 0]
    assert np.all(u1 >= -1e-12)
    slowly = (u >= 0.3) & (u <= 0.5)
    assert np.all(np.abs(v[slowly]) <= 0.4 * limits.velocity)
    at = np.flatnonzero(u >= 0.6)
    twists = np.array([tcp.jacobian(q[i]) @ v[i] for i in at]).reshape(-1, 2, 3)
    speed, turn = np.linalg.norm(twists, axis=2).T
    assert speed.max() <= cartesian.velocity
    assert turn.max() <= cartesian.rotation_velocity


def test_a_law_is_at_rest_at_both_ends_and_covers_the_whole_path(rng: np.random.Generator) -> None:
    times, positions = np.cumsum(rng.uniform(0.2, 0.8, 6)), rng.uniform(-1.0, 1.0, (6, 7))
    law = path_law(smooth_path(times, positions, None), arm_limits("iiwa"), [], [], TimeLaw.JERK_LIMITED)
    assert law.coefficients.shape[1] == 4
    np.testing.assert_allclose(law.state(0.0, 2)[:, 0], [times[0], 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(law.state(law.end, 2)[:, 0], [times[-1], 0.0, 0.0], atol=1e-12)


def test_on_a_straight_path_it_is_nearly_as_fast_as_the_double_s(rng: np.random.Generator) -> None:
    """The double S is ruckig's, whose law is the fastest one."""
    for _ in range(6):
        limits = random_limits(rng, 7)
        start, goal = rng.uniform(limits.lower, limits.upper, (2, 7))
        goal = start + rng.choice([1.0, 0.05]) * (goal - start)
        law = path_law(joint_line(start, goal), limits, [], [], TimeLaw.JERK_LIMITED)
        best = plan_ptp(start, goal, limits).duration
        assert best <= law.end <= 1.06 * best


def test_a_line_near_a_singularity_is_slow_only_there() -> None:
    """The wrist of the Puma is singular where joint 5 is 0: the line passes it at 0.1 rad, in its middle."""
    chain, limits = kinematics("puma560"), arm_limits("puma560")
    middle = np.array([0.1, -0.7, -0.5, 0.2, 0.1, 0.3])
    start, goal = chain.forward(middle)[-1], chain.forward(middle)[-1]
    start[1, 3] -= 0.1
    goal[1, 3] += 0.1
    plan = plan_lin(chain, plan_lin(chain, middle, start, limits).goal, goal, limits)
    path = plan.tracks[0].path
    usual = CartesianLimits()
    own = jerk_limited_profile(1.0, usual.velocity / 0.2, usual.acceleration / 0.2, usual.jerk / 0.2)
    assert plan.duration < 0.6 * slowed_down(path, own, limits).end
    _, v, a, j = plan.derivatives(np.arange(0.0, plan.duration, FINE))
    assert np.all(np.abs(v) <= limits.velocity)
    assert np.all(np.abs(a) <= limits.acceleration)
    assert np.all(np.abs(j) <= limits.jerk)
    # The position is u times 0.2 m along the line.
    _, u1, u2, u3 = np.abs(plan.tracks[0].time_law.states(np.arange(0.0, plan.duration, FINE), 3)[:, :, 0]).max(axis=1)
    assert 0.2 * u1 <= usual.velocity
    assert 0.2 * u2 <= usual.acceleration
    assert 0.2 * u3 <= usual.jerk


@pytest.mark.parametrize("kind", TimeLaw)
def test_a_limit_may_begin_where_a_piece_does_but_for_rounding(kind: TimeLaw, rng: np.random.Generator) -> None:
    """The third of ten pieces ends at 0.30000000000000004: no cell of the path is between that and 0.3."""
    tenths = np.array([0.1 * i for i in range(11)])
    path, limits = smooth_path(tenths, rng.uniform(-1.5, 1.5, (11, 7)), None), arm_limits("iiwa")
    assert 0.3 < path.breaks[3] < 0.3 + 1e-15
    law = path_law(path, limits, [JointBound(0.3, 0.6, np.full(7, 0.1))], [], kind)
    u, u1 = law.states(np.arange(0.0, law.end, FINE), 1)[:, :, 0]
    slowly = (u >= 0.3) & (u <= 0.6)
    velocities = np.abs(path.states(u[slowly], 1)[1] * u1[slowly, None]) / limits.velocity
    assert 0.05 < velocities.max() <= 0.1


def test_a_limit_on_a_part_of_the_path_slows_that_part_alone(rng: np.random.Generator) -> None:
    path, limits = smooth_path(np.arange(6.0), rng.uniform(-1.5, 1.5, (6, 7)), None), arm_limits("iiwa")
    free = path_law(path, limits, [], [], TimeLaw.JERK_LIMITED)
    slow = path_law(path, limits, [JointBound(2.2, 2.6, np.full(7, 0.1))], [], TimeLaw.JERK_LIMITED)

    def seconds(law: PiecewisePolynomial, begin: float, end: float) -> float:
        return nominal_time(law, end, 0.0) - nominal_time(law, begin, 0.0)

    assert seconds(slow, 2.2, 2.6) > 2.0 * seconds(free, 2.2, 2.6)
    assert seconds(slow, 3.5, 5.0) < 1.1 * seconds(free, 3.5, 5.0)


def test_the_same_path_has_the_same_law_to_the_last_bit(rng: np.random.Generator) -> None:
    path = smooth_path(np.arange(5.0), rng.uniform(-1.5, 1.5, (5, 7)), None)
    one, other = (path_law(path, arm_limits("iiwa"), [], [], TimeLaw.JERK_LIMITED) for _ in range(2))
    np.testing.assert_array_equal(one.breaks, other.breaks)
    np.testing.assert_array_equal(one.coefficients, other.coefficients)


@pytest.mark.parametrize("law", TimeLaw)
def test_any_path_gets_a_law_that_keeps_its_limits(law: TimeLaw, rng: np.random.Generator) -> None:
    """Paths that no planner makes: short and long pieces, loops, parameters from 0.001 to 1,000, limits far apart.

    Looked at between the breaks too, on both sides of each; the time-optimal law keeps no jerk.
    """
    for _ in range(8):
        joints, count = int(rng.integers(1, 9)), int(rng.integers(2, 20))
        limits = random_limits(rng, joints)
        limits = replace(limits, velocity=limits.velocity * 10.0 ** rng.uniform(-1, 1, joints))
        positions = np.cumsum(rng.normal(size=(count, joints)) * 10.0 ** rng.uniform(-2, 0), axis=0)
        times = np.cumsum(rng.uniform(0.05, 1.0, count)) * 10.0 ** rng.uniform(-3, 3)
        rates = rng.normal(size=(2, count, joints)) / times[-1] * np.array([1.0, 1.0 / times[-1]])[:, None, None]
        path = quintic_hermite(times, positions, rates[0], rates[1])
        begin, end = np.sort(rng.uniform(path.start, path.end, 2))
        slow = JointBound(begin, end, rng.uniform(0.05, 1.0, joints))
        track = Track(path, path_law(path, limits, [slow], [], law))
        found = track.time_law
        taus = np.sort(np.concatenate([np.linspace(0.0, found.end, 20_000), track.grid(2)]))
        _, v, a, j = track.derivatives(taus)
        u = found.evaluate(taus)[:, 0]
        assert np.all(np.diff(u) >= -1e-12 * path.end)
        assert (u[0], u[-1]) == pytest.approx((path.start, path.end))
        inside = (u >= begin) & (u <= end)
        assert np.all(np.abs(v) <= limits.velocity)
        assert np.all(np.abs(v[inside]) <= slow.share * limits.velocity)
        assert np.all(np.abs(a) <= limits.acceleration)
        assert law is TimeLaw.TIME_OPTIMAL or np.all(np.abs(j) <= limits.jerk)
