"""Cancels: a motion brakes on its path as fast as its jerk limits allow, or runs to its goal when that is sooner."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
import ruckig
from virtualrobot_kernel.motion import plan_execution
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import Plan, plan_lin, plan_ptp, plan_together
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.running_motion import Phase

from .motions import (
    FINE,
    TICK,
    arm_limits,
    fine_steps,
    kinematics,
    random_group,
    random_limits,
    random_line,
    random_ptp,
    random_trajectory,
)


@dataclass
class Stop:
    """A cancelled motion from the cancel to its end: the joints at each tick and at ten points between two ticks."""

    end: PlanExecution
    ticks: int
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    progress: np.ndarray


def stopped(motion: PlanExecution) -> Stop:
    """Cancel a motion and follow it to its end."""
    steps = [motion, motion.cancel()]
    ticks = 0
    while not steps[-1].ended:
        steps.extend(fine_steps(steps[-1].advance(TICK, motion.override)))
        ticks += 1
    q, v, a = (np.array(values) for values in zip(*(step.sample() for step in steps[1:]), strict=True))
    return Stop(steps[-1], ticks, q, v, a, np.array([step.progress for step in steps]))


def at(plan: Plan, tau: float, override: float = 1.0) -> PlanExecution:
    """Return the motion `tau` s of nominal time after its start."""
    return plan_execution.start(plan, override).advance(tau / override, override)


def check_limits(plan: Plan, stop: Stop) -> None:
    """Velocity integrates to position without jumps, and the joints keep their limits; the last tick may cut a step."""
    assert np.all(np.abs(stop.v) <= plan.max_velocity * (1 + 1e-9))
    assert np.all(np.abs(stop.a) <= plan.max_acceleration * 1.005)
    jerk = np.diff(stop.a, axis=0)[:-11] / FINE
    assert np.all(np.abs(jerk) <= plan.max_jerk * 1.02)
    drift = (np.diff(stop.q, axis=0) - FINE * 0.5 * (stop.v[1:] + stop.v[:-1]))[:-11]
    assert np.all(np.abs(drift) <= plan.max_jerk * FINE**3)
    assert np.all(np.diff(stop.progress) >= -1e-9)
    assert not stop.v[-1].any()


def optimal_stop_time(velocity: float, acceleration: float, max_acceleration: float, max_jerk: float) -> float:
    """Return the shortest time (s) from a velocity and acceleration to rest, by ruckig's velocity interface."""
    given = ruckig.InputParameter(1)
    given.control_interface = ruckig.ControlInterface.Velocity
    given.current_velocity, given.current_acceleration = [velocity], [acceleration]
    given.target_velocity, given.target_acceleration = [0.0], [0.0]
    given.max_acceleration, given.max_jerk = [max_acceleration], [max_jerk]
    trajectory = ruckig.Trajectory(1)
    assert ruckig.Ruckig(1).calculate(given, trajectory) == ruckig.Result.Working
    return trajectory.duration


@pytest.mark.long
@pytest.mark.parametrize("joints", range(1, 8))
def test_a_cancelled_ptp_keeps_path_and_limits_and_stops_no_later_than_its_plan(
    joints: int, rng: np.random.Generator
) -> None:
    for override in (1.0, 1.0, float(rng.uniform(0.1, 0.9))):
        limits = random_limits(rng, joints)
        start = rng.uniform(limits.lower, limits.upper)
        goal = start + (rng.uniform(limits.lower, limits.upper) - start) * 10.0 ** rng.uniform(-3.0, 0.0)
        plan = plan_ptp(start, goal, limits)
        for tau in plan.duration * rng.uniform(0.0, 1.0, 6) ** 2:
            stop = stopped(at(plan, tau, override))
            check_limits(plan, stop)
            share = (stop.q - start) @ (goal - start) / ((goal - start) @ (goal - start))
            assert np.abs(stop.q - start - share[:, None] * (goal - start)).max() < 1e-12
            assert np.all(np.diff(share) >= -1e-12)
            left = (plan.duration - tau) / override
            assert stop.ticks <= math.ceil(left / TICK + 1e-6)
            if stop.end.phase is Phase.SUCCEEDED:
                assert stop.ticks >= math.floor(left / TICK)
                np.testing.assert_array_equal(stop.q[-1], goal)
            else:
                assert share[-1] < 1.0


