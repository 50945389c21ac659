"""Fewer triangles for the same surface, within a tolerance, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

from virtualrobot_kernel.numeric.hull import distance_from_triangle

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Faces = np.ndarray[Any, np.dtype[np.int32]]

ROUNDS = 8
"""The tolerance is reached in so many rounds: what costs least goes first."""

BEND = 0.5
"""Cosine of the angle by which a triangle may turn, at the least: 60 degrees."""


@inlined
def _normal(points: Floats, a: int, b: int, c: int, normal: Floats) -> float:
    """Write the unit normal of a triangle, zeros where it has no area; return twice its area."""
    x1, y1, z1 = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    x2, y2, z2 = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    length = np.sqrt(x * x + y * y + z * z)
    scale = 1.0 / length if length > 0.0 else 0.0
    normal[0], normal[1], normal[2] = x * scale, y * scale, z * scale
    return length


@inlined
def _add_plane(squares: Floats, vertex: int, points: Floats, normal: Floats, through: int) -> None:
    """Add the square of the distance from a plane to what a vertex keeps: (1, x, y, z) times a symmetric matrix."""
    d = 0.0
    for k in range(3):
        d -= normal[k] * points[through, k]
    place = 0
    for i in range(4):
        first = normal[i] if i < 3 else d
        for j in range(i, 4):
            squares[vertex, place] += first * (normal[j] if j < 3 else d)
            place += 1


@inlined
def _off(squares: Floats, one: int, other: int, points: Floats, at: int) -> float:
    """Return the sum of the squares of a point's distances from the planes that two vertices keep."""
    total, place = 0.0, 0
    for i in range(4):
        first = points[at, i] if i < 3 else 1.0
        for j in range(i, 4):
            second = points[at, j] if j < 3 else 1.0
            part = (squares[one, place] + squares[other, place]) * first * second
            total += part if i == j else 2.0 * part
            place += 1
    return total


@inlined
def _list_faces(faces: Faces, count: int, starts: Integers, around: Integers) -> None:
    """Write the faces around each vertex: those of vertex v are around[starts[v] : starts[v + 1]]."""
    starts[:] = 0
    for row in range(count):
        for k in range(3):
            starts[faces[row, k] + 1] += 1
    for vertex in range(starts.shape[0] - 1):
        starts[vertex + 1] += starts[vertex]
    for row in range(count):
        for k in range(3):
            vertex = faces[row, k]
            around[starts[vertex]] = row
            starts[vertex] += 1
    for vertex in range(starts.shape[0] - 1, 0, -1):
        starts[vertex] = starts[vertex - 1]
    starts[0] = 0


@inlined
def _has(faces: Faces, row: int, vertex: int) -> bool:
    return bool(faces[row, 0] == vertex or faces[row, 1] == vertex or faces[row, 2] == vertex)


@inlined
def _is_dead(faces: Faces, row: int) -> bool:
    return bool(faces[row, 0] == faces[row, 1] or faces[row, 1] == faces[row, 2] or faces[row, 2] == faces[row, 0])


