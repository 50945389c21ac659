"""Triangle meshes as surfaces: corners joined, each triangle with a normal, each edge with the triangles beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

SAME = 1e-7
"""Distance below which corners are one, and triangles that are no higher have no area: in parts of the mesh's size."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Surface of triangles that lie the same way round, seen from outside counter-clockwise.

    Attributes:
        corners: (v, 3) in m.
        triangles: (f, 3) numbers of corners.
        normals: (f, 3) unit normals, outward.
        edges: (e, 2) numbers of corners, from the first to the second as the triangle on the left has them.
        beside: (e, 2) numbers of the triangles on the left and on the right of an edge seen from outside; -1 for none.
    """

    corners: Floats
    triangles: Whole
    normals: Floats
    edges: Whole
    beside: Whole

    @property
    def size(self) -> float:
        """The diagonal of its box (m)."""
        return float(np.linalg.norm(np.ptp(self.corners, axis=0)))


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    """Return the surface of a mesh (m), open or closed, of one body or more.

    Raises:
        InvalidArgumentError: for a mesh without triangles, with corners that are not finite, with triangles that have
            no area, with edges of more than two triangles or of two that lie different ways round, and for a closed one
            that is inside out.
    """
    corners, triangles = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    if not len(triangles):
        raise InvalidArgumentError("the mesh has no triangles")
    if not np.isfinite(corners).all():
        row = int(np.flatnonzero(~np.isfinite(corners).all(axis=1))[0])
        raise InvalidArgumentError(f"corner {row} of the mesh is {corners[row].tolist()}; it must be finite")
    size = float(np.linalg.norm(np.ptp(corners[np.unique(triangles)], axis=0)))
    corners, triangles = _joined(corners, triangles, SAME * size)
    normals = _normals(corners, triangles, SAME * size)
    edges, beside = _edges(corners, triangles)
    if (beside >= 0).all() and (volume := _volume(corners, triangles)) <= 0.0:
        raise InvalidArgumentError(
            f"the mesh is inside out: its volume is {1e6 * volume:.6g} cm^3; turn its triangles round (in trimesh: "
            "mesh.invert())"
        )
    return Surface(corners, triangles, normals, edges, beside)


def solid_of(mesh: trimesh.Trimesh) -> Surface:
    """Return the surface of a mesh that is one closed body.

    Raises:
        InvalidArgumentError: for what `surface_of` refuses, for an open mesh, and for several bodies.
    """
    surface = surface_of(mesh)
    border = np.flatnonzero(surface.beside[:, 1] < 0)
    if len(border):
        raise InvalidArgumentError(
            f"the mesh is open: {len(border)} of its edges have one triangle alone, the first at "
            f"{_millimeters(surface.corners[surface.edges[border[0]]].mean(axis=0))} mm; close it"
        )
    bodies = int(_bodies(surface).max()) + 1
    if bodies > 1:
        raise InvalidArgumentError(
            f"the mesh has {bodies} bodies, and where two of them meet neither has an edge; let them lie in each other "
            "a little and join them (trimesh.boolean.union), or take one alone"
        )
    return surface


def _joined(corners: Floats, triangles: Whole, same: float) -> tuple[Floats, Whole]:
    """Return a mesh whose corners within a distance are one, without the triangles that become lines by that."""
    if same == 0.0:
        raise InvalidArgumentError("the mesh has no size: all its corners are at one place")
    used, numbers = np.unique(triangles, return_inverse=True)
    _, first, joined = np.unique(
        np.round((corners[used] - corners[used].min(axis=0)) / same), axis=0, return_index=True, return_inverse=True
    )
    corners, triangles = corners[used][first], joined.ravel()[numbers.reshape(-1, 3)]
    left = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    if not left.any():
        raise InvalidArgumentError("no triangle of the mesh has an area")
    return corners, triangles[left]


def _normals(corners: Floats, triangles: Whole, flat: float) -> Floats:
    """Return the unit normals (f, 3) of triangles; raise InvalidArgumentError for those that are lines."""
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    doubled = np.linalg.norm(across, axis=1)
    longest = np.max([np.linalg.norm(one, axis=1) for one in (b - a, c - b, a - c)], axis=0)
    thin = np.flatnonzero(doubled <= flat * longest)
    if len(thin):
        raise InvalidArgumentError(
            f"{len(thin)} of {len(triangles)} triangles of the mesh have no area, the first at "
            f"{_millimeters(a[thin[0]])} mm; mend it"
        )
    return across / doubled[:, None]


def _edges(corners: Floats, triangles: Whole) -> tuple[Whole, Whole]:
    """Return the edges (e, 2) of triangles, and the triangles (e, 2) on the left and on the right of each."""
    half = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(len(triangles)), 3)
    keys = half.min(axis=1) * len(corners) + half.max(axis=1)
    order = np.argsort(keys, kind="stable")
    _, starts, counts = np.unique(keys[order], return_index=True, return_counts=True)
    first, second = order[starts], order[np.minimum(starts + 1, len(order) - 1)]
    paired = counts == 2
    many = np.flatnonzero(counts > 2)
    turned = np.flatnonzero(paired & (half[first, 0] == half[second, 0]))
    for found, words in (
        (many, "has more than two triangles: two bodies touch there, or a triangle is doubled"),
        (turned, "has two triangles that lie different ways round: one of them is inside out"),
    ):
        if len(found):
            place = _millimeters(corners[half[first[found[0]]]].mean(axis=0))
            raise InvalidArgumentError(f"the edge of the mesh at {place} mm {words}; mend it")
    return half[first], np.stack([owner[first], np.where(paired, owner[second], -1)], axis=1)


def _volume(corners: Floats, triangles: Whole) -> float:
    """Return the volume (m^3) within closed triangles, below 0 where they are inside out."""
    a, b, c = (corners[triangles[:, k]] - corners.mean(axis=0) for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def _bodies(surface: Surface) -> Whole:
    """Return the number (f,) of the body that each triangle belongs to: bodies hang together by edges."""
    label = np.arange(len(surface.triangles))
    left, right = surface.beside[surface.beside[:, 1] >= 0].T
    while True:
        least = np.minimum(label[left], label[right])
        after = label.copy()
        np.minimum.at(after, left, least)
        np.minimum.at(after, right, least)
        after = after[after]
        if (after == label).all():
            return np.unique(label, return_inverse=True)[1]
        label = after


def _millimeters(place: Floats) -> str:
    return "(" + ", ".join(f"{one:.6g}" for one in (np.round(1e3 * place, 6) + 0.0).tolist()) + ")"