def test_one_tick_after_its_start_a_motion_stops_within_three_more(rng: np.random.Generator) -> None:
    # Jerk +J for t, -J for 2 t, +J for t: back at rest after 2 J t³.
    for _ in range(10):
        limits = random_limits(rng, 1)
        jerk = float(limits.jerk[0])
        plan = plan_ptp([0.0], [float(rng.uniform(0.05, 1.0))], limits)
        motion = plan_execution.start(plan, 1.0).advance(TICK, 1.0)
        assert motion.cancel().brakes[0].end == pytest.approx(3.0 * TICK, rel=1e-9)
        stop = stopped(motion)
        assert stop.end.phase is Phase.CANCELLED
        assert stop.ticks in (3, 4)
        assert stop.q[-1, 0] == pytest.approx(2.0 * jerk * TICK**3, rel=1e-6)


def test_before_its_first_tick_a_motion_stops_where_it_is(rng: np.random.Generator) -> None:
    for plan in (random_ptp(rng), random_group(rng)):
        stop = stopped(plan_execution.start(plan, 1.0))
        assert (stop.end.phase, stop.ticks, stop.end.progress) == (Phase.CANCELLED, 1, 0.0)
        np.testing.assert_array_equal(stop.q[-1], plan.start)


def test_one_joint_stops_in_the_shortest_time_there_is(rng: np.random.Generator) -> None:
    for _ in range(30):
        limits = random_limits(rng, 1)
        plan = plan_ptp([-1.0], [-1.0 + 2.9 * float(rng.uniform(0.01, 1.0))], limits)
        tau = plan.duration * float(rng.uniform(0.0, 0.99))
        motion = at(plan, tau)
        _, velocity, acceleration = (float(x[0]) for x in motion.sample())
        shortest = optimal_stop_time(velocity, acceleration, float(limits.acceleration[0]), float(limits.jerk[0]))
        brakes = motion.cancel().brakes
        if brakes:
            assert brakes[0].end == pytest.approx(shortest, rel=1e-6)
            assert shortest < plan.duration - tau
        else:
            assert shortest == pytest.approx(plan.duration - tau, rel=1e-4, abs=1e-5), "its own law is the shortest"


def test_from_top_speed_one_joint_stops_by_a_double_s(rng: np.random.Generator) -> None:
    # Biagiotti, Melchiorri (2008), eq. 3.21, 3.22: v / a + a / j, or 2 sqrt(v / j) when a is not reached.
    for reached in (True, False):
        velocity, jerk = rng.uniform(1.0, 2.0), rng.uniform(50.0, 100.0)
        acceleration = float(np.sqrt(velocity * jerk) * (0.6 if reached else 1.5))
        values = (np.array([value]) for value in (-9.0, 9.0, velocity, acceleration, jerk))
        plan = plan_ptp([-4.0], [4.0], JointLimits(("joint",), *values))
        expected = velocity / acceleration + acceleration / jerk if reached else 2.0 * math.sqrt(velocity / jerk)
        motion = at(plan, 0.4 * plan.duration).cancel()
        assert motion.brakes[0].end == pytest.approx(expected, rel=1e-9)


def test_a_cancel_before_a_quarter_of_a_short_motion_stops_it_and_later_it_reaches_its_goal() -> None:
    # Jerk +J, -J, -J, +J, a quarter each: from the first quarter on, the rest of the motion is the fastest stop.
    plan = plan_ptp(np.zeros(7), np.array([0.1, 0.05, 0.0, 0.0, 0.0, -0.02, 0.0]), arm_limits("iiwa"))
    for share, phase in ((0.02, "CANCELLED"), (0.2, "CANCELLED"), (0.3, "SUCCEEDED"), (0.9, "SUCCEEDED")):
        stop = stopped(at(plan, share * plan.duration))
        assert stop.end.phase.value == phase
        if phase == "SUCCEEDED":
            assert stop.ticks == math.ceil((1.0 - share) * plan.duration / TICK - 1e-6)


@pytest.mark.parametrize("name", ["iiwa", "panda"])
def test_a_cancelled_line_stays_on_its_line_and_stops_no_later_than_its_plan(
    name: str, rng: np.random.Generator
) -> None:
    chain = kinematics(name)
    for _ in range(3):
        plan, start, goal, _ = random_line(rng, name)
        origin = chain.forward(start)[-1][:3, 3]
        along = (goal[:3, 3] - origin) / np.linalg.norm(goal[:3, 3] - origin)
        for tau in plan.duration * rng.uniform(0.0, 1.0, 4):
            stop = stopped(at(plan, tau))
            check_limits(plan, stop)
            assert stop.ticks * TICK <= plan.duration - tau + TICK
            for q in stop.q[::11]:
                away = chain.forward(q)[-1][:3, 3] - origin
                assert np.linalg.norm(away - (away @ along) * along) < 1e-5


