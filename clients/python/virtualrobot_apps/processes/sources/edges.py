"""Edges of a part, concave ones such as a fillet weld has and convex ones such as are deburred, as ways."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.processes.sources.sampling import CORNER, ways_of
from virtualrobot_apps.processes.sources.surface import Floats, Surface, solid_of

SHARP = np.radians(25.0)
"""Angle (rad) between two faces from which on what is between them is an edge."""
KINDS = ("concave", "convex")


def edges(
    mesh: trimesh.Trimesh, kind: str = "concave", *, sharp: float = SHARP, corner: float = CORNER, least: float = 0.0
) -> list[Way]:
    """Return the concave or convex edges of a closed body as ways with the normals of both faces, longest first.

    Ways end at corners of three edges or more, and where they turn by more than `corner`. One begins at the end
    that is first by x, y and z; a loop begins at the corner that is, and goes on to its neighbour that is.

    Args:
        mesh: one closed body (m).
        kind: `concave` or `convex`.
        sharp: the angle (rad) between the normals of two triangles from which on they meet in an edge.
        corner: the turn (rad) from which on a way is split.
        least: the length (m) below which ways are left out.

    Raises:
        InvalidArgumentError: for a mesh that `solid_of` refuses, and for another kind.
    """
    if kind not in KINDS:
        raise InvalidArgumentError(f"edges are {' or '.join(KINDS)}, not {kind!r}")
    surface = solid_of(mesh)
    left, right = surface.beside.T
    angles = np.arccos(np.clip(np.einsum("ij,ij->i", surface.normals[left], surface.normals[right]), -1.0, 1.0))
    chosen = np.flatnonzero((angles > sharp) & (_concave(surface) == (kind == "concave")))
    found = [
        way
        for corners, faces in _rows(surface, chosen)
        for way in ways_of(surface.corners[corners], surface.normals[faces], corners[0] == corners[-1], corner)
        if way.length >= least
    ]
    return sorted(found, key=lambda way: (-round(way.length, 9), *np.round(way.points[0], 9).tolist()))


def nearest(ways: Sequence[Way], point: ArrayLike) -> Way:
    """Return the way that comes nearest to a point (3,) in m; raises InvalidArgumentError where there is none."""
    if not ways:
        raise InvalidArgumentError("there is no way to choose from")
    return min(ways, key=lambda way: _distance(way.points, np.asarray(point, dtype=np.float64)))


def _distance(points: Floats, point: Floats) -> float:
    """Return the least distance (m) of a point (3,) from the lines between points (n, 3)."""
    steps = np.diff(points, axis=0)
    part = np.einsum("ij,ij->i", point - points[:-1], steps) / np.einsum("ij,ij->i", steps, steps)
    return float(np.linalg.norm(points[:-1] + np.clip(part, 0.0, 1.0)[:, None] * steps - point, axis=1).min())


def _concave(surface: Surface) -> np.ndarray:
    """Return whether each edge (e,) is concave: the triangle on the right rises over the plane of the left one."""
    left, right = surface.beside.T
    # Of three corners the third is the sum less the two on the edge.
    third = surface.triangles[right].sum(axis=1) - surface.edges.sum(axis=1)
    rise = surface.corners[third] - surface.corners[surface.edges[:, 0]]
    return np.einsum("ij,ij->i", rise, surface.normals[left]) > 0.0


def _rows(surface: Surface, chosen: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return rows of chosen edges: corners (n,), and the triangles (n - 1, 2) on the left and right of each line."""
    at: dict[int, list[int]] = {}
    for edge in chosen.tolist():
        for corner in surface.edges[edge].tolist():
            at.setdefault(corner, []).append(edge)
    rank = np.empty(len(surface.corners), dtype=np.int64)
    rank[np.lexsort(np.round(surface.corners, 9).T[::-1])] = np.arange(len(surface.corners))
    left = set(chosen.tolist())

    def other(edge: int, corner: int) -> int:
        return int(surface.edges[edge].sum()) - corner

    def row(start: int, edge: int) -> tuple[np.ndarray, np.ndarray]:
        corners, faces = [start], []
        while True:
            left.discard(edge)
            here = corners[-1]
            faces.append(surface.beside[edge] if surface.edges[edge, 0] == here else surface.beside[edge, ::-1])
            corners.append(other(edge, here))
            following = at[corners[-1]]
            if corners[-1] == start or len(following) != 2:
                return np.array(corners), np.array(faces)
            edge = following[0] if following[1] == edge else following[1]

    found = []
    # Rows from their ends first; what is left then are loops.
    ends = sorted((corner for corner, around in at.items() if len(around) != 2), key=lambda corner: rank[corner])
    for start in [*ends, *sorted((corner for corner in at if len(at[corner]) == 2), key=lambda corner: rank[corner])]:
        for edge in sorted(at[start], key=lambda edge: rank[other(edge, start)]):
            if edge in left:
                found.append(row(start, edge))
    return found
