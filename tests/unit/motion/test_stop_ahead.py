"""Compiled brakes: the choice is that of plain NumPy, the stop that of the ticks, of all kinds of motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from virtualrobot_kernel.motion import brake, online, plan_execution
from virtualrobot_kernel.motion.online import Bounds, JointState
from virtualrobot_kernel.motion.path_law import TimeLaw
from virtualrobot_kernel.motion.plan import Plan, plan_ptp
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.program import of_plan
from virtualrobot_kernel.motion.program_run import start as start_program
from virtualrobot_kernel.motion.running_motion import Phase

from . import plain_brakes
from .motions import (
    TICK,
    arm_limits,
    random_arc,
    random_group,
    random_limits,
    random_line,
    random_ptp,
    random_spline,
    random_trajectory,
)

MOST = 4000
"""Ticks; longer than any motion here."""


def time_optimal(rng: np.random.Generator) -> Plan:
    limits = random_limits(rng, 6)
    start, goal = rng.uniform(limits.lower, limits.upper, (2, 6))
    return plan_ptp(start, goal, limits, time_law=TimeLaw.TIME_OPTIMAL)


KINDS: dict[str, Callable[[np.random.Generator], Plan]] = {
    "ptp": random_ptp,
    "line": lambda rng: random_line(rng, "iiwa")[0],
    "arc": lambda rng: random_arc(rng, "iiwa").plan,
    "spline": lambda rng: random_spline(rng, "panda").plan,
    "group": random_group,
    "time_optimal": time_optimal,
    "trajectory": lambda rng: random_trajectory(rng)[0],
}
ALL = [
    pytest.param("ptp", 2, 10, id="ptp"),
    pytest.param("line", 1, 10, id="line"),
    pytest.param("group", 1, 6, id="group"),
    *(pytest.param(kind, 3, 12, id=f"{kind}, many", marks=pytest.mark.long) for kind in KINDS),
]


def moments(plan: Plan, count: int, rng: np.random.Generator) -> Iterator[PlanExecution]:
    """Yield a running motion at random moments; some by another override, or while its rate changes."""
    for _ in range(count):
        override = float(rng.choice([1.0, rng.uniform(0.1, 1.0)]))
        motion = plan_execution.start(plan, override)
        for _ in range(round(rng.uniform(0.0, 1.0) * plan.duration / override / TICK)):
            motion = motion.advance(TICK, override)
        chance = rng.random()
        if chance < 0.4 and not motion.ended:
            motion = motion.pause() if chance < 0.2 else motion.set_override(float(rng.uniform(0.1, 1.0)))
            for _ in range(int(rng.integers(0, 60))):
                motion = motion.advance(TICK, motion.override)
        if not motion.ended:
            yield motion


@pytest.mark.parametrize(("kind", "plans", "count"), ALL)
def test_the_choice_is_that_of_plain_numpy(kind: str, plans: int, count: int, rng: np.random.Generator) -> None:
    for plan in [KINDS[kind](rng) for _ in range(plans)]:
        for motion in moments(plan, count, rng):
            for wanted, stops in ((0.0, True), (0.0, False), (float(rng.uniform(0.1, 1.0)), False)):
                waiting = float(rng.choice([0.0, 10.0]))
                now = brake.RateState(motion.tau, motion.ramp_tau, motion.elapsed, waiting, motion.ramp)
                found = brake.change(plan, now, wanted, stops=stops)
                brakes, ramp, waits = plain_brakes.change(plan, now, wanted, stops=stops)
                assert (len(found.brakes), found.ramp is None, found.waits) == (len(brakes), ramp is None, waits)
                for one, other in zip(found.brakes, brakes, strict=True):
                    assert one.end == pytest.approx(other.end, rel=1e-9, abs=1e-12)
                    times = np.linspace(0.0, other.end, 20)
                    np.testing.assert_allclose(one.states(times, 0), other.states(times, 0), rtol=0.0, atol=1e-12)
                if found.ramp and ramp:
                    assert found.ramp.length == pytest.approx(ramp.length, rel=1e-12)
                    np.testing.assert_allclose(found.ramp.coefficients, ramp.coefficients, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("kind", "plans", "count"), ALL)
def test_the_stop_is_what_the_ticks_make(kind: str, plans: int, count: int, rng: np.random.Generator) -> None:
    for plan in [KINDS[kind](rng) for _ in range(plans)]:
        for motion in moments(plan, count, rng):
            override = motion.override if rng.random() < 0.8 else float(rng.uniform(0.1, 1.0))
            braking = motion.cancel()
            for _ in range(int(rng.integers(0, 30)) if rng.random() < 0.5 else 0):
                braking = braking.advance(TICK, motion.override)
            for begin in (motion, braking):
                ahead = begin.stop_ahead(TICK, override, MOST)
                if ahead is None:
                    assert begin.ended or begin.phase is Phase.PAUSED or override != motion.override
                    continue
                now = begin.cancel()
                rows = [now.sample()[0]]
                while not now.ended:
                    now = now.advance(TICK, override)
                    rows.append(now.sample()[0])
                # Where it stands right at a tick, rounding says whether the one after it counts.
                last = min(len(rows), len(ahead.positions)) - 1
                assert max(len(rows), len(ahead.positions)) <= last + 2
                np.testing.assert_allclose(ahead.positions[: last + 1], rows[: last + 1], rtol=0.0, atol=1e-12)
                assert np.abs(ahead.positions[last:] - rows[-1]).max() <= 1e-12
                assert ahead.at_goal == (now.phase is Phase.SUCCEEDED)
                if not ahead.at_goal:
                    np.testing.assert_allclose(ahead.reached, [u for u, _, _ in now.path_states], rtol=0.0, atol=1e-12)


def test_it_is_the_same_to_the_last_bit_again(rng: np.random.Generator) -> None:
    for motion in moments(random_group(rng), 5, rng):
        one, other = (motion.stop_ahead(TICK, motion.override, MOST) for _ in range(2))
        assert one is None or (other is not None and one.positions.tobytes() == other.positions.tobytes())


def test_it_takes_no_more_ticks_than_it_may(rng: np.random.Generator) -> None:
    plan = random_ptp(rng)
    motion = plan_execution.start(plan, 1.0).advance(0.4 * plan.duration, 1.0)
    whole, part = (motion.stop_ahead(TICK, 1.0, most) for most in (MOST, 7))
    assert whole is not None and part is not None
    np.testing.assert_array_equal(part.positions, whole.positions[:8])


def test_the_stop_of_a_program_ends_at_the_goal_of_its_stage() -> None:
    # From the first quarter on the rest of so short a motion is the fastest stop (see test_brake).
    plan = plan_ptp(np.zeros(7), np.array([0.1, 0.05, 0.0, 0.0, 0.0, -0.02, 0.0]), arm_limits("iiwa"))
    run = start_program(of_plan(plan), 1.0).advance(0.6 * plan.duration, 1.0)
    ahead = run.stop_ahead(TICK, 1.0, MOST)
    assert ahead is not None and ahead.at_goal
    np.testing.assert_array_equal(ahead.positions[-1], plan.goal)
    assert run.arrived().phase is Phase.SUCCEEDED


def test_joints_that_follow_setpoints_stop_as_ruckig_has_them_stop(rng: np.random.Generator) -> None:
    for _ in range(200):
        limits = random_limits(rng, 3)
        share = rng.choice([0.0, 1.0, -1.0, rng.uniform(-1.0, 1.0)], (2, 3))
        now = JointState(
            tuple(rng.uniform(0.5 * limits.lower, 0.5 * limits.upper).tolist()),
            tuple((share[0] * limits.velocity).tolist()),
            tuple((share[1] * limits.acceleration).tolist()),
        )
        bounds = Bounds.of(limits, ())
        rows = brake.joints_stop_ahead(now, bounds[:4], TICK, MOST)
        way, _ = online.brake(now, bounds, TICK)
        assert abs(len(rows) - 1 - way.duration / TICK) < 1.0 + 1e-9
        wanted = np.array([way.at(row * TICK).q for row in range(len(rows))])
        np.testing.assert_allclose(rows, wanted, rtol=0.0, atol=1e-12)
