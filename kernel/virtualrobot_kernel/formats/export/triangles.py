"""Primitives as triangles with normals, at their size, for formats that lack them."""

from __future__ import annotations

from virtualrobot_kernel.formats import shapes
from virtualrobot_kernel.formats.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Sphere

Solid = Box | Sphere | Cylinder | Cone | Capsule


def triangles(solid: Solid) -> Submesh:
    """Return a primitive as triangles in the frame of its figure; meters, float32."""
    match solid:
        case Box(size):
            return shapes.transformed(shapes.box(), size)
        case Sphere(radius):
            return shapes.transformed(shapes.sphere(), (radius, radius, radius))
        case Cylinder(radius, length):
            return shapes.transformed(shapes.cylinder(), (radius, radius, length))
        case Cone(radius, length):
            return shapes.transformed(shapes.cone(), (radius, radius, length))
        case Capsule(radius, length):
            return shapes.capsule(radius, length)
