"""The journal: every batch of commands that was applied, with its tick and author; a run is replayed from it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tick import advance


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A batch that was applied: after how many ticks, who sent it, and what it said."""

    tick: int
    author: str
    commands: tuple[Command, ...]


class Journal(Protocol):
    """Where applied batches are written. The world thread calls `append`; anyone may read `entries`."""

    def append(self, entry: Entry) -> None:
        """Write one entry at the end."""
        ...

    def entries(self) -> Sequence[Entry]:
        """Return all entries, oldest first."""
        ...


class MemoryJournal:
    """Keeps the entries in memory."""

    def __init__(self) -> None:
        """Begin empty."""
        self._entries: list[Entry] = []

    def append(self, entry: Entry) -> None:
        """Write one entry at the end."""
        self._entries.append(entry)

    def entries(self) -> Sequence[Entry]:
        """Return all entries, oldest first."""
        return tuple(self._entries)


def replay(
    structure: Structure, state: State, entries: Iterable[Entry], last_tick: int, tick_seconds: float, forward: Forward
) -> Change:
    """Return the world at `last_tick`: the same commands at the same ticks give the same world, bit for bit."""
    change = Change(structure, state)
    for entry in entries:
        change = _waited(change, entry.tick, tick_seconds, forward)
        change = apply(change.structure, change.state, entry.commands, forward)
    return _waited(change, last_tick, tick_seconds, forward)


def _waited(change: Change, tick: int, tick_seconds: float, forward: Forward) -> Change:
    state = change.state
    while state.tick < tick:
        state = advance(change.structure, state, tick_seconds, forward)
    return Change(change.structure, state)
