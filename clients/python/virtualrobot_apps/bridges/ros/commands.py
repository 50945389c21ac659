"""Commands of a twist to a craft: the newest counts, and one that nobody repeats ends in a stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence

from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, LimitError, PluginFailedError, VirtualRobotError
from virtualrobot.streams.publishing import Publisher

from virtualrobot_apps.bridges.ros.hub import Refused

WATCHDOG_SECONDS = 0.5
"""Simulation time after which a craft that has got no new twist stops."""

_LOOK_SECONDS = 0.1
"""Time (s) after which it is seen whether the last twist was refused, where no other comes."""

_BRAKING_SECONDS = 5.0
"""Time (s) in which a craft whose twists came too late may still be braking, and takes no others."""


class TwistCommands:
    """Twists of one craft, sent by a thread of their own; a context that ends stops the craft."""

    def __init__(self, client: Client, stream: str, say: Callable[[str], None]) -> None:
        """Send nothing yet; the craft is free until the first twist."""
        self._client, self._stream, self._say = client, stream, say
        self._changed = threading.Condition()
        self._newest: tuple[Sequence[float], Refused] | None = None
        self._closed = False
        self._thread: threading.Thread | None = None
        self._said = ""
        self._ended = float("-inf")

    def send(self, twist: Sequence[float], refused: Refused) -> None:
        """Take a twist (vx, vy, omega; m/s, rad/s); returns at once. What is refused is said, also to `refused`."""
        with self._changed:
            self._newest = twist, refused
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
        refused: Refused = self._say
        while (newest := self._next(publisher is not None)) is not None:
            if publisher is not None and self._has_ended(publisher, refused):
                publisher = None
            if not newest:
                continue
            twist, refused = newest
            # The kernel ends a motion that gets nothing for half a second: the next twist begins another one.
            try:
                if publisher is None:
                    publisher = self._client.streams.publisher(self._stream, timeout=WATCHDOG_SECONDS)
                publisher.send(twist)
                self._said = ""
            except VirtualRobotError as error:
                if publisher is not None:
                    self._has_ended(publisher, refused)
                elif time.monotonic() - self._ended > _BRAKING_SECONDS:
                    self._tell(str(error), refused)
                publisher = None
        if publisher is not None:
            try:
                publisher.close()
            except VirtualRobotError:
                pass  # it has stopped already

    def _next(self, is_open: bool) -> tuple[Sequence[float], Refused] | tuple[()] | None:
        """Return the newest twist, nothing when it is time to look after the last, None at the end."""
        with self._changed:
            while self._newest is None and not self._closed:
                if not self._changed.wait(_LOOK_SECONDS if is_open else None):
                    return ()
            newest, self._newest = self._newest, None
            return None if self._closed else newest

    def _has_ended(self, publisher: Publisher, refused: Refused) -> bool:
        """Return whether a craft follows no more; where its kernel has refused the last twist, that is told."""
        try:
            publisher.check()
        except VirtualRobotError as error:
            self._ended = time.monotonic()
            if isinstance(error, InvalidArgumentError | LimitError | PluginFailedError):
                self._tell(str(error), refused)
            return True
        return False

    def _tell(self, words: str, refused: Refused) -> None:
        refused(words)
        if words != self._said:
            self._say(f"{self._stream}: a twist is not taken: {words}")
        self._said = words
