"""Readings of sensors, and their readers: one for each sensor at work, whatever its kind."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.state import Snapshot

Content = Any
"""Content of a reading: a frozen value that the sensor's reader makes; `api/convert/readings.py` tells it."""


class SensorState(Enum):
    """State of a sensor; the values are the contract's numbers."""

    STOPPED = 1
    RUNNING = 2
    FAULT = 3


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """Instant and world that a reader is given for one reading.

    Attributes:
        snapshot: the world as it is at the reading.
        history: snapshots of earlier ticks, the oldest first, as far back as the reader's `history_seconds` and as the
            sensor has run; without `snapshot`.
        number: counts the readings that were due since the sensor was started, from 1.
        rng: made of the sensor's seed and `number`, so the same in every run.
        elapsed: ticks since the sensor was started; 0 for a single reading of one that does not run.
    """

    snapshot: Snapshot
    history: tuple[Snapshot, ...]
    number: int
    rng: np.random.Generator
    elapsed: int = 0


class Reader(Protocol):
    """Makes the readings of one sensor. It is made, used and closed by one thread, the sensor's."""

    @property
    def history_seconds(self) -> float:
        """Return how much of the past it needs (simulation time); 0: none."""
        ...

    @property
    def deadline_seconds(self) -> float:
        """Return how long a reading may take on the wall clock; a sensor that takes longer has a fault."""
        ...

    @property
    def takes_turns(self) -> bool:
        """Return whether a reading keeps a core of this process busy, so that it waits for its turn."""
        ...

    def read(self, moment: Moment, kinds: object | None = None) -> Content:
        """Return what the sensor says.

        `kinds` are the kinds of pictures that a single reading asks for; None means those that the sensor is set to.
        Raises KernelError when it cannot be said: that is the sensor's fault, and it reads no more.
        """
        ...

    def close(self) -> None:
        """End what it has started."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """Reading of a sensor, or why it says nothing.

    Attributes:
        snapshot: the world as the sensor saw it.
        uid: the sensor's node.
        name: its name then.
        state: how the sensor is.
        fault: why there is no content, in words; empty where there is one.
        number: counts the readings since the sensor was started, from 1; for a single reading, those asked for.
        missed: how many readings the sensor was late for and left out so far.
        world_t_sensor: (4, 4) where the sensor was.
        content: what it said; None where it said nothing.
        seconds: how long the reading took on the wall clock.
    """

    snapshot: Snapshot
    uid: int
    name: str
    state: SensorState
    fault: str
    number: int
    missed: int
    world_t_sensor: NDArray[np.float64]
    content: Content | None
    seconds: float
