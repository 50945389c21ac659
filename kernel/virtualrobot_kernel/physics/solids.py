"""Solids of figures: shapes for a physics engine, and mass spread evenly in them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.physics import BodyShape, ShapeKind

from virtualrobot_kernel.collision.outline import hull_of
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.physics.heights import Heights, heights_of
from virtualrobot_kernel.shapes.submesh import Meshes, stacked
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Mesh, Sphere
from virtualrobot_kernel.world.structure import Inertial

Floats = NDArray[np.float64]

MOST_CORNERS = 64
"""Greatest number of the corners of a hull: engines look at each of them."""
MOST_HULLS = 4096
"""Greatest number of meshes whose hulls are kept."""
LEAST_VOLUME = 1e-14
"""Least volume (m^3) of a mesh that engines tell from none: that of a cube of 22 micrometers."""
SEGMENTS = 32
"""Corners around the base of a cone."""


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Mass (kg), center of mass (3,) and moments of inertia (3, 3) about it, in the frame of a node."""

    mass: float
    center: Floats
    inertia: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """Solids that meshes are, each made once.

    hull: gives the corners (n, 3) of the convex hull of a mesh; none where it has no volume. heights: gives the height
    field that a mesh is; None where it is none.
    """

    hull: Callable[[Mesh], Floats]
    heights: Callable[[Mesh], Heights | None]


def solids(meshes: Meshes) -> Solids:
    """Return what gives solids of meshes; `meshes` gives their triangles."""

    @lru_cache(maxsize=MOST_HULLS)
    def hull(mesh: Mesh) -> Floats:
        corners, faces, _ = hull_of(stacked(meshes(mesh))[0].astype(float), MOST_CORNERS)
        a, b, c = corners[faces].transpose(1, 0, 2) - corners[:1]
        return corners if np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 >= LEAST_VOLUME else corners[:0]

    @lru_cache(maxsize=MOST_HULLS)
    def heights(mesh: Mesh) -> Heights | None:
        corners, faces = stacked(meshes(mesh))
        return heights_of(corners.astype(float), faces.astype(np.int64))

    return Solids(hull, heights)


def shape_of(figure: Figure, solids: Solids, node: str, *, stands: bool = False) -> BodyShape | None:
    """Return the shape of a figure in its node's frame, of meshes and cones their convex hull; None for what is thin.

    Of a mesh that is a height field, and `stands`, the field. Raises KernelError for any other mesh whose hull has no
    volume, by the name of its `node`.
    """
    geometry, pose = figure.geometry, np.asarray(figure.node_t_figure)
    match geometry:
        case Box():
            x, y, z = geometry.size
            return BodyShape(ShapeKind.BOX, (x / 2.0, y / 2.0, z / 2.0), pose)
        case Sphere():
            return BodyShape(ShapeKind.SPHERE, (geometry.radius,), pose)
        case Cylinder():
            return BodyShape(ShapeKind.CYLINDER, (geometry.radius, geometry.length / 2.0), pose)
        case Capsule():
            return BodyShape(ShapeKind.CAPSULE, (geometry.radius, geometry.length / 2.0), pose)
        case Cone():
            turns = np.linspace(0.0, 2.0 * math.pi, SEGMENTS, endpoint=False)
            low = np.full(SEGMENTS, -geometry.length / 2.0)
            base = np.stack([geometry.radius * np.cos(turns), geometry.radius * np.sin(turns), low], axis=1)
            return BodyShape(ShapeKind.HULL, (), pose, np.vstack([base, (0.0, 0.0, geometry.length / 2.0)]))
        case Mesh():
            if stands and (field := solids.heights(geometry)) is not None:
                middle = np.eye(4)
                middle[:2, 3] = field.middle
                return BodyShape(ShapeKind.HEIGHTS, field.cell, pose @ middle, heights=field.heights)
            corners = solids.hull(geometry)
            if not len(corners):
                raise KernelError(
                    f"the mesh {geometry.uri!r} of {node!r} has no volume; what is touched by forces needs one, of "
                    f"{LEAST_VOLUME:g} m^3 at least",
                    node=node,
                    uri=geometry.uri,
                )
            return BodyShape(ShapeKind.HULL, (), pose, corners)
        case _:
            return None


