"""Verification: a replay against the hash of every tick that was."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.replay import Cursor, Replay
from virtualrobot_kernel.history.tick_hash import BYTES, TICKS_AT_ONCE, differing_robots, hashes_of
from virtualrobot_kernel.world.structure import Structure


@dataclass(frozen=True, slots=True)
class Verdict:
    """Result of a verification.

    Attributes:
        ticks: how many were the same.
        without_hash: how many had no hash to compare with, as after the kernel was killed.
        tick: the first one that differs; None where none does.
        robots: names of the robots that it differs by: one, where the hash tells them apart.
        entry: the number of the last entry before it.
        warnings: what could not be repeated.
    """

    ticks: int
    without_hash: int
    tick: int | None = None
    robots: tuple[str, ...] = ()
    entry: int = 0
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return the result in words."""
        left = f"; {self.without_hash} had no hash" if self.without_hash else ""
        if self.tick is None:
            return f"{self.ticks} ticks are the same{left}"
        which = " or ".join(map(repr, self.robots[:8])) or "no robot"
        where = f"tick {self.tick} differs, by {which}, after entry {self.entry}"
        return f"{where}; {self.ticks} before it are the same{left}"


def verify(
    replay: Replay, hashes: Iterable[tuple[int, bytes]], told: Callable[[int], None] = lambda tick: None
) -> Verdict:
    """Return whether a replay comes to the same joints in every tick of which a hash was written.

    Args:
        replay: what is verified, from its first moment on.
        hashes: (first tick, hashes of it and of those after it), in order.
        told: is called with each tick in turn.

    Raises KernelError, which names what is damaged.
    """
    cursor = replay.begin()
    cursor.settle()
    begun, same = cursor.state.tick, 0
    ticks = _ticks(cursor, hashes)
    while True:
        block, failed = _block(ticks)
        found = hashes_of((one.structure, one) for one in block)
        for place, one in enumerate(block):
            told(one.tick)
            if (hash := found[place * BYTES : (place + 1) * BYTES]) != one.wanted:
                names = _moving(one, differing_robots(one.structure, one.wanted, hash))
                without = one.tick - begun - 1 - same
                return Verdict(same, without, one.tick, names, one.entry, tuple(replay.warnings.values()))
            same += 1
        if failed is not None:  # after the ticks before it: what differs first is told
            raise failed
        if not block:
            return Verdict(same, replay.last_tick - begun - same, warnings=tuple(replay.warnings.values()))


class _Tick(NamedTuple):
    """Tick of a replay, before what was done in it: the hash that it had, and the last entry before it.

    Of the world as much as the hash needs: whole states of a block would take up the processor's caches.
    """

    tick: int
    wanted: bytes
    structure: Structure
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    entry: int


def _ticks(cursor: Cursor, hashes: Iterable[tuple[int, bytes]]) -> Iterator[_Tick]:
    """Yield the ticks of which there are hashes."""
    last = cursor.state.tick
    for first, blob in hashes:
        for tick, at in enumerate(range(0, len(blob), BYTES), first):
            if tick <= last:
                continue  # before what is kept, or written twice
            while cursor.state.tick < tick - 1:
                cursor.step()
            cursor.tick()
            state, wanted = cursor.state, blob[at : at + BYTES]
            yield _Tick(tick, wanted, cursor.structure, state.q, state.v, cursor.moment.number)
            cursor.settle()
            last = tick


def _block(ticks: Iterator[_Tick]) -> tuple[list[_Tick], KernelError | None]:
    """Return the next ticks, whose hashes are made together, and the error that has ended them."""
    block: list[_Tick] = []
    try:
        for one in islice(ticks, TICKS_AT_ONCE):
            block.append(one)
    except KernelError as error:
        return block, error
    return block, None


def _moving(tick: _Tick, uids: Sequence[int]) -> tuple[str, ...]:
    """Return the names of robots; of several those alone that move: what stands still for certain is none of them."""
    structure, v = tick.structure, tick.v
    moving = [uid for uid in uids if np.any(v[structure.robots[uid].v_slice])]
    return tuple(structure.nodes[uid].name for uid in (moving if len(uids) > 1 and moving else uids))
