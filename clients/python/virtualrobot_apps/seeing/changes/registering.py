"""Registration of clouds: the pose at which the points of one lie on the surfaces of the other.

GICP of small_gicp: A. Segal, D. Haehnel, S. Thrun, Generalized-ICP, Robotics: Science and Systems 2009. Where surfaces
leave a direction free, as along a corridor, what the robot says stays: J. Zhang, M. Kaess, S. Singh, On Degeneracy of
Optimization-based State Estimation Problems, IEEE ICRA 2016.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import small_gicp
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.changes.scan import Floats
from virtualrobot_apps.seeing.spreads import spreads

SPACING = 0.06
"""Distance (m) between points that are registered."""
FEWEST = 20
"""Fewest points, so far from each other, that are registered."""
NEIGHBOURS = 30
"""Number of points that a plane goes through."""
REACH, CLOSE = 0.4, 0.06
"""Distance (m) up to which a point is drawn at first, and at the end; within twice the latter it fits."""
FREE = 0.005
"""Information about a direction, as part of that about the best known one, below which surfaces leave it free."""
LEAST_DEVIATION = 0.001
_STEPS, _STILL = 40, 1e-5


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
    """Return the pose of points (m, 3) in the frame of others (n, 3), from the robot's guess (4, 4) on.

    Raises:
        InvalidArgumentError: where points lie too close together for surfaces.
    """
    for called, cloud in (("first", first), ("second", second)):
        if (count := len(thinned(cloud))) < FEWEST:
            raise InvalidArgumentError(
                f"the {called} cloud fills {count} cubes of {SPACING} m, and {FEWEST} at least are needed"
            )
    target, tree = small_gicp.preprocess_points(first, SPACING)
    source, _ = small_gicp.preprocess_points(second, SPACING)
    pose = np.array(guess, np.float64)
    for reach in (REACH, CLOSE):
        found = small_gicp.align(
            target,
            source,
            tree,
            pose,
            max_correspondence_distance=reach,
            max_iterations=_STEPS,
            rotation_epsilon=_STILL,
            translation_epsilon=_STILL,
        )
        pose = np.asarray(found.T_target_source, np.float64)
    near, points = KDTree(first), thinned(second)
    off, normals = off_planes(near, first, moved(pose, points), CLOSE)
    lies = np.isfinite(off)
    deviation = CLOSE
    if lies.any():
        deviation = max(LEAST_DEVIATION, 1.4826 * float(np.median(np.abs(off[lies]))))
        pose = _known(pose, guess, points[lies] @ pose[:3, :3].T, normals[lies])
    away, _ = near.query(moved(pose, points), distance_upper_bound=2.0 * CLOSE)
    return Registration(pose, float(np.isfinite(away).mean()), deviation)


def _known(pose: Floats, guess: Floats, arms: Floats, normals: Floats) -> Floats:
    """Return a pose (4, 4), as the guess has it along what planes, with normals (n, 3) at arms (n, 3), leave free."""
    size = float(np.sqrt((arms**2).sum(axis=1).mean()))
    slope = np.hstack([normals, np.cross(arms, normals) / size])
    information, along = np.linalg.eigh(slope.T @ slope)
    free = along[:, information < FREE * information[-1]]
    turn = Rotation.from_matrix(guess[:3, :3] @ pose[:3, :3].T).as_rotvec()
    back = free @ free.T @ np.concatenate([guess[:3, 3] - pose[:3, 3], turn * size])
    known = pose.copy()
    known[:3, :3] = Rotation.from_rotvec(back[3:] / size).as_matrix() @ pose[:3, :3]
    known[:3, 3] += back[:3]
    return known


def moved(pose: Floats, points: Floats) -> Floats:
    """Return points (n, 3) of a frame in that in which it has a pose (4, 4)."""
    return points @ pose[:3, :3].T + pose[:3, 3]


def thinned(points: Floats, spacing: float = SPACING) -> Floats:
    """Return one of the points (n, 3) in each cube of an edge (m)."""
    keys = np.floor((points - points.min(axis=0)) / spacing).astype(np.int64) @ [1, 1 << 21, 1 << 42]
    return points[np.sort(np.unique(keys, return_index=True)[1])]


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
