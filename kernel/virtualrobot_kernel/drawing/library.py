"""Shapes that are drawn, each made once: primitives at unit size, meshes as their files have them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.figure_glb import Rgba, encode
from virtualrobot_kernel.shapes import primitives
from virtualrobot_kernel.shapes.creases import shaded
from virtualrobot_kernel.shapes.figure_library import FigureLibrary
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Frame, Geometry, Mesh, Sphere

log = logging.getLogger(__name__)

Vector = tuple[float, float, float]
ShapeKey = str | Capsule | Mesh
"""A unit primitive by name, or a geometry that is not scaled."""

AXIS_ARROW = "axis arrow"

UNIT_SHAPES: dict[str, Callable[[], Submesh]] = {
    "box": primitives.box,
    "sphere": primitives.sphere,
    "cylinder": primitives.cylinder,
    "cone": primitives.cone,
    "frame": primitives.frame,
    AXIS_ARROW: primitives.axis_arrow,
}


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """Triangles with normals; for bounds the places (n, 3) of their corners, and the corners (8, 3) of their box."""

    parts: tuple[Submesh, ...]
    points: NDArray[np.float32]
    corners: NDArray[np.float32]


NOWHERE = np.zeros((0, 3), np.float32)
EMPTY = Shape((), NOWHERE, NOWHERE)


def shape_key(geometry: Geometry) -> tuple[ShapeKey, Vector] | None:
    """Return which shape a geometry is and the factors that scale it; None for points, lines and labels."""
    match geometry:
        case Box(size):
            return "box", size
        case Sphere(radius):
            return "sphere", (radius, radius, radius)
        case Cylinder(radius, length):
            return "cylinder", (radius, radius, length)
        case Cone(radius, length):
            return "cone", (radius, radius, length)
        case Frame(length):
            return "frame", (length, length, length)
        case Capsule() | Mesh():
            return geometry, (1.0, 1.0, 1.0)
    return None


class ShapeLibrary(FigureLibrary[ShapeKey, Shape]):
    """Shapes that are drawn. A mesh that cannot be read is told once and drawn as nothing."""

    def files(self, key: ShapeKey, color: Rgba | None) -> tuple[bytes, ...]:
        """Return the GLB files that show a shape in a colour."""
        return encode(self.get(key).parts, color)

    def _made(self, key: ShapeKey) -> Shape:
        if isinstance(key, str):
            parts = (UNIT_SHAPES[key](),)
        elif isinstance(key, Capsule):
            parts = (primitives.capsule(key.radius, key.length),)
        else:
            try:
                parts = tuple(shaded(part) for part in self.meshes(key))
            except Exception:  # a mesh that cannot be drawn must not take the picture of everything else with it
                log.exception("mesh %s is not drawn", key.uri)
                return EMPTY
        points = np.concatenate([part.vertices for part in parts])
        low, high = points.min(axis=0), points.max(axis=0)
        corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(8, 3)
        return Shape(parts, points, corners)
