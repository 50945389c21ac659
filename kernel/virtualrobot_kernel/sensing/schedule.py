"""Schedule of a sensor's readings: which are due, and what each is given of the world."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.state import Snapshot


@dataclass(slots=True)
class Schedule:
    """Schedule of readings: number k at the first tick at or after k periods from the start, so without drift.

    Attributes:
        start: the tick at which the sensor was started.
        period: ticks between readings, 1 or more.
        count: how many have been due so far.
    """

    start: int
    period: float
    count: int = 0

    def due(self, tick: int) -> int:
        """Return how many have become due since this was last asked."""
        # A tick that is late only by rounding is in time: 0.1 s are 25 ticks of 4 ms.
        count = math.floor((tick - self.start) / self.period + 1e-6)
        new, self.count = max(count - self.count, 0), max(count, self.count)
        return new


@dataclass(frozen=True, slots=True, eq=False)
class Instant:
    """The world at one tick, and ticks before it, the oldest first."""

    snapshot: Snapshot
    history: tuple[Snapshot, ...]

    def moment(self, number: int, history_seconds: float, seed: int, schedule: Schedule | None) -> Moment:
        """Return what the reading `number` is given, with so much of the past, and time since its sensor's start."""
        snapshot = self.snapshot
        oldest = snapshot.state.tick - math.ceil(history_seconds / snapshot.tick_seconds - 1e-6)
        past = tuple(one for one in self.history if oldest <= one.state.tick < snapshot.state.tick)
        elapsed = snapshot.state.tick - schedule.start if schedule is not None else 0
        return Moment(snapshot, past, number, np.random.default_rng((seed, number)), elapsed)
