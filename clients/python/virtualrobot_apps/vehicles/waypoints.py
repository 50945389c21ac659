"""Waypoints for a vehicle that turns on the spot: it heads for one after the other, by a PI or PID controller.

Reference: the mission of "Unmanned Ground Vehicle Modelling in Gazebo/ROS-Based Environments", section 3: each waypoint
within 0.1 m, at most 0.5 m/s and 1.0 rad/s, at 20 Hz. The paper tells no gains; those here are ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

REACHED = 0.1
"""Distance (m) from a waypoint at which the next one counts."""
FASTEST = 0.5
"""Greatest speed (m/s)."""
QUICKEST = 1.0
"""Greatest turning rate (rad/s)."""
PERIOD = 0.05
"""Time (s) between two commands."""
TURNED = 0.3
"""Angle (rad) between heading and bearing from which the vehicle turns on the spot."""


@dataclass(frozen=True)
class Gains:
    """Gains of the turning rate: times the angle to the waypoint (1/s), its integral (1/s^2) and its derivative."""

    proportional: float
    integral: float
    derivative: float = 0.0


CONTROLLERS = {"PI": Gains(2.0, 0.3), "PID": Gains(2.0, 0.3, 0.25)}


class Waypoints:
    """Leads a vehicle through waypoints; it is told where the vehicle is, once a period, and says how to drive."""

    def __init__(self, points: ArrayLike, gains: Gains, start: ArrayLike = (0.0, 0.0)) -> None:
        """Lead from `start` (2,) through points (n, 2), in the world (m); raise ValueError where they are none."""
        self.points = np.array(points, dtype=np.float64)
        if (
            self.points.ndim != 2
            or self.points.shape[1] != 2
            or not len(self.points)
            or not np.isfinite(self.points).all()
        ):
            raise ValueError(f"waypoints are pairs of finite numbers, one at least, not {self.points.tolist()}")
        self.gains = gains
        self.reached: list[float] = []
        """Times (s) at which waypoints were reached, one after the other."""
        self.angle = 0.0
        """Angle (rad) from the heading to the bearing of the waypoint, at the last position."""
        self.cross_track = 0.0
        """Distance (m) from the line between the waypoints before and ahead, at the last position."""
        self._from = np.array(start, dtype=np.float64)
        self._sum = 0.0
        self._last: float | None = None
        self._now = 0.0

    @property
    def done(self) -> bool:
        """Return whether all waypoints were reached."""
        return len(self.reached) == len(self.points)

    def twist(self, position: ArrayLike, heading: float, now: float) -> tuple[float, float] | None:
        """Return speed (m/s) and turning (rad/s) at a place (2,), a heading (rad) and a time (s); None once done."""
        place = np.array(position, dtype=np.float64)
        while not self.done and math.dist(place, self.points[len(self.reached)]) < REACHED:
            self._from = self.points[len(self.reached)]
            self.reached.append(now)
            self._sum, self._last = 0.0, None
        if self.done:
            return None
        way = self.points[len(self.reached)] - place
        line = self.points[len(self.reached)] - self._from
        off = place - self._from
        length = math.hypot(line[0], line[1])
        self.cross_track = abs(float(off[0] * line[1] - off[1] * line[0])) / length if length > 0.0 else 0.0
        angle = math.remainder(math.atan2(way[1], way[0]) - heading, 2.0 * math.pi)
        elapsed = now - self._now if self._last is not None else 0.0
        # What is summed up is bounded: otherwise it would be great after each turn on the spot, and swing over.
        self._sum = min(1.0, max(-1.0, self._sum + angle * elapsed))
        rate = (
            math.remainder(angle - self._last, 2.0 * math.pi) / elapsed if self._last is not None and elapsed else 0.0
        )
        self.angle = self._last = angle
        self._now = now
        gains = self.gains
        turning = gains.proportional * angle + gains.integral * self._sum + gains.derivative * rate
        speed = FASTEST * math.cos(angle) if abs(angle) < TURNED else 0.0
        return speed, min(QUICKEST, max(-QUICKEST, turning))


def square(side: float) -> list[Sequence[float]]:
    """Return the corners of a square (m) from (0, 0), the first side along x, and back there."""
    return [(side, 0.0), (side, side), (0.0, side), (0.0, 0.0)]
