"""Appends are commands: replayed to the last bit, and refused when the motion is past the place where they join it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NoReturn

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.planning.blending import PlannedRun
from virtualrobot_kernel.planning.moves import PointToPoint
from virtualrobot_kernel.planning.plan_append import PlannedAppend, plan_append
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import MotionSpec, MoveStep, SetSignalStep, Step, TrackingSpec, Zone
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateSignal, PauseMotion, ResumeMotion, SetSpeedFactor
from virtualrobot_kernel.world.journal import MemoryJournal, replay
from virtualrobot_kernel.world.state import Motion, Signal, State
from virtualrobot_kernel.world.store import World

from tests.unit.journals import entries_of
from tests.unit.world.builders import LIMITS, TICK, arm

GUARD = 30.0


@pytest.fixture
def world() -> Iterator[World]:
    made = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, round(TICK * 1e9)))
    made.start()
    made.submit([arm(), CreateSignal(Signal("on", False))]).result(GUARD)
    yield made
    made.close()


def no_solver(*_: object) -> NoReturn:
    raise AssertionError("goals in joints need no solver")


def to(**joints: float) -> MoveStep:
    return MoveStep((PointToPoint("arm", joints),), Zone(percent=30.0))


def started(world: World, *steps: Step) -> PlannedRun | None:
    planned = plan_motion(world.snapshot, MotionSpec(steps=steps), no_solver, open=True)
    world.submit([planned.command]).result(GUARD)
    return planned.end


def planned(world: World, end: PlannedRun | None, *steps: Step, last: bool = False) -> PlannedAppend:
    return plan_append(world.snapshot, world.snapshot.state.motions[0], steps, end, 0.0, no_solver, last=last)


def running(world: World) -> ProgramRun:
    return running_of(world.snapshot.state.motions[0])


def running_of(motion: Motion) -> ProgramRun:
    assert isinstance(motion.running, ProgramRun)
    return motion.running


@pytest.mark.long
def test_appends_are_replayed_and_keep_limits(world: World, rng: np.random.Generator) -> None:
    seen: list[State] = []
    world.listen_ticks(lambda snapshot: seen.append(snapshot.state))
    first, since = world.snapshot, len(entries_of(world))
    end, joined, count = started(world, to(a=0.5)), 0, 1
    for _ in range(15):
        factors = [SetSpeedFactor("", float(rng.uniform(0.5, 1.0)))] if rng.random() < 0.2 else []
        pauses = [PauseMotion("motion-1")] if rng.random() < 0.2 else [ResumeMotion("motion-1")]
        world.submit([*factors, *pauses]).result(GUARD)
        world.step(int(rng.integers(1, 250))).result(GUARD)
        goal = {joint: float(rng.uniform(-1.5, 1.5)) for joint in "ab" if rng.random() < 0.8} or {"b": 0.0}
        lead = float(rng.uniform(0.0, 1.0)) if rng.random() < 0.5 else 0.0
        between = [SetSignalStep("on", bool(rng.integers(2)), lead)] if rng.random() < 0.5 else []
        append = planned(world, end, *between, to(**goal))
        world.submit([append.command]).result(GUARD)
        end, joined, count = append.end, joined + (append.command.cut is not None), count + len(between) + 1
        assert len(running(world).program.stages) < 12  # what is done is gone
    world.submit([planned(world, end, last=True).command, ResumeMotion("motion-1")]).result(GUARD)
    while world.snapshot.state.motions:
        world.step(100).result(GUARD)
    last = world.snapshot.state
    assert joined > 3 and (last.ended[-1].running.phase, last.ended[-1].step_count) == (Phase.SUCCEEDED, count)
    again = replay(first.structure, first.state, entries_of(world)[since:], last.tick, TICK, world_poses).state
    np.testing.assert_array_equal(again.q, last.q)
    np.testing.assert_array_equal(again.v, last.v)
    assert [one.end_tick for one in again.ended] == [one.end_tick for one in last.ended]
    stages = [stage for one in last.ended for stage in running_of(one).program.stages]
    times = [time for stage in stages for time, *_ in (*stage.steps, *stage.marks)]
    assert {type(time) for time in times} == {float}  # of no other kind, which journals would have to tell apart
    q, v = (np.array([getattr(state, name) for state in seen])[:, :2] for name in "qv")
    assert np.abs(v).max() <= LIMITS.velocity * (1.0 + 1e-6)
    acceleration = np.diff(v, axis=0) / TICK
    assert np.abs(acceleration).max() <= LIMITS.acceleration * 1.005
    assert np.abs(np.diff(acceleration, axis=0)).max() / TICK <= LIMITS.jerk * 1.05
    # Positions are the integral of the velocities: the trapezoidal rule is off by the jerk times a tick cubed over 12.
    assert np.abs(np.diff(q, axis=0) - 0.5 * TICK * (v[1:] + v[:-1])).max() < LIMITS.jerk * TICK**3 / 11.0


@pytest.mark.parametrize("share", [0.2, 0.6])
def test_leads_of_signals_stay_where_the_way_changes(world: World, share: float) -> None:
    """A corner that is made anew carries leads with it; what is set already is set once, at its time."""
    seen: list[State] = []
    world.listen_ticks(lambda snapshot: seen.append(snapshot.state))
    world.submit([CreateSignal(Signal("late", False)), CreateSignal(Signal("count", 0))]).result(GUARD)
    end = started(world, to(a=0.8))
    append = planned(world, end, SetSignalStep("on", True, lead=0.1), SetSignalStep("count", 1), to(a=0.8, b=0.8))
    world.submit([append.command]).result(GUARD)
    world.step(round(share * running(world).program.duration / TICK)).result(GUARD)
    append = planned(world, append.end, SetSignalStep("late", True, lead=0.3), SetSignalStep("count", 2), to(a=0.0))
    assert append.command.cut is not None
    world.submit([append.command]).result(GUARD)
    (stage,) = running(world).program.stages
    times = {number: time for time, number in stage.steps}
    world.submit([planned(world, append.end, last=True).command]).result(GUARD)
    while world.snapshot.state.motions:
        world.step(50).result(GUARD)
    began = {number: next(n for n, one in enumerate(seen) if one.signals["count"].value == number) for number in (1, 2)}
    ticks = {name: next(n for n, one in enumerate(seen) if one.signals[name].value) for name in ("on", "late")}
    assert abs(began[1] - ticks["on"] - 0.1 / TICK) <= 1 and abs(began[2] - ticks["late"] - 0.3 / TICK) <= 1
    assert abs(began[2] - began[1] - (times[6] - times[3]) / TICK) <= 1
    for name in ("on", "late", "count"):  # each value once
        values = [one.signals[name].value for one in seen if name in one.signals]
        assert sum(before != after for before, after in pairwise(values)) == (2 if name == "count" else 1)


def test_what_was_planned_for_another_moment_is_refused(world: World) -> None:
    end = started(world, to(a=1.0))
    late, other = planned(world, end, to(a=1.5)), planned(world, end, to(a=-0.5))
    assert late.command.cut is not None
    world.submit([other.command]).result(GUARD)
    for append in (late, other):  # it has two steps by now
        refused = world.submit([append.command]).exception(GUARD)
        assert isinstance(refused, KernelError) and refused.reason is Reason.PLAN_OUTDATED
    append = planned(world, other.end, to(a=1.0))
    assert append.command.cut is not None
    world.step(round(append.command.cut / TICK) + 5).result(GUARD)
    refused = world.submit([append.command]).exception(GUARD)
    assert isinstance(refused, KernelError) and "has gone on" in str(refused)
    assert world.snapshot.state.motions[0].step_count == 2


def test_a_ramp_that_is_under_way_is_not_cut(world: World) -> None:
    end = started(world, to(a=1.5))
    world.step(100).result(GUARD)  # it has its greatest speed
    append = planned(world, end, to(a=0.5))
    assert append.command.cut is not None
    world.step(int(append.command.cut / TICK) - 105).result(GUARD)
    world.submit([PauseMotion("motion-1")]).result(GUARD)
    world.step(1).result(GUARD)
    moving = running(world).running
    assert moving is not None and moving.tau < append.command.cut < moving.settled
    refused = world.submit([append.command]).exception(GUARD)
    assert isinstance(refused, KernelError) and refused.reason is Reason.PLAN_OUTDATED


def test_what_cannot_be_open_is_refused(world: World) -> None:
    for spec in (MotionSpec(moves=to(a=1.0).moves), MotionSpec(steps=(to(a=1.0),), tracking=TrackingSpec("arm", 1.0))):
        with pytest.raises(KernelError, match="only a program of steps"):
            plan_motion(world.snapshot, spec, no_solver, open=True)
