"""Repair of a folder whose journal is damaged: what can be read is kept, and the damaged files are set aside."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from virtualrobot_kernel.errors import KernelError, MalformedFileError, MissingFileError
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.folder import JOURNAL, LAST_TICK, PROJECT, TAIL, Project, read_project, take_folder
from virtualrobot_kernel.history.last_tick import LastTick
from virtualrobot_kernel.history.pages import rows
from virtualrobot_kernel.history.recovery import empty_world, moment_of, recovered, repeated
from virtualrobot_kernel.history.rows import CheckpointRow
from virtualrobot_kernel.history.salvage import SalvagedStore
from virtualrobot_kernel.history.steps import Steps
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.stored_steps import StoredSteps
from virtualrobot_kernel.history.tail import MAGIC, tail_rows
from virtualrobot_kernel.whole_files import sync_folder
from virtualrobot_kernel.world.change import Forward

ASIDE = "damaged"
"""Name of the folder, in the project's, that gets the damaged files; later ones have a number, too."""

WAL = f"{JOURNAL}-wal"
FILES = (JOURNAL, WAL, f"{JOURNAL}-shm", *TAIL, LAST_TICK)
"""Names of the files that are made anew."""


@dataclass(frozen=True, slots=True)
class Repaired:
    """Result of a repair.

    Attributes:
        first: number of the first entry that is kept,
        last: and of the last one: the world is as it was after it. It is `first` - 1 where none is kept.
        lost: how many entries are lost, with those that come after a lost one and can't be done without it.
        tick: how far time has come.
        lost_ticks: how many ticks came after it, as far as that is known.
        lost_checkpoints: how many checkpoints can't be read.
        lost_tail: whether a killed kernel has left entries that can't be read: those of its last second.
        made_steps: how many steps, which undo and the history tell, were lost and are made anew of their entries.
        aside: the folder with the damaged files.
    """

    first: int
    last: int
    lost: int
    tick: int
    lost_ticks: int
    lost_checkpoints: int
    lost_tail: bool
    made_steps: int
    aside: Path

    def __str__(self) -> str:
        """Return the result in words."""
        kept = f"entries {self.first:,} to {self.last:,}" if self.last >= self.first else "a checkpoint"
        lost = f"{self.lost:,} entries, {self.lost_ticks:,} ticks and {self.lost_checkpoints:,} checkpoints"
        more = ", and what was changed in the last second" if self.lost_tail else ""
        made = f"; {self.made_steps:,} steps are made anew of entries" if self.made_steps else ""
        where = f"the damaged files are in {self.aside}"
        return f"{kept} and {self.tick:,} ticks are kept; as far as can be told {lost} are lost{more}{made}; {where}"


def repair(path: Path, forward: Forward) -> Repaired | None:
    """Make the journal of a folder anew of all that can be read; return None, and do nothing, when it is sound.

    The world goes back to the last entry before which none is missing. The damaged files are moved as they are.

    Raises KernelError, and changes nothing, when it is no project, a kernel uses it, or nothing can be read.
    """
    if not (path / PROJECT).is_file():
        raise MissingFileError(f"{path} is no project folder, it has no {PROJECT}", path=path)
    project = read_project(path)
    if not (path / JOURNAL).exists():
        raise MissingFileError(f"{path} has no {JOURNAL} that could be repaired", path=path)
    lock = take_folder(path)
    try:
        with TemporaryDirectory(prefix="repair-", dir=path) as made:
            if _is_sound(_copied(path, Path(made) / "opened"), project):
                return None
            return _repaired(path, project, _copied(path, Path(made) / "read"), forward)
    except OSError as error:
        raise KernelError(f"{path} can't be repaired: {error}", path=path) from error
    finally:
        os.close(lock)


def _copied(path: Path, to: Path) -> Path:
    """Copy the files: SQLite writes even where it only reads."""
    to.mkdir()
    for name in FILES:
        with suppress(FileNotFoundError):
            shutil.copyfile(path / name, to / name)
    return to


def _is_sound(copy: Path, project: Project) -> bool:
    try:
        with closing(Store(copy / JOURNAL, project.seed)) as store:
            store.note_tick(project.tick_nanoseconds)
            store.check()
    except MalformedFileError:
        return False
    return True


