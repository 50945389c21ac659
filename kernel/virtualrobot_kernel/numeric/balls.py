"""Trees of balls around triangles, and whether two figures are certainly farther apart than a distance; compiled.

S. Quinlan, Efficient distance computation between non-convex objects, IEEE ICRA 1994: triangles are cut until each fits
into a small ball, and each ball of the tree holds those below it. Where balls do not tell, the triangles at the ends of
the tree do, by the distances of their corners from faces and of their edges from edges (C. Ericson, Real-Time Collision
Detection, 2005, 5.1). So what is apart is found to be, but for rounding.

A tree is an array (m, 11), a row for each ball: centre, radius, how many rows on its subtree is over, and the triangle
in it, -1 where others are below; then a direction, about that in which the triangles look, and along it from the centre
on the middle and half the height of a slab that holds them: surfaces that face each other balls alone tell apart late.
Rows are in depth-first order, so that walking down a tree needs no stack.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]

DEEPEST = 128
"""Room for subtrees that wait: a tree is halved in space, and no halves are smaller than its leaves."""

_FLAT = 1e-12
"""A normal whose square is below this part of its triangle's edges to the fourth says nothing."""


@inlined
def _cut(triangles: Floats, size: float, cut: Floats) -> int:
    """Write triangles with edges of at most sqrt(3) sizes, which a ball of that radius holds each; return their number.

    To `cut` (m, 10), corners and the triangle that each is of, go as many as there is room for.
    """
    count, one, waiting = 0, np.empty(9), np.empty((DEEPEST, 9))
    for triangle in range(triangles.shape[0]):
        for i in range(9):
            waiting[0, i] = triangles[triangle, i // 3, i % 3]
        left = 1
        while left:
            left -= 1
            for i in range(9):
                one[i] = waiting[left, i]
            longest, first = -1.0, 0
            for i in range(3):
                edge = 0.0
                for axis in range(3):
                    edge += (one[3 * i + axis] - one[3 * ((i + 1) % 3) + axis]) ** 2
                if edge > longest:
                    longest, first = edge, i
            if longest <= 3.0 * size * size or left + 2 > DEEPEST:
                if count < cut.shape[0]:
                    for i in range(9):
                        cut[count, i] = one[i]
                    cut[count, 9] = triangle
                count += 1
                continue
            after, last = (first + 1) % 3, (first + 2) % 3
            for axis in range(3):
                middle = 0.5 * (one[3 * first + axis] + one[3 * after + axis])
                for half in range(2):
                    waiting[left + half, axis] = one[3 * (after if half else first) + axis]
                    waiting[left + half, 3 + axis] = middle
                    waiting[left + half, 6 + axis] = one[3 * last + axis]
            left += 2
    return count


@inlined
def _add_normal(cut: Floats, row: int, normal: Floats) -> None:
    """Add a triangle's normal, twice as long as its area."""
    a, b, c = cut[row, 3] - cut[row, 0], cut[row, 4] - cut[row, 1], cut[row, 5] - cut[row, 2]
    d, e, f = cut[row, 6] - cut[row, 0], cut[row, 7] - cut[row, 1], cut[row, 8] - cut[row, 2]
    normal[0] += b * f - c * e
    normal[1] += c * d - a * f
    normal[2] += a * e - b * d


@compiled(array_of(float64, 3), float64)
def ball_tree(triangles: Floats, size: float) -> Floats:
    """Return the tree (m, 11) around triangles (n, 3, 3), n > 0, whose leaves have a radius of at most about `size`.

    A ball is around the middle of the box that holds its triangles, and is halved where that is widest.
    """
    count = _cut(triangles, size, np.empty((0, 10)))
    cut = np.empty((count, 10))
    _cut(triangles, size, cut)
    order, balls, above = np.empty(count, np.int64), np.empty((2 * count - 1, 11)), np.empty(2 * count - 1, np.int64)
    for place in range(count):
        order[place] = place
    waiting = np.empty((count + 1, 3), np.int64)
    waiting[0, 0], waiting[0, 1], waiting[0, 2] = 0, count, -1
    left, made = 1, 0
    low, high, normal = np.empty(3), np.empty(3), np.empty(3)
    while left:
        left -= 1
        begin, end, ball = waiting[left, 0], waiting[left, 1], made
        above[ball] = waiting[left, 2]
        made += 1
        for axis in range(3):
            low[axis], high[axis], normal[axis] = np.inf, -np.inf, 0.0
        for place in range(begin, end):
            _add_normal(cut, order[place], normal)
            for corner in range(3):
                for axis in range(3):
                    low[axis] = min(low[axis], cut[order[place], 3 * corner + axis])
                    high[axis] = max(high[axis], cut[order[place], 3 * corner + axis])
        widest, square = 0, 0.0
        size = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        bottom, top = np.inf, -np.inf
        for axis in range(3):
            normal[axis] = normal[axis] / size if size > 0.0 else 0.0
            balls[ball, 6 + axis] = normal[axis]
            balls[ball, axis] = 0.5 * (low[axis] + high[axis])
            if high[axis] - low[axis] > high[widest] - low[widest]:
                widest = axis
        for place in range(begin, end):
            for corner in range(3):
                apart, along = 0.0, 0.0
                for axis in range(3):
                    away = cut[order[place], 3 * corner + axis] - balls[ball, axis]
                    apart += away * away
                    along += away * normal[axis]
                square, bottom, top = max(square, apart), min(bottom, along), max(top, along)
        balls[ball, 3], balls[ball, 4], balls[ball, 5] = math.sqrt(square), 1.0, -1.0
        balls[ball, 9], balls[ball, 10] = 0.5 * (bottom + top), 0.5 * (top - bottom)
        if end - begin == 1:
            balls[ball, 5] = cut[order[begin], 9]
            continue
        first, last, middle = begin, end - 1, 3.0 * balls[ball, widest]
        while first <= last:
            one = order[first]
            if cut[one, widest] + cut[one, 3 + widest] + cut[one, 6 + widest] < middle:
                first += 1
            else:
                order[first], order[last] = order[last], one
                last -= 1
        half = first if begin < first < end else (begin + end) // 2
        for part in range(2):
            waiting[left, 0], waiting[left, 1] = (begin, half) if part else (half, end)
            waiting[left, 2] = ball
            left += 1
    for ball in range(made - 1, 0, -1):
        balls[above[ball], 4] += balls[ball, 4]
    return balls


@inlined
def moved(triangles: Floats, triangle: int, other_t_one: Floats, corners: Floats) -> None:
    """Write the corners (3, 3) of one of the triangles (n, 3, 3) as they are in another frame."""
    for corner in range(3):
        for i in range(3):
            corners[corner, i] = other_t_one[i, 3]
            for j in range(3):
                corners[corner, i] += other_t_one[i, j] * triangles[triangle, corner, j]


@inlined
def _beyond_box(corners: Floats, half: Floats, box: int, margin: float) -> bool:
    """Return whether a triangle (3, 3) is apart from a box half[box] about the origin, grown by a margin to each side.

    By their separating axes: the box's, the triangle's normal, and those across an edge of each.
    """
    for axis in range(13):
        x, y, z = 0.0, 0.0, 0.0
        if axis < 3:
            x, y, z = 1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0
        else:
            k = (axis - 3) // 3 if axis < 12 else 0
            a = corners[(k + 1) % 3, 0] - corners[k, 0]
            b = corners[(k + 1) % 3, 1] - corners[k, 1]
            c = corners[(k + 1) % 3, 2] - corners[k, 2]
            if axis == 12:
                d, e, f = corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1], corners[2, 2] - corners[0, 2]
                x, y, z = b * f - c * e, c * d - a * f, a * e - b * d
            elif (axis - 3) % 3 == 0:
                y, z = c, -b
            elif (axis - 3) % 3 == 1:
                x, z = -c, a
            else:
                x, y = b, -a
        reach = half[box, 0] * abs(x) + half[box, 1] * abs(y) + half[box, 2] * abs(z)
        reach += margin * (abs(x) + abs(y) + abs(z))
        low, high = np.inf, -np.inf
        for corner in range(3):
            at = corners[corner, 0] * x + corners[corner, 1] * y + corners[corner, 2] * z
            low, high = min(low, at), max(high, at)
        if low > reach or high < -reach:
            return True
    return False


