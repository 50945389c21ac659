"""Pace of stepped time beside the wall clock, so that people can watch."""

from __future__ import annotations

import time


class Pace:
    """Keeps stepped time from running ahead of the wall clock, from its making on."""

    def __init__(self, factor: float) -> None:
        """Take simulated seconds for each second of the wall clock; 0: as fast as it can be."""
        self._factor = factor
        self._begun = time.monotonic()

    def keep(self, now: float) -> None:
        """Sleep until the wall clock has come to a simulation time since it began (s)."""
        if self._factor > 0.0:
            time.sleep(max(0.0, self._begun + now / self._factor - time.monotonic()))