def _repaired(path: Path, project: Project, made: Path, forward: Forward) -> Repaired:
    """Make the files anew beside their copies in `made`, and put them in place of those of the project."""
    with closing(LastTick(made / LAST_TICK, project.seed)) as file:
        known_tick = file.read()
    new = made / "new.db"
    with closing(SalvagedStore(new, project.seed)) as store:
        forgotten, lost_tail = _adopt(store, made, project)
        unreadable = [head.id for head in store.checkpoints() if not _is_readable(store, head)]
        store.remove_checkpoints(unreadable)
        after, last = _longest(store)
        if last == 0:
            raise MalformedFileError(
                f"there is nothing to go on from: neither the first entry nor a checkpoint of {path / JOURNAL} can be "
                "read; put a copy back",
                file=path / JOURNAL,
            )
        known = max([store.last_seq, *(step.number for step in islice(store.steps(), 1))])
        known_tick = tick = max(known_tick, store.last_tick)
        if known > last or lost_tail:  # what came next may have changed what moves
            tick = max(_tick_of(store, after, last))
        store.keep_only(after, last, tick)
        recovered(store, world_codec(), tick, project.tick_nanoseconds * 1e-9, forward)
        made_steps = _make_steps(store, after, project.tick_nanoseconds * 1e-9, forward)
    (made / LAST_TICK).unlink()
    with closing(LastTick(made / LAST_TICK, project.seed)) as file:
        file.write(tick)
    aside = _new_folder(path / ASIDE)
    for name in FILES:
        with suppress(FileNotFoundError):
            (path / name).rename(aside / name)
    (made / LAST_TICK).rename(path / LAST_TICK)
    new.rename(path / JOURNAL)  # last: without it nobody takes the rest for a project
    sync_folder(path)
    lost = known - min(forgotten, after) - (last - after)
    return Repaired(after + 1, last, lost, tick, known_tick - tick, len(unreadable), lost_tail, made_steps, aside)


def _adopt(store: SalvagedStore, copy: Path, project: Project) -> tuple[int, bool]:
    """Bring all rows that can be read into a new store, and those of the tail.

    Return the number of the last entry that was thinned out, and whether entries of the tail can't be read. Where
    nobody knows how much was thinned out, all before the first that can be read was.
    """
    said: dict[str, int] = {}

    def found() -> Iterator[tuple[Any, ...]]:
        for columns in rows(copy / JOURNAL, copy / WAL):
            if len(columns) != 2:
                yield columns
            elif isinstance(columns[0], str) and isinstance(columns[1], int):
                said[columns[0]] = columns[1]

    store.adopt(found())
    store.note_tick(said.get("tick_nanoseconds", project.tick_nanoseconds))
    store.note_tick(project.tick_nanoseconds)
    runs = store.runs()
    life = said.get("life", 0)
    tail, _ = tail_rows(copy, project.seed, life, runs[-1][1] if runs else store.last_seq)
    store.write(tail)
    is_left = any((copy / name).exists() and (copy / name).read_bytes().startswith(MAGIC) for name in TAIL)
    first = runs[0][0] - 1 if runs else store.last_seq
    return (said.get("forgotten", 0) if "seed" in said else first), is_left and not life


def _is_readable(store: Store, head: CheckpointRow) -> bool:
    try:
        moment_of(store, world_codec(), head)
    except KernelError:
        return False
    return True


def _longest(store: SalvagedStore) -> tuple[int, int]:
    """Return the number before the first entry, and that of the last one, of what leads furthest without a gap.

    It begins with the first entry of all, or after a checkpoint.
    """
    runs = store.runs()
    begins = [0, *(head.seq for head in store.checkpoints())]
    ends = [next((last for first, last in runs if first <= begin + 1 <= last), begin) for begin in begins]
    last = max(ends)
    return min(begin for begin, end in zip(begins, ends, strict=True) if end == last), last


def _make_steps(store: SalvagedStore, after: int, tick_seconds: float, forward: Forward) -> int:
    """Make the steps anew that are missing of the entries after one, as far as these can be read; return how many."""
    codec = world_codec()
    moment = next((moment_of(store, codec, head) for head in store.checkpoints() if head.seq == after), empty_world())
    there = store.entries_of_steps()
    steps, made = Steps(kept := StoredSteps(store, codec)), 0
    with suppress(KernelError):
        for told, failed in repeated(moment, store.rows(after), codec, tick_seconds, forward):
            if failed is None and told.number not in there:
                steps.keep([told])
                waiting = kept.waiting()
                store.write([], waiting)
                kept.written()
                made += sum(not replaced for _, replaced in waiting)
    return made


def _tick_of(store: Store, after: int, last: int) -> list[int]:
    """Return the ticks of the last entry that is kept, and of the checkpoint before it, as far as they are there."""
    heads = [head.tick for head in store.checkpoints() if after <= head.seq <= last]
    return [*(row.tick for row in store.rows(last - 1, last)), *heads] if last > after else heads


def _new_folder(path: Path) -> Path:
    for number in count(1):
        place = path if number == 1 else path.with_name(f"{path.name}-{number}")
        with suppress(FileExistsError):
            place.mkdir()
            return place
    raise AssertionError