@inlined
def between_edges(first: Floats, i: int, second: Floats, j: int) -> tuple[float, float, float]:
    """Return what leads from the nearest point of edge j of a triangle (3, 3) to that of edge i of another, first one.

    C. Ericson, Real-Time Collision Detection, 2005, 5.1.9.
    """
    ax, ay, az = first[i, 0], first[i, 1], first[i, 2]
    bx, by, bz = second[j, 0], second[j, 1], second[j, 2]
    k, m = (i + 1) % 3, (j + 1) % 3
    ux, uy, uz = first[k, 0] - ax, first[k, 1] - ay, first[k, 2] - az
    vx, vy, vz = second[m, 0] - bx, second[m, 1] - by, second[m, 2] - bz
    rx, ry, rz = ax - bx, ay - by, az - bz
    a, e, f = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, vx * rx + vy * ry + vz * rz
    b, c = ux * vx + uy * vy + uz * vz, ux * rx + uy * ry + uz * rz
    across, s = a * e - b * b, 0.0
    if across > 0.0:
        s = min(max((b * f - c * e) / across, 0.0), 1.0)
    t = (b * s + f) / e if e > 0.0 else 0.0
    if t < 0.0 or t > 1.0 or e == 0.0:
        t = min(max(t, 0.0), 1.0)
        s = min(max((b * t - c) / a, 0.0), 1.0) if a > 0.0 else 0.0
    return rx + s * ux - t * vx, ry + s * uy - t * vy, rz + s * uz - t * vz


