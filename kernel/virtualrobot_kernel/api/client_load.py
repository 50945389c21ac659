"""Load that each client puts on the server: its calls in this second, and its open streams; used in one event loop."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from virtualrobot_kernel.api.limits import Limits
from virtualrobot_kernel.errors import Reason

STOPPING = frozenset(f"/virtualrobot.v1.MotionService/{name}" for name in ("Stop", "CancelMotion", "PauseMotion"))
"""Methods that nobody is kept from, whatever he has asked for before."""


class ClientLoad:
    """Counts by client: the name of a token, or the connection of who has the kernel's own."""

    def __init__(self, limits: Limits, now: Callable[[], float] = time.monotonic) -> None:
        """Allow what the limits `calls_per_second` and `streams` say; `now` is a clock in seconds."""
        self._limits, self._now = limits, now
        self._second = 0
        self._calls: Counter[str] = Counter()
        self._streams: Counter[str] = Counter()

    @contextmanager
    def of(self, client: str, method: str, is_stream: bool) -> Iterator[None]:
        """Count a call for the length of a block; raise KernelError for one that is too many."""
        if (second := int(self._now())) != self._second:
            self._second = second
            self._calls.clear()
        self._calls[client] += 1
        if self._calls[client] > self._limits.calls_per_second and method not in STOPPING:
            what = "a client may make {limit:,} calls a second; this is number {asked:,}"
            raise self._limits.refusal("calls_per_second", self._calls[client], what, Reason.TOO_MANY_CALLS)
        if not is_stream:
            yield
            return
        if self._streams[client] >= self._limits.streams:
            what = "a client may have {limit:,} streams open at a time; this would be number {asked:,}"
            raise self._limits.refusal("streams", self._streams[client] + 1, what, Reason.TOO_MANY_CALLS)
        self._streams[client] += 1
        try:
            yield
        finally:
            self._streams[client] -= 1
            if not self._streams[client]:
                del self._streams[client]
