"""Guidance along a path of straight legs: a vehicle heads for a point on the path some way ahead of it (line of sight).

T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (Wiley, 2011), section 10.3. Wanted is a
velocity over ground, so that a current needs no angle of its own: whoever controls the velocity counters it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ARRIVED = 0.1
"""Distance (m) from the end at which a path is done."""


@dataclass(frozen=True, eq=False)
class Path:
    """A path of straight legs between points (n, 3) in the world (m), two at least, no two in a row the same."""

    points: Floats
    lengths: Floats
    """(n,) way along the path at each point."""

    @classmethod
    def through(cls, points: Floats) -> Path:
        """Return the path through points; raise ValueError for fewer than two, and two in a row that are the same."""
        places = np.array(points, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 3 or len(places) < 2 or not np.isfinite(places).all():
            raise ValueError(f"a path needs two points of three finite numbers at least, not {places.tolist()}")
        legs = np.linalg.norm(np.diff(places, axis=0), axis=1)
        if legs.min() <= 0.0:
            raise ValueError(f"points {int(legs.argmin())} and {int(legs.argmin()) + 1} of the path are the same")
        return cls(places, np.concatenate([[0.0], np.cumsum(legs)]))

    @property
    def length(self) -> float:
        """Return the whole way (m)."""
        return float(self.lengths[-1])

    def at(self, way: float) -> Floats:
        """Return the point (3,) after a way along the path, at its ends beyond them."""
        return np.array([np.interp(way, self.lengths, self.points[:, i]) for i in range(3)])

    def nearest(self, position: Floats, begin: float, end: float) -> float:
        """Return the way to the point of the path between two ways that is nearest to a position."""
        best, best_way = math.inf, begin
        for i in range(len(self.points) - 1):
            low, high = max(begin, self.lengths[i]), min(end, self.lengths[i + 1])
            if low > high:
                continue
            leg = (self.points[i + 1] - self.points[i]) / (self.lengths[i + 1] - self.lengths[i])
            way = min(high, max(low, float(self.lengths[i] + leg @ (position - self.points[i]))))
            off = float(np.linalg.norm(position - self.at(way)))
            if off < best:
                best, best_way = off, way
        return best_way


@dataclass(frozen=True, eq=False)
class Wanted:
    """Velocity over ground (3,) that a vehicle should have, along the world's axes (m/s), and its heading (rad)."""

    velocity: Floats
    heading: float


class Follower:
    """Leads a vehicle along a path: it keeps how far it has come, so that a path may cross itself."""

    def __init__(self, path: Path, speed: float, look_ahead: float = 0.5) -> None:
        """Follow a path at a speed (m/s); the point ahead is `look_ahead` (m) further along the path."""
        self.path, self.speed, self.look_ahead = path, speed, look_ahead
        self.way = 0.0
        self.cross_track = 0.0
        """Distance from the path (m) at the last position."""

    def wanted(self, position: Floats, heading: float) -> Wanted | None:
        """Return what is wanted at a position (3,) and a heading (rad); None once the end is reached."""
        path = self.path
        self.way = path.nearest(position, self.way, min(path.length, self.way + 2.0 * self.look_ahead))
        self.cross_track = float(np.linalg.norm(position - path.at(self.way)))
        last = path.points[-1] - position
        remaining = path.length - self.way
        if remaining < ARRIVED and float(np.linalg.norm(last)) < ARRIVED:
            return None
        ahead = path.at(self.way + self.look_ahead) - position
        along = float(np.linalg.norm(ahead))
        # Towards the end it slows in proportion to what remains, in a second for each.
        velocity = ahead / along * min(self.speed, 0.5 * max(remaining, float(np.linalg.norm(last))))
        if math.hypot(ahead[0], ahead[1]) > 0.5 * self.look_ahead:
            heading = math.atan2(ahead[1], ahead[0])
        return Wanted(velocity, heading)


def held(place: Floats, position: Floats, heading: float, rate: float = 0.5) -> Wanted:
    """Return what is wanted to come back to a place (3,) and stay there: a velocity of `rate` (1/s) times the way."""
    return Wanted(rate * (place - position), heading)
