"""Rays by the interface of the package embreex, for where its library can't be driven directly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, Shape


class EmbreexScene:
    """Elements at their places, as triangles of one scene that is built anew whenever one of them moves."""

    def __init__(self) -> None:
        """Make an empty scene; raises ImportError where there is no embreex."""
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._new_scene, self._add = EmbreeScene, TriangleMesh
        self._scene = EmbreeScene(robust=True)
        self._keys: list[str] = []
        self._poses = np.empty((0, 4, 4))
        self._elements = np.empty(0, np.int32)  # of each geometry of the scene

    def place(self, shapes: Sequence[Shape], world_t_element: Floats) -> None:
        """Have the elements `shapes` (e) at `world_t_element` (e, 4, 4), rigid transforms; e may be 0.

        Raises ArgumentError, before anything has changed, for poses of another number or not finite, and for triangles
        of vertices that are not there or not finite.
        """
        poses = np.array(world_t_element, np.float64)
        if poses.shape != (len(shapes), 4, 4) or not np.isfinite(poses).all():
            raise ArgumentError(f"{len(shapes)} elements need as many finite poses (e, 4, 4), not {poses.shape}")
        keys = [shape.key for shape in shapes]
        if keys == self._keys and np.array_equal(poses, self._poses):
            return
        scene = self._new_scene(robust=True)
        elements = []
        for i, (shape, pose) in enumerate(zip(shapes, poses, strict=True)):
            if not len(shape.triangles):
                continue
            if not 0 <= shape.triangles.min() <= shape.triangles.max() < len(shape.vertices):
                raise ArgumentError(f"a shape has triangles of other corners than its {len(shape.vertices)} vertices")
            vertices = (shape.vertices @ pose[:3, :3].T + pose[:3, 3]).astype(np.float32)
            if not np.isfinite(vertices).all():
                raise ArgumentError("a shape has vertices that are not finite")
            self._add(scene, vertices, shape.triangles)
            elements.append(i)
        self._scene, self._keys, self._poses = scene, keys, poses
        self._elements = np.array(elements, np.int32)

    def hits(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """Return what rays (n, 3) first meet within `max_range` (m)."""
        n = len(directions)
        distance, normal = np.full(n, np.inf), np.zeros((n, 3))
        element, triangle = np.full(n, NO_ELEMENT, np.int32), np.full(n, -1, np.int32)
        if n and len(self._elements):
            found = self._scene.run(origins.astype(np.float32), directions.astype(np.float32), output=True)
            is_hit = (found["geomID"] >= 0) & (found["tfar"] <= max_range)
            across = found["Ng"][is_hit].astype(np.float64)
            slope = np.einsum("ij,ij->i", across, directions[is_hit])
            across *= np.where(slope > 0.0, -1.0, 1.0)[:, None]
            # So small a triangle that its normal is lost in single precision has the ray's.
            across[~across.any(axis=1)] = -directions[is_hit][~across.any(axis=1)]
            distance[is_hit] = found["tfar"][is_hit]
            element[is_hit], triangle[is_hit] = self._elements[found["geomID"][is_hit]], found["primID"][is_hit]
            normal[is_hit] = across / np.linalg.norm(across, axis=1, keepdims=True)
        return Hits(distance, element, normal, triangle)
