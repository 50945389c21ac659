"""The world thread: batches in order, stale revisions, steps, the end; and replay from the journal."""

from __future__ import annotations

from collections.abc import Iterator
from threading import Event, Thread

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.limits import JointLimits as MotionLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import of_plan
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    CreateNodes,
    CreateSignal,
    PauseMotion,
    RemoveNode,
    ResumeMotion,
    SetJointPositions,
    SetSignal,
    SetSpeedFactor,
    StartMotion,
)
from virtualrobot_kernel.world.journal import MemoryJournal, replay, weight
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.store import MAX_STEPS, World

from tests.unit.journals import entries_of
from tests.unit.world.builders import arm, part, shifted

TICK = 4_000_000
GUARD = 30.0
"""Seconds after which a test gives up waiting."""


@pytest.fixture
def world() -> Iterator[World]:
    made = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, TICK))
    made.start()
    yield made
    made.close()


def turn(goal: float, start: float = 0.0) -> StartMotion:
    """Return a motion of joint `a`."""
    limits = MotionLimits(("a",), *(np.array([value]) for value in (-2.0, 2.0, 1.0, 4.0)), jerk=np.array([40.0]))
    return StartMotion((("arm", "a"),), of_plan(plan_ptp([start], [goal], limits)))


def test_a_batch_is_published_with_its_results(world: World) -> None:
    first = world.snapshot
    applied = world.submit([arm(), CreateSignal(Signal("ready", False))]).result(GUARD)
    assert applied.snapshot is world.snapshot
    assert applied.snapshot.revision == first.revision + 1
    assert applied.created[0] == world.snapshot.structure.node("arm").uid
    assert not first.state.signals, "what was published never changes"


def test_published_arrays_cannot_be_written_to(world: World) -> None:
    snapshot = world.submit([arm(), turn(1.0)]).result(GUARD).snapshot
    for _ in range(2):
        for array in (snapshot.state.q, snapshot.state.v, snapshot.state.parent_t_node, snapshot.world_t_node):
            assert not array.flags.writeable
        snapshot = world.step(3).result(GUARD)


def test_a_stale_revision_is_refused(world: World) -> None:
    revision = world.submit([arm()]).result(GUARD).snapshot.structure.revision
    world.submit([CreateNodes((part("p", shifted()),))]).result(GUARD)
    refused = world.submit([RemoveNode("p")], expected_revision=revision).exception(GUARD)
    assert isinstance(refused, KernelError)
    assert refused.reason is Reason.STALE_REVISION
    assert refused.metadata == {"revision": str(revision + 1), "expected_structure_revision": str(revision)}
    assert world.snapshot.structure.node("p")


def test_steps_count_ticks_exactly(world: World, rng: np.random.Generator) -> None:
    ticks = rng.integers(1, 100, 5).tolist()
    for count in ticks:
        world.step(count).result(GUARD)
    assert world.snapshot.state.tick == sum(ticks)
    assert world.snapshot.simulation_time == pytest.approx(sum(ticks) * 0.004, abs=1e-12)


def test_listeners_to_ticks_are_told_each_one_of_a_step(world: World, rng: np.random.Generator) -> None:
    told: list[int] = []
    joints: list[float] = []

    def ticked(snapshot: Snapshot) -> None:
        assert snapshot is world.snapshot
        told.append(snapshot.state.tick)
        joints.append(float(snapshot.state.q[0]))

    world.submit([arm(), turn(1.0)]).result(GUARD)
    end = world.listen_ticks(ticked)
    count = int(rng.integers(2, 50))
    world.step(count).result(GUARD)
    world.submit([CreateSignal(Signal("on", True))]).result(GUARD)
    assert told == list(range(1, count + 1)), "a command makes no tick"
    assert len(set(joints)) == count, "the arm moves in each"
    end()
    world.step(3).result(GUARD)
    assert len(told) == count