@inlined
def _over(face: Floats, normal: Floats, x: float, y: float, z: float) -> bool:
    """Return whether a point is above or below a triangle (3, 3), along its normal (3,)."""
    for i in range(3):
        k = (i + 1) % 3
        a, b, c = face[k, 0] - face[i, 0], face[k, 1] - face[i, 1], face[k, 2] - face[i, 2]
        d, e, f = x - face[i, 0], y - face[i, 1], z - face[i, 2]
        side = normal[0] * (b * f - c * e) + normal[1] * (c * d - a * f) + normal[2] * (a * e - b * d)
        if side < 0.0:
            return False
    return True


@inlined
def _face_apart(face: Floats, other: Floats, margin: float, work: Floats) -> int:
    """Return 1 where a triangle's plane tells it apart from another one (3, 3), -1 where the face is met, else 0.

    work (2, 3): room.
    """
    normal, away = work[0], work[1]
    a, b, c = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1], face[1, 2] - face[0, 2]
    d, e, f = face[2, 0] - face[0, 0], face[2, 1] - face[0, 1], face[2, 2] - face[0, 2]
    normal[0], normal[1], normal[2] = b * f - c * e, c * d - a * f, a * e - b * d
    square = normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2
    if square <= _FLAT * (a * a + b * b + c * c) * (d * d + e * e + f * f):
        return 0
    size = 1.0 / math.sqrt(square)
    low, high = np.inf, -np.inf
    for i in range(3):
        normal[i] *= size
    for i in range(3):
        away[i] = 0.0
        for axis in range(3):
            away[i] += (other[i, axis] - face[0, axis]) * normal[axis]
        low, high = min(low, away[i]), max(high, away[i])
    if low > margin or high < -margin:
        return 1
    for i in range(3):
        if abs(away[i]) <= margin and _over(face, normal, other[i, 0], other[i, 1], other[i, 2]):
            return -1
        k = (i + 1) % 3
        if away[i] * away[k] < 0.0:
            s = away[i] / (away[i] - away[k])
            x = other[i, 0] + s * (other[k, 0] - other[i, 0])
            y = other[i, 1] + s * (other[k, 1] - other[i, 1])
            z = other[i, 2] + s * (other[k, 2] - other[i, 2])
            if _over(face, normal, x, y, z):
                return -1
    return 0


