"""Efforts that motors have exerted in the latest ticks, for whoever tells of them; the world does without."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.state import Snapshot

KEPT = 512
"""Number of ticks of which they are kept: who tells every tick may be a little late."""


class _Tick(NamedTuple):
    """Efforts at the end of a tick (N m, N), and the joints (robot uid, name) whose motors exerted them."""

    tick: int
    joints: tuple[tuple[int, str], ...]
    efforts: NDArray[np.float64]


class Exerted:
    """Efforts of the latest ticks. The world's thread keeps them, any thread reads them."""

    def __init__(self) -> None:
        """Begin with none."""
        self._ticks: list[_Tick | None] = [None] * KEPT
        self._last: _Tick | None = None

    def keep(self, tick: int, joints: tuple[tuple[int, str], ...], efforts: NDArray[np.float64]) -> None:
        """Keep the efforts (m,) of joints that led to a tick."""
        self._ticks[tick % KEPT] = self._last = _Tick(tick, joints, efforts)

    def forget(self) -> None:
        """Forget all: nothing moves by forces any more."""
        self._last, self._ticks = None, [None] * KEPT

    def of(self, snapshot: Snapshot, robot: int) -> list[float]:
        """Return what the motors of a robot (a uid) exerted, in the order of its velocities; nothing where none did.

        While all rests, motors exert what they did last.
        """
        last, index = self._last, snapshot.structure.robots[robot]
        if last is None or robot not in snapshot.state.motored:
            return []
        tick = self._ticks[snapshot.state.tick % KEPT]
        if tick is None or tick.tick != snapshot.state.tick:
            if last.tick > snapshot.state.tick:
                return []
            tick = last
        found = np.zeros(index.v_slice.stop - index.v_slice.start)
        for (uid, name), effort in zip(tick.joints, tick.efforts.tolist(), strict=True):
            if uid == robot and (coordinate := index.coordinates.get(name)) is not None:
                found[coordinate.v - index.v_slice.start] = effort
        return found.tolist()
