"""Things where the map has nothing: seen lately, and forgotten once rays pass through where they stood."""

from __future__ import annotations

import numpy as np

from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.poses import Floats, between, moved
from virtualrobot_apps.seeing.navigation.regions import apart
from virtualrobot_apps.seeing.navigation.scans import Scan

APART = 0.15
"""Distance (m) from what the map has, from which on an echo is unforeseen."""
FORGOTTEN_SECONDS = 20.0
"""Time after which what was not seen again is forgotten."""
THROUGH = 0.15
"""Length (m) by which rays pass a place that is empty now."""
_BINS = 360


class Unforeseen:
    """Points that were seen and that the map does not have, in the frame of the map."""

    def __init__(self) -> None:
        """Begin with none."""
        self.clear()
        self._field: Floats | None = None
        self._of: int | None = None

    def clear(self) -> None:
        """Forget all."""
        self._points, self._times = np.zeros((0, 2)), np.zeros(0)

    def points(self) -> Floats:
        """Return the points (n, 2) (m)."""
        return self._points

    def update(self, scan: Scan, pose: Floats, grid: Grid) -> None:
        """Take in a scan made at a pose (3,) of the base."""
        if len(self._points):
            near = moved(between(pose, np.zeros(3)), self._points) - scan.origin
            away, bins = np.hypot(*near.T), _bins(near)
            sight = np.full(_BINS, np.inf)
            np.minimum.at(sight, _bins(scan.points - scan.origin), np.hypot(*(scan.points - scan.origin).T))
            if len(scan.empty):
                ends = scan.empty - scan.origin
                unseen = np.isinf(sight)
                told = np.zeros(_BINS)
                np.maximum.at(told, _bins(ends), np.hypot(*ends.T))
                sight = np.where(unseen, told, sight)
            sight[np.isinf(sight)] = 0.0
            kept = (away > sight[bins] - THROUGH) & (scan.time - self._times < FORGOTTEN_SECONDS)
            self._points, self._times = self._points[kept], self._times[kept]
        echoes = moved(pose, scan.points)
        new = echoes[self._apart(echoes, grid) > APART]
        if len(new):
            keys = np.floor(np.vstack([new, self._points]) / 0.05).astype(np.int64)
            _, first = np.unique(keys, axis=0, return_index=True)
            points = np.vstack([new, self._points])[first]
            times = np.concatenate([np.full(len(new), scan.time), self._times])[first]
            self._points, self._times = points, times

    def _apart(self, points: Floats, grid: Grid) -> Floats:
        """Return how far points (n, 2) are from what the map has (m); 0 where nothing is known."""
        if self._field is None or self._of != id(grid.log_odds) or self._field.shape != grid.log_odds.shape:
            occupied = grid.occupied
            field = apart(occupied) * grid.resolution
            self._field = np.where(grid.log_odds == 0.0, 0.0, field)
            self._of = id(grid.log_odds)
        away = np.full(len(points), np.inf)
        inside = grid.has(points)
        away[inside] = self._field[grid.cells(points[inside])]
        return away


def _bins(points: Floats) -> np.ndarray:
    return np.floor((np.arctan2(points[:, 1], points[:, 0]) + np.pi) / (2.0 * np.pi) * _BINS).astype(int) % _BINS
