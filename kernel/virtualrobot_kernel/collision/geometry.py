"""Figures as FCL has them, each made once: solids for touching, and their cores as triangles for distances.

FCL's distances between triangles are exact to rounding and bring the right points; those of its convex solver are off
by up to 3e-4 m at curved surfaces, and its points are wrong between a mesh and a solid (python-fcl 0.7). So distances
are always asked between triangles: a sphere is a point and a capsule a segment, both with a radius around.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import fcl
import numpy as np

from virtualrobot_kernel.collision import nearest
from virtualrobot_kernel.collision.nearest import Floats, Nearest
from virtualrobot_kernel.collision.outline import Outline, hull_of, outline_of
from virtualrobot_kernel.collision.tessellation import Integers, box_triangles, pieces, turned_triangles
from virtualrobot_kernel.numeric.balls import ball_tree
from virtualrobot_kernel.shapes.figure_library import FigureLibrary
from virtualrobot_kernel.shapes.submesh import stacked
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Sphere

log = logging.getLogger(__name__)

SMALL = 1e-6
"""A hull out of which a mesh reaches less than this part of its size is the hull: that is rounding."""

SLIVER = 1e-9
"""A triangle that is lower than this part of its length has no area."""

STEP = 1 << 16

BALL, BALLS = 0.008, 25.0
"""Radius in m of the balls that triangles are cut for; of large figures half their length divided by the second."""

NOTHING = -1e30
"""Half the extent of what has no triangles, in meters: it is near to nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Some triangles of a core: the FCL model, its corners (n, 3, 3), and the box around it in the figure's frame."""

    model: Any
    triangles: Floats
    centre: Floats
    half: Floats


@dataclass(frozen=True, slots=True)
class MadeOfMesh:
    """Result of making a mesh's solids.

    Attributes:
        triangles: how many it has.
        warning: what is wrong with it, in words; empty when nothing is.
        seconds: how long it took to make what collides.
    """

    triangles: int
    warning: str
    seconds: float


@dataclass(frozen=True, eq=False)
class Solid:
    """A figure: what is nearer than `radius` to its core.

    Attributes:
        solid: FCL's solid; None for a mesh, which is a surface.
        pieces: the core's triangles.
        radius: in meters; 0 but for spheres and capsules.
        nearest: finds the nearest point of the core; None for a mesh.
        piece_centre: (k, 3) and `piece_half` (k, 3): the box around each piece in the figure's frame.
        centre: (3,) and `half` (3,): the box around the core; a half far below 0 where there are no triangles.
        is_box: whether it is a box about its frame's origin, all of it.
        circles: of cylinders and cones half the length, the radius below and above; None of others.
        margin: by how much it counts as thicker, in meters: so far a mesh reaches out of the hull that it collides as.
        mesh: what is to be told of a mesh; None for others.
    """

    solid: Any
    pieces: tuple[Piece, ...]
    radius: float
    nearest: Nearest | None
    piece_centre: Floats
    piece_half: Floats
    centre: Floats
    half: Floats
    circles: tuple[float, float, float] | None = None
    margin: float = 0.0
    mesh: MadeOfMesh | None = None
    is_box: bool = False

    @cached_property
    def outline(self) -> Outline:
        """The convex outline of the core, made when first asked for: a mesh's takes its time."""
        if self.circles is not None:
            return Outline(np.zeros((0, 3)), self.circles, True)
        triangles = np.concatenate([piece.triangles for piece in self.pieces])
        if self.solid is not None:
            return Outline(np.unique(triangles.reshape(-1, 3), axis=0), None, self.margin == 0.0)
        return outline_of(triangles)

    @cached_property
    def tree(self) -> tuple[Floats, Floats]:
        """The tree of balls around the core's triangles (`numeric.balls`), and these (n, 3, 3); empty without any.

        Made when first asked for: a mesh's takes its time.
        """
        triangles = np.concatenate([np.zeros((0, 3, 3)), *(piece.triangles for piece in self.pieces)])
        if not len(triangles):
            return np.zeros((0, 11)), triangles
        return ball_tree(triangles, max(BALL, float(self.half.max()) / BALLS)), triangles

    @property
    def blocks(self) -> tuple[Floats, Floats]:
        """Return centre and half (k, 3) of the boxes that hold what can touch: around a mesh's pieces, or the solid."""
        if self.solid is None:
            return self.piece_centre, self.piece_half
        return self.centre[None], self.half[None] + self.radius


