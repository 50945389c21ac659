"""Least distances for the browser: measured in a thread of their own, while pictures go on being drawn."""

from __future__ import annotations

import logging
import time
from concurrent.futures import Future, ThreadPoolExecutor

from virtualrobot_kernel.collision.bodies import made_of
from virtualrobot_kernel.collision.clearances import Clearance, Measure, Measured
from virtualrobot_kernel.world.state import Snapshot, unchanged

PERIOD_SECONDS = 0.05
"""The least time from one measuring to the next."""

REST = 2.0
"""A measuring is followed by a pause so many times as long as it took, so that it leaves time for everybody else."""

log = logging.getLogger(__name__)


class ClearanceMeter:
    """Owns the thread, which is started when first needed; asked by the drawing thread alone."""

    def __init__(self, measure: Measure) -> None:
        """Have `measure` called in the thread."""
        self._measure = measure
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="clearance")
        self._running: Future[tuple[Measured, float]] | None = None
        self._asked: tuple[object, ...] = ()
        self._found: Measured = {}
        self._due = 0.0
        self._told = ""

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown(wait=True, cancel_futures=True)

    def latest(self, snapshot: Snapshot, wanted: tuple[Clearance, ...]) -> Measured:
        """Return what was measured last of these, at once, and have it measured anew when something has moved."""
        if self._running is not None and self._running.done():
            self._take(self._running)
            self._running = None
        if not wanted:
            self._asked, self._found = (), {}
            return {}
        about = (wanted, snapshot.world_t_node, *made_of(snapshot))
        if not unchanged(self._asked, about) and self._running is None and time.monotonic() >= self._due:
            self._asked = about
            self._running = self._thread.submit(self._timed, snapshot, wanted)
        return {one: self._found[one] for one in wanted if one in self._found}

    def _timed(self, snapshot: Snapshot, wanted: tuple[Clearance, ...]) -> tuple[Measured, float]:
        began = time.monotonic()
        return self._measure(snapshot, wanted), time.monotonic() - began

    def _take(self, done: Future[tuple[Measured, float]]) -> None:
        try:
            self._found, seconds = done.result()
            self._told = ""
        except Exception as error:  # what cannot be measured must not end the picture
            if (text := f"{type(error).__name__}: {error}") != self._told:
                log.exception("distances for the viewer could not be measured")
                self._told = text
            self._found, seconds = {}, 1.0
        self._due = time.monotonic() + max(PERIOD_SECONDS - seconds, REST * seconds)
