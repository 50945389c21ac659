"""Verification: a replay against the hash of every tick that was."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.history.replay import Cursor, Replay
from virtualrobot_kernel.history.tick_hash import BYTES, TickHashes, differing_robots


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
    begun = cursor.state.tick
    same, last = 0, begun
    hashes_now = TickHashes()
    for first, blob in hashes:
        for place in range(len(blob) // BYTES):
            tick = first + place
            if tick <= last:
                continue  # before what is kept, or written twice
            while cursor.state.tick < tick - 1:
                cursor.step()
            cursor.tick()
            told(tick)
            wanted = blob[place * BYTES : (place + 1) * BYTES]
            found = hashes_now.of(cursor.structure, cursor.state)
            if wanted != found:
                return _different(replay, cursor, same, tick - begun - 1 - same, wanted, found)
            cursor.settle()
            same, last = same + 1, tick
    return Verdict(same, replay.last_tick - begun - same, warnings=tuple(replay.warnings.values()))


def _different(replay: Replay, cursor: Cursor, same: int, without: int, wanted: bytes, found: bytes) -> Verdict:
    structure, state = cursor.structure, cursor.state
    uids = differing_robots(structure, wanted, found)
    # What stands still for certain is none of them, if another one moves.
    moving = [uid for uid in uids if np.any(state.v[structure.robots[uid].v_slice])]
    names = tuple(structure.nodes[uid].name for uid in (moving if len(uids) > 1 and moving else uids))
    warnings = tuple(replay.warnings.values())
    return Verdict(same, without, cursor.state.tick, names, cursor.moment.number, warnings)
