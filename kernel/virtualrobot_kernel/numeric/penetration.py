"""Penetration depth of two convex bodies: bounds from directions that are halved until they meet, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

Floats = np.ndarray[Any, np.dtype[np.float64]]

LEVELS = 40
"""Largest number of halvings of directions: by then they differ by rounding."""

ALONG = 1e-14
"""Unit vectors that are less than this across an axis count as along it: of a circle the middle is as far."""

FEW = 256
"""Of so many triangles of directions the plane through their supports is tried too, of more only the best one's."""


@inlined
def _support(vertices: Floats, turned: Floats, x: float, y: float, z: float, out: Floats, sign: float) -> None:
    """Add `sign` times the farthest point of a body in a direction to `out` (3,)."""
    if turned.shape[0] == 0:
        best, at = -np.inf, 0
        for row in range(vertices.shape[0]):
            reach = x * vertices[row, 0] + y * vertices[row, 1] + z * vertices[row, 2]
            if reach > best:
                best, at = reach, row
        for axis in range(3):
            out[axis] += sign * vertices[at, axis]
        return
    along = x * turned[3] + y * turned[4] + z * turned[5]
    u, v, w = x - along * turned[3], y - along * turned[4], z - along * turned[5]
    # Once more: what rounding leaves along the axis is much, where little is across.
    left = u * turned[3] + v * turned[4] + w * turned[5]
    u, v, w = u - left * turned[3], v - left * turned[4], w - left * turned[5]
    across = np.sqrt(u * u + v * v + w * w)
    up = turned[8] * across + turned[6] * along >= turned[7] * across - turned[6] * along
    half, radius = (turned[6], turned[8]) if up else (-turned[6], turned[7])
    scale = radius / across if across > ALONG else 0.0
    out[0] += sign * (turned[0] + half * turned[3] + scale * u)
    out[1] += sign * (turned[1] + half * turned[4] + scale * v)
    out[2] += sign * (turned[2] + half * turned[5] + scale * w)


@inlined
def _game(m: Floats) -> float:
    """Return the most that the least column of a mixture of rows of `m` (3, 3) can be: the value of a matrix game."""
    best = -np.inf
    for i in range(3):
        best = max(best, min(m[i, 0], m[i, 1], m[i, 2]))
        k = (i + 1) % 3
        for j in range(3):
            after = (j + 1) % 3
            one, other = m[i, j] - m[i, after], m[k, j] - m[k, after]
            if one * other < 0.0:
                share = other / (other - one)
                value = np.inf
                for column in range(3):
                    value = min(value, share * m[i, column] + (1.0 - share) * m[k, column])
                best = max(best, value)
    a0, a1, a2 = m[0, 0] - m[0, 1], m[1, 0] - m[1, 1], m[2, 0] - m[2, 1]
    b0, b1, b2 = m[0, 0] - m[0, 2], m[1, 0] - m[1, 2], m[2, 0] - m[2, 2]
    w0, w1, w2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    total = w0 + w1 + w2
    if total < 0.0:
        w0, w1, w2, total = -w0, -w1, -w2, -total
    if total > 0.0 and w0 >= 0.0 and w1 >= 0.0 and w2 >= 0.0:
        value = np.inf
        for column in range(3):
            value = min(value, (w0 * m[0, column] + w1 * m[1, column] + w2 * m[2, column]) / total)
        best = max(best, value)
    return best


@inlined
def _least(t: Floats, m: Floats) -> float:
    """Return a lower bound of the reach in the directions of a triangle `t` (6, 3): three corners, their supports."""
    for i in range(3):
        for j in range(3):
            m[i, j] = t[3 + i, 0] * t[j, 0] + t[3 + i, 1] * t[j, 1] + t[3 + i, 2] * t[j, 2]
    value = _game(m)
    if value >= 0.0:
        return value
    # Directions between the three are shorter than 1 before they are made so: at least by the plane through them.
    x1, y1, z1 = t[1, 0] - t[0, 0], t[1, 1] - t[0, 1], t[1, 2] - t[0, 2]
    x2, y2, z2 = t[2, 0] - t[0, 0], t[2, 1] - t[0, 1], t[2, 2] - t[0, 2]
    x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    length = np.sqrt(x * x + y * y + z * z)
    return value * length / abs(x * t[0, 0] + y * t[0, 1] + z * t[0, 2])


