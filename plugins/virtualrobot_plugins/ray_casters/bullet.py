"""A ray caster by PyBullet (E. Coumans and Y. Bai, 2016-2021): an engine of its own to compare others with."""

from __future__ import annotations

import importlib
import os
import sys
import weakref
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from virtualrobot_sdk.errors import PluginError
from virtualrobot_sdk.kinematics import Floats, Integers
from virtualrobot_sdk.poses import quaternion
from virtualrobot_sdk.ray_checks import check_rays
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene, Shape

RAYS_AT_ONCE = 16_383
"""Largest number of rays in a call of PyBullet: one less than it says; of 16,384 it answers none."""
TRIANGLES_AT_ONCE = 40_000
"""Largest number of triangles of a mesh: PyBullet takes 131,072 vertices, and each triangle may have three."""
MOST_UNUSED = 500_000
"""Largest number of triangles kept of shapes that are no longer in the scene, should they come back."""
_NUMBERS = list(range(3 * TRIANGLES_AT_ONCE))


@dataclass(slots=True)
class _Kept:
    """Bullet's copies of one of our shapes."""

    meshes: list[int]
    """Its collision shapes, one for each piece."""
    triangles: int
    radius: float
    """Distance of the farthest vertex from the origin of its frame (m)."""
    bodies: list[list[int]] = field(default_factory=list)
    """For each element that has the shape, the bodies that are its pieces."""


class BulletCaster:
    """Asks PyBullet, in a client of its own, about the triangles as they are and never about hulls around them.

    Curved surfaces are met as their triangles: Bullet's own spheres, cylinders and capsules are not met from inside. It
    does not tell which triangle.
    """

    def __init__(self) -> None:
        """Connect; raises PluginError where PyBullet is not installed."""
        try:
            self._bullet = _imported()
        except ImportError as error:
            said = "PyBullet cannot be imported (it has packages for Python up to 3.11): pip install pybullet"
            raise PluginError(f"{said}; {error}") from error
        self._client = self._bullet.connect(self._bullet.DIRECT)
        weakref.finalize(self, self._bullet.disconnect, self._client)
        self._kept: dict[str, _Kept] = {}

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return the first hits, as `RayCaster` says."""
        check_rays(scene, origins, directions, max_range)
        element_of = self._place(scene)
        n = len(origins)
        # Its rays have ends, and its answer is a part of their length: they end right behind the scene.
        lengths = np.minimum(self._across(scene, origins), max_range) if element_of else np.zeros(n)
        hits = Hits(np.full(n, np.inf), np.full(n, NO_ELEMENT, np.int32), np.zeros((n, 3)))
        for start in range(0, n if element_of else 0, RAYS_AT_ONCE):
            part = slice(start, start + RAYS_AT_ONCE)
            ends = origins[part] + lengths[part, None] * directions[part]
            answers = self._bullet.rayTestBatch(origins[part], ends, physicsClientId=self._client)
            bodies, _, fractions, _, normals = zip(*answers, strict=True)
            element = np.array([element_of.get(body, NO_ELEMENT) for body in bodies], np.int32)
            is_hit = element != NO_ELEMENT
            hits.element[part] = element
            hits.distance[part] = np.where(is_hit, np.array(fractions) * lengths[part], np.inf)
            hits.normal[part] = np.where(is_hit[:, None], _turned(np.array(normals), directions[part]), 0.0)
        return hits

    def _place(self, scene: RayScene) -> dict[int, int]:
        """Put a body, or more, where each element is; return the element of each body."""
        wanted = {shape.key: shape for shape in scene.shapes}
        if sum(kept.triangles for key, kept in self._kept.items() if key not in wanted) > MOST_UNUSED:
            # Bullet refuses to take away a single shape that once had a body.
            self._bullet.resetSimulation(physicsClientId=self._client)
            self._kept.clear()
        for key, shape in wanted.items():
            if key not in self._kept:
                meshes = [self._mesh(*piece) for piece in _pieces(shape)]
                radius = float(np.linalg.norm(shape.vertices, axis=1).max(initial=0.0))
                self._kept[key] = _Kept(meshes, len(shape.triangles), radius)
        placed = dict.fromkeys(self._kept, 0)
        element_of = {}
        for i, (shape, pose) in enumerate(zip(scene.shapes, scene.world_t_element, strict=True)):
            kept = self._kept[shape.key]
            if placed[shape.key] == len(kept.bodies):
                made = [self._bullet.createMultiBody(0.0, mesh, physicsClientId=self._client) for mesh in kept.meshes]
                kept.bodies.append(made)
            position, turn = pose[:3, 3].tolist(), quaternion(pose[:3, :3])
            for body in kept.bodies[placed[shape.key]]:
                self._bullet.resetBasePositionAndOrientation(body, position, turn, physicsClientId=self._client)
                element_of[body] = i
            placed[shape.key] += 1
        for key, count in placed.items():
            for bodies in self._kept[key].bodies[count:]:
                for body in bodies:
                    self._bullet.removeBody(body, physicsClientId=self._client)
            del self._kept[key].bodies[count:]
        return element_of

    def _across(self, scene: RayScene, origins: Floats) -> Floats:
        """Return how far away (n,) from each origin the far side of a sphere around the scene is."""
        positions = scene.world_t_element[:, :3, 3]
        center = positions.mean(axis=0)
        farthest = [self._kept[shape.key].radius for shape in scene.shapes]
        radius = (np.linalg.norm(positions - center, axis=1) + farthest).max()
        return np.linalg.norm(origins - center, axis=1) + 1.001 * radius + 1e-3

    def _mesh(self, vertices: Floats, triangles: Integers) -> int:
        """Return a new collision shape of triangles (t, 3), rows of `vertices` (v, 3), as they are."""
        rows = vertices.tolist()
        mesh = self._bullet.createCollisionShape(
            self._bullet.GEOM_MESH,
            vertices=rows,
            indices=[_NUMBERS[i] for i in triangles.ravel().tolist()],
            flags=self._bullet.GEOM_FORCE_CONCAVE_TRIMESH,
            physicsClientId=self._client,
        )
        # PyBullet never gives back the objects in the two lists: so they are emptied here, and always the same there.
        for row in rows:
            row.clear()
        return mesh


def _imported() -> Any:  # noqa: ANN401  a module without types
    """Return PyBullet, imported without the line that its native code writes to the error output each time."""
    sys.stderr.flush()
    errors, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        return importlib.import_module("pybullet")
    finally:
        os.dup2(errors, 2)
        os.close(errors)
        os.close(nowhere)


def _pieces(shape: Shape) -> Iterator[tuple[Floats, Integers]]:
    """Yield the triangles that have an area in pieces that PyBullet takes: vertices (v, 3) and rows of them (t, 3)."""
    a, b, c = np.moveaxis(shape.vertices[shape.triangles].astype(np.float64), 1, 0)
    triangles = shape.triangles[np.cross(b - a, c - a).any(axis=1)]
    for start in range(0, len(triangles), TRIANGLES_AT_ONCE):
        used, rows = np.unique(triangles[start : start + TRIANGLES_AT_ONCE], return_inverse=True)
        yield shape.vertices[used].astype(np.float64), rows.astype(np.int32)


def _turned(normals: Floats, directions: Floats) -> Floats:
    """Return the normals (n, 3) of unit length, each turned to the origin of its ray."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0.0, lengths, 1.0)
    return np.where(np.einsum("ij,ij->i", normals, directions)[:, None] > 0.0, -normals, normals)
