"""Clock of the world: due times of ticks. Time is a count of equal ticks; only this file looks at the wall clock."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

CATCH_UP_SECONDS = 0.05
"""Lateness that is caught up by ticks in quick succession; beyond it simulation time falls behind."""

FACTOR_WINDOW_SECONDS = 0.5
"""Window of the wall clock over which the real-time factor is measured, about."""


class Mode(Enum):
    """Mode of the clock: ticks follow the wall clock, or come only when they are asked for."""

    REALTIME = "realtime"
    STEPPED = "stepped"


@dataclass(frozen=True, slots=True)
class Recorded:
    """Ticks that a replay has, from the first one to the last."""

    first_tick: int
    last_tick: int


@dataclass(frozen=True, slots=True)
class Clock:
    """Mode, speed and measured punctuality of time; `tick_nanoseconds` is the length of a tick in simulation time.

    recorded: what a replay has; None where time makes what comes.
    """

    mode: Mode
    speed_factor: float
    tick_nanoseconds: int
    real_time_factor: float = 0.0
    late_ticks: int = 0
    recorded: Recorded | None = None

    @property
    def tick_seconds(self) -> float:
        """Return the length of a tick in seconds of simulation time."""
        return self.tick_nanoseconds * 1e-9


class Pacer:
    """Due times of ticks on a monotonic wall clock; a late tick is never merged with the next.

    Attributes:
        clock: how time runs.
        catch_up_seconds: lateness that is caught up, see `CATCH_UP_SECONDS`.
        made: when the tick that was begun last was due, in seconds of that clock.
    """

    def __init__(self, clock: Clock, now: float) -> None:
        """Begin at `now`, in seconds of a monotonic clock."""
        self.clock = clock
        self.catch_up_seconds = CATCH_UP_SECONDS
        self.made = now
        self._due = now + self._period
        self._window = (now, 0)

    @property
    def _period(self) -> float:
        return self.clock.tick_seconds / self.clock.speed_factor

    def set(self, mode: Mode, speed_factor: float, now: float) -> None:
        """Change mode and speed factor; the next tick is due one period from now."""
        self.clock = replace(self.clock, mode=mode, speed_factor=speed_factor, real_time_factor=0.0)
        self._due = now + self._period
        self._window = (now, 0)

    def wait_seconds(self, now: float) -> float | None:
        """Return the time (s) until the next tick is due (0: now), or None when ticks only come by Step."""
        return max(0.0, self._due - now) if self.clock.mode is Mode.REALTIME else None

    def ticked(self, now: float) -> None:
        """Note that a tick was begun in REALTIME at `now`."""
        late, self.made = now - self._due, self._due
        if late > self._period:
            self.clock = replace(self.clock, late_ticks=self.clock.late_ticks + 1)
        self._due = self._due + self._period if late < self.catch_up_seconds else now + self._period
        since, count = self._window
        self._window = (since, count + 1)
        if now - since >= FACTOR_WINDOW_SECONDS:
            reached = (count + 1) * self.clock.tick_seconds / (now - since)
            self.clock = replace(self.clock, real_time_factor=reached)
            self._window = (now, 0)
