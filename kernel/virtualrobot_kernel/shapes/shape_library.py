"""Figures as shapes for rays, each made once: primitives at their size, meshes as their files have them."""

from __future__ import annotations

import logging

import numpy as np
from virtualrobot_sdk.rays import Primitive, Round, Shape, make_shape

from virtualrobot_kernel.shapes import primitives
from virtualrobot_kernel.shapes.figure_library import FigureLibrary
from virtualrobot_kernel.shapes.submesh import Submesh, stacked
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Sphere

log = logging.getLogger(__name__)

EMPTY = make_shape(np.zeros((0, 3)), np.zeros((0, 3)))


class ShapeLibrary(FigureLibrary[Geometry, Shape | None]):
    """Shapes by geometry; None for points, lines, frames and labels, which no ray meets.

    A mesh that cannot be read is told once and seen as nothing.
    """

    def _made(self, key: Geometry) -> Shape | None:
        match key:
            case Box(size):
                return _shape(primitives.transformed(primitives.box(), size))
            case Sphere(radius):
                return _shape(
                    primitives.transformed(primitives.sphere(), (radius, radius, radius)),
                    Primitive(Round.SPHERE, radius),
                )
            case Cylinder(radius, length):
                unit = primitives.transformed(primitives.cylinder(), (radius, radius, length))
                return _shape(unit, Primitive(Round.CYLINDER, radius, length))
            case Cone(radius, length):
                unit = primitives.transformed(primitives.cone(), (radius, radius, length))
                return _shape(unit, Primitive(Round.CONE, radius, length))
            case Capsule(radius, length):
                return _shape(primitives.capsule(radius, length), Primitive(Round.CAPSULE, radius, length))
            case Mesh():
                return self._mesh(key)
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
