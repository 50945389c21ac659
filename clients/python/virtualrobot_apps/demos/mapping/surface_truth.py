"""All surfaces of a world within a box, by rays, and how well a map of voxels has them.

Points on surfaces come of rays along +x, -x, +y, -y, +z and -z at equal steps; behind each hit the ray goes on. A point
that is within TOLERANCE of a voxel's side belongs to the voxels on both sides of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from virtualrobot_apps.demos.mapping.octree_map import Keys, keys_of

Floats = NDArray[np.float64]
Cast = Callable[[Floats, Floats, float], tuple[Floats, NDArray[np.bool_]]]
"""(origins (n, 3), directions (n, 3), greatest distance) -> distances (n,), inf: a miss; and which hits count (n,)."""

STEP = 1e-4
"""Distance behind a hit at which its ray goes on (m)."""
TOLERANCE = 1e-3
MOST_LAYERS = 100
MOST_RAYS = 100_000
"""Largest number of rays in one call."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """Numbers of voxels: occupied, and of these with a surface; with a visible surface, and of these not occupied."""

    occupied: int
    true: int
    visible: int
    missed: int

    @property
    def false_rate(self) -> float:
        """The part of the occupied voxels that hold no surface."""
        return 1.0 - self.true / self.occupied if self.occupied else 0.0

    @property
    def missed_rate(self) -> float:
        """The part of the surface voxels which a scan could have seen that are not occupied."""
        return self.missed / self.visible if self.visible else 0.0


def surface_points(cast: Cast, low: ArrayLike, high: ArrayLike, spacing: float) -> Floats:
    """Return points (n, 3) on all surfaces between two corners, from rays `spacing` meters apart."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    found = [np.empty((0, 3))]
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        lines = [np.arange(low[other] + 0.5 * spacing, high[other], spacing) for other in others]
        first, second = np.meshgrid(*lines, indexing="ij")
        for sign in (1.0, -1.0):
            starts = np.empty((first.size, 3))
            starts[:, others[0]], starts[:, others[1]] = first.ravel(), second.ravel()
            starts[:, axis] = low[axis] if sign > 0.0 else high[axis]
            direction = np.zeros(3)
            direction[axis] = sign
            found += list(_through(cast, starts, direction, float(high[axis] - low[axis])))
    return np.concatenate(found)


def points_in_voxels(cast: Cast, keys: Keys, resolution: float, steps: int = 20) -> Floats:
    """Return points (n, 3) on surfaces in some voxels, from `steps` x `steps` rays through each along each axis."""
    found = [np.empty((0, 3))]
    across = (np.arange(steps) + 0.5) / steps
    first, second = (grid.ravel() for grid in np.meshgrid(across, across, indexing="ij"))
    for axis in range(3):
        offsets = np.zeros((len(first), 3))
        offsets[:, (axis + 1) % 3], offsets[:, (axis + 2) % 3] = first, second
        offsets[:, axis] = -TOLERANCE / resolution
        starts = ((keys[:, None, :] + offsets) * resolution).reshape(-1, 3)
        found += list(_through(cast, starts, np.eye(3)[axis], resolution + 2.0 * TOLERANCE))
    return np.concatenate(found)


def _through(cast: Cast, starts: Floats, direction: Floats, length: float) -> Iterator[Floats]:
    """Yield what rays of this length (m) meet, layer by layer."""
    gone = np.zeros(len(starts))
    for _ in range(MOST_LAYERS):
        if not len(starts):
            return
        parts = range(0, len(starts), MOST_RAYS)
        answers = [cast(part := starts[i : i + MOST_RAYS], np.tile(direction, (len(part), 1)), length) for i in parts]
        distance = np.concatenate([one[0] for one in answers])
        counts = np.concatenate([one[1] for one in answers])
        hit = np.isfinite(distance)
        hit[hit] = gone[hit] + distance[hit] <= length
        yield (starts + np.where(hit, distance, 0.0)[:, None] * direction)[hit & counts]
        step = distance[hit] + STEP
        starts, gone = starts[hit] + step[:, None] * direction, gone[hit] + step


def seen_from(cast: Cast, points: Floats, origin: Floats) -> NDArray[np.bool_]:
    """Return which points (n, 3) nothing stands before, seen from `origin` (3,)."""
    seen = np.zeros(len(points), np.bool_)
    for start in range(0, len(points), MOST_RAYS):
        away = points[start : start + MOST_RAYS] - origin
        distance = np.linalg.norm(away, axis=1)
        directions = away / distance[:, None]
        met, _ = cast(np.broadcast_to(origin, away.shape), directions, float(distance.max()) + 1.0)
        seen[start : start + MOST_RAYS] = met >= distance - TOLERANCE
    return seen


def compare(cast: Cast, occupied: Keys, resolution: float, points: Floats, visible: NDArray[np.bool_]) -> Comparison:
    """Return how the occupied voxels (m, 3) of a map agree with surface points (n, 3), some of them `visible` (n,).

    Voxels in which the points have no surface are looked at again with finer rays before they count as false.
    """
    have = _as_set(occupied)
    true = have & _as_set(_touched(points, resolution))
    doubtful = np.array(sorted(have - true), np.int64).reshape(-1, 3)
    if len(doubtful):
        finer = points_in_voxels(cast, doubtful, resolution)
        true |= have & _as_set(_touched(finer, resolution))
    could = points[visible]
    # A surface voxel is there when it, or one across a side that its point lies on, is occupied.
    near = np.stack([keys_of(could + shift, resolution) for shift in _SHIFTS], axis=1)
    found = np.array([any(tuple(key) in have for key in keys) for keys in near.tolist()], np.bool_)
    own = [tuple(key) for key in keys_of(could, resolution).tolist()]
    wanted = set(own)
    got = {key for key, there in zip(own, found.tolist(), strict=True) if there}
    return Comparison(len(have), len(true), len(wanted), len(wanted - got))


_SHIFTS = TOLERANCE * np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])


def _touched(points: Floats, resolution: float) -> Keys:
    return np.concatenate([keys_of(points + shift, resolution) for shift in _SHIFTS])


def _as_set(keys: Keys) -> set[tuple[int, ...]]:
    return set(map(tuple, np.unique(keys, axis=0).tolist())) if len(keys) else set()
