"""Who computes: sensors in this process take turns, one core less than there are, so that calls and ticks have one.

Ten lidars that are due in the same tick would otherwise be ten threads on two cores, and a call would wait behind them
all: measured, its 99th percentile was ten times as long.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable

PATIENCE_SECONDS = 1.0
"""How long to wait for a turn: whoever hangs holds up nobody for longer."""


class Turns:
    """As many turns as there are cores, but one; any thread may ask."""

    def __init__(self, count: int | None = None) -> None:
        """Have `count` turns; None means those of this machine."""
        self._free = threading.Semaphore(count or max(1, len(os.sched_getaffinity(0)) - 1))

    def take(self, seconds: float = PATIENCE_SECONDS) -> Callable[[], None]:
        """Wait for a turn, at most so long, and return what gives it back; calling that again does nothing."""
        if not self._free.acquire(timeout=seconds):
            return lambda: None
        given_back = threading.Lock()

        def give_back() -> None:
            if given_back.acquire(blocking=False):
                self._free.release()

        return give_back
