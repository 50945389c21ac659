"""Surfaces as points with normals: sampled on a mesh, or seen by a sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.given import finite
from virtualrobot_apps.seeing.spreads import spreads

Floats = NDArray[np.float64]

NEIGHBOURS = 16
"""Number of points of a cloud that a normal is of."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Points (n, 3) of a body (m), and normals (n, 3) of length 1 that lead out of it."""

    points: Floats
    normals: Floats

    def __post_init__(self) -> None:
        """Raise InvalidArgumentError for too few points, and for numbers that are not finite."""
        points, normals = finite(self.points, 3, "points of a surface"), finite(self.normals, 3, "normals of a surface")
        if len(points) != len(normals):
            raise InvalidArgumentError(f"a surface has a normal for each point, not {len(normals)} for {len(points)}")
        if len(self.points) < NEIGHBOURS:
            raise InvalidArgumentError(f"a surface has {NEIGHBOURS} points at least, not {len(self.points)}")

    @property
    def spacing(self) -> float:
        """Return the distance between points that are beside each other (m)."""
        away, _ = KDTree(self.points).query(self.points, k=2)
        return float(np.median(away[:, 1]))


def surface_of_mesh(vertices: ArrayLike, faces: ArrayLike, count: int, rng: np.random.Generator) -> Surface:
    """Return points of a mesh, as many for each area; one that is inside out is turned.

    Raises:
        InvalidArgumentError: for a mesh without area.
    """
    corners = np.asarray(vertices, np.float64)[np.asarray(faces, np.int64)]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(across, axis=1)
    if not len(corners) or not np.isfinite(doubled).all() or doubled.sum() <= 0.0:
        raise InvalidArgumentError(f"a mesh of {len(corners)} triangles has no area that could be gripped")
    chosen = rng.choice(len(corners), count, p=doubled / doubled.sum())
    # R. Osada et al., Shape Distributions, ACM Transactions on Graphics 21, 2002, equation 1.
    first, second = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.column_stack([1.0 - first, first * (1.0 - second), first * second])
    points = (corners[chosen] * weights[:, :, None]).sum(axis=1)
    volume = (np.cross(corners[:, 0], corners[:, 1]) * corners[:, 2]).sum()
    return Surface(points, across[chosen] / doubled[chosen, None] * (1.0 if volume >= 0.0 else -1.0))


def surface_of_cloud(points: Floats, seen_from: Floats) -> Surface:
    """Return a cloud (n, 3) with normals towards the places (3,) or (n, 3) that its points were seen from."""
    points = finite(points, 3, "points of a cloud")
    seen_from = finite(np.atleast_2d(seen_from), 3, "places that a cloud was seen from")
    if len(seen_from) not in (1, len(points)):
        raise InvalidArgumentError(
            f"a cloud of {len(points)} points was seen from 1 place or as many, not {len(seen_from)}"
        )
    if len(points) < NEIGHBOURS:
        raise InvalidArgumentError(f"a cloud has {NEIGHBOURS} points at least, not {len(points)}")
    normals = spreads(KDTree(points), points, points, NEIGHBOURS).axes[:, :, 0]
    sides = np.where((normals * (seen_from - points)).sum(axis=1) < 0.0, -1.0, 1.0)
    return Surface(points, normals * sides[:, None])
