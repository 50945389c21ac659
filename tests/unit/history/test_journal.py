"""The journal's thread: entries in order, answered once they are kept, and refused from the first that could not be."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence

import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.journal import Journal, Told
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateSignal, SetSignal
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.store import World

GUARD = 60.0


class Held:
    """Keeper that waits until it may, and fails when told to."""

    def __init__(self) -> None:
        """May keep everything at first."""
        self.may = threading.Event()
        self.may.set()
        self.fault: Exception | None = None
        self.kept: list[Told] = []

    def keep(self, told: Sequence[Told]) -> None:
        """Keep entries, or fail."""
        assert self.may.wait(GUARD)
        if self.fault is not None:
            raise self.fault
        self.kept += told


@pytest.fixture
def keeper() -> Held:
    return Held()


@pytest.fixture
def world(keeper: Held) -> Iterator[World]:
    journal = Journal([keeper], last_number=7)
    made = World(world_poses, journal, Clock(Mode.STEPPED, 1.0, 4_000_000))
    journal.start()
    made.start()
    yield made
    keeper.may.set()
    made.close()
    journal.close()


def test_a_call_is_answered_once_its_entry_is_kept(world: World, keeper: Held) -> None:
    keeper.may.clear()
    first = world.submit([CreateSignal(Signal("s", 0))], "me")
    others = [world.submit([SetSignal("s", value)]) for value in range(1, 9)]
    world.step(1).result(GUARD)  # the world goes on meanwhile, and whoever reads it sees what comes
    assert world.snapshot.state.signals["s"].value == 8
    assert not any(one.done() for one in (first, *others))
    keeper.may.set()
    assert [one.result(GUARD).snapshot.state.signals["s"].value for one in (first, *others)] == [*range(9)]
    assert [one.number for one in keeper.kept] == [*range(8, 17)]
    assert keeper.kept[0].entry.author == "me" and keeper.kept[0].entry.wall_time > 1.7e9
    assert all(one.after.state is other.before.state for one, other in zip(keeper.kept, keeper.kept[1:], strict=False))


def test_nothing_changes_any_more_once_an_entry_could_not_be_kept(
    world: World, keeper: Held, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("WARNING")
    world.submit([CreateSignal(Signal("s", 0))]).result(GUARD)
    keeper.fault = OSError("no space left on device")
    for value in (1, 2):
        refused = world.submit([SetSignal("s", value)]).exception(GUARD)
        assert isinstance(refused, KernelError) and "no space left on device" in str(refused)
        assert "All that was answered is kept" in str(refused)
    assert "no space left on device" in caplog.text and not any(record.exc_info for record in caplog.records)
    assert world.snapshot.state.signals["s"].value == 1, "the first of them could be taken back by nobody"
    assert world.step(3).result(GUARD).state.tick == 3
    assert [one.number for one in keeper.kept] == [8]


def test_what_is_left_is_kept_and_answered_at_the_end(keeper: Held) -> None:
    journal = Journal([keeper])
    world = World(world_poses, journal, Clock(Mode.STEPPED, 1.0, 4_000_000))
    journal.start()
    world.start()
    keeper.may.clear()
    waiting = [world.submit([CreateSignal(Signal(f"s{number}", 0))]) for number in range(600)]
    threading.Timer(0.1, keeper.may.set).start()
    world.close()
    journal.close()
    kept = [one for one in waiting if one.exception(GUARD) is None]
    assert len(kept) == len(keeper.kept) == len(world.snapshot.state.signals)