@compiled(array_of(float64, 2), output_of(int32, 2), float64)
def simplify(points: Floats, faces: Faces, tolerance: float) -> int:
    """Take triangles away as long as the surface stays within a tolerance; return how many are left.

    Edges are collapsed into one of their ends (M. Garland, P. Heckbert, Surface simplification using quadric error
    metrics, SIGGRAPH 1997): each corner that stays is within the tolerance of the planes of all triangles that went
    into it, and of planes across the borders among them. Their shares are not weighted, so that the sum of the squares
    of distances is at least the greatest one. Where planes meet at a sharp angle these tell too little: how far corners
    that went are from the triangles that are left is added up, and within the tolerance, too.

    Args:
        points: (n, 3) corners, each place once.
        faces: (m, 3) rows of `points`; those that are left are written to its beginning.
        tolerance: greatest distance, in the unit of the points.
    """
    vertices, count = points.shape[0], faces.shape[0]
    squares = np.zeros((vertices, 10))
    starts, around = np.zeros(vertices + 1, np.int64), np.zeros(3 * count, np.int64)
    touched, marks = np.zeros(vertices, np.int64), np.zeros(vertices, np.int64)
    normal, turned, border, off = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(vertices)
    corners, new = np.zeros((4, 3)), np.array([[1, 2, 3]], np.int32)
    _list_faces(faces, count, starts, around)
    for row in range(count):
        if _is_dead(faces, row) or _normal(points, faces[row, 0], faces[row, 1], faces[row, 2], normal) == 0.0:
            continue
        for k in range(3):
            a, b = faces[row, k], faces[row, (k + 1) % 3]
            _add_plane(squares, a, points, normal, a)
            sharers = 0
            for at in range(starts[a], starts[a + 1]):
                sharers += 1 if _has(faces, around[at], b) else 0
            if sharers == 2:
                continue
            # An edge of a border: the plane through it and across the triangle holds it in its place.
            length = 0.0
            for i in range(3):
                j, h = (i + 1) % 3, (i + 2) % 3
                border[i] = (points[b, j] - points[a, j]) * normal[h] - (points[b, h] - points[a, h]) * normal[j]
                length += border[i] ** 2
            if length > 0.0:
                border /= np.sqrt(length)
                _add_plane(squares, a, points, border, a)
                _add_plane(squares, b, points, border, a)
    mark, step = 0, 1
    while step <= ROUNDS:
        limit = (tolerance * (step / ROUNDS) ** 2) ** 2
        touched[:] = 0
        collapsed = 0
        for row in range(count):
            for side in range(6):
                a, b = faces[row, side % 3], faces[row, (side + 1 + side // 3) % 3]
                # `a` goes into `b`: the lists of faces around both are true as long as neither was touched.
                if a == b or touched[a] or touched[b] or _off(squares, a, b, points, b) > limit:
                    continue
                mark += 2
                for at in range(starts[b], starts[b + 1]):
                    if not _is_dead(faces, around[at]):
                        for k in range(3):
                            marks[faces[around[at], k]] = mark
                shared, common, sound, near = 0, 0, True, np.inf
                corners[0] = points[a]
                for at in range(starts[a], starts[a + 1]):
                    face = around[at]
                    if _is_dead(faces, face):
                        continue
                    for k in range(3):
                        vertex = faces[face, k]
                        if vertex != a and vertex != b and marks[vertex] == mark:
                            common += 1
                            marks[vertex] = mark + 1
                    if _has(faces, face, b):
                        shared += 1
                        continue
                    _normal(points, faces[face, 0], faces[face, 1], faces[face, 2], normal)
                    one = b if faces[face, 0] == a else faces[face, 0]
                    two = b if faces[face, 1] == a else faces[face, 1]
                    three = b if faces[face, 2] == a else faces[face, 2]
                    area = _normal(points, one, two, three, turned)
                    bend = normal[0] * turned[0] + normal[1] * turned[1] + normal[2] * turned[2]
                    if area == 0.0 or bend < BEND:
                        sound = False
                        break
                    corners[1], corners[2], corners[3] = points[one], points[two], points[three]
                    near = min(near, distance_from_triangle(corners, 0, new, 0))
                # Corners beside both that no triangle of the edge has would become a fold.
                if not sound or common != shared:
                    continue
                for at in range(starts[b], starts[b + 1]):
                    face = around[at]
                    if not _is_dead(faces, face) and not _has(faces, face, a):
                        near = min(near, distance_from_triangle(points, a, faces, face))
                if near + off[a] > tolerance * (step / ROUNDS) ** 2:
                    continue
                off[b] = max(off[b], off[a] + near)
                for at in range(starts[a], starts[a + 1]):
                    for k in range(3):
                        if faces[around[at], k] == a:
                            faces[around[at], k] = b
                for place in range(10):
                    squares[b, place] += squares[a, place]
                touched[a], touched[b] = 1, 1
                collapsed += 1
        left = 0
        for row in range(count):
            if not _is_dead(faces, row):
                for k in range(3):
                    faces[left, k] = faces[row, k]
                left += 1
        count = left
        _list_faces(faces, count, starts, around)
        if collapsed * 200 <= vertices:
            step += 1
    return count
