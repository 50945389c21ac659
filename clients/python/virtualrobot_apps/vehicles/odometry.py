"""Odometry of a vehicle with two driven wheels: its way as the wheels' angles tell it, on exact arcs.

Reference: J. Borenstein and L. Feng, Measurement and Correction of Systematic Odometry Errors in Mobile Robots, IEEE
Transactions on Robotics and Automation 12 (1996), equations 1.1-1.3, with arcs in place of chords.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


class Odometry:
    """Reckons where the middle of the axle is, from where it was first; encoders are all that it knows."""

    def __init__(self, track: float, radius: float, right_radius: float | None = None) -> None:
        """Take the distance of the wheels (m), the radius of both (m), or of the left one and of the right one."""
        self._track = track
        self._radii = np.array([radius, radius if right_radius is None else right_radius])
        self._last: Floats | None = None
        self.x = self.y = self.heading = 0.0
        """Place (m) and heading (rad, unwrapped) in the frame where it began, x ahead there."""
        self.distance = 0.0
        """Way of the middle (m), backwards negative."""

    def update(self, angles: ArrayLike) -> tuple[float, float, float]:
        """Return x, y (m) and heading (rad) at the angles (2,) of the left and the right wheel (rad).

        The first call tells where it begins. Wheels count as turning evenly between two calls.
        """
        now = np.array(angles, dtype=np.float64)
        if now.shape != (2,) or not np.isfinite(now).all():
            raise ValueError(f"the angles of two wheels are two finite numbers, not {now.tolist()}")
        left, right = self._radii * (now - (now if self._last is None else self._last))
        self._last = now
        way, turn = 0.5 * float(left + right), float(right - left) / self._track
        chord = way * float(np.sinc(turn / (2.0 * math.pi)))
        self.x += chord * math.cos(self.heading + 0.5 * turn)
        self.y += chord * math.sin(self.heading + 0.5 * turn)
        self.heading += turn
        self.distance += way
        return self.x, self.y, self.heading


def reckoned(angles: ArrayLike, track: float, radius: float, right_radius: float | None = None) -> Floats:
    """Return the poses (n, 3) that odometry makes of the wheels' angles (n, 2), as `Odometry` tells them."""
    odometry = Odometry(track, radius, right_radius)
    return np.array([odometry.update(row) for row in np.asarray(angles, dtype=np.float64)])


def counted(angles: ArrayLike, counts: int) -> Floats:
    """Return angles (rad) as encoders with so many counts a turn tell them: the last whole count."""
    step = 2.0 * math.pi / counts
    # So little off a whole count that rounding decides nothing.
    return np.floor(np.asarray(angles, dtype=np.float64) / step + 1e-7) * step