def test_listeners_to_ticks_are_told_each_one_in_realtime() -> None:
    world = World(world_poses, MemoryJournal(), Clock(Mode.REALTIME, 1.0, TICK))
    told: list[int] = []
    enough = Event()

    def ticked(snapshot: Snapshot) -> None:
        told.append(snapshot.state.tick)
        if len(told) == 20:
            enough.set()

    world.listen_ticks(ticked)
    world.start()
    assert enough.wait(GUARD)
    world.close()
    assert told == list(range(1, len(told) + 1))


@pytest.mark.parametrize("ticks", [0, MAX_STEPS + 1])
def test_impossible_steps_are_refused(world: World, ticks: int) -> None:
    assert "1 to" in str(world.step(ticks).exception(GUARD))


def test_stepping_needs_stepped_mode(world: World) -> None:
    world.set_clock(Mode.REALTIME, 1.0).result(GUARD)
    refused = world.step(1).exception(GUARD)
    assert isinstance(refused, KernelError)
    assert refused.reason is Reason.WRONG_STATE


def test_a_listener_that_has_ended_is_told_no_more(world: World) -> None:
    seen: list[int] = []
    end = world.listen(lambda: seen.append(world.snapshot.revision))
    world.submit([arm()]).result(GUARD)
    end()
    world.submit([RemoveNode("arm")]).result(GUARD)
    assert seen == [1]


def test_a_listener_that_fails_stops_neither_the_world_nor_others(
    world: World, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("broken listener")

    seen: list[int] = []
    world.listen(fail)
    world.listen(lambda: seen.append(world.snapshot.revision))
    world.listen_ticks(fail)
    world.listen_ticks(lambda snapshot: seen.append(-snapshot.state.tick))
    world.submit([arm()]).result(GUARD)
    world.step(2).result(GUARD)
    assert seen == [1, 2, -1, 3, -2]
    assert caplog.text.count("broken listener") >= 5


def test_a_motion_ends_at_its_goal_and_is_remembered(world: World) -> None:
    world.submit([arm(), turn(1.0)]).result(GUARD)
    while world.snapshot.state.motions:
        world.step(10).result(GUARD)
    state = world.snapshot.state
    assert state.q[0] == pytest.approx(1.0, abs=1e-12)
    assert state.v[0] == 0.0
    assert [motion.id for motion in state.ended] == ["motion-1"]


def test_a_motion_planned_from_elsewhere_is_refused(world: World) -> None:
    world.submit([arm(), SetJointPositions("arm", {"a": 0.5})]).result(GUARD)
    refused = world.submit([turn(1.0)]).exception(GUARD)
    assert isinstance(refused, KernelError)
    assert refused.reason is Reason.PLAN_OUTDATED
    assert "'a' of 'arm' is at 0.5, but the motion was planned from 0" in str(refused)


def test_what_is_queued_at_the_end_is_refused() -> None:
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, TICK))
    world.start()
    world.close()
    refused = world.submit([arm()]).exception(GUARD)
    assert isinstance(refused, KernelError)
    assert refused.reason is Reason.SHUTTING_DOWN


def test_an_end_waits_for_no_long_step(world: World) -> None:
    ending = Thread(target=world.close)

    def ticked(snapshot: Snapshot) -> None:
        if snapshot.state.tick == 10:
            ending.start()
        if snapshot.state.tick > 10:
            ending.join(0.01)  # so slow that the end of the step is far away

    world.listen_ticks(ticked)
    refused = world.step(MAX_STEPS).exception(GUARD)
    ending.join(GUARD)
    assert isinstance(refused, KernelError) and refused.reason is Reason.SHUTTING_DOWN
    assert world.snapshot.state.tick < MAX_STEPS


