"""The right-hand rule by three sonars, and the steering that keeps the middle between walls.

Reference: "Boe-Bot simulation in Gazebo", table 5.1: no wall on the right: turn right; else none ahead: keep straight;
else turn left; a wall is what is nearer than 0.25 m, and it turns at 0.3 rad/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from virtualrobot_apps.vehicles.boebot.worlds import WALL

NEAR = 0.25
"""Distance (m) from which on a wall counts as none. (The document's text has "0.25 cms", its program 0.25 m.)"""
TURNING = 0.3
"""Turning rate (rad/s)."""
SPEED = 0.15
"""Speed along a passage (m/s): the document's program wants 0.3, which the servos don't reach."""
FRONT_X, SIDE_Y = 0.04, 0.04
"""Places of the front sonar before the axle, and of those at the sides beside the middle (m)."""

STIFFNESS, DAMPING = 1.7, 1.0
"""Turning rate for a metre off the middle (rad/s/m), and for a radian off the passage (1/s): critically damped."""
PLACE_GAIN, HEADING_GAIN = 0.3, 0.05
"""Parts of the difference between a measured and an expected place that count (g-h filter: R. Labbe, Kalman and
Bayesian Filters in Python, chapter 1)."""
SHORTEST = 0.01
"""Way (m) between two measurements that counts at least."""
PLAUSIBLE = 0.06
"""Distance (m) that a side's wall may be from its place in the middle of a passage: beyond, it is another wall."""


@dataclass(frozen=True)
class Distances:
    """Distances that the three sonars measure (m); inf where nothing is heard."""

    left: float
    front: float
    right: float


def turn_of(distances: Distances) -> int:
    """Return what the right-hand rule does: -1 turn right (and go on), 0 keep straight, 1 turn left (and ask again)."""
    if distances.right > NEAR:
        return -1
    return 0 if distances.front > NEAR else 1


def remaining_of(front: float) -> float | None:
    """Return how far (m) it is to the middle of the square before a wall ahead; None where no wall is so near."""
    remaining = front - (0.5 * WALL - FRONT_X)
    return remaining if remaining < 0.6 * WALL else None


class Steering:
    """Keeps the middle of a passage: it estimates how far off it is, and how far it is turned from the passage."""

    def __init__(self) -> None:
        """Begin in the middle, along the passage."""
        self.off = 0.0
        """Distance left of the middle (m)."""
        self.heading = 0.0
        """Angle by which it is turned to the left of the passage (rad)."""

    def turned(self, quarter: int, ahead: float) -> float:
        """Tell that it has turned by a right angle, to the left (1) or to the right (-1); return how far ahead it is.

        `ahead` is how far past the middle of the square it stood (m): that is to its side now, and the other way round.
        """
        self.off, ahead = -quarter * ahead, quarter * self.off
        return ahead

    def rolled(self, way: float, turn: float) -> None:
        """Tell a way (m) and a turn (rad) as the wheels count them."""
        self.heading += turn
        self.off += way * math.sin(self.heading)

    def seen(self, way: float, distances: Distances) -> None:
        """Tell what the sonars say, a way (m) after they were asked before."""
        middle = 0.5 * WALL - SIDE_Y
        # To the left wall it is as far as from the middle, less what it is off; to the right one as much more.
        told = [middle - distances.left, distances.right - middle]
        plausible = [off for off in told if abs(off) < PLAUSIBLE]
        if plausible:
            difference = sum(plausible) / len(plausible) - self.off
            self.off += PLACE_GAIN * difference
            # As it starts or stops, ways are so short that only noise would be told.
            self.heading += HEADING_GAIN * difference / max(way, SHORTEST)

    def rate(self) -> float:
        """Return the turning rate (rad/s) that leads back to the middle, and along it."""
        return min(TURNING, max(-TURNING, -STIFFNESS * self.off - DAMPING * self.heading))
