"""Shapes for export: primitives as triangles for formats that lack them, meshes by their content."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.shapes import primitives
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Mesh, Sphere

Solid = Box | Sphere | Cylinder | Cone | Capsule


def triangles(solid: Solid) -> Submesh:
    """Return a primitive as triangles in the frame of its figure; meters, float32."""
    match solid:
        case Box(size):
            return primitives.transformed(primitives.box(), size)
        case Sphere(radius):
            return primitives.transformed(primitives.sphere(), (radius, radius, radius))
        case Cylinder(radius, length):
            return primitives.transformed(primitives.cylinder(), (radius, radius, length))
        case Cone(radius, length):
            return primitives.transformed(primitives.cone(), (radius, radius, length))
        case Capsule(radius, length):
            return primitives.capsule(radius, length)


def same_content(mesh: Mesh) -> Mesh:
    """Return a mesh that equals that of every mesh with the same bytes and scale, wherever they came from."""
    return replace(mesh, uri=f"mesh{ending(mesh.uri)}")