@inlined
def _triangles_apart(both: Floats, margin: float, work: Floats) -> bool:
    """Return whether two triangles (2, 3, 3) are farther than a margin apart; work (2, 3): room."""
    for side in range(2):
        told = _face_apart(both[side], both[1 - side], margin, work)
        if told != 0:
            return told > 0
    square = margin * margin
    for edges in range(9):
        x, y, z = between_edges(both[0], edges // 3, both[1], edges % 3)
        if x * x + y * y + z * z <= square:
            return False
    return True


@inlined
def tree_and_box(
    balls: Floats, triangles: Floats, box_t_tree: Floats, half: Floats, box: int, margin: float, corners: Floats
) -> bool:
    """Return whether a tree is certainly farther than `margin` from a box half[box]; what is in it is not far.

    balls (m, 11) and triangles (n, 3, 3): the tree; box_t_tree (3, 4): its frame in that of the box, whose middle is
    its origin; corners (3, 3): room.
    """
    ball = 0
    while ball < balls.shape[0]:
        apart, along, tall = 0.0, balls[ball, 9], balls[ball, 10] + margin
        for axis in range(3):
            at, turned = box_t_tree[axis, 3], 0.0
            for i in range(3):
                at += box_t_tree[axis, i] * balls[ball, i]
                turned += box_t_tree[axis, i] * balls[ball, 6 + i]
            gap = max(abs(at) - half[box, axis], 0.0)
            apart += gap * gap
            along += at * turned
            tall += abs(turned) * half[box, axis]
        reach = balls[ball, 3] + margin
        if apart > reach * reach or abs(along) > tall:
            ball += int(balls[ball, 4])
            continue
        triangle = int(balls[ball, 5])
        if triangle >= 0:
            moved(triangles, triangle, box_t_tree, corners)
            if not _beyond_box(corners, half, box, margin):
                return False
        ball += 1
    return True


@inlined
def halve(balls: Floats, others: Floats, one: int, other: int, waiting: Integers, left: int) -> int:
    """Have the two below the larger one of two balls wait instead of it, and return how many wait."""
    if others[other, 5] >= 0.0 or (balls[one, 5] < 0.0 and balls[one, 3] >= others[other, 3]):
        waiting[left, 0], waiting[left + 1, 0] = one + 1, one + 1 + int(balls[one + 1, 4])
        waiting[left, 1], waiting[left + 1, 1] = other, other
    else:
        waiting[left, 0], waiting[left + 1, 0] = one, one
        waiting[left, 1], waiting[left + 1, 1] = other + 1, other + 1 + int(others[other + 1, 4])
    return left + 2


@inlined
def two_trees(
    balls: Floats,
    triangles: Floats,
    others: Floats,
    faces: Floats,
    other_t_one: Floats,
    margin: float,
    most: float,
    last: Integers,
    waiting: Integers,
    both: Floats,
    work: Floats,
) -> bool:
    """Return whether two trees are certainly farther than `margin` apart.

    Args:
        balls: (m, 11) and `triangles` (n, 3, 3): the one tree.
        triangles: as told.
        others: (k, 11) and `faces` (l, 3, 3): the other.
        faces: as told.
        other_t_one: (3, 4) the first one's frame in that of the other.
        margin: in m.
        most: so many balls are near each other at the most; where there are more the answer is no.
        last: (2,) the balls that were near when this was asked last, looked at first; below 0 for none.
        waiting: (w, 2) room; where there is too little the answer is no.
        both: (2, 3, 3) room.
        work: (2, 3) room.
    """
    waiting[0, 0], waiting[0, 1], waiting[1, 0], waiting[1, 1] = 0, 0, last[0], last[1]
    left, held, beside, looks = 2 if last[0] >= 0 else 1, -1, -1, 0
    while left:
        left -= 1
        one, other = waiting[left, 0], waiting[left, 1]
        apart = 0.0
        for axis in range(3):
            work[0, axis] = other_t_one[axis, 3] - others[other, axis]
            for i in range(3):
                work[0, axis] += other_t_one[axis, i] * balls[one, i]
            apart += work[0, axis] * work[0, axis]
        both_radii = balls[one, 3] + others[other, 3]
        reach = both_radii + margin
        if apart > reach * reach:
            continue
        looks += 1
        if looks > most or (margin > both_radii and apart <= (margin - both_radii) ** 2):
            last[0], last[1] = one, other
            return False
        cosine, along, across = 0.0, 0.0, 0.0
        for axis in range(3):
            turned = 0.0
            for i in range(3):
                turned += other_t_one[axis, i] * balls[one, 6 + i]
            cosine += turned * others[other, 6 + axis]
            along += work[0, axis] * turned
            across += work[0, axis] * others[other, 6 + axis]
        # Along the direction of either, what is in the other's slab is beside it by no more than its ball.
        sine, tall = math.sqrt(max(1.0 - cosine * cosine, 0.0)), abs(cosine)
        away = abs(along + balls[one, 9] - cosine * others[other, 9])
        if away > margin + balls[one, 10] + tall * others[other, 10] + sine * others[other, 3]:
            continue
        away = abs(across + cosine * balls[one, 9] - others[other, 9])
        if away > margin + others[other, 10] + tall * balls[one, 10] + sine * balls[one, 3]:
            continue
        triangle, face = int(balls[one, 5]), int(others[other, 5])
        if triangle >= 0 and face >= 0:
            # Neighbours are often parts of the same two triangles.
            if triangle == held and face == beside:
                continue
            moved(triangles, triangle, other_t_one, both[0])
            for corner in range(3):
                for axis in range(3):
                    both[1, corner, axis] = faces[face, corner, axis]
            if not _triangles_apart(both, margin, work):
                last[0], last[1] = one, other
                return False
            held, beside = triangle, face
            continue
        if left + 2 > waiting.shape[0]:
            return False
        left = halve(balls, others, one, other, waiting, left)
    return True
