"""Arcs of the tool centre point, through three points."""

from __future__ import annotations

import math

import numpy as np


class Arc:
    """Arc from a point through another one to a third, each (3,) in m; three on one line are no arc."""

    def __init__(self, start: np.ndarray, via: np.ndarray, end: np.ndarray) -> None:
        """Find its centre, radius and angle.

        The centre is that of the triangle's circumcircle: start + (b² n x a + a² b x n) / (2 n²) with a = end - start,
        b = via - start and n = a x b. Raises ValueError.
        """
        a, b = end - start, via - start
        normal = np.cross(a, b)
        square = float(normal @ normal)
        if square < 1e-18:
            raise ValueError("the three points are on one line")
        offset = (float(b @ b) * np.cross(normal, a) + float(a @ a) * np.cross(b, normal)) / (2.0 * square)
        self.center, self.radius = start + offset, float(np.linalg.norm(offset))
        self._x = -offset / self.radius
        self._y = np.cross(-normal / math.sqrt(square), self._x)
        self.angle = self._angle(end)

    def _angle(self, point: np.ndarray) -> float:
        """Return by what angle (rad), 0 to 2 pi, a point is behind the start."""
        away = point - self.center
        return math.atan2(float(away @ self._y), float(away @ self._x)) % (2.0 * math.pi)

    @property
    def length(self) -> float:
        """Length (m)."""
        return self.radius * self.angle

    def point(self, share: float) -> np.ndarray:
        """Return the point at a share of the way, 0 to 1."""
        angle = share * self.angle
        return self.center + self.radius * (math.cos(angle) * self._x + math.sin(angle) * self._y)

    def share(self, point: np.ndarray) -> float:
        """Return at which share of the way a point is, 0 to 1; one outside of it is at the nearer end."""
        angle = self._angle(point)
        if angle <= self.angle:
            return angle / self.angle
        return 1.0 if angle - self.angle < 2.0 * math.pi - angle else 0.0

    def rest(self, point: np.ndarray) -> np.ndarray:
        """Return the point, (3,), in the middle of what is left of the arc from one of its points."""
        return self.point((self.share(point) + 1.0) / 2.0)
