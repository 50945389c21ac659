"""Admittance: along an axis a tool goes at (wanted + felt) / damping, until it pushes as it shall.

The damping is at least what keeps a contact as stiff as its forces have lately shown, over the ways to them, from
trembling.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

DAMPING = np.array([200.0] * 3 + [10.0] * 3)
"""Damping along and about three axes (N s/m, Nm s/rad), unless another one is wished."""
_SETTLING_SECONDS = 0.1
"""Time (s) in which a contact comes to its force; several times that from a movement to its force's being known."""
_LOOK_BACK_SECONDS = 0.1
"""Time (s) of which forces and ways are compared."""
_FORGETTING_SECONDS = 0.2
"""Time (s) in which of a contact's stiffness that shows no more e to 1 is left: a tool that bounces meets it again."""
_SMALLEST_WAY = np.array([2e-5] * 3 + [2e-4] * 3)
"""Way (m, rad) below which none is told from rest; gone at an even speed, its variance is a twelfth of its square."""
_ACCELERATION = np.array([1.0] * 3 + [5.0] * 3)
"""Highest acceleration (m/s^2, rad/s^2) along and about an axis."""


class Admittance:
    """Law by which a tool gives way, cycle by cycle, along and about three axes."""

    def __init__(self, rate: float) -> None:
        """Begin at rest; cycles are 1/rate seconds."""
        self._dt = 1.0 / rate
        self._speed = np.zeros(6)
        self._past: deque[tuple[Floats, Floats]] = deque(maxlen=max(2, round(_LOOK_BACK_SECONDS * rate)))
        self._way, self._stiff = np.zeros(6), np.zeros(6)

    def rest(self) -> None:
        """Stand still from now on, until it gives way again."""
        self._speed = np.zeros(6)

    def velocity(
        self,
        moved: Floats,
        felt: Floats,
        wanted: Floats,
        limits: Floats,
        damping: ArrayLike = DAMPING,
        pace: float = 1.0,
    ) -> Floats:
        """Return the velocity (6,) by which the tool gives way in this cycle.

        Args:
            moved: how far the tool has come along and about the axes since the cycle before, (6,).
            felt: force and torque on the tool, (6,), as long ago as `moved` was measured.
            wanted: what the tool puts on what it touches, (6,).
            limits: the highest speeds, (6,).
            damping: the least one, (6,).
            pace: share of its speed at which it gives way, 0 where it stands.
        """
        self._way = self._way + moved
        self._past.append((self._way, felt))
        ways, forces = (np.array(column) - np.mean(column, axis=0) for column in zip(*self._past, strict=True))
        # The slope of forces over ways: what trembles by itself, as the noise of a sensor, is no stiffness.
        stiffness = np.abs(np.sum(ways * forces, axis=0)) / np.maximum(
            np.sum(ways**2, axis=0), len(ways) * _SMALLEST_WAY**2 / 12.0
        )
        self._stiff = np.maximum(stiffness, self._stiff * (1.0 - self._dt / _FORGETTING_SECONDS))
        speed = (wanted + felt) / np.maximum(damping, self._stiff * _SETTLING_SECONDS)
        speed = np.clip(speed, -limits, limits) * pace
        change = _ACCELERATION * self._dt
        self._speed = self._speed + np.clip(speed - self._speed, -change, change)
        return self._speed