class CollisionShapes(FigureLibrary[Geometry, Solid | None]):
    """Solids by geometry; None for points, lines, frames and labels, which nothing touches.

    FCL changes none of them when it is asked, so that threads share them; each has collision objects of its own. A mesh
    that cannot be read is told once and touches nothing.
    """

    def _made(self, key: Geometry) -> Solid | None:
        match key:
            case Box(size):
                return replace(_solid(fcl.Box(*size), box_triangles(size), 0.0, nearest.of_box(size)), is_box=True)
            case Sphere(radius):
                return _solid(fcl.Sphere(radius), _segment(0.0), radius, nearest.of_segment(0.0))
            case Capsule(radius, length):
                return _solid(fcl.Capsule(radius, length), _segment(length), radius, nearest.of_segment(length))
            case Cylinder(radius, length):
                surface = turned_triangles(radius, radius, length)
                near, circles = nearest.of_cylinder(radius, length), (0.5 * length, radius, radius)
                return _solid(fcl.Cylinder(radius, length), surface, 0.0, near, circles)
            case Cone(radius, length):
                surface = turned_triangles(radius, 0.0, length)
                near, circles = nearest.of_cone(radius, length), (0.5 * length, radius, 0.0)
                return _solid(fcl.Cone(radius, length), surface, 0.0, near, circles)
            case Mesh():
                return self._of_mesh(key)
        return None

    def _of_mesh(self, mesh: Mesh) -> Solid:
        """Return what a mesh collides as: its triangles, or the hull that it names."""
        started = time.perf_counter()
        warning = ""
        try:
            vertices, faces = self._triangles(mesh)
        except Exception as error:  # a mesh that cannot be read must not end all sensors
            log.exception("mesh %s touches nothing", mesh.uri)
            vertices, faces = np.zeros((0, 3)), np.zeros((0, 3), np.int32)
            warning = f"{mesh.uri} cannot be read and touches nothing: {error}"
        solid, margin = None, 0.0
        count = len(faces)
        core = vertices, faces
        if count and mesh.collision_hull_vertices:
            corners, hull, exceeded = hull_of(_used(vertices, faces), mesh.collision_hull_vertices)
            if len(hull):
                core = corners, hull
                solid = fcl.Convex(corners, len(hull), np.insert(hull, 0, 3, axis=1).ravel())
                margin = exceeded if exceeded > SMALL * float(np.ptp(corners, axis=0).max()) else 0.0
            else:
                warning = f"the corners of {mesh.uri} are in a plane: it has no hull and collides as its triangles"
        made = _solid(solid, core, 0.0, None)
        flat = sum(_flat(piece.triangles) for piece in made.pieces) if solid is None else 0
        if flat and not warning:
            warning = f"{flat} of the {count} triangles of {mesh.uri} have no area; they touch as points and lines"
        return replace(made, margin=margin, mesh=MadeOfMesh(count, warning, time.perf_counter() - started))

    def _triangles(self, mesh: Mesh) -> tuple[Floats, Integers]:
        vertices, faces = stacked(self.meshes(mesh))
        return vertices.astype(np.float64), faces


def _used(vertices: Floats, faces: Integers) -> Floats:
    """Return the vertices that are corners of triangles; in steps, since each holds the interpreter's lock."""
    used = np.zeros(len(vertices), np.bool_)
    for start in range(0, len(faces), STEP):
        used[faces[start : start + STEP]] = True
    return vertices[used]


def _flat(triangles: Floats) -> int:
    """Return how many triangles (m, 3, 3) have no area, but for rounding."""
    edges = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return int((areas <= SLIVER * (edges**2).sum(axis=2).max(axis=1)).sum())


def _segment(length: float) -> tuple[Floats, Integers]:
    """Return a segment along z as one triangle without area."""
    end = np.array([0.0, 0.0, 0.5 * length])
    return np.array([-end, end, end]), np.array([[0, 1, 2]], np.int32)


def _solid(
    solid: Any,  # noqa: ANN401 FCL has no types
    core: tuple[Floats, Integers],
    radius: float,
    near: Nearest | None,
    circles: tuple[float, float, float] | None = None,
) -> Solid:
    vertices, faces = core
    made = tuple(_piece(vertices, some) for some in pieces(vertices, faces))
    centre = np.array([piece.centre for piece in made]).reshape(-1, 3)
    half = np.array([piece.half for piece in made]).reshape(-1, 3)
    if not made:
        return Solid(solid, made, radius, near, centre, half, np.zeros(3), np.full(3, NOTHING))
    lower, upper = (centre - half).min(axis=0), (centre + half).max(axis=0)
    return Solid(solid, made, radius, near, centre, half, 0.5 * (lower + upper), 0.5 * (upper - lower), circles)


def _piece(vertices: Floats, faces: Integers) -> Piece:
    used, places = np.unique(faces, return_inverse=True)
    corners = np.ascontiguousarray(vertices[used], np.float64)
    model = fcl.BVHModel()
    model.beginModel(len(corners), len(faces))
    model.addSubModel(corners, places.reshape(-1, 3))
    model.endModel()
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    return Piece(model, corners[places.reshape(-1, 3)], 0.5 * (lower + upper), 0.5 * (upper - lower))
