"""Normals for triangles that come without: smooth over gentle bends, sharp over creases."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.shapes.submesh import Submesh

CREASE = np.cos(np.radians(40.0))
"""Faces that meet at a wider angle than 40 degrees keep a sharp edge between them."""

MOST_FACES = 64
"""Around one vertex; beyond, faces are compared with the vertex's mean normal only: all pairs would be too many."""

AT_ONCE = 8192
"""So many corners are worked on at once: NumPy holds the interpreter's lock meanwhile, and other threads wait."""


def shaded(part: Submesh) -> Submesh:
    """Return the submesh with normals: its own, or else made for it."""
    if part.normals is not None:
        return part
    rows, faces, normals = with_normals(part.vertices, part.faces)
    return Submesh(
        part.vertices[rows],
        faces,
        normals,
        part.color,
        None if part.vertex_colors is None else part.vertex_colors[rows],
        None if part.uv is None else part.uv[rows],
        part.texture,
    )


def with_normals(
    vertices: NDArray[np.float32], faces: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
    """Return (rows, faces, normals) that shade the triangles well.

    Args:
        vertices: (n, 3), each place once.
        faces: (m, 3) rows of `vertices`, counter-clockwise seen from outside.

    Returns:
        rows: (k,) which of `vertices` each new vertex is a copy of; a vertex on a crease gets several.
        faces: (m, 3) rows of the new vertices.
        normals: (k, 3) unit vectors, means of the normals of neighbouring faces weighted by area.
    """
    corners = vertices[faces].astype(np.float64)
    weighted = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit = weighted / np.maximum(np.linalg.norm(weighted, axis=1, keepdims=True), 1e-30)
    face_of = np.repeat(np.arange(len(faces)), 3)
    vertex_of = faces.reshape(-1)
    normals = _corner_normals(vertex_of, face_of, unit, weighted, len(vertices))
    # Corners of one vertex that came out equal become one vertex again: vertex and rounded normal packed in one number.
    steps = np.round(normals * 256.0).astype(np.int64) + 256
    keys = (vertex_of.astype(np.int64) << 30) | (steps[:, 0] << 20) | (steps[:, 1] << 10) | steps[:, 2]
    _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    return (
        vertex_of[first].astype(np.int32),
        place.reshape(faces.shape).astype(np.int32),
        normals[first].astype(np.float32),
    )


def _corner_normals(vertex_of: NDArray, face_of: NDArray, unit: NDArray, weighted: NDArray, count: int) -> NDArray:
    """Return (3m, 3): for each corner, the mean normal of the faces around its vertex that bend gently from its own."""
    order = np.argsort(vertex_of, kind="stable")
    valence = np.bincount(vertex_of, minlength=count)
    starts = np.concatenate([[0], np.cumsum(valence)[:-1]])
    sums = np.zeros((len(vertex_of), 3))
    few = valence[vertex_of] <= MOST_FACES
    corners = np.flatnonzero(few)
    for begin in range(0, len(corners), AT_ONCE):
        corner = corners[begin : begin + AT_ONCE]
        repeats = valence[vertex_of[corner]]
        firsts = np.cumsum(repeats) - repeats
        own = np.repeat(corner, repeats)
        step = np.arange(len(own)) - np.repeat(firsts, repeats)
        other = face_of[order[starts[vertex_of[own]] + step]]
        gentle = np.einsum("ij,ij->i", unit[face_of[own]], unit[other]) >= CREASE
        sums[corner] = np.add.reduceat(np.where(gentle[:, None], weighted[other], 0.0), firsts, axis=0)
    crowded = np.flatnonzero(~few)
    if len(crowded):
        means = np.stack([np.bincount(vertex_of, weighted[face_of, k], minlength=count) for k in range(3)], axis=1)
        means /= np.maximum(np.linalg.norm(means, axis=1, keepdims=True), 1e-30)
        mean, flat = means[vertex_of[crowded]], unit[face_of[crowded]]
        sums[crowded] = np.where((np.einsum("ij,ij->i", mean, flat) >= CREASE)[:, None], mean, flat)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(length > 1e-30, sums / np.maximum(length, 1e-30), [0.0, 0.0, 1.0])
