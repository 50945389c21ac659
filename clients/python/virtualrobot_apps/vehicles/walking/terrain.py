"""Ground to walk on: height fields as meshes, and what rays say how high the ground is."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client

Floats = NDArray[np.float64]
MOST_LAYERS = 50
"""Number of things above the ground that a ray is cast through."""


def rolling(rng: np.random.Generator, cells: int = 80, cell: float = 0.05, height: float = 0.03) -> Floats:
    """Return heights (cells + 1, cells + 1) in m of rolling ground, from 0 to `height`, level at its middle.

    Sums of waves of random directions, as long as 6 cells and more; `cell` is the distance of two heights (m).
    """
    axis = cell * (np.arange(cells + 1) - cells / 2.0)
    x, y = np.meshgrid(axis, axis)
    heights = np.zeros_like(x)
    for _ in range(24):
        length = rng.uniform(6.0, 20.0) * cell
        direction, phase = rng.uniform(0.0, 2.0 * np.pi, 2)
        along = np.cos(direction) * x + np.sin(direction) * y
        heights += length * np.sin(2.0 * np.pi * along / length + phase)
    heights = (heights - heights.min()) / np.ptp(heights) * height
    # Where it begins a machine stands on the level.
    far = np.clip((np.hypot(x, y) - 0.25) / 0.25, 0.0, 1.0)
    return heights * far**2 * (3.0 - 2.0 * far)


def triangles_of(heights: Floats, cell: float) -> tuple[Floats, NDArray[np.int64]]:
    """Return corners (n, 3) in m and triangles (m, 3) of a height field (rows along y, columns along x) about 0, 0."""
    rows, columns = heights.shape
    x = cell * (np.arange(columns) - (columns - 1) / 2.0)
    y = cell * (np.arange(rows) - (rows - 1) / 2.0)
    grid = np.meshgrid(x, y)
    corners = np.stack([*grid, heights], axis=-1).reshape(-1, 3)
    first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
    lower = np.stack([first, first + 1, first + columns + 1], axis=-1)
    upper = np.stack([first, first + columns + 1, first + columns], axis=-1)
    return corners, np.concatenate([lower, upper])


class SensedGround:
    """Ground as rays from above find it: heights and normals of the nodes that are ground, seen through what is above.

    Rays pass through the nodes `ignored`, such as the machine that stands on the ground. Where something else touches
    the ground a ray misses it, and may find what is below.
    """

    def __init__(
        self, client: Client, nodes: Collection[str], ignored: Collection[str] = (), top: float = 10.0
    ) -> None:
        """Look at these nodes from `top` (m)."""
        self._client = client
        self._ignored = tuple(ignored)
        self._nodes = frozenset(nodes)
        self._top = top
        self.rays = 0

    def __call__(self, places: Floats) -> tuple[Floats, Floats]:
        """Return heights (m,) in m, nan where there is no ground, and unit normals (m, 3) below places (m, 2)."""
        heights, normals = np.full(len(places), np.nan), np.tile([0.0, 0.0, 1.0], (len(places), 1))
        origins = np.column_stack([places, np.full(len(places), self._top)])
        left = np.arange(len(places))
        for _ in range(MOST_LAYERS):
            if not len(left):
                break
            down = np.tile([0.0, 0.0, -1.0], (len(left), 1))
            hits = self._client.rays.cast(origins[left], down, ignored=self._ignored)
            self.rays += len(left)
            found = np.isfinite(hits.distances)
            is_ground = np.array([name in self._nodes for name in hits.nodes])
            there = left[is_ground]
            heights[there] = origins[there, 2] - hits.distances[is_ground]
            normals[there] = hits.normals[is_ground]
            onward = found & ~is_ground
            origins[left[onward], 2] -= hits.distances[onward] + 1e-4
            left = left[onward]
        return heights, normals
