"""The convex outline of a figure: what its depth in others is measured with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.numeric.hull import convex_hull

Floats = NDArray[np.float64]

CORNERS = 2048
"""The most corners of an outline: each direction that is tried costs one multiplication and addition for each."""

DIRECTIONS = 256
"""In how many the outline of a flat mesh of many triangles is looked for."""

ROUNDING = 1e-6
"""A mesh is its hull when surface and volume of both differ by less than this part."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """The hull of points, or of two circles about z.

    Attributes:
        corners: (n, 3) in the figure's frame; n is 0 for circles.
        circles: half the length along z, the radius below and the radius above; None for points.
        exact: whether the figure is this, but for its radius, and not merely within.
    """

    corners: Floats
    circles: tuple[float, float, float] | None
    exact: bool

    def placed(self, pose: Floats, origin: Floats) -> tuple[Floats, Floats]:
        """Return corners (n, 3) and circles (9,) or (0,) at a pose, relative to an origin, for `penetration`."""
        place = pose[:3, 3] - origin
        if self.circles is None:
            return np.ascontiguousarray(self.corners @ pose[:3, :3].T + place), np.zeros(0)
        return np.zeros((0, 3)), np.concatenate([place, pose[:3, 2], self.circles])


def hull_of(points: Floats, most: int) -> tuple[Floats, NDArray[np.int32], float]:
    """Return the hull of points (m, 3): corners (n, 3), faces (k, 3), and how far it is exceeded, in meters.

    Where all are in a plane there are no faces, and the corners are all of them.

    Args:
        points: m at least 1.
        most: how many corners the hull has at most, 4 or more.
    """
    points = np.ascontiguousarray(points)
    faces, exceeded = np.empty((2 * most, 3), np.int32), np.zeros(1)
    count = convex_hull(points, most, faces, exceeded)
    used, places = np.unique(faces[:count], return_inverse=True)
    if count == 0:
        return points, faces[:0], 0.0
    return points[used], places.reshape(-1, 3).astype(np.int32), float(exceeded[0])


def outline_of(triangles: Floats) -> Outline:
    """Return the outline of triangles (m, 3, 3), with at most CORNERS corners.

    It is exact when the triangles are a closed convex surface: then both surface and volume are those of the hull.
    """
    corners, faces, exceeded = hull_of(triangles.reshape(-1, 3), CORNERS)
    size = float(np.ptp(corners, axis=0).max())
    if not len(faces):
        return Outline(_spread(corners), None, len(triangles) == 1)
    hull = _measures(corners[faces])
    same = all(abs(ours - theirs) <= ROUNDING * theirs for ours, theirs in zip(_measures(triangles), hull, strict=True))
    return Outline(corners, None, same and exceeded <= ROUNDING * size)


def _spread(corners: Floats) -> Floats:
    """Return the farthest of the points of a plane in DIRECTIONS, or all where they are few."""
    if len(corners) <= CORNERS:
        return corners
    _, _, axes = np.linalg.svd(corners[:: len(corners) // CORNERS] - corners[0], full_matrices=False)
    angle = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
    directions = np.cos(angle)[:, None] * axes[0] + np.sin(angle)[:, None] * axes[1]
    return corners[np.unique([int((corners @ direction).argmax()) for direction in directions])]


def _measures(triangles: Floats) -> tuple[float, float]:
    """Return the surface (m^2) of triangles (m, 3, 3), and the volume (m^3) that they enclose if they are closed."""
    a = triangles[0, 0]
    edges = triangles[:, 1:] - triangles[:, :1]
    normals = np.cross(edges[:, 0], edges[:, 1])
    volume = float(np.einsum("ij,ij->", triangles[:, 0] - a, normals)) / 6.0
    return 0.5 * float(np.linalg.norm(normals, axis=1).sum()), abs(volume)
