"""The journal: entries survive before they are answered, go to keepers in order, and end all changes if they can't."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history import journal as journals
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.journal import Journal, Told
from virtualrobot_kernel.history.recovery import empty_world
from virtualrobot_kernel.history.tail import MappedFile, Tail, tail_rows
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateSignal, SetSignal, StopMotions
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.store import World

GUARD = 60.0
SEED = 0x5EED5EED
CODEC = world_codec()
BEGIN = replace(empty_world(), number=7)


class Tried:
    """Keeper that fails when told to."""

    def __init__(self) -> None:
        """May keep everything at first."""
        self.fault: Exception | None = None
        self.kept: list[Told] = []

    def keep(self, told: Sequence[Told]) -> None:
        """Keep entries, or fail."""
        if self.fault is not None:
            raise self.fault
        self.kept += told


class Disk:
    """Disk with the files of a tail, which fills up when told to."""

    def __init__(self, folder: Path, keeper: Tried) -> None:
        """Begin empty; what the keeper has is not in the tail."""
        self.folder, self.keeper, self.life = folder, keeper, 0
        self.is_full, self.synced = False, 0

    def opened(self, path: Path, size: int) -> MappedFile:
        """Open a file of it."""
        disk = self

        class File(MappedFile):
            def resize(self, size: int) -> None:
                if disk.is_full:
                    raise OSError("no space left on device")
                super().resize(size)

            def sync(self) -> None:
                if disk.is_full:
                    raise OSError("no space left on device")
                disk.synced += 1

        return File(path, size)

    def note(self, life: int) -> None:
        """Note a kernel's number."""
        self.life = life

    def signals(self) -> list[object]:
        """Return the values that signals were set to in the tail of a kernel that is killed now."""
        after = self.keeper.kept[-1].number if self.keeper.kept else 7
        rows, damage = tail_rows(self.folder, SEED, self.life, after)
        assert not damage
        commands = [one for row in rows for one in CODEC.decode(row.commands)]
        return [one.value for one in commands if isinstance(one, SetSignal)]


@pytest.fixture
def keeper() -> Tried:
    return Tried()


@pytest.fixture
def disk(tmp_path: Path, keeper: Tried) -> Disk:
    return Disk(tmp_path, keeper)


@pytest.fixture
def power() -> bool:
    return False


@pytest.fixture
def journal(keeper: Tried, disk: Disk, power: bool, monkeypatch: pytest.MonkeyPatch) -> Journal:
    monkeypatch.setattr(journals, "RETRY_SECONDS", 0.0)
    tail = Tail(disk.folder, SEED, power, disk.opened)
    return Journal([keeper], BEGIN, tail=tail, encode=CODEC.encode, note_life=disk.note, power=power)


@pytest.fixture
def world(journal: Journal) -> Iterator[World]:
    made = World(world_poses, journal, Clock(Mode.STEPPED, 1.0, 4_000_000))
    journal.start()
    made.start()
    yield made
    made.close()
    journal.close()


def test_a_call_is_answered_once_its_entry_survives_and_kept_in_order(
    world: World, journal: Journal, keeper: Tried, disk: Disk
) -> None:
    world.submit([CreateSignal(Signal("s", 0))], "me").result(GUARD)
    for value in range(1, 9):
        assert world.submit([SetSignal("s", value)]).result(GUARD).snapshot.state.signals["s"].value == value
        assert disk.signals() == [*range(5 if value > 4 else 1, value + 1)]
        if value == 4:
            assert not keeper.kept
            journal.settle()
            assert len(keeper.kept) == 5
    journal.settle()
    assert [one.number for one in keeper.kept] == [*range(8, 17)]
    assert keeper.kept[0].entry.author == "me" and keeper.kept[0].entry.wall_time > 1.7e9
    assert all(one.after.state is other.before.state for one, other in zip(keeper.kept, keeper.kept[1:], strict=False))


