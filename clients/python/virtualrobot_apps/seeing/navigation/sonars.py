"""Ultrasonic sensors of a vehicle: what they hear and its lidar does not see, since it lies below or above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from virtualrobot_apps.seeing.navigation.poses import Floats, between, moved

EXPLAINED = 0.15
"""Distance (m) by which an echo may lie beyond what the lidar sees in the cone, and still be of that."""
SPACING = 0.05
"""Distance (m) between points that stand for an echo, which may come from anywhere across its cone."""
FORGOTTEN_SECONDS = 20.0
"""Time after which what was not heard again is forgotten: the lidar's rays, which pass above it, tell nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Sonar:
    """Ultrasonic sensor: its pose (3,) on the base, half of its cone's angle (rad), and how far it hears (m)."""

    base_t_sonar: Floats
    half_angle: float
    reach: float

    def unseen(self, heard: float, points: Floats) -> Floats:
        """Return points (n, 2) across the cone at a distance that was heard (m), about the base.

        None where nothing was heard, or where the lidar's points (m, 2) about the base explain it.
        """
        if not 0.0 < heard < self.reach:
            return np.zeros((0, 2))
        near = moved(between(self.base_t_sonar, np.zeros(3)), points)
        inside = np.abs(np.arctan2(near[:, 1], near[:, 0])) < self.half_angle + 0.05
        if (np.hypot(*near[inside].T) < heard + EXPLAINED).any():
            return np.zeros((0, 2))
        count = 1 + int(np.ceil(2.0 * self.half_angle * heard / SPACING))
        angles = np.linspace(-self.half_angle, self.half_angle, count)
        return moved(self.base_t_sonar, heard * np.column_stack([np.cos(angles), np.sin(angles)]))


class Heard:
    """Points that were heard lately, in the frame of the map."""

    def __init__(self) -> None:
        """Begin with none."""
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self._points, self._times = np.zeros((0, 2)), np.zeros(0)

    def points(self) -> Floats:
        """Return the points (n, 2) (m)."""
        return self._points

    def update(self, points: Floats, time: float) -> None:
        """Take in points (n, 2) heard at a time (s)."""
        lately = time - self._times < FORGOTTEN_SECONDS
        both = np.vstack([points, self._points[lately]])
        times = np.concatenate([np.full(len(points), time), self._times[lately]])
        _, first = np.unique(np.floor(both / SPACING).astype(np.int64), axis=0, return_index=True)
        self._points, self._times = both[first], times[first]
