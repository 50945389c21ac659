"""Inputs of a tick: the newest of each writer counts, and all of a tick are one entry of the journal."""

from __future__ import annotations

from threading import Thread

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.inputs.mailbox import MOST_TARGETS, Mailbox
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import EndSetpoints, SetMeasuredJoints, SetSetpoint, StartSetpointMotion
from virtualrobot_kernel.world.journal import MemoryJournal, replay
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.tick_inputs import InputCommand, TickInput

from tests.unit.world.builders import arm, empty

TICK = 4_000_000
GUARD = 30.0


def given(command: InputCommand, writer: str = "writer", told: list[KernelError] | None = None) -> TickInput:
    return TickInput(command, writer, (told if told is not None else []).append)


def setpoint(value: float, motion: str = "motion-1") -> SetSetpoint:
    return SetSetpoint(motion, (value,))


def test_the_newest_of_a_writer_and_a_target_is_taken_in_the_order_of_targets() -> None:
    box = Mailbox()
    for value in (0.1, 0.2):
        box.put("a", given(setpoint(value)))
        box.put("b", given(EndSetpoints("motion-1")))
        box.put("a", given(setpoint(value + 1.0), "other"))
    assert [item.command for item in box.take()] == [setpoint(0.2), EndSetpoints("motion-1"), setpoint(1.2)]
    assert box.take() == []


def test_a_full_mailbox_refuses_new_targets_and_takes_newer_values() -> None:
    box = Mailbox()
    for target in range(MOST_TARGETS):
        box.put(target, given(setpoint(0.0)))
    with pytest.raises(KernelError, match="'flood' has one more") as caught:
        box.put("new", given(setpoint(0.0), "flood"))
    assert caught.value.reason is Reason.TOO_LARGE
    box.put(0, given(setpoint(1.0)))
    assert len(taken := box.take()) == MOST_TARGETS
    assert taken[0].command == setpoint(1.0)


def test_nothing_newest_is_lost_while_threads_write() -> None:
    """Of what each writer puts in, the last value is the last that is taken, and no value is taken twice."""
    box, last, count = Mailbox(), 5000, 4
    writers = [
        Thread(target=lambda name=name: [box.put("t", given(setpoint(float(n)), name)) for n in range(last + 1)])
        for name in map(str, range(count))
    ]
    for writer in writers:
        writer.start()
    seen: dict[str, list[float]] = {}
    while any(writer.is_alive() for writer in writers) or box._waiting:
        for item in box.take():
            assert isinstance(item.command, SetSetpoint)
            seen.setdefault(item.writer, []).append(item.command.values[0])
    assert len(seen) == count
    for values in seen.values():
        assert values[-1] == last
        assert (np.diff(values) > 0.0).all()


def test_all_inputs_of_a_tick_are_one_entry_and_one_publication_and_replay_gives_the_same_bits() -> None:
    box, journal, told = Mailbox(), MemoryJournal(), []
    world = World(world_poses, journal, Clock(Mode.STEPPED, 1.0, TICK), inputs=box.take)
    world.start()
    try:
        names = [f"arm{place}" for place in range(3)]
        world.submit([arm(name) for name in names]).result(GUARD)
        starts = [StartSetpointMotion(name, ("a", "b"), SetpointMode.POSITION, 1.0) for name in names]
        ids = [str(id) for id in world.submit(starts).result(GUARD).created]
        robot = world.snapshot.structure.node("arm1").uid
        published: list[int] = []
        world.listen(lambda: published.append(world.snapshot.state.tick))
        refused: list[KernelError] = []
        for tick in range(1, 41):
            for id in ids:
                box.put(id, given(SetSetpoint(id, (0.001 * tick, -0.002 * tick)), id, refused))
            box.put("bad", given(SetSetpoint(ids[0], (9.0, 0.0)), "bad", refused))
            box.put("arm1", given(SetMeasuredJoints(robot, np.array([0.001, 0.002, 0.003]) * tick), "driver", refused))
            before = len(journal.entries())
            told.append(world.step(1).result(GUARD).state)
            entry = journal.entries()[-1]
            assert len(journal.entries()) == before + 1
            assert (entry.tick, entry.author) == (tick - 1, "motion-1, motion-2, motion-3, driver")
            assert [type(command) for command in entry.commands] == [SetSetpoint] * 3 + [SetMeasuredJoints]
        assert published == list(range(1, 41))
        assert len(refused) == 40
        assert all(isinstance(error, LimitError) and error.metadata["joint"] == "a" for error in refused)
    finally:
        world.close()
    first = empty()
    for state in told[::13]:
        entries = [entry for entry in journal.entries() if entry.tick < state.tick]
        again = replay(first.structure, first.state, entries, state.tick, TICK * 1e-9, world_poses).state
        np.testing.assert_array_equal((again.q, again.v), (state.q, state.v), strict=True)
        assert [(one.q.tolist(), one.v.tolist()) for one in again.commanded.values()] == [
            (one.q.tolist(), one.v.tolist()) for one in state.commanded.values()
        ]


def test_a_permit_keeps_an_input_out_and_a_fault_hurts_no_other(caplog: pytest.LogCaptureFixture) -> None:
    box, journal, refused = Mailbox(), MemoryJournal(), []
    world = World(world_poses, journal, Clock(Mode.STEPPED, 1.0, TICK), inputs=box.take)
    world.start()
    try:
        command = StartSetpointMotion("arm", ("a",), SetpointMode.VELOCITY, 1.0)
        world.submit([arm(), command]).result(GUARD)

        def no(snapshot: object, batch: object) -> None:
            raise KernelError("leased", reason=Reason.LEASED)

        box.put("leased", TickInput(setpoint(0.3), "stranger", refused.append, no))
        box.put("odd", given("no command", "odd", refused))  # pyright: ignore[reportArgumentType]
        box.put("good", given(setpoint(0.5)))
        world.step(3).result(GUARD)
        assert [error.reason for error in refused] == [Reason.LEASED, Reason.INTERNAL]
        assert journal.entries()[-1].commands == (setpoint(0.5),)
        assert world.snapshot.state.v[0] > 0.0
        assert "an input of odd failed" in caplog.text
    finally:
        world.close()