def test_nothing_changes_any_more_while_entries_can_not_be_kept(
    world: World, journal: Journal, keeper: Tried, disk: Disk, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("WARNING")
    world.submit([CreateSignal(Signal("s", 0))]).result(GUARD)
    journal.settle()
    keeper.fault = OSError("no space left on device")
    world.submit([SetSignal("s", 1)]).result(GUARD)
    journal.settle()
    for value in (2, 3):
        refused = world.submit([SetSignal("s", value)]).exception(GUARD)
        assert isinstance(refused, KernelError) and "no space left on device" in str(refused)
        assert "All that was answered is kept" in str(refused)
    assert "no space left on device" in caplog.text and not any(record.exc_info for record in caplog.records)
    assert world.snapshot.state.signals["s"].value == 1 and disk.signals() == [1]
    assert world.step(3).result(GUARD).state.tick == 3
    world.submit([StopMotions()]).result(GUARD)
    assert [one.number for one in keeper.kept] == [8]
    keeper.fault = None
    journal.settle()
    assert "2 entries were kept late" in caplog.text
    world.submit([SetSignal("s", 4)]).result(GUARD)
    journal.settle()
    assert [one.number for one in keeper.kept] == [8, 9, 10, 11]


def test_what_the_tail_has_no_room_for_is_refused_and_changes_nothing(
    world: World, journal: Journal, keeper: Tried, disk: Disk
) -> None:
    large = [CreateSignal(Signal(f"s{number}", "x" * 4000)) for number in range(400)]
    world.submit([CreateSignal(Signal("s", ""))]).result(GUARD)
    disk.is_full = True
    before = world.snapshot.state
    refused = world.submit(large).exception(GUARD)
    assert isinstance(refused, KernelError) and "no space left on device" in str(refused)
    assert world.snapshot.state is before
    world.submit([StopMotions()]).result(GUARD)
    assert isinstance(world.submit([SetSignal("s", "y")]).exception(GUARD), KernelError)
    disk.is_full = False
    journal.settle()
    world.submit(large).result(GUARD)
    world.submit([SetSignal("s", "z")]).result(GUARD)
    assert disk.signals() == ["z"] and [one.number for one in keeper.kept] == [8, 9]
    journal.settle()
    assert [one.number for one in keeper.kept] == [8, 9, 10, 11]


@pytest.mark.parametrize("power", [True])
def test_with_power_an_answer_waits_for_the_disk(world: World, journal: Journal, disk: Disk) -> None:
    world.submit([CreateSignal(Signal("s", 0))]).result(GUARD)
    before = disk.synced
    world.submit([SetSignal("s", 1)]).result(GUARD)
    assert disk.synced > before
    disk.is_full = True
    refused = world.submit([SetSignal("s", 2)]).exception(GUARD)
    assert isinstance(refused, KernelError) and "no space left on device" in str(refused)
    world.submit([StopMotions()]).result(GUARD)
    assert isinstance(world.submit([SetSignal("s", 3)]).exception(GUARD), KernelError)
    assert world.snapshot.state.signals["s"].value == 2, "it could be taken back by nobody"
    disk.is_full = False
    journal.settle()
    world.submit([SetSignal("s", 4)]).result(GUARD)


def test_what_is_left_is_kept_at_the_end_and_those_who_ask_do_not_outrun_it(
    keeper: Tried, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journals, "MOST_WAITING", 300)
    journal = Journal([keeper])
    world = World(world_poses, journal, Clock(Mode.STEPPED, 1.0, 4_000_000))
    journal.start()
    world.start()
    answered = [world.submit([CreateSignal(Signal(f"s{number}", 0))]) for number in range(600)]
    assert len(answered[0].result(GUARD).snapshot.state.signals) == 1
    world.step(1).result(GUARD)
    assert answered[299].done() and not answered[300].done()
    world.close()
    journal.close()
    assert all(one.exception(GUARD) is None for one in answered)
    assert len(keeper.kept) == len(world.snapshot.state.signals) == 600