def test_all_robots_of_a_cancelled_group_stop_each_on_its_own_path(rng: np.random.Generator) -> None:
    for _ in range(3):
        # So far that half-way it has no sooner stop at its goal.
        limits = random_limits(rng, 6)
        far = plan_ptp(rng.uniform(limits.lower, -1.0), rng.uniform(1.0, limits.upper), limits)
        plan = plan_together([far, random_line(rng, "panda")[0]])
        tau = plan.duration * float(rng.uniform(0.01, 0.5))
        motion = at(plan, tau).cancel()
        stop = stopped(at(plan, tau))
        check_limits(plan, stop)
        assert stop.end.phase is Phase.CANCELLED
        assert stop.ticks == math.ceil(max(brake.end for brake in motion.brakes) / TICK - 1e-9)
        assert not any(speed or slope for _, speed, slope in stop.end.path_states)
        for track, (u, _, _) in zip(plan.tracks, stop.end.path_states, strict=True):
            assert track.time_law.evaluate(tau)[0] < u < track.path.end
            assert nominal_time(track.time_law, u, 0.0) >= stop.end.tau - 1e-9


def test_a_robot_of_a_group_that_does_not_move_holds_up_nothing(rng: np.random.Generator) -> None:
    limits = random_limits(rng, 2)
    plan = plan_together([plan_ptp([0.1, 0.2], [0.1, 0.2], limits), plan_ptp([0.0, 0.0], [1.0, 1.0], limits)])
    tau = 0.2 * plan.duration
    stop = stopped(at(plan, tau))
    assert stop.end.phase is Phase.CANCELLED
    assert stop.end.tau > tau
    np.testing.assert_array_equal(stop.q[-1, :2], [0.1, 0.2])


def test_progress_at_standstill_is_that_of_the_place(rng: np.random.Generator) -> None:
    plan = random_ptp(rng)
    stop = stopped(at(plan, 0.3 * plan.duration))
    u = plan.tracks[0].time_law.evaluate(stop.end.progress * plan.duration)[0]
    np.testing.assert_allclose(plan.start + u * (plan.goal - plan.start), stop.q[-1], atol=1e-12)
    assert stop.end.advance(TICK, 1.0) is stop.end


def test_a_cancel_while_the_rate_changes_brakes_from_there(rng: np.random.Generator) -> None:
    for request in (PlanExecution.pause, lambda motion: motion.set_override(0.3)):
        plan = plan_ptp([-1.9, 1.0], [1.9, -1.0], random_limits(rng, 2))
        motion = request(at(plan, 0.4 * plan.duration))
        motion = motion.advance(float(rng.uniform(0.1, 0.8)) * motion.ramp.length, motion.override)
        rest = motion.ramp.length - motion.elapsed
        stop = stopped(motion)
        check_limits(plan, stop)
        assert stop.end.phase is Phase.CANCELLED
        if motion.phase is Phase.PAUSING:
            assert stop.ticks <= math.ceil(rest / TICK)
        np.testing.assert_allclose(stop.q[0], motion.sample()[0], atol=1e-12)
        np.testing.assert_allclose(stop.a[0], motion.sample()[2], atol=1e-9)


def test_a_timed_trajectory_stops_by_a_ramp_of_its_rate(rng: np.random.Generator) -> None:
    plan = random_trajectory(rng)[0]
    motion = at(plan, 0.3 * plan.duration).cancel()
    assert not motion.brakes
    while not motion.ended:
        motion = motion.advance(TICK, 1.0)
    assert (motion.phase, motion.ramp.goal) == (Phase.CANCELLED, 0.0)


def test_the_nominal_time_of_a_place_inverts_the_law(rng: np.random.Generator) -> None:
    for plan in (random_ptp(rng), plan_lin(kinematics("iiwa"), *easy_line(), arm_limits("iiwa"))):
        law = plan.tracks[0].time_law
        for tau in rng.uniform(0.0, plan.duration, 50):
            u = law.scalar_state(float(tau))[0]
            assert law.scalar_state(nominal_time(law, u, 0.0))[0] == pytest.approx(u, abs=1e-15, rel=1e-14)


def easy_line() -> tuple[np.ndarray, np.ndarray]:
    """Return joints of the iiwa and a pose 0.3 m to the side."""
    ready = np.array([0.0, 0.5, 0.0, -1.4, 0.0, 1.2, 0.0])
    goal = kinematics("iiwa").forward(ready)[-1].copy()
    goal[1, 3] += 0.3
    return ready, goal
