"""Reports of the collision monitor: what touches now, and what has happened."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from virtualrobot_kernel.collision.scene import Collision
from virtualrobot_kernel.collision.touching import MOST_POINTS, Contacts, spread
from virtualrobot_kernel.world.state import Snapshot

REMEMBERED = 1000
"""Number of events that a report remembers."""


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """Two nodes that touch and may not.

    Attributes:
        pair: which (uids), where and how deep when it began.
        names: of the two nodes, as they were when it began.
        tick: when it began, or the watching did.
        simulation_time: the same in seconds.
        tolerated: whether they touched already when the watching began; such a touch stops nothing.
    """

    pair: Collision
    names: tuple[str, str]
    tick: int
    simulation_time: float
    tolerated: bool


@dataclass(frozen=True, slots=True, eq=False)
class Ended:
    """Two nodes that were told to touch do no more (`apart`), or are not watched any more."""

    touch: Touch
    apart: bool


@dataclass(frozen=True, slots=True, eq=False)
class Stopped:
    """Robots (names) were stopped, by cancelling these motions, and why."""

    robots: tuple[str, ...]
    motions: tuple[str, ...]
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Failed:
    """Checks fail, and why; with an empty fault they succeed again."""

    fault: str


What: TypeAlias = Touch | Ended | Stopped | Failed


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """Event of a tick; `number` counts them from 1."""

    number: int
    tick: int
    simulation_time: float
    what: What


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """State of contacts; a new one takes its place after each check.

    Attributes:
        snapshot: the world that was checked last.
        touching: what touches and may not, of robots that are watched.
        fault: why the last check failed; empty where it did not.
        checks: how many there were.
        seconds: what these took together.
        events: the last ones, the oldest first.
        event_count: how many there were.
    """

    snapshot: Snapshot
    touching: tuple[Touch, ...] = ()
    fault: str = ""
    checks: int = 0
    seconds: float = 0.0
    events: tuple[Event, ...] = ()
    event_count: int = 0

    def after(self, number: int) -> tuple[tuple[Event, ...], int]:
        """Return the events after that of a number, and how many of them are not remembered any more."""
        forgotten = self.event_count - len(self.events)
        return self.events[max(number - forgotten, 0) :], max(forgotten - number, 0)


def thinned(collision: Collision) -> Collision:
    """Return two nodes that touch with those points alone that are told, spread over all their figures."""
    counts = [len(one.points) for one in collision.contacts]
    if sum(counts) <= MOST_POINTS:
        return collision
    told = np.zeros(sum(counts), np.bool_)
    told[spread(len(told))] = True
    each = zip(collision.contacts, np.split(told, np.cumsum(counts[:-1])), strict=True)
    return replace(collision, contacts=tuple(Contacts(one.points[own], one.normal) for one, own in each if own.any()))
