"""PlanExecution motions: pause, resume, cancel and override at random times stay on the path and within the limits."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion import plan_execution
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.plan import Plan, plan_lin, plan_ptp, plan_together
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.running_motion import Phase

from tests.tiers import Draws

from .motions import (
    FINE,
    TICK,
    arm_limits,
    fine_steps,
    kinematics,
    nominal_times,
    random_arc,
    random_group,
    random_limits,
    random_line,
    random_ptp,
    random_spline,
    random_trajectory,
)

MAKERS: dict[str, Callable[[np.random.Generator], Plan]] = {
    "ptp": random_ptp,
    "lin": lambda rng: random_line(rng, "iiwa")[0],
    "circ": lambda rng: random_arc(rng, "iiwa").plan,
    "spline": lambda rng: random_spline(rng, "iiwa").plan,
    "trajectory": lambda rng: random_trajectory(rng)[0],
    "group": random_group,
}


@dataclass
class Program:
    """Random requests, each with the same chance in each tick; the same seed gives the same program."""

    rng: np.random.Generator
    override: float = 1.0

    def step(self, motion: PlanExecution) -> PlanExecution:
        """Return the motion one tick later, perhaps after a request."""
        if self.rng.random() < 0.01:
            request = self.rng.choice(["pause", "resume", "override", "cancel"], p=[0.35, 0.3, 0.3, 0.05])
            if request == "override":
                self.override = float(self.rng.uniform(0.05, 1.0))
            elif motion.phase is not Phase.STOPPING:
                motion = getattr(motion, request)()
        if motion.phase is Phase.PAUSED and self.rng.random() < 0.05:
            motion = motion.resume()
        return motion.advance(TICK, self.override)


@pytest.mark.long
@pytest.mark.parametrize("kind", MAKERS)
def test_requests_at_random_times_keep_path_and_limits(kind: str, rng: np.random.Generator, draws: Draws) -> None:
    phases = set()
    for _ in range(draws(6)):
        plan = MAKERS[kind](rng)
        program = Program(rng, float(rng.choice([1.0, 0.3])))
        motion = plan_execution.start(plan, program.override)
        samples, still = [motion.sample()], set()
        taus = [nominal_times(motion)]
        for _ in range(20000):
            before, motion = motion, program.step(motion)
            phases.add(motion.phase)
            if motion.phase is Phase.PAUSED or (before.phase is Phase.PAUSED and motion.ended):
                samples.append(motion.sample())
                taus.append(nominal_times(motion))
                still.add(len(samples) - 1)
            else:
                for step in fine_steps(motion):
                    samples.append(step.sample())
                    taus.append(nominal_times(step))
            if motion.ended:
                break
        assert motion.ended
        q, v, a = (np.array(values) for values in zip(*samples, strict=True))
        # On the path: every sampled q of a robot is the plan's at a nominal time, and that never runs back.
        first = 0
        for track, track_taus in zip(plan.tracks, np.array(taus).T, strict=True):
            assert np.all(np.diff(track_taus) >= -1e-9)
            joints = slice(first, first + track.path.dimension)
            np.testing.assert_allclose(q[:, joints], track.derivatives(track_taus)[0], atol=1e-9)
            first = joints.stop
        moving = np.array([i not in still and i - 1 not in still for i in range(1, len(q))])
        assert np.all(np.abs(v) <= plan.max_velocity * (1 + 1e-9))
        assert np.all(np.abs(a) <= plan.max_acceleration * 1.01)
        # Jerk by differences, so that a jump of the acceleration would show; the last tick ends within a step.
        jerk = (np.diff(a, axis=0) / FINE)[moving][:-11]
        assert np.all(np.abs(jerk) <= plan.max_jerk * 1.02)
        change = np.abs(np.diff(q, axis=0) - FINE * 0.5 * (v[1:] + v[:-1]))[moving][:-11]
        assert change.max(initial=0.0) <= float(plan.max_jerk.max()) * FINE**3
        if motion.phase is Phase.SUCCEEDED:
            np.testing.assert_array_equal(q[-1], plan.goal)
        np.testing.assert_array_equal(v[-1], 0.0)
    assert Phase.RUNNING in phases


def test_a_line_keeps_its_own_acceleration_through_pauses(
    rng: np.random.Generator,
) -> None:
    plan, start, goal, cartesian = random_line(rng, "panda")
    travel = goal[:3, 3] - kinematics("panda").forward(start)[-1][:3, 3]
    length = float(np.linalg.norm(travel))
    program = Program(rng)
    motion = plan_execution.start(plan, 1.0)
    while not motion.ended and motion.phase is not Phase.STOPPING:
        motion = program.step(motion)
        if motion.phase is not Phase.STOPPING:
            assert length * abs(motion.path_states[0][2]) <= 1.01 * cartesian.acceleration


def test_a_cancelled_line_stops_faster_than_its_own_acceleration() -> None:
    # 0.25 m/s and 0.5 m/s²: a quintic pause takes 15/8 of 0.25 / 0.5 s; a cancel brakes as hard as the joints can.
    chain = kinematics("iiwa")
    ready = np.array([0.0, 0.5, 0.0, -1.4, 0.0, 1.2, 0.0])
    goal = chain.forward(ready)[-1].copy()
    goal[:3, 3] += 0.0, 0.4, 0.0
    limits = CartesianLimits(velocity=0.25, acceleration=0.5, jerk=20.0)
    plan = plan_lin(chain, ready, goal, arm_limits("iiwa"), limits)
    cruising = plan_execution.start(plan, 1.0).advance(0.5 * plan.duration, 1.0)
    shortest = 1.875 * 0.25 / 0.5
    assert shortest * 0.99 <= cruising.pause().ramp.length <= shortest * 1.2
    (brake,) = cruising.cancel().brakes
    assert 0.0 < brake.end < 0.5 * shortest


def test_without_requests_the_motion_follows_the_plan(rng: np.random.Generator) -> None:
    plan = random_ptp(rng)
    motion = plan_execution.start(plan, 1.0)
    ticks = 0
    while not motion.ended:
        motion = motion.advance(TICK, 1.0)
        ticks += 1
        expected = plan.derivatives(np.array([min(ticks * TICK, plan.duration)]))[:, 0]
        for values, wanted in zip(motion.sample(), expected[:3], strict=False):
            if not motion.ended:
                np.testing.assert_allclose(values, wanted, atol=1e-8)
        assert motion.progress == pytest.approx(min(1.0, ticks * TICK / plan.duration), rel=1e-9)
    assert motion.phase is Phase.SUCCEEDED
    assert ticks == int(np.ceil((plan.duration - 1e-9) / TICK))
    assert motion.advance(TICK, 1.0) is motion


def test_motions_sampled_at_once_are_where_each_is_by_itself_to_the_last_bit(rng: np.random.Generator) -> None:
    """Some go, some slow down, some brake, some are at their goal; NumPy says where, by the chain rule."""
    plans = [random_ptp(rng, 6), random_trajectory(rng)[0], plan_together([random_ptp(rng, 2), random_ptp(rng, 7)])]
    motions: list[PlanExecution] = []
    for plan in plans:
        going = plan_execution.start(plan, 0.6).advance(float(rng.uniform(0.2, 1.2)) * plan.duration, 0.6)
        motions += [going, going.pause().advance(TICK, 0.6), going.cancel().advance(TICK, 0.6)]
        motions.append(going.advance(2.0 * plan.duration, 0.6))
    assert any(motion.brakes for motion in motions)
    motions = [motions[place] for place in rng.permutation(len(motions))]
    together = plan_execution.sample_all(motions)
    for values, own in zip(together, zip(*(motion.sample() for motion in motions), strict=True), strict=True):
        np.testing.assert_array_equal(values, np.concatenate(own))
    for motion in motions:
        found = []
        for track, (u, speed, slope) in zip(motion.plan.tracks, motion.path_states, strict=True):
            q, q1, q2 = track.path.states(np.array([u]), 2)[:, 0]
            found.append([q, q1 * speed, q2 * speed**2 + q1 * slope])
        for values, wanted, atol in zip(
            motion.sample(), np.concatenate(found, axis=1), (1e-12, 1e-11, 1e-9), strict=True
        ):
            np.testing.assert_allclose(values, wanted, atol=atol)


def test_an_override_from_the_start_stretches_time(rng: np.random.Generator) -> None:
    plan = random_ptp(rng)
    override = float(rng.uniform(0.1, 0.9))
    motion = plan_execution.start(plan, override)
    ticks = 0
    while not motion.ended:
        motion = motion.advance(TICK, override)
        ticks += 1
    assert ticks == int(np.ceil((plan.duration - 1e-9) / override / TICK))


def test_a_change_of_override_settles_at_the_new_rate(rng: np.random.Generator) -> None:
    motion = plan_execution.start(random_ptp(rng), 0.05)
    for override in (0.2, 0.1):
        settled = False
        while not motion.ended and not settled:
            motion = motion.advance(TICK, override)
            settled = (motion.rate, motion.rate_slope) == (override, 0.0)
        assert settled


@pytest.mark.parametrize("kind", MAKERS)
def test_a_stop_takes_little_longer_than_from_top_speed(kind: str, rng: np.random.Generator) -> None:
    # Waiting for a ramp that fits takes at most one stop time, the ramp at most 1.2^9 of them (docs/motion.md).
    plan = MAKERS[kind](rng)
    bound = max(plan.braking.stop_time, 0.1) + 1.2**9 * plan.braking.stop_time + 0.05
    for tau in rng.uniform(0.0, plan.duration, 10):
        motion = plan_execution.start(plan, 1.0)
        motion = motion.advance(float(tau), 1.0).cancel()
        ticks = 0
        while not motion.ended:
            motion = motion.advance(TICK, 1.0)
            ticks += 1
        assert ticks * TICK <= bound


def test_a_pause_from_top_speed_brakes_at_the_limit(rng: np.random.Generator) -> None:
    # One joint, cruising: a quintic stop in time T has peak deceleration 15/8 v / T and peak jerk 10/sqrt(3) v / T².
    limits = random_limits(rng, 1)
    plan = plan_ptp([-1.9], [1.9], limits)
    velocity, acceleration, jerk = (float(x[0]) for x in (limits.velocity, limits.acceleration, limits.jerk))
    shortest = max(1.875 * velocity / acceleration, float(np.sqrt(10 / np.sqrt(3) * velocity / jerk)))
    assert plan.braking.stop_time == pytest.approx(shortest, rel=1e-6)
    motion = plan_execution.start(plan, 1.0).advance(plan.duration * 0.4, 1.0).pause()
    assert motion.phase is Phase.PAUSING
    assert motion.ramp.length == pytest.approx(shortest, rel=0.2)
    while motion.phase is not Phase.PAUSED:
        motion = motion.advance(TICK, 1.0)
    q, v, a = motion.sample()
    assert (v, a, motion.rate) == (0.0, 0.0, 0.0)
    later = motion.advance(TICK, 1.0)
    np.testing.assert_array_equal(later.sample()[0], q)
    motion = later.resume()
    assert motion.phase is Phase.RUNNING
    while not motion.ended:
        motion = motion.advance(TICK, 1.0)
    np.testing.assert_array_equal(motion.sample()[0], plan.goal)


def test_a_pause_can_be_taken_back_midway_without_a_jump(rng: np.random.Generator) -> None:
    plan = plan_ptp([-1.9], [1.9], random_limits(rng, 1))
    motion = plan_execution.start(plan, 1.0).advance(plan.duration * 0.3, 1.0).pause()
    motion = motion.advance(motion.ramp.length * float(rng.uniform(0.2, 0.8)), 1.0)
    resumed = motion.resume()
    assert resumed.phase is Phase.RUNNING
    before, after = motion.ramp.state(motion.elapsed), resumed.ramp.state(resumed.elapsed)
    np.testing.assert_allclose(after[:3], before[:3], atol=1e-9)
    while not resumed.ended:
        resumed = resumed.advance(TICK, 1.0)
    assert resumed.phase is Phase.SUCCEEDED


def test_each_phase_answers_each_request(rng: np.random.Generator) -> None:
    plan = plan_ptp([-1.9], [1.9], random_limits(rng, 1))
    going = plan_execution.start(plan, 1.0).advance(plan.duration * 0.4, 1.0)
    pausing = going.pause()
    assert pausing.pause() is pausing
    assert going.resume() is going
    paused = pausing
    while paused.phase is not Phase.PAUSED:
        paused = paused.advance(TICK, 1.0)
    assert paused.pause() is paused
    assert paused.set_override(0.5).rate == 0.0
    assert paused.cancel().phase is Phase.CANCELLED
    stopping = pausing.cancel()
    assert stopping.phase is Phase.STOPPING
    assert stopping.cancel() is stopping
    for refused in (PlanExecution.pause, PlanExecution.resume):
        for motion in (stopping, paused.cancel()):
            with pytest.raises(KernelError, match=motion.phase.value) as refusal:
                refused(motion)
            assert refusal.value.reason is Reason.WRONG_STATE
    while not stopping.ended:
        stopping = stopping.advance(TICK, 1.0)
    assert stopping.phase is Phase.CANCELLED
    assert 0.0 < stopping.progress < 1.0
    assert stopping.cancel() is stopping


def test_overrides_outside_0_to_1_are_refused(rng: np.random.Generator) -> None:
    plan = random_ptp(rng)
    for bad in (0.0, -0.5, 1.01, float("nan")):
        with pytest.raises(KernelError, match="speed override must be above 0 and at most 1"):
            plan_execution.start(plan, bad)
        with pytest.raises(KernelError, match="speed override"):
            plan_execution.start(plan, 1.0).set_override(bad)


def test_a_motion_without_length_has_succeeded_at_once(rng: np.random.Generator) -> None:
    motion = plan_execution.start(plan_ptp([0.5, 0.1], [0.5, 0.1], random_limits(rng, 2)), 1.0)
    assert motion.phase is Phase.SUCCEEDED
    assert motion.progress == 1.0
    np.testing.assert_array_equal(motion.sample()[0], [0.5, 0.1])
    np.testing.assert_array_equal(motion.sample()[1], 0.0)


def test_the_path_state_is_the_derivative_of_the_path_parameter(rng: np.random.Generator) -> None:
    plan = random_ptp(rng)
    motion = plan_execution.start(plan, 1.0).advance(0.4 * plan.duration, 1.0).pause()
    motion = motion.advance(0.5 * motion.ramp.length, 1.0)
    later = motion.advance(1e-6, 1.0)
    (u0, v0, a0), (u1, v1, a1) = motion.path_states[0], later.path_states[0]
    assert (u1 - u0) / 1e-6 == pytest.approx((v0 + v1) / 2, rel=1e-5, abs=1e-9)
    assert (v1 - v0) / 1e-6 == pytest.approx((a0 + a1) / 2, rel=1e-4, abs=1e-6)


def test_plans_that_are_kept_do_not_keep_their_braking_tables(rng: np.random.Generator) -> None:
    """The journal keeps every plan; their tables, a hundred times as large, must not stay with them."""
    plans = [random_ptp(rng) for _ in range(200)]
    first = weakref.ref(plans[0].braking)
    assert first() is not None
    for plan in plans:
        assert plan.braking is plan.braking, "made once while it is needed"
    gc.collect()
    assert first() is None
