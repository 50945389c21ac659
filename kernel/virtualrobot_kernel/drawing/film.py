"""Frames of a film: one snapshot at each equal step of simulation time, caught as they come and drawn later."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from virtualrobot_kernel.drawing.renderer import Sight
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World

MOST_BEHIND = 10_000
"""Largest number of pictures that wait to be drawn."""
MOST_BYTES = 1_000_000_000
"""Largest memory (bytes) that what waits may take."""
PARTS = 3
"""A snapshot takes about so many times the memory of its nodes' poses."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A picture to be drawn: its number from 0, and what it shows."""

    number: int
    sight: Sight


class Film:
    """Catches snapshots in the world thread and keeps them for one reader."""

    def __init__(self, world: World, sight: Callable[[Snapshot], Sight], rate: float, count: int | None) -> None:
        """Catch `rate` snapshots a second of simulation time, `count` of them or without end; see `subscribe`.

        `sight` tells how a snapshot is to be seen, at once.
        """
        self._world, self._sight = world, sight
        self._rate, self._count = rate, count
        self._waiting: deque[Frame] = deque()
        self._caught = 0
        self._start = 0
        self._told: Callable[[object], None] = lambda _: None
        self._beginning = threading.Lock()
        self._lost = 0

    def subscribe(self, told: Callable[[object], None]) -> Callable[[], None]:
        """Begin with the world as it is now; `told` is called when there is more. Return what ends it."""
        self._told = told
        with self._beginning:  # a tick that comes meanwhile waits, so that it is neither lost nor taken twice
            end = self._world.listen_ticks(self._ticked)
            self._start = self._world.snapshot.state.tick
            self._catch(self._world.snapshot)
        return end

    @property
    def behind(self) -> int:
        """Return how many pictures are still to be drawn of what has happened already."""
        return len(self._waiting)

    @property
    def is_over(self) -> bool:
        """Return whether all has been caught and taken."""
        return self._caught == self._count and not self._waiting

    def take(self) -> Frame | None:
        """Return the next picture to be drawn, None while there is none.

        Raises KernelError (TOO_LARGE) after the last one, when so many waited that no more were kept: a film whose end
        has happened already becomes whole.
        """
        if self._lost and not self._waiting:
            raise KernelError(
                f"drawing was {self._lost:,} pictures behind the simulation, and no more are kept; take smaller ones, "
                "fewer a second, or let time go slower",
                reason=Reason.TOO_LARGE,
                behind=self._lost,
            )
        return self._waiting.popleft() if self._waiting else None

    def _ticked(self, snapshot: Snapshot) -> None:
        with self._beginning:
            if snapshot.state.tick < self._due(snapshot) or self._caught == self._count or self._lost:
                return
            self._catch(snapshot)
        self._told(snapshot)

    def _due(self, snapshot: Snapshot) -> int:
        """Return the first tick at or after the time of the next picture."""
        return self._start + math.ceil(self._caught / (self._rate * snapshot.tick_seconds) - 1e-6)

    def _catch(self, snapshot: Snapshot) -> None:
        most = min(MOST_BEHIND, MOST_BYTES // (PARTS * snapshot.world_t_node.nbytes))
        if len(self._waiting) >= most:
            self._lost = len(self._waiting)
            return
        self._waiting.append(Frame(self._caught, self._sight(snapshot)))
        self._caught += 1