def test_realtime_ticks_by_itself_and_goes_on_after_a_change_of_speed() -> None:
    world = World(world_poses, MemoryJournal(), Clock(Mode.REALTIME, 100.0, TICK))
    ended = Event()
    world.listen(lambda: ended.set() if world.snapshot.state.ended else None)
    world.start()
    try:
        before = world.set_clock(Mode.REALTIME, 50.0).result(GUARD).state.tick
        world.submit([arm(), turn(1.0)]).result(GUARD)
        assert ended.wait(GUARD)
        assert world.snapshot.state.tick > before
        assert world.snapshot.state.ended[0].end_tick <= world.snapshot.state.tick
    finally:
        world.close()


@pytest.mark.parametrize("most", [{"most_entries": 32}, {"most_bytes": 40_000}], ids=["entries", "bytes"])
def test_a_journal_keeps_the_newest_and_the_world_that_they_begin_from(most: dict[str, int]) -> None:
    journal = MemoryJournal(**most)
    world = World(world_poses, journal, Clock(Mode.STEPPED, 1.0, TICK))
    world.start()
    world.submit([arm(), CreateSignal(Signal("s", False)), turn(1.5)]).result(GUARD)
    for number in range(200):
        world.step(3).result(GUARD)
        world.submit([SetSpeedFactor("", (number % 9 + 1) / 10)], str(number)).result(GUARD)
        if number % 20 == 0:
            world.submit([arm(f"arm{number}")], str(number)).result(GUARD)
    world.close()
    record, last = journal.record(), world.snapshot
    assert record.state.tick > 0 and record.entries[-1].author == "199"
    assert len(record.entries) <= most.get("most_entries", 211)
    assert sum(weight(entry) for entry in record.entries) <= most.get("most_bytes", 1e6)
    again = replay(record.structure, record.state, record.entries, last.state.tick, 0.004, world_poses)
    assert again.state.q.tobytes() == last.state.q.tobytes()
    assert again.state.v.tobytes() == last.state.v.tobytes()
    assert list(again.structure.nodes) == list(last.structure.nodes)


def test_a_run_is_replayed_from_its_journal_bit_for_bit(world: World, rng: np.random.Generator) -> None:
    first = world.snapshot
    world.submit([arm(), CreateSignal(Signal("s", False)), turn(1.5)], "a").result(GUARD)
    for _ in range(60):
        world.step(int(rng.integers(1, 20))).result(GUARD)
        choice = rng.integers(6)
        id = f"motion-{world.snapshot.state.motion_count}"
        now = float(world.snapshot.state.q[0])
        command = [
            SetSpeedFactor("", float(rng.uniform(0.1, 1.0))),
            SetSignal("s", bool(rng.integers(2))),
            PauseMotion(id),
            ResumeMotion(id),
            CancelMotion(id),
            turn(float(rng.uniform(-2, 2)), now),
        ][choice]
        world.submit([command], "b").exception(GUARD)  # a refusal leaves no trace in the journal
    last = world.snapshot
    again = replay(first.structure, first.state, entries_of(world), last.state.tick, 0.004, world_poses)
    assert again.state.tick == last.state.tick
    assert again.state.q.tobytes() == last.state.q.tobytes()
    assert again.state.v.tobytes() == last.state.v.tobytes()
    assert again.state.signals == last.state.signals
    assert [m.id for m in again.state.ended] == [m.id for m in last.state.ended]
    assert world_poses(again.structure, again.state).tobytes() == last.world_t_node.tobytes()
    assert {entry.author for entry in entries_of(world)} <= {"a", "b"}


def test_time_goes_on_after_a_tick_that_failed(caplog: pytest.LogCaptureFixture) -> None:
    left = [1, 1]

    def inputs() -> tuple[()]:
        if left:
            raise ZeroDivisionError(left.pop())
        return ()

    gone_on = Event()
    made = World(world_poses, MemoryJournal(), Clock(Mode.REALTIME, 1.0, TICK), inputs=inputs)
    made.listen(lambda: gone_on.set() if made.snapshot.state.tick > 3 else None)
    made.start()
    assert gone_on.wait(GUARD)
    made.close()
    assert [record.message for record in caplog.records] == [
        "a tick failed inside the kernel; the world is as it was before"
    ] * 2
