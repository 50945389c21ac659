"""Figures as shapes for rays, each made once: primitives at their size, meshes as their files have them."""

from __future__ import annotations

import logging
import threading

import numpy as np
from virtualrobot_sdk.rays import Primitive, Round, Shape, make_shape

from virtualrobot_kernel.formats import shapes
from virtualrobot_kernel.formats.submesh import Meshes, Submesh, stacked
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Sphere

log = logging.getLogger(__name__)

EMPTY = make_shape(np.zeros((0, 3)), np.zeros((0, 3)))


class ShapeLibrary:
    """Shapes by geometry, made when first asked for; any thread may ask.

    Two threads that ask for the same new shape at once both make it, and keep one. A mesh that cannot be read is told
    once and seen as nothing.
    """

    def __init__(self, meshes: Meshes) -> None:
        """Take the triangles of meshes from `meshes`."""
        self.meshes = meshes
        self._shapes: dict[Geometry, Shape] = {}
        self._lock = threading.Lock()

    def get(self, geometry: Geometry) -> Shape | None:
        """Return a shape; None for points, lines, frames and labels, which no ray meets."""
        shape = self._shapes.get(geometry)
        if shape is None:
            made = self._made(geometry)
            if made is None:
                return None
            with self._lock:
                shape = self._shapes.setdefault(geometry, made)
        return shape

    def __len__(self) -> int:
        """Return how many shapes are kept."""
        return len(self._shapes)

    def keep(self, geometries: set[Geometry]) -> None:
        """Forget all shapes but those of `geometries`."""
        with self._lock:
            self._shapes = {key: shape for key, shape in self._shapes.items() if key in geometries}

    def _made(self, geometry: Geometry) -> Shape | None:
        match geometry:
            case Box(size):
                return _shape(shapes.transformed(shapes.box(), size))
            case Sphere(radius):
                return _shape(
                    shapes.transformed(shapes.sphere(), (radius, radius, radius)), Primitive(Round.SPHERE, radius)
                )
            case Cylinder(radius, length):
                unit = shapes.transformed(shapes.cylinder(), (radius, radius, length))
                return _shape(unit, Primitive(Round.CYLINDER, radius, length))
            case Cone(radius, length):
                unit = shapes.transformed(shapes.cone(), (radius, radius, length))
                return _shape(unit, Primitive(Round.CONE, radius, length))
            case Capsule(radius, length):
                return _shape(shapes.capsule(radius, length), Primitive(Round.CAPSULE, radius, length))
            case Mesh():
                return self._mesh(geometry)
        return None

    def _mesh(self, mesh: Mesh) -> Shape:
        try:
            parts = self.meshes(mesh)
        except Exception:  # a mesh that cannot be read must not blind all sensors
            log.exception("mesh %s is not seen by sensors", mesh.uri)
            return EMPTY
        return make_shape(*stacked(parts))


def _shape(part: Submesh, primitive: Primitive | None = None) -> Shape:
    return make_shape(part.vertices, part.faces, primitive)
