"""Normals for triangles that come without: smooth over gentle bends, sharp over creases."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CREASE = np.cos(np.radians(40.0))
"""Faces that meet at a wider angle than 40 degrees keep a sharp edge between them."""

MOST_FACES = 64
"""Around one vertex; beyond, faces are compared with the vertex's mean normal only: all pairs would be too many."""


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
    # Corners of one vertex that came out equal become one vertex again.
    keys = np.column_stack([vertex_of, np.round(normals * 512.0).astype(np.int64)])
    _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
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
    corner = np.flatnonzero(few)
    repeats = valence[vertex_of[corner]]
    own = np.repeat(corner, repeats)
    step = np.arange(len(own)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    other = order[starts[vertex_of[own]] + step]
    gentle = np.einsum("ij,ij->i", unit[face_of[own]], unit[face_of[other]]) >= CREASE
    for axis in range(3):
        values = weighted[face_of[other[gentle]], axis]
        sums[:, axis] = np.bincount(own[gentle], values, minlength=len(sums))
    crowded = np.flatnonzero(~few)
    if len(crowded):
        means = np.stack([np.bincount(vertex_of, weighted[face_of, k], minlength=count) for k in range(3)], axis=1)
        means /= np.maximum(np.linalg.norm(means, axis=1, keepdims=True), 1e-30)
        mean, flat = means[vertex_of[crowded]], unit[face_of[crowded]]
        sums[crowded] = np.where((np.einsum("ij,ij->i", mean, flat) >= CREASE)[:, None], mean, flat)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(length > 1e-30, sums / np.maximum(length, 1e-30), [0.0, 0.0, 1.0])
