"""Registration of clouds: the pose at which the points of one lie on the surfaces of the other.

Y. Chen, G. Medioni, Object Modelling by Registration of Multiple Range Images, Image and Vision Computing 10, 1992:
each point is drawn to the plane through its neighbours in the other cloud. What the robot says about the pose is one
more measurement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from virtualrobot_apps.seeing.changes.scan import Floats
from virtualrobot_apps.seeing.spreads import spreads

SPACING = 0.06
"""Distance (m) between points that are registered."""
NEIGHBOURS = 12
"""Number of points that a plane goes through."""
REACH, CLOSE = 0.4, 0.06
"""Distance (m) up to which a point is drawn at first, and at the end; within the latter it fits."""
METERS, RADIANS = 0.1, 0.05
"""Deviations of what the robot says about the pose."""
LEAST_DEVIATION = 0.001
_STEPS, _STILL = 30, 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """Registration of two clouds.

    pose: (4, 4) of the second in the frame of the first. share: of its points that fit, 0 to 1. deviation: of points
    from the planes of the first (m).
    """

    pose: Floats
    share: float
    deviation: float


def registered(first: Floats, second: Floats, guess: Floats) -> Registration:
    """Return the pose of points (m, 3) in the frame of others (n, 3), from the robot's guess (4, 4) on."""
    tree = KDTree(first)
    source = thinned(second)
    pose, reach = np.array(guess, np.float64), REACH
    deviation, prior = CLOSE, np.array([METERS] * 3 + [RADIANS] * 3) ** -2.0
    for _ in range(_STEPS):
        points = source @ pose[:3, :3].T + pose[:3, 3]
        off, normals = off_planes(tree, first, points, reach)
        drawn = np.isfinite(off)
        if drawn.sum() < 6:
            break
        off, normals = off[drawn], normals[drawn]
        deviation = max(LEAST_DEVIATION, 1.4826 * float(np.median(np.abs(off))))
        # P. J. Huber's loss: what is far draws no harder.
        weights = np.minimum(1.0, 1.345 * deviation / np.maximum(np.abs(off), 1e-12)) / deviation**2
        arms = points[drawn] - pose[:3, 3]
        slope = np.hstack([normals, np.cross(arms, normals)])
        change = guess[:3, :3] @ pose[:3, :3].T
        behind = np.concatenate([pose[:3, 3] - guess[:3, 3], -Rotation.from_matrix(change).as_rotvec()])
        weighted = slope * weights[:, None]
        step = -np.linalg.solve(weighted.T @ slope + np.diag(prior), weighted.T @ off + prior * behind)
        pose[:3, 3] += step[:3]
        pose[:3, :3] = Rotation.from_rotvec(step[3:]).as_matrix() @ pose[:3, :3]
        settled = reach <= CLOSE
        reach = max(CLOSE, 0.6 * reach)
        if settled and float(np.abs(step).max()) < _STILL:
            break
    away, _ = tree.query(source @ pose[:3, :3].T + pose[:3, 3], distance_upper_bound=2.0 * CLOSE)
    return Registration(pose, float(np.isfinite(away).mean()), deviation)


def thinned(points: Floats, spacing: float = SPACING) -> Floats:
    """Return one of the points (n, 3) in each cube of an edge (m)."""
    _, first = np.unique(np.floor(points / spacing).astype(np.int64), axis=0, return_index=True)
    return points[np.sort(first)]


def off_planes(
    tree: KDTree, cloud: Floats, points: Floats, reach: float, count: int = NEIGHBOURS
) -> tuple[Floats, Floats]:
    """Return how far points (k, 3) are off planes through `count` neighbours in a cloud (n, 3), and normals (k, 3).

    NaN where no neighbour is within `reach` (m), or neighbours lie on no plane.
    """
    away, _ = tree.query(points, distance_upper_bound=reach)
    within = np.flatnonzero(np.isfinite(away))
    found = spreads(tree, cloud, points[within], count)
    thin, middle, wide = found.squares.T
    # A plane: thin across, and wide along both other directions.
    plane = (thin < 0.1 * middle) & (middle > 0.01 * wide)
    off, normals = np.full(len(points), np.nan), np.zeros((len(points), 3))
    normals[within] = found.axes[:, :, 0]
    off[within] = np.where(plane, ((points[within] - found.middles) * normals[within]).sum(axis=1), np.nan)
    return off, normals
