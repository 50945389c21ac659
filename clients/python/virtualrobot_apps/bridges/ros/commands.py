"""Commands of a twist to a craft: the newest counts, and one that nobody repeats ends in a stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.streams.publishing import Publisher

WATCHDOG_SECONDS = 0.5
"""Simulation time after which a craft that has got no new twist stops."""

_BRAKING_SECONDS = 5.0
"""Time (s) in which a craft whose twists came too late may still be braking, and takes no others."""


class TwistCommands:
    """Twists of one craft, sent by a thread of their own; a context that ends stops the craft."""

    def __init__(self, client: Client, stream: str, say: Callable[[str], None]) -> None:
        """Send nothing yet; the craft is free until the first twist."""
        self._client, self._stream, self._say = client, stream, say
        self._changed = threading.Condition()
        self._newest: Sequence[float] | None = None
        self._closed = False
        self._thread: threading.Thread | None = None
        self._said = ""
        self._ended = float("-inf")

    def send(self, twist: Sequence[float]) -> None:
        """Take a twist (vx, vy, omega) in m/s and rad/s; returns at once."""
        with self._changed:
            self._newest = twist
            self._changed.notify()
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name=f"twists of {self._stream}", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """Stop the craft."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        publisher: Publisher | None = None
        while (twist := self._next()) is not None:
            # The kernel ends a motion that gets nothing for half a second: the next twist begins another one.
            for _ in range(2):
                try:
                    if publisher is None:
                        publisher = self._client.streams.publisher(self._stream, timeout=WATCHDOG_SECONDS)
                    publisher.send(twist)
                    self._said = ""
                    break
                except VirtualRobotError as error:
                    began, publisher = publisher is None, None
                    if not began:
                        self._ended = time.monotonic()
                    elif time.monotonic() - self._ended > _BRAKING_SECONDS:
                        self._tell(str(error))
                        break
        if publisher is not None:
            try:
                publisher.close()
            except VirtualRobotError:
                pass  # it has stopped already

    def _next(self) -> Sequence[float] | None:
        with self._changed:
            while self._newest is None and not self._closed:
                self._changed.wait()
            twist, self._newest = self._newest, None
            return None if self._closed else twist

    def _tell(self, words: str) -> None:
        if words != self._said:
            self._say(f"{self._stream}: a twist is not taken: {words}")
        self._said = words
