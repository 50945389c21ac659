"""Time that goes as slowly as a film of it is drawn, once too many of its pictures wait."""

from __future__ import annotations

import time
from collections.abc import Callable

from virtualrobot.clock import Clock
from virtualrobot.view.pictures import Picture

MOST_BEHIND, LEAST_BEHIND = 3_000, 1_500
"""Waiting pictures above which time goes slower, until no more than the second number wait; the kernel keeps 10,000."""
SHARE = 0.8
"""Rate of new pictures as part of those that are drawn while time goes slower: so fewer and fewer wait."""
SLOWEST = 0.01
"""The least factor that a clock takes."""


class Pace:
    """Sets a clock's speed by how far the drawing of a film is behind; `told` is told each picture.

    Until the first picture is drawn, time goes no faster than the wall clock; then as fast as before, and, from
    MOST_BEHIND pictures that wait until LEAST_BEHIND, a little slower than they are drawn.
    """

    def __init__(self, clock: Clock, rate: float, now: Callable[[], float] = time.monotonic) -> None:
        """Begin; `rate` is that of the film, in pictures a second of simulation time, `now` tells seconds."""
        self._clock, self._rate, self._now = clock, rate, now
        self.wanted = clock.speed_factor
        self._speed = self.wanted
        self.slow = False
        self._last: float | None = None
        self._seconds = 0.0
        self._set(min(self.wanted, 1.0))

    def told(self, picture: Picture) -> None:
        """Set the speed by one more picture that is drawn."""
        last, self._last = self._last, self._now()
        if last is not None:
            took = self._last - last
            self._seconds += 0.2 * (took - self._seconds) if self._seconds else took
        self.slow = picture.behind > (LEAST_BEHIND if self.slow else MOST_BEHIND)
        speed = self.wanted
        if self.slow and self._seconds > 0.0:
            speed = max(SLOWEST, min(self.wanted, SHARE / (self._seconds * self._rate)))
        # A call for each little change would cost more than it is worth.
        if speed == self.wanted or not 0.7 < speed / self._speed < 1.4:
            self._set(speed)

    def end(self) -> None:
        """Let time go as fast as before."""
        self._set(self.wanted)

    def _set(self, speed: float) -> None:
        if speed != self._speed:
            self._clock.speed_factor = speed
            self._speed = speed
