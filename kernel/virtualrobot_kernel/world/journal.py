"""Journal of every batch of commands that was applied, with its tick and author; a run is replayed from it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol

import numpy as np

from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tick import advance

MOST_ENTRIES = 16_000
"""Greatest number of batches in memory: a minute of setpoints at each tick, days of what people do."""

MOST_BYTES = 64 * 1024 * 1024
"""Greatest size of the batches in memory, in bytes; an imported robot and a plan have some tens of KiB each."""

PARTS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """Entry of a batch that was applied: the number of ticks before it, its author, and its commands.

    `wall_time` (seconds since 1970) is for people: clocks are set back, and entries are in their order without it.
    """

    tick: int
    author: str
    commands: tuple[Command, ...]
    wall_time: float = 0.0


Answer = Callable[[Exception | None], None]
"""Answer to whoever gave a batch: it is kept (None), or it could not be."""


class Journal(Protocol):
    """Log of applied batches. The world thread alone calls it, and each method returns at once."""

    def admit(self, commands: Sequence[Command]) -> None:
        """Raise KernelError when these commands could not be kept; the world is left as it is then."""
        ...

    def append(self, entry: Entry, before: Change, after: Change) -> None:
        """Keep one entry after all others."""
        ...

    def answer(self, answer: Answer) -> None:
        """Call `answer`, from any thread, once all entries so far are kept."""
        ...

    def ticked(self, structure: Structure, state: State) -> None:
        """Note the world as a tick has made it; none is left out."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """Entries in a row, and the world before the first one: what a replay begins from."""

    structure: Structure
    state: State
    entries: Sequence[Entry]


class MemoryJournal:
    """Journal in memory of the newest entries: all of them would fill it in a kernel that runs for weeks."""

    def __init__(self, most_entries: int = MOST_ENTRIES, most_bytes: int = MOST_BYTES) -> None:
        """Begin empty; keep at most so many entries, and bytes in them.

        They go in parts of an eighth, since what a replay begins from is kept for each part only; an entry that is
        larger than a part is one by itself.
        """
        self._part_entries, self._part_bytes = most_entries // PARTS, most_bytes // PARTS
        self._parts: tuple[Record, ...] = ()
        self._last: list[Entry] = []
        self._bytes = 0

    def admit(self, commands: Sequence[Command]) -> None:
        """Admit all commands: the oldest entries make room."""

    def append(self, entry: Entry, before: Change, after: Change) -> None:
        """Keep one entry after all others. The oldest ones may go."""
        size = weight(entry)
        if not self._parts or len(self._last) >= self._part_entries or self._bytes + size > self._part_bytes:
            self._last, self._bytes = [], 0
            self._parts = (*self._parts[1 - PARTS :], Record(before.structure, before.state, self._last))
        self._last.append(entry)
        self._bytes += size

    def answer(self, answer: Answer) -> None:
        """Answer at once."""
        answer(None)

    def ticked(self, structure: Structure, state: State) -> None:
        """Keep nothing of a tick: it follows from the entries."""

    def entries(self) -> Sequence[Entry]:
        """Return the entries that are kept, oldest first."""
        return self.record().entries if self._parts else ()

    def record(self) -> Record:
        """Return all that is kept; there must be an entry."""
        parts = self._parts
        return Record(parts[0].structure, parts[0].state, tuple(entry for part in parts for entry in part.entries))


def weight(value: object) -> int:
    """Return about how many bytes a value takes with all that it consists of: arrays, tuples, maps, dataclasses."""
    total, seen, left = 0, set[int](), [value]
    while left:
        one = left.pop()
        if id(one) in seen:
            continue
        seen.add(id(one))
        if isinstance(one, np.ndarray):
            total += one.nbytes
            continue
        total += sys.getsizeof(one)
        if isinstance(one, (int, float, str)):
            continue
        if isinstance(one, Mapping):
            left += (*one.keys(), *one.values())
        elif isinstance(one, (tuple, list, frozenset, set)):
            left += one
        elif not isinstance(one, (type, Enum)) and hasattr(one, "__dataclass_fields__"):
            left += (getattr(one, name) for name in one.__dataclass_fields__)  # pyright: ignore
    return total


def replay(
    structure: Structure, state: State, entries: Iterable[Entry], last_tick: int, tick_seconds: float, forward: Forward
) -> Change:
    """Return the world at `last_tick`: the same commands at the same ticks give the same world, bit for bit."""
    change = Change(structure, state)
    for entry in entries:
        change = waited(change, entry.tick, tick_seconds, forward)
        change = apply(change.structure, change.state, entry.commands, forward)
    return waited(change, last_tick, tick_seconds, forward)


def waited(change: Change, tick: int, tick_seconds: float, forward: Forward) -> Change:
    """Return the world at a later tick, when nothing is done until then."""
    state = change.state
    while state.tick < tick:
        told = state.readings or None, state.dynamics, state.moved_parts, state.told_contacts
        if not state.motions and all(one is None for one in told):
            state = replace(state, tick=tick)  # nothing but time goes on
            break
        state = advance(change.structure, state, tick_seconds, forward)
    return Change(change.structure, state)
