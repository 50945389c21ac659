"""Upkeep of the store in a thread of its own: hashes of ticks, checkpoints, thinning, and what SQLite has to tidy."""

from __future__ import annotations

import logging
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.background import let_others_go_on
from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.documents import Parts
from virtualrobot_kernel.history.last_tick import LastTick
from virtualrobot_kernel.history.rows import CheckpointRow
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.tick_hash import TICKS_AT_ONCE, hashes_of
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure

ROUND_SECONDS = 1.0
"""Time (s) between two rounds: so much may be lost with the power where not each answer is safe from that."""

GATHERED_SECONDS = 0.02
"""Time (s) that entries wait for others where somebody waits for what becomes of them."""

MEBIBYTE = 1024 * 1024

KERNEL = "kernel"
"""Author of checkpoints that nobody asked for."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Rules:
    """Rules of when a checkpoint is made, and of what is kept of the history.

    Attributes:
        entries: so many of them make a checkpoint due,
        bytes: or so many bytes in them,
        motion_ticks: or so many ticks of motions: they take about ten seconds to be made again.
        most_bytes: greatest size of the store; the oldest entries go.
        most_seconds: greatest age of an entry, about; None: any.
    """

    entries: int = 50_000
    bytes: int = 64 * MEBIBYTE
    motion_ticks: int = 250_000
    most_bytes: int = 4096 * MEBIBYTE
    most_seconds: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """World as it is after an entry and all ticks up to its own."""

    number: int
    structure: Structure
    state: State


class _Tick(NamedTuple):
    """Tick as far as its hash needs it: whole states of a second would take up the processor's caches."""

    tick: int
    structure: Structure
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    motions: int


