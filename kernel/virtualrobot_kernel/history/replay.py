"""Replay: the past of a world at any moment, made again from checkpoints and entries. It plans nothing and asks nobody.

Between two checkpoints the world is kept at moments that take a quarter of a second to come to, so that every other one
is as near; states are immutable, and what didn't change is shared.
"""

from __future__ import annotations

import threading
import time
from bisect import bisect_right, insort
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.recovery import empty_world, entry, moment_of
from virtualrobot_kernel.history.rows import Row
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.upkeep import Moment
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.journal import waited
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tick import advance

APART_SECONDS = 0.25
"""Time (s) of a core between two moments that are kept."""

MOST_WARNINGS = 20
"""Number of entries that can't be repeated and are told one by one."""


@dataclass(frozen=True, slots=True, eq=False)
class _Kept:
    tick: int
    number: int
    moment: Callable[[], Moment]

    @property
    def place(self) -> tuple[int, int]:
        """Return the order of moments: by tick, and within a tick by entry."""
        return self.tick, self.number


class Replay:
    """Past of a world as a store has it."""

    def __init__(
        self, store: Store, codec: Codec, tick_seconds: float, forward: Forward, last_tick: int | None = None
    ) -> None:
        """Prepare for the ticks from the first one that is kept to `last_tick` (None: of which the store tells).

        Raises KernelError when there is nothing to begin from.
        """
        self.store, self._codec = store, codec
        self._tick_seconds, self._forward = tick_seconds, forward
        self._keeping = threading.Lock()
        self._kept: list[_Kept] = []
        self.warnings: dict[int, str] = {}
        """Entries that could not be repeated, in words by their number."""
        if not store.forgotten:
            self._kept.append(_Kept(0, 0, empty_world))
        self._kept += (
            _Kept(head.tick, head.seq, partial(moment_of, store, codec, head)) for head in store.checkpoints()
        )
        self._kept = sorted((one for one in self._kept if one.number >= store.forgotten), key=lambda one: one.place)
        if not self._kept:
            raise store.damaged(f"the entries up to {store.forgotten} were thinned out, and no checkpoint is left")
        self.first_tick = self._kept[0].tick
        self.last_tick = max(store.last_tick, self.first_tick, last_tick or 0)

    def at(self, tick: int) -> Cursor:
        """Return the world at a tick, with all that was done in it; one before the first or after the last is that."""
        tick = min(max(tick, self.first_tick), self.last_tick)
        kept = self._kept[max(bisect_right(self._kept, (tick, -1), key=lambda one: one.place) - 1, 0)]
        cursor = Cursor(self, kept.moment())
        cursor.go_to(tick)
        return cursor

    @property
    def newest(self) -> Structure:
        """Structure of the last moment that is at hand, without going through what came after it."""
        return self._kept[-1].moment().structure

    def begin(self) -> Cursor:
        """Return the world at the first moment that is kept, before what was done in its tick."""
        return Cursor(self, self._kept[0].moment())

    def keep_moments(self, going_on: Callable[[], bool] = lambda: True) -> None:
        """Go through all of the past once and keep moments on the way, while `going_on` says so."""
        cursor = self.begin()
        cursor.settle()
        began = time.thread_time()
        while cursor.state.tick < self.last_tick and going_on():
            cursor.step()
            if time.thread_time() - began >= APART_SECONDS:
                self._keep(cursor.moment)
                began = time.thread_time()

    def ticked(self, structure: Structure, state: State) -> State:
        """Return a state one tick later."""
        return advance(structure, state, self._tick_seconds, self._forward)

    def waited(self, structure: Structure, state: State, tick: int) -> State:
        """Return a state at a later tick, when nothing is done until then."""
        return waited(Change(structure, state), tick, self._tick_seconds, self._forward).state

    def done(self, moment: Moment, row: Row) -> Moment:
        """Return the world after an entry; one that can't be repeated is left out and told in `warnings`.

        Raises KernelError, which names the entry, when it was written by a newer program, or is damaged.
        """
        structure, state, commands = moment.structure, moment.state, entry(row, self._codec).commands
        try:
            change = apply(structure, state, commands, self._forward)
            structure, state = change.structure, change.state
        except KernelError as error:
            if len(self.warnings) < MOST_WARNINGS:
                self.warnings[row.seq] = f"entry {row.seq} by {row.author or 'nobody'} can't be repeated: {error}"
        return Moment(row.seq, structure, state)

    def _keep(self, moment: Moment) -> None:
        with self._keeping:
            kept = _Kept(moment.state.tick, moment.number, lambda: moment)
            insort(self._kept, kept, key=lambda one: one.place)


class Cursor:
    """Moment that goes forward through a replay; used by one thread."""

    def __init__(self, replay: Replay, moment: Moment) -> None:
        """Begin at a moment."""
        self._replay = replay
        self.moment = moment
        self._rows: Iterator[Row] = replay.store.rows(moment.number)
        self._next = next(self._rows, None)

    @property
    def structure(self) -> Structure:
        """Return the world's structure at this moment."""
        return self.moment.structure

    @property
    def state(self) -> State:
        """Return the world's state at this moment."""
        return self.moment.state

    def settle(self) -> None:
        """Do what was done in this tick."""
        while self._next is not None and self._next.tick <= self.state.tick:
            self.moment = self._replay.done(self.moment, self._next)
            self._next = next(self._rows, None)

    def tick(self) -> None:
        """Let time go on by a tick, in which nothing is done yet."""
        state = self._replay.ticked(self.structure, self.state)
        self.moment = replace(self.moment, state=state)

    def step(self) -> None:
        """Let time go on by a tick, and do what was done in it."""
        self.tick()
        self.settle()

    def go_to(self, tick: int) -> None:
        """Let time go on to a tick, and do what was done until then and in it."""
        self.settle()
        while self.state.tick < tick:
            until = tick if self._next is None else min(tick, self._next.tick)
            self.moment = replace(self.moment, state=self._replay.waited(self.structure, self.state, until))
            self.settle()
