"""Solids for tests of collisions: each kind of figure, random places, and the same in coal."""

from __future__ import annotations

from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
import trimesh
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Pose, Sphere

from tests.unit.world.builders import random_pose

coal: Any = import_module("coal")  # it comes with pinocchio and has no types

TORUS = Mesh("torus.stl", "0" * 64)
PRIMITIVES: dict[str, Geometry] = {
    "box": Box((0.3, 0.2, 0.5)),
    "sphere": Sphere(0.2),
    "cylinder": Cylinder(0.1, 0.4),
    "cone": Cone(0.1, 0.4),
    "capsule": Capsule(0.1, 0.4),
}
GEOMETRIES: dict[str, Geometry] = {**PRIMITIVES, "torus": TORUS}


@lru_cache
def torus() -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) as single floats and faces (m, 3) of a torus: eight pieces."""
    mesh = trimesh.creation.torus(0.3, 0.1, major_sections=64, minor_sections=32)
    return np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.int32)


def load(mesh: Mesh) -> tuple[Submesh, ...]:
    """Return the torus as two submeshes."""
    vertices, faces = torus()
    half = len(faces) // 2
    return Submesh(vertices, faces[:half]), Submesh(vertices, faces[half:])


@lru_cache
def shapes() -> CollisionShapes:
    """Return a library that knows the torus."""
    return CollisionShapes(load)


def placed(*elements: tuple[Geometry, Pose]) -> Placed:
    """Return figures at poses."""
    solids = [shapes().get(geometry) for geometry, _ in elements]
    return Placed([one for one in solids if one], np.array([pose for _, pose in elements]).reshape(-1, 4, 4))


def near(rng: np.random.Generator, spread: float = 0.6) -> Pose:
    """Return a random pose whose origin is within a cube of edges twice `spread`."""
    pose = random_pose(rng)
    pose[:3, 3] *= spread
    return pose


@lru_cache
def in_coal(geometry: Geometry) -> Any:  # noqa: ANN401 coal has no types
    """Return a figure as coal has it."""
    match geometry:
        case Box(size):
            return coal.Box(*size)
        case Sphere(radius):
            return coal.Sphere(radius)
        case Cylinder(radius, length):
            return coal.Cylinder(radius, length)
        case Cone(radius, length):
            return coal.Cone(radius, length)
        case Capsule(radius, length):
            return coal.Capsule(radius, length)
    return model_in_coal(*torus())


def model_in_coal(vertices: np.ndarray, faces: np.ndarray) -> Any:  # noqa: ANN401 coal has no types
    """Return triangles as coal has them."""
    model = coal.BVHModelOBBRSS()
    corners, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in vertices.astype(np.float64):
        corners.append(vertex)
    for face in faces.tolist():
        triangles.append(coal.Triangle(*face))
    model.beginModel(len(faces), len(vertices))
    model.addSubModel(corners, triangles)
    model.endModel()
    return model


def distance_by_coal(one: Geometry, pose: Pose, other: Geometry, place: Pose) -> float:
    """Return the distance that coal tells, to 1e-9; at most 0 where they touch."""
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-9, 1000
    at = (coal.Transform3s(each[:3, :3], each[:3, 3]) for each in (pose, place))
    return coal.distance(in_coal(one), next(at), in_coal(other), next(at), request, result)