class Upkeep:
    """Thread that looks after the store once a second."""

    def __init__(
        self,
        store: Store,
        codec: Codec,
        rules: Rules,
        begin: Moment,
        last_tick: LastTick | None = None,
        settle: Callable[[], None] = lambda: None,
    ) -> None:
        """Look after `store` from the moment `begin` on.

        Args:
            store: the journal.
            codec: how it is written.
            rules: what is kept how long.
            begin: the moment whose entries are all in it.
            last_tick: gets the number of each tick, if there is one.
            settle: has all written that was told (`Journal.settle`).
        """
        self._store = store
        self._codec = codec
        self.rules = rules
        self._last_tick = last_tick
        self._settle = settle
        self._parts = Parts()
        self._ticks: deque[_Tick] = deque()
        self._hashes: tuple[int, bytes] | None = None
        self._latest = begin
        self._entries = self._bytes = self._motion_ticks = 0
        self._checkpointing, self._looking_after = threading.Lock(), threading.Lock()
        self._failed = False
        self._ended, self._hurried = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="history upkeep", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self, checkpoint: bool = False) -> None:
        """End the thread and finish what it has begun; with a checkpoint the next kernel begins from it at once."""
        self._ended.set()
        self._hurried.set()
        if self._thread.is_alive():
            self._thread.join(10.0)
        self.look_after()
        if checkpoint and not self._failed:
            self.checkpoint()

    def hurry(self) -> None:
        """Have entries kept soon."""
        if not self._hurried.is_set():
            self._hurried.set()

    def ticked(self, structure: Structure, state: State) -> None:
        """Note a tick; the world thread calls it."""
        self._ticks.append(_Tick(state.tick, structure, state.q, state.v, len(state.motions)))
        if self._last_tick is not None:
            self._last_tick.write(state.tick)

    def kept(self, entries: int, bytes: int) -> None:
        """Note that so many entries more are kept, with so many bytes in all."""
        self._entries += entries
        self._bytes += bytes

    def settled(self, now: Moment) -> None:
        """Note a moment whose entries are all kept: it is the one that checkpoints are of."""
        self._latest = now

    def checkpoint(self, name: str = "", author: str = KERNEL, past: Moment | None = None) -> int:
        """Write the world as a checkpoint and return its id, from any thread.

        As it was in the `past`, else as it was when the journal was settled last.
        """
        with self._checkpointing:
            now = past or self._latest
            if past is None:
                self._entries = self._bytes = self._motion_ticks = 0
            try:
                written = self._codec.encode_in_parts(image_of(now.structure, now.state), self._parts)
                tick, nodes, parts = now.state.tick, len(now.structure.nodes), tuple(written.parts)
                row = CheckpointRow(0, now.number, tick, name, author, time.time(), nodes, written.body, parts)
                return self._store.add_checkpoint(row, written.fresh)
            except BaseException:
                self._parts = Parts()  # some of them may not have been written
                raise

    def remove_checkpoints(self, ids: Sequence[int]) -> None:
        """Take checkpoints out of the store, with the parts that no other one has."""
        with self._checkpointing:
            self._parts = Parts()
            self._store.remove_checkpoints(ids)

    def _run(self) -> None:
        due = time.monotonic() + ROUND_SECONDS
        while not self._ended.is_set():
            if self._hurried.wait(max(0.0, due - time.monotonic())):
                self._ended.wait(GATHERED_SECONDS)
                self._hurried.clear()
                self._settle()
            if time.monotonic() >= due and not self._ended.is_set():
                self.look_after()
                due = time.monotonic() + ROUND_SECONDS

    def look_after(self) -> None:
        """Do what is due."""
        with self._looking_after:
            self._do_what_is_due()

    def _do_what_is_due(self) -> None:
        try:
            self._hash()
            self._store.tidy()
            if self._is_due():
                self.checkpoint()
            self._thin()
        except Exception as error:
            if not self._failed:
                is_disk = isinstance(error, (sqlite3.Error, OSError))  # it is full, or gone: no fault of the program's
                trace = error if not is_disk or log.isEnabledFor(logging.DEBUG) else None
                log.error("the history can't be looked after; it is tried again: %s", error, exc_info=trace)
            self._failed = True
        else:
            self._failed = False

    def _hash(self) -> None:
        """Write the hashes of the ticks since the last round; those that can't be written wait for the next one."""
        count = len(self._ticks)
        self._settle()  # entries of ticks whose hashes are written are written
        first, hashes = self._hashes or (self._ticks[0].tick if count else 0, b"")
        for at in range(0, count, TICKS_AT_ONCE):
            ticks = [self._ticks.popleft() for _ in range(min(TICKS_AT_ONCE, count - at))]
            hashes += hashes_of((one.structure, one) for one in ticks)
            self._motion_ticks += sum(one.motions for one in ticks)
            let_others_go_on()
        if hashes:
            self._hashes = first, hashes
            self._store.add_hashes(first, hashes)
            self._hashes = None

    def _is_due(self) -> bool:
        """Return whether replaying from the last checkpoint takes too long."""
        rules = self.rules
        return self._entries >= rules.entries or self._bytes >= rules.bytes or self._motion_ticks >= rules.motion_ticks

    def _thin(self) -> None:
        """Forget the oldest entries, up to a checkpoint, where the rules want it."""
        begin = self._wanted_begin()
        if begin is None or begin.seq <= self._store.forgotten:
            return
        self.remove_checkpoints([one.id for one in self._store.begin_with(begin) if not one.name])

    def _wanted_begin(self) -> CheckpointRow | None:
        """Return the checkpoint with which the history shall begin; None leaves it as it is."""
        store, rules = self._store, self.rules
        wanted = None
        if rules.most_seconds is not None:
            oldest = time.time() - rules.most_seconds
            old = [one for one in store.checkpoints() if one.time < oldest]
            wanted = max(old, key=lambda one: one.seq, default=None)
        size, last, forgotten = store.size_bytes, store.last_seq, store.forgotten
        if size > rules.most_bytes:
            # To seven eighths, so that it isn't done all the time.
            cut = forgotten + (last - forgotten) * (1.0 - rules.most_bytes * 0.875 / size)
            if not any(one.seq >= cut for one in store.checkpoints()):
                self.checkpoint()
            fits = min((one for one in store.checkpoints() if one.seq >= cut), key=lambda one: one.seq)
            wanted = fits if wanted is None else max(wanted, fits, key=lambda one: one.seq)
        return wanted
