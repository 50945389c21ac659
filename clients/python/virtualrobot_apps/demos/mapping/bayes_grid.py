"""An occupancy grid from the cones of an ultrasonic sensor, by Bayes' rule.

H. P. Moravec and A. Elfes, High Resolution Maps from Wide Angle Sonar, IEEE ICRA 1985: a reading r says that the cone
is empty before r - e, less surely towards r and towards its edge, and that something is at r within e, less surely
towards the edge. With d the distance of a cell from the sensor, t its angle from the axis, w half the cone's angle:

    empty      p = 1/2 (1 - k (1 - (d / (r - e))^2) (1 - (t / w)^2))     d < r - e
    occupied   p = 1/2 (1 + k (1 - ((d - r) / e)^2) (1 - (t / w)^2))     |d - r| <= e

A. Elfes, Using Occupancy Grids for Mobile Robot Perception and Navigation, Computer 22, 1989: by Bayes' rule, with
cells and readings independent, each reading adds log(p / (1 - p)) to a cell's log-odds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

MOST_ODDS = 8.0
"""Log-odds go no further than this to either side, so that what changes can be learned anew."""


@dataclass(frozen=True, slots=True)
class Cone:
    """The sensor: half the angle of its cone (rad), how wrong r may be (m), how sure a reading is (k, 0 to 1)."""

    half_angle: float
    error: float
    certainty: float = 0.9


class BayesGrid:
    """Cells between two corners; their log-odds of being occupied, 0 where nothing is known."""

    def __init__(self, low: ArrayLike, high: ArrayLike, resolution: float) -> None:
        """Begin with nothing known between the corners `low` and `high` (3,), whole multiples of the resolution (m)."""
        self.resolution = resolution
        self.first = np.rint(np.asarray(low, np.float64) / resolution).astype(np.int64)
        shape = np.rint(np.asarray(high, np.float64) / resolution).astype(np.int64) - self.first
        self.log_odds = np.zeros(shape)
        axes = [(np.arange(n) + k + 0.5) * resolution for n, k in zip(shape, self.first, strict=True)]
        self._centers = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def update(self, origin: ArrayLike, direction: ArrayLike, reading: float, cone: Cone) -> None:
        """Take in one reading (m) from `origin` (3,) along the unit vector `direction` (3,), in the world's frame."""
        away = self._centers - np.asarray(origin, np.float64)
        distance = np.linalg.norm(away, axis=1)
        along = away @ np.asarray(direction, np.float64)
        inside = (distance <= reading + cone.error) & (along > np.cos(cone.half_angle) * distance)
        cells = np.flatnonzero(inside)
        near = distance[cells]
        angle = np.arccos(np.clip(along[cells] / np.maximum(near, 1e-12), -1.0, 1.0))
        to_edge = 1.0 - (angle / cone.half_angle) ** 2
        is_empty = near < reading - cone.error
        before = max(reading - cone.error, 1e-12)
        sure = np.where(is_empty, (near / before) ** 2 - 1.0, 1.0 - ((near - reading) / cone.error) ** 2)
        p = 0.5 * (1.0 + cone.certainty * sure * to_edge)
        odds = self.log_odds.reshape(-1)
        odds[cells] = np.clip(odds[cells] + np.log(p / (1.0 - p)), -MOST_ODDS, MOST_ODDS)

    def voxels(self) -> tuple[NDArray[np.int64], Floats]:
        """Return the known cells (n, 3), cell k from k to k + 1 times the resolution, and their log-odds (n,)."""
        known = np.argwhere(self.log_odds != 0.0)
        return known + self.first, self.log_odds[tuple(known.T)]
