"""Time-optimal laws: speed and acceleration kept everywhere, as fast as formulas and toppra itself say is possible."""

from __future__ import annotations

import logging
import math
import sys

import numpy as np
import pytest
from toppra import SplineInterpolator
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion import plan_execution, time_optimal
from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.path import joint_line, smooth_path
from virtualrobot_kernel.motion.path_law import path_law
from virtualrobot_kernel.motion.plan import Plan, plan_circ, plan_lin, plan_ptp
from virtualrobot_kernel.motion.planned import Track
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_kernel.motion.running_motion import Phase

from .motions import (
    FINE,
    TICK,
    RandomArc,
    arm_limits,
    circle_of,
    distances_from_circle,
    fine_steps,
    kinematics,
    random_arc,
    random_limits,
    random_line,
)

OPTIMAL = TimeLaw.TIME_OPTIMAL


def bang_bang(length: float, velocity: float, acceleration: float) -> float:
    """Return the least time (s) from rest to rest: Biagiotti, Melchiorri 2008, section 3.2."""
    if length >= velocity**2 / acceleration:
        return length / velocity + velocity / acceleration
    return 2.0 * math.sqrt(length / acceleration)


def assert_joints_keep(law: PiecewisePolynomial, path: PiecewisePolynomial, limits: JointLimits) -> None:
    """Look at velocity and acceleration at ticks, at ten points between, and on both sides of each break."""
    breaks = law.breaks
    taus = np.concatenate([np.arange(0.0, law.end, FINE), breaks, np.nextafter(breaks, -np.inf)])
    _, v, a, _ = Track(path, law).derivatives(taus)
    assert np.all(np.abs(v) <= limits.velocity * (1 + 1e-9))
    assert np.all(np.abs(a) <= limits.acceleration * (1 + 1e-9))
    assert np.all(law.states(taus, 1)[1] >= -1e-9)


def test_a_point_to_point_move_takes_the_time_of_the_bang_bang_law(rng: np.random.Generator) -> None:
    for _ in range(20):
        limits = random_limits(rng, 7)
        start, goal = rng.uniform(limits.lower, limits.upper, (2, 7))
        goal = start + rng.choice([1.0, 0.01]) * (goal - start)
        plan = plan_ptp(start, goal, limits, 0.8, OPTIMAL)
        travel = np.abs(goal - start)
        velocity, acceleration = (0.8 * limits.velocity / travel).min(), (limits.acceleration / travel).min()
        assert plan.duration == pytest.approx(bang_bang(1.0, velocity, acceleration), rel=1e-12)
        assert_joints_keep(plan.tracks[0].time_law, plan.tracks[0].path, limits)
        np.testing.assert_array_equal(plan.goal, goal)
        assert plan.duration < plan_ptp(start, goal, limits, 0.8).duration


def test_a_straight_path_takes_the_time_of_the_bang_bang_law(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 7)
    start, goal = rng.uniform(limits.lower, limits.upper, (2, 7))
    law = path_law(joint_line(start, goal), limits, [], [], OPTIMAL)
    travel = np.abs(goal - start)
    best = bang_bang(1.0, (limits.velocity / travel).min(), (limits.acceleration / travel).min())
    assert best <= law.end <= 1.002 * best


def test_curved_paths_take_as_long_as_by_toppra_alone(rng: np.random.Generator) -> None:
    """The peer has its own cubic spline, constraints and grid of 1,000; both go along the same path.

    Ours is slowed down as a whole where a limit would be exceeded between nodes: by 0.3% usually, now and then by 2%.
    """
    longer = []
    for _ in range(5):
        limits = random_limits(rng, 6)
        positions = rng.uniform(-1.0, 1.0, (6, 6))
        spline = SplineInterpolator(np.arange(6.0), positions)
        coefficients = spline.cspl.c[::-1].transpose(1, 0, 2)
        path = PiecewisePolynomial(spline.cspl.x, coefficients)
        law = path_law(path, limits, [], [], OPTIMAL)
        bounds = [JointVelocityConstraint(limits.velocity), JointAccelerationConstraint(limits.acceleration)]
        solver = TOPPRA(bounds, spline, gridpoints=np.linspace(0.0, 5.0, 1001), solver_wrapper="seidel")
        speeds = solver.compute_parameterization(0.0, 0.0)[1]
        assert speeds is not None
        longer.append(law.end / float((2.0 * 0.005 / (speeds[1:] + speeds[:-1])).sum()))
        assert_joints_keep(law, path, limits)
    assert np.median(longer) == pytest.approx(1.0, abs=0.02)
    assert min(longer) > 0.98 and max(longer) < 1.1


