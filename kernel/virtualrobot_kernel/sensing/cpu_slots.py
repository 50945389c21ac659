"""Slots of computing: sensors in this process take turns, one core less than there are, so that calls have one.

Ten lidars that are due in the same tick would otherwise be ten threads on two cores, and a call would wait behind them
all: measured, its 99th percentile was ten times as long.
"""

from __future__ import annotations

import contextlib
import queue
from collections.abc import Callable

from virtualrobot_kernel.background import spare_cores

PATIENCE_SECONDS = 1.0
"""Longest time (s) to wait for a turn: whoever hangs holds up nobody for longer."""


class CpuSlots:
    """As many turns as there are cores, but one; any thread may ask."""

    def __init__(self, count: int | None = None) -> None:
        """Have `count` turns; None means those of this machine."""
        # A queue rather than a semaphore: waiting and waking is compiled, so nobody is held up in the middle of it.
        self._free: queue.SimpleQueue[None] = queue.SimpleQueue()
        for _ in range(count or spare_cores()):
            self._free.put(None)

    def take(self, seconds: float = PATIENCE_SECONDS) -> Callable[[], None]:
        """Wait for a turn, at most so long, and return what gives it back; calling that again does nothing."""
        try:
            self._free.get(timeout=seconds)
        except queue.Empty:
            return lambda: None
        given_back: list[None] = [None]

        def give_back() -> None:
            with contextlib.suppress(IndexError):
                self._free.put(given_back.pop())

        return give_back
