"""A ray caster in plain NumPy: the one to read, to change and to replace by one's own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.ray_checks import check_rays
from virtualrobot_sdk.rays import NO_ELEMENT, Booleans, Hits, RayScene, Singles

PAIRS = 1 << 18
"""Number of pairs of a ray and a triangle tried at once: so memory stays below some 80 MB, whatever the scene."""


class ReferenceCaster:
    """Tries each ray on each triangle of the elements that it comes near to, in plain NumPy: to read and to replace."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return the first hits, as `RayCaster` says."""
        check_rays(scene, origins, directions, max_range)
        n = len(origins)
        distance, normal = np.full(n, np.inf), np.zeros((n, 3))
        element, triangle = np.full(n, NO_ELEMENT, np.int32), np.full(n, -1, np.int32)
        for i, (shape, world_t_element) in enumerate(zip(scene.shapes, scene.world_t_element, strict=True)):
            # Rays are brought to the element rather than the element to the rays: a ray is less than a mesh.
            rotation, position = world_t_element[:3, :3], world_t_element[:3, 3]
            o, d = (origins - position) @ rotation, directions @ rotation
            rays = np.flatnonzero(comes_near(shape.vertices, o, d, np.minimum(distance, max_range)))
            if len(rays) == 0:
                continue
            at_once = PAIRS // len(rays) + 1
            for start in range(0, len(shape.triangles), at_once):
                corners = shape.vertices[shape.triangles[start : start + at_once]].astype(np.float64)
                found, row, across = first_hits(corners, o[rays], d[rays])
                nearer = (found < distance[rays]) & (found <= max_range)
                hit = rays[nearer]
                distance[hit], element[hit], triangle[hit] = found[nearer], i, start + row[nearer]
                normal[hit] = across[nearer] @ rotation.T
        # Surfaces have two sides: the normal is the one of the side that the ray comes from.
        normal[np.einsum("ij,ij->i", normal, directions) > 0.0] *= -1.0
        return Hits(distance, element, normal, triangle)


def comes_near(vertices: Singles, origins: Floats, directions: Floats, ranges: Floats) -> Booleans:
    """Return which rays (n,) meet a sphere around vertices (v, 3) before they end, each at its range."""
    if len(vertices) == 0:
        return np.zeros(len(origins), np.bool_)
    low, high = vertices.min(axis=0).astype(np.float64), vertices.max(axis=0).astype(np.float64)
    to_center, radius = (low + high) / 2.0 - origins, np.linalg.norm(high - low) / 2.0
    along = np.einsum("ij,ij->i", to_center, directions)
    beside = np.linalg.norm(to_center - along[:, None] * directions, axis=1)
    return (beside <= radius) & (along >= -radius) & (along - radius <= ranges)


def first_hits(corners: Floats, origins: Floats, directions: Floats) -> tuple[Floats, NDArray[np.intp], Floats]:
    """Return how far n rays come (n,), inf without a hit, which triangle (n,) each meets first, and its normal (n, 3).

    A hit solves o + t d = a + u (b - a) + v (c - a) with u, v >= 0 and u + v <= 1 (T. Moeller and B. Trumbore, "Fast,
    Minimum Storage Ray/Triangle Intersection", 1997). By Cramer's rule t, u and v are quotients of triple products, and
    with the ray's moment m = o x d these are matrix products of all rays with all triangles.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, ac, moments = b - a, c - a, np.cross(origins, directions)
    normal = np.cross(ab, ac)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = directions @ normal.T
        t = ((a * normal).sum(axis=1) - origins @ normal.T) / slope
        u = -(moments @ ac.T + directions @ np.cross(a, ac).T) / slope
        v = (moments @ ab.T + directions @ np.cross(a, ab).T) / slope
        # Of a triangle without area, or one that the ray runs along, they are infinite or NaN, and nothing is hit.
        t = np.where((t >= 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0), t, np.inf)
        first = t.argmin(axis=1)
        return t[np.arange(len(t)), first], first, (normal / np.linalg.norm(normal, axis=1, keepdims=True))[first]