def test_joint_and_tcp_bounds_on_parts_of_a_path_are_kept(rng: np.random.Generator) -> None:
    plan, _, _, cartesian = random_line(rng, "iiwa")
    chain, limits, path = kinematics("iiwa"), arm_limits("iiwa"), plan.tracks[0].path
    tcp = TcpKinematics(chain, np.eye(4))
    bounds = [TcpBound(0.5, 1.0, slice(0, path.dimension), tcp, cartesian)]
    law = path_law(path, limits, [JointBound(0.1, 0.4, np.full(path.dimension, 0.3))], bounds, OPTIMAL)
    assert_joints_keep(law, path, limits)
    taus = np.arange(0.0, law.end, FINE)
    q, v, a, _ = Track(path, law).derivatives(taus)
    u = law.evaluate(taus)[:, 0]
    slow = (u >= 0.1) & (u <= 0.4)
    assert np.all(np.abs(v[slow]) <= 0.3 * limits.velocity * (1 + 1e-9))
    for i in np.flatnonzero(u >= 0.5)[::10]:
        step = 1e-5
        jacobian = tcp.jacobian(q[i])
        slope = (tcp.jacobian(q[i] + step * v[i]) - tcp.jacobian(q[i] - step * v[i])) / (2.0 * step)
        twist, change = jacobian @ v[i], jacobian @ a[i] + slope @ v[i]
        assert np.linalg.norm(twist[:3]) <= cartesian.velocity * (1 + 1e-5)
        assert np.linalg.norm(twist[3:]) <= cartesian.rotation_velocity * (1 + 1e-5)
        assert np.linalg.norm(change[:3]) <= cartesian.acceleration * (1 + 1e-4)
        assert np.linalg.norm(change[3:]) <= cartesian.rotation_acceleration * (1 + 1e-4)


@pytest.mark.parametrize("name", ["iiwa", "ur5", "puma560"])
def test_lines_keep_speed_and_acceleration_and_are_faster(name: str, rng: np.random.Generator) -> None:
    usual, start, goal, cartesian = random_line(rng, name)
    chain, limits = kinematics(name), arm_limits(name)
    plan = plan_lin(chain, start, goal, limits, cartesian, time_law=OPTIMAL)
    assert plan.duration < usual.duration
    path, law = plan.tracks[0].path, plan.tracks[0].time_law
    np.testing.assert_array_equal(path.coefficients, usual.tracks[0].path.coefficients)
    assert_joints_keep(law, path, limits)
    length = np.linalg.norm(goal[:3, 3] - chain.forward(start)[-1][:3, 3])
    _, u1, u2 = np.abs(law.states(np.arange(0.0, law.end, FINE), 2)[:, :, 0])
    assert length * u1.max() <= cartesian.velocity * (1 + 1e-9)
    assert length * u2.max() <= cartesian.acceleration * (1 + 1e-9)


def optimal_arc(arc: RandomArc, name: str) -> Plan:
    """Return the same circular motion by a time-optimal law."""
    chain, limits = kinematics(name), arm_limits(name)
    return plan_circ(chain, arc.start, arc.shape, arc.goal, limits, arc.cartesian, tip_t_tcp=arc.tool, time_law=OPTIMAL)


@pytest.mark.parametrize("name", ["iiwa", "puma560"])
def test_arcs_keep_speed_and_acceleration_in_space(name: str, rng: np.random.Generator) -> None:
    arc = random_arc(rng, name)
    plan = optimal_arc(arc, name)
    path, law = plan.tracks[0].path, plan.tracks[0].time_law
    assert_joints_keep(law, path, arm_limits(name))
    tcp = TcpKinematics(kinematics(name), arc.tool)
    circle = circle_of(arc, tcp.pose(arc.start))
    taus = np.arange(0.0, law.end, FINE)
    positions = np.array([tcp.pose(q)[:3, 3] for q in path.evaluate(law.evaluate(taus)[::20, 0])])
    assert distances_from_circle(positions, circle).max() < 1e-5
    # On a circle of radius r the acceleration is that along it and v²/r across.
    twist = tcp.jacobian(arc.start) @ path.state(0.0, 1)[1]
    _, u1, u2 = law.states(taus, 2)[:, :, 0]
    speed, along = np.linalg.norm(twist[:3]) * u1, np.linalg.norm(twist[:3]) * u2
    assert speed.max() <= arc.cartesian.velocity * (1 + 1e-6)
    assert np.hypot(along, speed**2 / circle[1]).max() <= arc.cartesian.acceleration * (1 + 1e-6)


def plans(rng: np.random.Generator) -> list[Plan]:
    """Return a time-optimal motion of each kind."""
    limits = random_limits(rng, 7)
    ends = rng.uniform(limits.lower, limits.upper, (2, 7))
    ptp = plan_ptp(ends[0], ends[1], limits, 1.0, OPTIMAL)
    _, start, goal, cartesian = random_line(rng, "ur5")
    lin = plan_lin(kinematics("ur5"), start, goal, arm_limits("ur5"), cartesian, time_law=OPTIMAL)
    return [ptp, lin, optimal_arc(random_arc(rng, "puma560"), "puma560")]


