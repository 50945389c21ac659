"""Cartesian arc: the tool centre point goes along a circle while its orientation turns about one fixed axis."""

from __future__ import annotations

from dataclasses import dataclass
from math import cbrt, sqrt
from typing import ClassVar

import numpy as np

from virtualrobot_kernel.motion.cartesian_path import ConstantSpeedPath
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.polynomial import Array

#: Shares of acceleration and jerk that the circle itself may take; the rest is for speeding up and slowing down.
_CENTRIPETAL_ACCELERATION, _CENTRIPETAL_JERK, _NORMAL_JERK = 0.8, 0.4, 0.6


@dataclass(frozen=True, eq=False)
class Arc(ConstantSpeedPath):
    """Path on a circle: start + radius * (sin(u * sweep) * along + (1 - cos(u * sweep)) * inward), base frame.

    along, inward (3,): unit vectors of the base frame at the start, tangential and to the centre; radius in m; sweep
    in rad, above 0. via: the fraction at which a via point is passed, if there is one.
    """

    kind: ClassVar[str] = "circ"
    noun: ClassVar[str] = "arc"

    along: Array
    inward: Array
    radius: float
    sweep: float
    via: float | None = None

    @property
    def length(self) -> float:
        """Length of the arc in m."""
        return self.radius * self.sweep

    @property
    def center(self) -> Array:
        """Centre (3,) of the circle in m, base frame."""
        return self.base_t_start[:3, 3] + self.radius * self.inward

    @property
    def stations(self) -> tuple[tuple[float, str], ...]:
        """Fractions of the via point and the goal; without a via point the quarters of the arc."""
        if self.via is not None:
            return (self.via, "via point"), (1.0, "goal")
        return (1.0, "goal"), *((0.25 * quarter, f"place at {25 * quarter}%") for quarter in (1, 2, 3))

    def position(self, u: float) -> Array:
        """Return the position (3,) at the fraction `u` in m, base frame."""
        half = 0.5 * u * self.sweep
        sine = np.sin(half)
        # sin(x) = 2 sin(x/2) cos(x/2) and 1 - cos(x) = 2 sin²(x/2): no cancellation however large the circle is.
        way = 2.0 * self.radius * sine
        return self.base_t_start[:3, 3] + way * (np.cos(half) * self.along + sine * self.inward)

    def twist(self, u: float) -> Array:
        """Return the derivative (6,) of the pose by u: m, then rad, base frame, at the TCP."""
        angle = u * self.sweep
        direction = np.cos(angle) * self.along + np.sin(angle) * self.inward
        return np.concatenate([self.length * direction, self.rotation])

    def tangential(self, limits: CartesianLimits, speed: float) -> tuple[float, float, float]:
        """Return velocity, acceleration and jerk along the arc with which those of the position keep `limits`.

        On a circle of radius r at speed v, with acceleration a and jerk j along it, the position has the acceleration
        (a, v²/r) and the jerk (j - v³/r², 3 v a / r), tangential and normal. v²/r may take 0.8 of the limit A, v³/r²
        0.4 and 3 v a / r 0.6 of the limit J; then a = min(sqrt(A² - (v²/r)²), 0.2 J r / v) and
        j = sqrt(J² - (3 v a / r)²) - v³/r² keep both at each moment, and with r they grow to A and J.
        """
        r, acceleration, jerk = self.radius, limits.acceleration, limits.jerk
        velocity = min(
            limits.velocity, sqrt(_CENTRIPETAL_ACCELERATION * acceleration * r), cbrt(_CENTRIPETAL_JERK * jerk * r * r)
        )
        v = velocity * speed
        along = min(sqrt(acceleration**2 - (v * v / r) ** 2), _NORMAL_JERK * jerk * r / (3.0 * v))
        return velocity, along, sqrt(jerk**2 - (3.0 * v * along / r) ** 2) - v**3 / r**2