@compiled(
    array_of(float64, 2),
    array_of(float64, 1),
    array_of(float64, 2),
    array_of(float64, 1),
    float64,
    float64,
    int64,
    output_of(float64, 1),
)
def penetration(
    vertices: Floats,
    turned: Floats,
    other_vertices: Floats,
    other_turned: Floats,
    thickness: float,
    tolerance: float,
    most: int,
    found: Floats,
) -> None:
    """Find the least way by which the second of two convex bodies must be moved until they only touch.

    That is the least reach of their Minkowski difference, over all directions; where it is below 0, the bodies are so
    far apart. The reach is bounded over a spherical triangle of directions by the supports of its corners: it is convex
    and grows with the length of the direction. Triangles that may hold the least are cut in four, the others left out
    (branch and bound: A. Land, A. Doig, Econometrica 28, 1960). A facet's direction, which the plane through three
    supports gives, is exact to rounding. Unlike an expanding polytope it has no topology that rounding could break.

    Args:
        vertices: (n, 3) of a body that is the hull of points; n is 0 for one that is turned.
        turned: (9,) of the hull of two circles: its middle (3), its axis (3), half its length, the radius at the
            beginning and at the end; (0,) for the hull of points.
        other_vertices: of the second body, in the same frame.
        other_turned: likewise.
        thickness: by how much both together are thicker than that, in meters.
        tolerance: how near the bounds shall be, in meters.
        most: how many triangles of directions are looked at in one go at most.
        found: (5,) written: the least way that was found, a lower bound of it, and its direction.
    """
    m, point = np.empty((3, 3)), np.empty(3)
    triangles = np.zeros((8, 6, 3))
    count = 0
    for sx in range(-1, 2, 2):
        for sy in range(-1, 2, 2):
            for sz in range(-1, 2, 2):
                triangles[count, 0, 0], triangles[count, 1, 1], triangles[count, 2, 2] = sx, sy, sz
                count += 1
    upper = np.inf
    found[:] = 0.0
    for _ in range(LEVELS):
        for row in range(count):
            t = triangles[row]
            for corner in range(3):
                t[3 + corner] = 0.0
                x, y, z = t[corner, 0], t[corner, 1], t[corner, 2]
                _support(vertices, turned, x, y, z, t[3 + corner], 1.0)
                _support(other_vertices, other_turned, -x, -y, -z, t[3 + corner], -1.0)
                reach = x * t[3 + corner, 0] + y * t[3 + corner, 1] + z * t[3 + corner, 2] + thickness
                if reach < upper:
                    upper = reach
                    found[2], found[3], found[4] = x, y, z
        lower = np.empty(count)
        best = 0
        for row in range(count):
            lower[row] = _least(triangles[row], m) + thickness
            if lower[row] < lower[best]:
                best = row
        for row in range(count):
            if row != best and (count > FEW or lower[row] >= upper - tolerance):
                continue
            t = triangles[row]
            x1, y1, z1 = t[4, 0] - t[3, 0], t[4, 1] - t[3, 1], t[4, 2] - t[3, 2]
            x2, y2, z2 = t[5, 0] - t[3, 0], t[5, 1] - t[3, 1], t[5, 2] - t[3, 2]
            x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
            length = np.sqrt(x * x + y * y + z * z)
            if length <= 1e-12 * (abs(x1) + abs(y1) + abs(z1)) * (abs(x2) + abs(y2) + abs(z2)):
                continue
            if x * t[0, 0] + y * t[0, 1] + z * t[0, 2] < 0.0:
                length = -length
            x, y, z = x / length, y / length, z / length
            point[:] = 0.0
            _support(vertices, turned, x, y, z, point, 1.0)
            _support(other_vertices, other_turned, -x, -y, -z, point, -1.0)
            reach = x * point[0] + y * point[1] + z * point[2] + thickness
            if reach < upper:
                upper = reach
                found[2], found[3], found[4] = x, y, z
        kept = 0
        for row in range(count):
            if lower[row] < upper - tolerance:
                kept += 1
        found[0], found[1] = upper, upper - tolerance if kept == 0 else lower[best]
        if kept == 0 or 4 * kept > most:
            return
        cut = np.empty((4 * kept, 6, 3))
        at = 0
        for row in range(count):
            if lower[row] >= upper - tolerance:
                continue
            t = triangles[row]
            for corner in range(3):
                after, last = (corner + 1) % 3, (corner + 2) % 3
                for axis in range(3):
                    cut[at, 0, axis], cut[at, 3, axis] = t[corner, axis], t[3 + corner, axis]
                    cut[at, 1, axis] = t[corner, axis] + t[after, axis]
                    cut[at, 2, axis] = t[corner, axis] + t[last, axis]
                    cut[at + 3 - corner, corner, axis] = t[after, axis] + t[last, axis]
                at += 1
            at += 1
        triangles, count = cut, 4 * kept
        for row in range(count):
            for corner in range(3):
                x, y, z = cut[row, corner, 0], cut[row, corner, 1], cut[row, corner, 2]
                length = np.sqrt(x * x + y * y + z * z)
                cut[row, corner, 0], cut[row, corner, 1], cut[row, corner, 2] = x / length, y / length, z / length
