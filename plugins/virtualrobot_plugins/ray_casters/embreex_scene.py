"""Rays by the interface of the package embreex, for where its library can't be driven directly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.embree import Traced
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Shape, Singles


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
        self._elements = np.array([*elements, NO_ELEMENT], np.int32)

    def cast(self, origins: ArrayLike, directions: ArrayLike, max_range: float) -> Traced:
        """Return what rays (n, 3) first meet within `max_range` (m)."""
        starts, along = np.array(origins, np.float32), np.array(directions, np.float32)
        n = len(along)
        if n == 0 or len(self._elements) < 2:
            nothing = np.full(n, NO_ELEMENT, np.int32)
            return Traced(np.full(n, np.inf, np.float32), nothing, nothing.copy(), *_zeros(n))
        found = self._scene.run(starts, along, output=True)
        is_hit = (found["geomID"] >= 0) & (found["tfar"] <= max_range)
        across = found["Ng"].astype(np.float64)
        length = np.linalg.norm(across, axis=1)
        is_lost = is_hit & ~(length > 0.0)  # so small a triangle that its normal is lost in single precision
        across[is_lost], length[is_lost] = -along[is_lost], 1.0
        uv, normal = _zeros(n)
        uv[is_hit] = np.column_stack([found["u"], found["v"]])[is_hit]
        normal[is_hit] = across[is_hit] / length[is_hit, None]
        return Traced(
            np.where(is_hit, found["tfar"], np.float32(np.inf)),
            np.where(is_hit, self._elements[found["geomID"]], NO_ELEMENT).astype(np.int32),
            np.where(is_hit, found["primID"], -1).astype(np.int32),
            uv,
            normal,
        )


def _zeros(n: int) -> tuple[Singles, Singles]:
    return np.zeros((n, 2), np.float32), np.zeros((n, 3), np.float32)
