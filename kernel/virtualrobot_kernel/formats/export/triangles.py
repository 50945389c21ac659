"""Shapes for export: primitives as triangles for formats that lack them, meshes by their content."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.formats import shapes
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.formats.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Mesh, Sphere

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


def same_content(mesh: Mesh) -> Mesh:
    """Return a mesh that equals that of every mesh with the same bytes and scale, wherever they came from."""
    return replace(mesh, uri=f"mesh{ending(mesh.uri)}")
