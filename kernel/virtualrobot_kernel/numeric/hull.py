"""The convex hull of points, with as many corners as asked for at most, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int32, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Faces = np.ndarray[Any, np.dtype[np.int32]]

NONE = -1
ROUNDING = 1e-8
"""Points are on a hull that are less than this outside of it, as part of the points' extent."""


@inlined
def _plane(points: Floats, face: Faces, row: int, planes: Floats) -> None:
    """Write the plane of a face: unit normal outwards and its distance from the origin; zeros where it has no area."""
    a, b, c = face[row, 0], face[row, 1], face[row, 2]
    x1, y1, z1 = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    x2, y2, z2 = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    length = np.sqrt(x * x + y * y + z * z)
    scale = 1.0 / length if length > 0.0 else 0.0
    planes[row, 0], planes[row, 1], planes[row, 2] = x * scale, y * scale, z * scale
    planes[row, 3] = scale * (x * points[a, 0] + y * points[a, 1] + z * points[a, 2])


@inlined
def _above(points: Floats, point: int, planes: Floats, row: int) -> float:
    """Return how far a point is above the plane of a face."""
    reach = planes[row, 0] * points[point, 0] + planes[row, 1] * points[point, 1] + planes[row, 2] * points[point, 2]
    return reach - planes[row, 3]


