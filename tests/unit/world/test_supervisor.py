"""Supervisors: asked before each tick and after each publication, obeyed in the same tick, journalled, replayed."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import Command, CreateSignal, SetSignal, StopRobots
from virtualrobot_kernel.world.journal import MemoryJournal, replay
from virtualrobot_kernel.world.state import Cancellation, EndCause, Signal, Snapshot
from virtualrobot_kernel.world.store import MOST_INTERVENTIONS, World

from tests.unit.journals import entries_of
from tests.unit.world.builders import arm
from tests.unit.world.test_store import GUARD, TICK, turn

Wanted = Callable[..., Sequence[Command]]


class Told:
    """A supervisor that remembers what it was asked, and answers by functions."""

    author = "tests"

    def __init__(self, before: Wanted | None = None, after: Wanted | None = None) -> None:
        """Answer by these functions; None wants nothing."""
        self.before, self.after = before, after
        self.refuse: KernelError | None = None
        self.asked: list[tuple[str, int]] = []

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        if self.refuse:
            raise self.refuse

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        assert later.state.tick == now.state.tick + 1
        self.asked.append(("before", now.state.tick))
        return self.before(now, later) if self.before else ()

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        self.asked.append(("after", now.state.tick))
        return self.after(now) if self.after else ()


@pytest.fixture
def world() -> Iterator[World]:
    made = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, TICK))
    made.start()
    yield made
    made.close()


def stop(now: Snapshot) -> StopRobots:
    return StopRobots((now.structure.node("arm").uid,), Cancellation(EndCause.COLLISION, "tests"))


def test_each_tick_and_each_batch_is_asked_about(world: World) -> None:
    supervisor = Told()
    world.supervise(supervisor)
    world.submit([arm()]).result(GUARD)
    world.step(2).result(GUARD)
    assert supervisor.asked == [("after", 0), ("before", 0), ("after", 1), ("before", 1), ("after", 2)]
    world.unsupervise(supervisor)
    world.step(2).result(GUARD)
    assert len(supervisor.asked) == 5


def test_commands_that_are_not_admitted_change_nothing(world: World) -> None:
    supervisor = Told()
    world.supervise(supervisor)
    supervisor.refuse = KernelError("not that", reason=Reason.COLLISION)
    before = world.snapshot
    with pytest.raises(KernelError, match="not that"):
        world.submit([arm()]).result(GUARD)
    assert world.snapshot is before and not entries_of(world)
    assert not supervisor.asked


def test_what_is_wanted_after_a_tick_is_done_in_it_and_replayed(world: World, rng: np.random.Generator) -> None:
    world.submit([arm(), turn(1.0)]).result(GUARD)
    tick = int(rng.integers(1, 60))
    world.supervise(Told(after=lambda now: [stop(now)] if now.state.tick == tick else ()))
    world.step(tick).result(GUARD)
    assert world.snapshot.state.motions[0].cancellation is not None
    assert world.snapshot.state.tick == tick
    end = world.step(1000).result(GUARD)
    entries = entries_of(world)
    assert [(entry.tick, entry.author) for entry in entries] == [(0, ""), (tick, "tests")]
    again = replay(
        World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, TICK)).snapshot.structure,
        World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, TICK)).snapshot.state,
        entries,
        end.state.tick,
        end.tick_seconds,
        world_poses,
    )
    assert again.state.q.tobytes() == end.state.q.tobytes()
    assert 0.0 < end.state.q[0] < 1.0, "it must have braked on its way"


def test_a_tick_is_made_again_after_a_stop(world: World) -> None:
    world.submit([arm(), turn(1.0)]).result(GUARD)
    bound = 0.3

    def keep(now: Snapshot, later: Snapshot) -> Sequence[Command]:
        # q + v^2 / 2a with the plan's 4 rad/s^2 and room for the jerk: where braking ends is below 2 * bound.
        moving = any(motion.cancellation is None for motion in now.state.motions)
        return [stop(now)] if moving and later.state.q[0] > bound else ()

    supervisor = Told(before=keep)
    world.supervise(supervisor)
    end = world.step(1000).result(GUARD)
    assert end.state.ended[-1].cancellation == Cancellation(EndCause.COLLISION, "tests")
    stopped = entries_of(world)[-1].tick
    assert supervisor.asked.count(("before", stopped)) == 2, "the tick in question is asked about again"
    assert bound < end.state.q[0] < 1.0
    assert math.isclose(end.state.v[0], 0.0)


def test_published_is_what_was_asked_about(world: World) -> None:
    candidates: list[Snapshot] = []
    world.submit([arm(), turn(1.0)]).result(GUARD)
    world.supervise(Told(before=lambda now, later: candidates.append(later) or ()))
    assert world.step(7).result(GUARD) is candidates[-1]


def test_one_that_never_ends_is_ended(world: World, caplog: pytest.LogCaptureFixture) -> None:
    world.submit([CreateSignal(Signal("s", False))]).result(GUARD)
    supervisor = Told(before=lambda now, later: [SetSignal("s", not now.state.signals["s"].value)])
    world.supervise(supervisor)
    with caplog.at_level(logging.ERROR):
        assert world.step(1).result(GUARD).state.tick == 1
    assert len(supervisor.asked) == MOST_INTERVENTIONS + 1
    assert "supervisors" in caplog.text


def test_a_failing_supervisor_stops_neither_time_nor_commands(world: World, caplog: pytest.LogCaptureFixture) -> None:
    def fail(*_: Snapshot) -> Sequence[Command]:
        raise ZeroDivisionError

    world.supervise(Told(fail, fail))
    with caplog.at_level(logging.ERROR):
        world.submit([arm()]).result(GUARD)
        assert world.step(2).result(GUARD).state.tick == 2
    assert "ZeroDivisionError" in caplog.text


def test_in_real_time_it_is_asked_too() -> None:
    world = World(world_poses, MemoryJournal(), Clock(Mode.REALTIME, 1.0, TICK))
    world.start()
    try:
        world.submit([arm(), turn(1.0)]).result(GUARD)
        world.supervise(
            Told(after=lambda now: [stop(now)] if any(not m.cancellation for m in now.state.motions) else ())
        )
        world.submit([]).result(GUARD)
        motion = (*world.snapshot.state.motions, *world.snapshot.state.ended)[0]
        assert motion.cancellation is not None
    finally:
        world.close()
