"""A ray caster in NumPy: T. Moeller and B. Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997."""

from __future__ import annotations

import numpy as np
from virtualrobot_plugins.ray_casters.embree import EmbreeCaster
from virtualrobot_plugins.ray_casters.embreex_scene import EmbreexScene
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.ray_checks import check_rays
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene, Shape, make_shape
from virtualrobot_sdk.testing.ray_curves import curve_hits

_SMALLEST = 1e-14
"""Determinants below this part of the largest possible one are of rays in the plane, or of triangles without area."""


class MoellerTrumbore:
    """Tries every ray on every triangle."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        check_rays(scene, origins, directions, max_range)
        n = len(origins)
        hits = Hits(np.full(n, np.inf), np.full(n, NO_ELEMENT, np.int32), np.zeros((n, 3)), np.full(n, -1, np.int32))
        for i, (shape, pose) in enumerate(zip(scene.shapes, scene.world_t_element, strict=True)):
            corners = (shape.vertices @ pose[:3, :3].T + pose[:3, 3])[shape.triangles]
            if len(corners) == 0:
                continue
            distance, triangle = self.first(corners, origins, directions)
            nearer = (distance <= max_range) & self.counts(distance, hits.distance)
            a, b, c = np.moveaxis(corners[triangle[nearer]], 1, 0)
            across = np.cross(b - a, c - a)
            hits.distance[nearer], hits.element[nearer] = distance[nearer], i
            assert hits.triangle is not None
            hits.triangle[nearer] = triangle[nearer]
            hits.normal[nearer] = self.turned(across / np.linalg.norm(across, axis=1)[:, None], directions[nearer])
        return hits

    def first(self, corners: Floats, origins: Floats, directions: Floats) -> tuple[Floats, np.ndarray]:
        """Return how far each ray comes (n,), and the triangle that it meets first."""
        a, b, c = np.moveaxis(corners, 1, 0)
        ab, ac = b - a, c - a
        p = np.cross(directions[:, None], ac)
        determinant = (p * ab).sum(-1)
        usable = np.abs(determinant) > _SMALLEST * (np.linalg.norm(ab, axis=1) * np.linalg.norm(ac, axis=1))
        inverse = 1.0 / np.where(usable, determinant, 1.0)
        t = origins[:, None] - a
        u = (t * p).sum(-1) * inverse
        q = np.cross(t, ab)
        v = (directions[:, None] * q).sum(-1) * inverse
        distance = (ac * q).sum(-1) * inverse
        hit = self.is_facing(determinant) & usable & (u >= 0) & (v >= 0) & (u + v <= 1) & (distance >= 0)
        distance = np.where(hit, distance, np.inf)
        triangle = distance.argmin(axis=1)
        return distance[np.arange(len(origins)), triangle], triangle

    def is_facing(self, determinant: Floats) -> np.ndarray:
        return np.ones(determinant.shape, np.bool_)

    def counts(self, distance: Floats, before: Floats) -> np.ndarray:
        return distance < before

    def turned(self, normal: Floats, directions: Floats) -> Floats:
        return np.where((normal * directions).sum(axis=1, keepdims=True) > 0, -normal, normal)


class OneSided(MoellerTrumbore):
    """Wrong: back faces are let through."""

    def is_facing(self, determinant: Floats) -> np.ndarray:
        return determinant > 0


class LastElement(MoellerTrumbore):
    """Wrong: of several elements the last one counts, not the nearest."""

    def counts(self, distance: Floats, before: Floats) -> np.ndarray:
        return np.isfinite(distance)


class OutwardNormals(MoellerTrumbore):
    """Wrong: normals point out of the solid, also to who is inside."""

    def turned(self, normal: Floats, directions: Floats) -> Floats:
        return normal


class EndlessRange(MoellerTrumbore):
    """Wrong: the range does not count."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        return super().cast(scene, origins, directions, np.inf)


class KeptByPlace(MoellerTrumbore):
    """Wrong: what is prepared for a shape is kept by its place in the scene, and never made anew."""

    def __init__(self) -> None:
        """Begin."""
        self.kept: dict[int, Shape] = {}

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        shapes = tuple(self.kept.setdefault(i, shape) for i, shape in enumerate(scene.shapes))
        return super().cast(RayScene(shapes, scene.world_t_element), origins, directions, max_range)


class NoChecks(MoellerTrumbore):
    """Wrong: rays that make no sense are cast."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        lengths = np.linalg.norm(directions, axis=1, keepdims=True)
        with np.errstate(all="ignore"):
            return super().cast(scene, origins, directions / lengths, max_range)


class WritesToRays(MoellerTrumbore):
    """Wrong: normalises directions in place."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        return super().cast(scene, origins, directions, max_range)


class ByFormula(MoellerTrumbore):
    """Meets curved surfaces as they are meant."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        flat = tuple(s if s.primitive is None else make_shape(np.zeros((0, 3)), np.zeros((0, 3))) for s in scene.shapes)
        hits = super().cast(RayScene(flat, scene.world_t_element), origins, directions, max_range)
        for i, (shape, pose) in enumerate(zip(scene.shapes, scene.world_t_element, strict=True)):
            if shape.primitive is not None:
                curved = curve_hits(shape.primitive, pose, origins, directions).hits
                nearer = (curved.distance < hits.distance) & (curved.distance <= max_range)
                hits.distance[nearer], hits.element[nearer] = curved.distance[nearer], i
                hits.normal[nearer] = curved.normal[nearer]
        return hits


class Swollen(MoellerTrumbore):
    """Wrong: curved surfaces are met 5 mm too large."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        grown = tuple(
            s if s.primitive is None else make_shape(s.vertices * (1.0 + 0.005 / s.primitive.radius), s.triangles)
            for s in scene.shapes
        )
        return super().cast(RayScene(grown, scene.world_t_element), origins, directions, max_range)


class NextTriangle(MoellerTrumbore):
    """Wrong: tells the triangle after the one that is hit."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        hits = super().cast(scene, origins, directions, max_range)
        assert hits.triangle is not None
        counts = np.array([len(shape.triangles) for shape in scene.shapes])
        is_hit = hits.element != NO_ELEMENT
        hits.triangle[is_hit] = (hits.triangle[is_hit] + 1) % counts[hits.element[is_hit]]
        return hits


class WithoutLibrary(EmbreeCaster):
    """The bundled `embree` as it is where its library can't be driven."""

    def __init__(self) -> None:
        """Have embreex do it."""
        super().__init__()
        self._scene = EmbreexScene()