@inlined
def _simplex(points: Floats, corners: Integers) -> float:
    """Write four points that are far apart to `corners` (4,); return how far the last is out of the others' plane."""
    count = points.shape[0]
    corners[:] = 0
    widest = -1.0
    for axis in range(3):
        low, high = 0, 0
        for row in range(count):
            if points[row, axis] < points[low, axis]:
                low = row
            if points[row, axis] > points[high, axis]:
                high = row
        if points[high, axis] - points[low, axis] > widest:
            widest = points[high, axis] - points[low, axis]
            corners[0], corners[1] = low, high
    a, b = corners[0], corners[1]
    x, y, z = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    best = -1.0
    for row in range(count):
        u, v, w = points[row, 0] - points[a, 0], points[row, 1] - points[a, 1], points[row, 2] - points[a, 2]
        area = (y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2
        if area > best:
            best = area
            corners[2] = row
    planes, face = np.empty((1, 4)), np.empty((1, 3), np.int32)
    face[0, 0], face[0, 1], face[0, 2] = a, b, corners[2]
    _plane(points, face, 0, planes)
    best = 0.0
    for row in range(count):
        above = _above(points, row, planes, 0)
        if abs(above) > abs(best):
            best = above
            corners[3] = row
    if best > 0.0:
        corners[1], corners[2] = corners[2], corners[1]
    return abs(best)


@inlined
def distance_from_triangle(points: Floats, point: int, faces: Faces, row: int) -> float:
    """Return the distance of a point from a triangle (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5)."""
    a, b, c = faces[row, 0], faces[row, 1], faces[row, 2]
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for k in range(3):
        ab, ac = points[b, k] - points[a, k], points[c, k] - points[a, k]
        d1 += ab * (points[point, k] - points[a, k])
        d2 += ac * (points[point, k] - points[a, k])
        d3 += ab * (points[point, k] - points[b, k])
        d4 += ac * (points[point, k] - points[b, k])
        d5 += ab * (points[point, k] - points[c, k])
        d6 += ac * (points[point, k] - points[c, k])
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        v, w = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        v, w = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        v, w = 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v, w = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        v, w = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    else:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    squared = 0.0
    for k in range(3):
        at = points[a, k] + v * (points[b, k] - points[a, k]) + w * (points[c, k] - points[a, k])
        squared += (points[point, k] - at) ** 2
    return np.sqrt(squared)


@compiled(array_of(float64, 2), int64, output_of(int32, 2), output_of(float64, 1))
def convex_hull(points: Floats, most: int, found: Faces, deviation: Floats) -> int:
    """Write the triangles of the hull of points and return how many there are; 0 where all are in a plane.

    The point that is farthest out of the hull is taken in next, until `most` are its corners (Quickhull: C. Barber,
    D. Dobkin, H. Huhdanpaa, ACM TOMS 22, 1996). Points are left out that rounding would take in the wrong way.

    Args:
        points: (n, 3).
        most: how many of them the hull has as corners at most, 4 or more.
        found: (2 * most, 3) the corners of its triangles, counter-clockwise seen from outside, are written to its
            beginning.
        deviation: (1,) written: the points are at most so far outside of the hull, in their unit.
    """
    count, room = points.shape[0], 2 * most + 16
    deviation[0] = 0.0
    corners = np.zeros(4, np.int64)
    if count < 4:
        return 0
    extent = 0.0
    for axis in range(3):
        extent = max(extent, points[:, axis].max() - points[:, axis].min())
    slack = ROUNDING * extent
    if _simplex(points, corners) <= slack:
        return 0
    faces, beside = np.empty((room, 3), np.int32), np.empty((room, 3), np.int32)
    planes, alive = np.zeros((room, 4)), np.zeros(room, np.int64)
    first: Any = np.full(room, NONE)
    far, farthest = np.zeros(room), np.full(room, NONE)
    after: Any = np.full(count, NONE)
    left_out = 0.0
    # Corner k is opposite of face k; beside[f, k] is the face over the edge from corner k to the next one.
    turns = np.array([[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]])
    for row in range(4):
        for k in range(3):
            faces[row, k] = corners[turns[row, k]]
        _plane(points, faces, row, planes)
        alive[row] = 1
    for row in range(4):
        for k in range(3):
            a, b = faces[row, k], faces[row, (k + 1) % 3]
            for other in range(4):
                for j in range(3):
                    if faces[other, j] == b and faces[other, (j + 1) % 3] == a:
                        beside[row, k] = other
    for point in range(count):
        best, at = slack, NONE
        for row in range(4):
            above = _above(points, point, planes, row)
            if above > best:
                best, at = above, row
        if at != NONE:
            after[point], first[at] = first[at], point
            if best > far[at]:
                far[at], farthest[at] = best, point
    free = np.arange(room - 1, 3, -1)
    free_count = room - 4
    seen, stack, visible = np.zeros(room, np.int64), np.empty(room, np.int64), np.empty(room, np.int64)
    edge_from, edge_to = np.empty(room, np.int64), np.empty(room, np.int64)
    edge_face, edge_slot, made = np.empty(room, np.int64), np.empty(room, np.int64), np.empty(room, np.int64)
    begins = np.full(count, NONE)
    total, mark = 4, 0
    while total < most:
        top = NONE
        for row in range(room):
            if alive[row] and farthest[row] != NONE and (top == NONE or far[row] > far[top]):
                top = row
        if top == NONE:
            break
        point = farthest[top]
        mark += 1
        seen[top], stack[0], visible[0] = mark, top, top
        depth, visible_count = 1, 1
        while depth > 0:
            depth -= 1
            row = stack[depth]
            for k in range(3):
                other = beside[row, k]
                if seen[other] != mark and _above(points, point, planes, other) > slack:
                    seen[other] = mark
                    stack[depth] = visible[visible_count] = other
                    depth += 1
                    visible_count += 1
        edges, sound = 0, True
        for i in range(visible_count):
            row = visible[i]
            for k in range(3):
                other = beside[row, k]
                if seen[other] != mark:
                    a = faces[row, k]
                    sound = sound and begins[a] == NONE
                    begins[a] = edges
                    edge_from[edges], edge_to[edges], edge_face[edges] = a, faces[row, (k + 1) % 3], other
                    for j in range(3):
                        if beside[other, j] == row and faces[other, j] == edge_to[edges]:
                            edge_slot[edges] = j
                    edges += 1
        # The horizon must be one ring of at least three edges, or rounding has made a hole in what is visible.
        length, at = 0, edge_to[0]
        while sound and length < edges:
            length += 1
            if at == edge_from[0]:
                break
            if begins[at] == NONE:
                sound = False
                break
            at = edge_to[begins[at]]
        sound = sound and length == edges and edges >= 3 and edges <= free_count + visible_count
        for i in range(edges):
            begins[edge_from[i]] = NONE if not sound else begins[edge_from[i]]
        if not sound:
            left_out = max(left_out, distance_from_triangle(points, point, faces, top))
            before, at = NONE, first[top]
            far[top], farthest[top] = 0.0, NONE
            while at != NONE:
                following = after[at]
                if at == point:
                    if before == NONE:
                        first[top] = following
                    else:
                        after[before] = following
                else:
                    before = at
                    above = _above(points, at, planes, top)
                    if above > far[top]:
                        far[top], farthest[top] = above, at
                at = following
            continue
        total += 1
        # What was above faces that go waits in one list.
        waiting: Any = NONE
        for i in range(visible_count):
            row = visible[i]
            at = first[row]
            while at != NONE:
                following = after[at]
                if at != point:
                    after[at], waiting = waiting, at
                at = following
            alive[row], first[row], far[row], farthest[row] = 0, NONE, 0.0, NONE
            free[free_count] = row
            free_count += 1
        for i in range(edges):
            free_count -= 1
            made[i] = row = free[free_count]
            faces[row, 0], faces[row, 1], faces[row, 2] = edge_from[i], edge_to[i], point
            _plane(points, faces, row, planes)
            alive[row] = 1
        for i in range(edges):
            row, following = made[i], begins[edge_to[i]]
            beside[row, 0], beside[row, 1] = edge_face[i], made[following]
            beside[made[following], 2] = row
            beside[edge_face[i], edge_slot[i]] = row
        for i in range(edges):
            begins[edge_from[i]] = NONE
        while waiting != NONE:
            following = after[waiting]
            best, at = slack, NONE
            for i in range(edges):
                above = _above(points, waiting, planes, made[i])
                if above > best:
                    best, at = above, made[i]
            if at != NONE:
                after[waiting], first[at] = first[at], waiting
                if best > far[at]:
                    far[at], farthest[at] = best, waiting
            waiting = following
    kept = 0
    worst = max(left_out, slack)
    for row in range(room):
        if not alive[row]:
            continue
        for k in range(3):
            found[kept, k] = faces[row, k]
        kept += 1
        at = first[row]
        while at != NONE:
            gap = distance_from_triangle(points, at, faces, row)
            for k in range(3):
                gap = min(gap, distance_from_triangle(points, at, faces, beside[row, k]))
            worst = max(worst, gap)
            at = after[at]
    deviation[0] = worst
    return kept
