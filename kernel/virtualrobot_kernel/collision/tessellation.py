"""Triangles for FCL: cylinders and cones so fine that distances are right, meshes cut into pieces of a bounded size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

SEGMENTS = 512
"""Around a cylinder or cone; flat sides stand in by at most (pi / SEGMENTS)^2 / 2 of the radius, 2e-5."""

PIECE = 512
"""The most triangles of a piece: FCL holds the interpreter's lock while it makes or asks one, 1 to 3 ms."""


def box_triangles(size: tuple[float, float, float]) -> tuple[Floats, Integers]:
    """Return the 8 corners and 12 triangles of a box about the origin with these edge lengths (m)."""
    corners = 0.5 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, _fans(quads)


def turned_triangles(bottom_radius: float, top_radius: float, length: float) -> tuple[Floats, Integers]:
    """Return the closed surface of a cylinder or truncated cone about z, from -length/2 to length/2; radii may be 0."""
    angle = np.arange(SEGMENTS) * (2.0 * np.pi / SEGMENTS)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    height = np.full((SEGMENTS, 1), 0.5 * length)
    vertices = np.concatenate(
        [
            np.hstack([bottom_radius * circle, -height]),
            np.hstack([top_radius * circle, height]),
            [[0.0, 0.0, -0.5 * length], [0.0, 0.0, 0.5 * length]],
        ]
    )
    at = np.arange(SEGMENTS)
    after = (at + 1) % SEGMENTS
    sides = _fans(np.stack([at, after, SEGMENTS + after, SEGMENTS + at], axis=1).tolist())
    bottom = np.stack([np.full(SEGMENTS, 2 * SEGMENTS), after, at], axis=1)
    top = np.stack([np.full(SEGMENTS, 2 * SEGMENTS + 1), SEGMENTS + at, SEGMENTS + after], axis=1)
    faces = np.concatenate([sides, bottom, top]).astype(np.int32)
    return vertices, faces[_areas(vertices, faces) > 0.0]


def pieces(vertices: Floats, faces: Integers) -> Iterator[Integers]:
    """Yield the faces (m, 3) in groups of neighbours, each of at most PIECE: halved across their widest side.

    J. Bentley, Multidimensional binary search trees used for associative searching, CACM 18, 1975.
    """
    centres = vertices[faces].mean(axis=1)
    waiting = [np.arange(len(faces))] if len(faces) else []
    while waiting:
        rows = waiting.pop()
        if len(rows) <= PIECE:
            yield faces[np.sort(rows)]
            continue
        widest = int(np.ptp(centres[rows], axis=0).argmax())
        half = len(rows) // 2
        order = np.argpartition(centres[rows, widest], half)
        waiting += [rows[order[half:]], rows[order[:half]]]


def _fans(quads: list[list[int]]) -> Integers:
    corners = np.array(quads, np.int32)
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


def _areas(vertices: Floats, faces: Integers) -> Floats:
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)