@pytest.mark.long
def test_pause_resume_override_and_cancel_stay_on_the_path_and_within_its_limits(rng: np.random.Generator) -> None:
    """Whatever is asked, and whenever; accelerations to the slack of ramps, 0.5%, and their samples."""
    for plan in plans(rng):
        track = plan.tracks[0]
        for action in ("cancel", "pause", "override"):
            motion = plan_execution.start(plan, 1.0)
            moment = int(rng.uniform(0.0, plan.duration) / TICK)
            for _ in range(moment):
                motion = motion.advance(TICK, 1.0)
            override = float(rng.uniform(0.01, 1.0)) if action == "override" else 1.0
            motion = motion if action == "override" else getattr(motion, action)()
            for tick in range(200_000):
                if motion.ended:
                    break
                if motion.phase is Phase.PAUSED:
                    motion = motion.resume()
                motion = motion.advance(TICK, override)
                if tick < 500:
                    for step in fine_steps(motion):
                        q, v, a = step.sample()
                        assert np.all(np.abs(v) <= plan.max_velocity * (1 + 1e-9))
                        assert np.all(np.abs(a) <= plan.max_acceleration * 1.006)
                        np.testing.assert_allclose(q, track.path.evaluate(step.path_states[0][0]), atol=1e-9)
            assert motion.ended
            if action != "cancel":
                np.testing.assert_array_equal(motion.sample()[0], plan.goal)


def test_a_cancel_brakes_with_limited_jerk(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 7)
    # So far that it has top speed at 40% and more than the 0.55 s to go that a stop takes at most.
    plan = plan_ptp(rng.uniform(limits.lower, -1.0), rng.uniform(1.0, limits.upper), limits, 1.0, OPTIMAL)
    motion = plan_execution.start(plan, 1.0)
    while motion.tau < 0.4 * plan.duration:
        motion = motion.advance(TICK, 1.0)
    stopping = motion.cancel()
    assert stopping.brakes
    _, v, a, j = Track(plan.tracks[0].path, stopping.brakes[0]).derivatives(
        np.linspace(0.0, stopping.brakes[0].end, 2000)
    )
    for values, limit in ((v, limits.velocity), (a, limits.acceleration), (j, limits.jerk)):
        assert np.all(np.abs(values) <= limit * 1.006)


def test_a_path_that_stands_still_is_refused() -> None:
    path = smooth_path(np.arange(3.0), np.zeros((3, 2)), None)
    limits = JointLimits(("a", "b"), *np.array([[-1.0] * 2, [1.0] * 2, [1.0] * 2, [1.0] * 2, [1.0] * 2]))
    for law in TimeLaw:
        with pytest.raises(KernelError, match="stands still"):
            path_law(path, limits, [], [], law)


@pytest.mark.parametrize("law", TimeLaw)
def test_a_path_may_stand_still_on_a_part(law: TimeLaw) -> None:
    positions = np.array([[0.0], [1.0], [1.0], [1.0], [2.0]])
    path = smooth_path(np.arange(5.0), positions, np.zeros((5, 1)))
    coefficients = path.coefficients.copy()
    coefficients[1:3] = 0.0
    coefficients[1:3, 0] = 1.0
    path = PiecewisePolynomial(path.breaks, coefficients)
    limits = JointLimits(("a",), *np.array([[-1.0], [3.0], [1.0], [2.0], [10.0]]))
    track = Track(path, path_law(path, limits, [], [], law))
    assert track.time_law.end < 10.0
    _, v, a, _ = track.derivatives(np.arange(0.0, track.time_law.end, FINE))
    assert np.abs(v).max() <= 1.0 + 1e-9
    assert np.abs(a).max() <= 2.0 + 1e-9


def test_what_toppra_fails_at_is_not_logged(caplog: pytest.LogCaptureFixture) -> None:
    """Another unit of time is tried then, and in the end it is an error of ours; its warnings alarm for nothing."""
    caplog.set_level(logging.WARNING)
    logging.getLogger("toppra").setLevel(logging.NOTSET)
    nodes = np.linspace(0.0, 1.0, 21)
    speeds = time_optimal._toppra(nodes, np.ones(21), np.full((21, 1), np.nan), np.zeros((21, 1)))
    assert speeds is None and not caplog.records


def test_without_the_library_a_curve_is_refused_and_a_straight_move_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "toppra.algorithm", None)
    limits = arm_limits("ur5")
    goal = np.full(6, 0.5)
    with pytest.raises(KernelError, match="needs the library toppra"):
        path_law(joint_line(np.zeros(6), goal), limits, [], [], OPTIMAL)
    assert plan_ptp(np.zeros(6), goal, limits, 1.0, OPTIMAL).duration > 0.0