def spread_of(inertial: Inertial) -> Spread:
    """Return the mass of a node as its file or its author tells it."""
    xx, yy, zz = inertial.diagonal
    xy, xz, yz = inertial.products
    rotation = np.asarray(inertial.link_t_inertial)[:3, :3]
    moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Spread(inertial.mass, np.asarray(inertial.link_t_inertial)[:3, 3], rotation @ moments @ rotation.T)


def placed(spread: Spread, pose: Floats) -> Spread:
    """Return a spread as seen from a frame in which its own is at `pose` (4, 4)."""
    turn = pose[:3, :3]
    return Spread(spread.mass, turn @ spread.center + pose[:3, 3], turn @ spread.inertia @ turn.T)


def together(pieces: Sequence[Spread]) -> Spread:
    """Return what some spreads, in one frame, are as one body; one of no mass is nothing."""
    mass = sum(piece.mass for piece in pieces)
    if not mass:
        return Spread(0.0, np.zeros(3), np.zeros((3, 3)))
    if len(pieces) == 1:
        return pieces[0]
    center = np.sum([piece.mass * piece.center for piece in pieces], axis=0) / mass
    inertia = np.sum([piece.inertia + _steiner(piece.mass, piece.center - center) for piece in pieces], axis=0)
    return Spread(mass, center, inertia)


def evenly(mass: float, shapes: Iterable[BodyShape], node: str) -> Spread:
    """Return a mass that is spread evenly in some shapes; what is in two of them counts twice.

    Raises KernelError where there are none, by the name of their `node`.
    """
    whole = together([placed(_own(shape), shape.body_t_shape) for shape in shapes])
    if not whole.mass:
        raise KernelError(f"{node!r} has no figure with a volume, and no `inertial`; to move by forces it needs one")
    return Spread(mass, whole.center, whole.inertia * (mass / whole.mass))


def _own(shape: BodyShape) -> Spread:
    """Return a shape with a density of 1, in its own frame."""
    origin = np.zeros(3)
    if shape.kind is ShapeKind.BOX:
        x, y, z = (2.0 * half for half in shape.size)
        mass = x * y * z
        return Spread(mass, origin, mass / 12.0 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y]))
    radius = shape.size[0] if shape.size else 0.0
    ball = 4.0 / 3.0 * math.pi * radius**3
    if shape.kind is ShapeKind.SPHERE:
        return Spread(ball, origin, 0.4 * ball * radius**2 * np.eye(3))
    if shape.kind is ShapeKind.HULL:
        assert shape.vertices is not None
        return _of_hull(shape.vertices)
    length = 2.0 * shape.size[1]
    tube = math.pi * radius**2 * length
    across, along = tube * (3.0 * radius**2 + length**2) / 12.0, tube * radius**2 / 2.0
    if shape.kind is ShapeKind.CYLINDER:
        return Spread(tube, origin, np.diag([across, across, along]))
    # Two half spheres, each with its center of mass 3/8 of the radius beyond the end of the tube.
    ends = ball * (0.4 * radius**2 + length**2 / 4.0 + 3.0 / 8.0 * length * radius)
    return Spread(tube + ball, origin, np.diag([across + ends, across + ends, along + 0.4 * ball * radius**2]))


def _of_hull(vertices: Floats) -> Spread:
    """Return the hull of points with a density of 1, by the tetrahedra from their middle to its faces."""
    middle = vertices.mean(axis=0)
    corners, faces, _ = hull_of(vertices, max(len(vertices), 4))
    tetrahedra = (corners - middle)[faces]
    volumes = np.einsum("ki,ki->k", tetrahedra[:, 0], np.cross(tetrahedra[:, 1], tetrahedra[:, 2])) / 6.0
    volume = float(volumes.sum())
    sums = tetrahedra.sum(axis=1)
    center = (volumes[:, None] * sums).sum(axis=0) / (4.0 * volume)
    # The second moments of a tetrahedron with a corner at the origin, over its other three.
    products = np.einsum("kci,kcj->kij", tetrahedra, tetrahedra) + np.einsum("ki,kj->kij", sums, sums)
    second = (volumes[:, None, None] * products).sum(axis=0) / 20.0 - volume * np.outer(center, center)
    return Spread(volume, middle + center, np.trace(second) * np.eye(3) - second)


def _steiner(mass: float, lever: Floats) -> Floats:
    """Return the moments of inertia of a point."""
    return mass * (float(lever @ lever) * np.eye(3) - np.outer(lever, lever))
