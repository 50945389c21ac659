"""Trees of balls that stay apart while one goes a way that is nearly straight; compiled.

Where a body slides by another one, it goes far and hardly nearer. A point that goes straight on is beyond a plane all
the way when it is at both ends, and its true way is beside that by no more than its bow (`motion_bounds.bow`). So what
a distance is compared with here is the bow, which is of second order, and not how far things go.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from virtualrobot_sdk.compiled.cache import inlined

from virtualrobot_kernel.numeric.balls import between_edges, halve, moved

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]


@inlined
def _beside(
    balls: Floats, one: int, others: Floats, other: int, turns: Floats, x: float, y: float, z: float, work: Floats
) -> float:
    """Return how far apart along a direction of length 1 what is in two balls' slabs stays at the least on a way.

    turns (3, 3, 4) and work (3, 3): how the one ball is turned, and where it is, at three places of it.
    """
    across = x * others[other, 6] + y * others[other, 7] + z * others[other, 8]
    reach = abs(across) * others[other, 10] + math.sqrt(max(1.0 - across * across, 0.0)) * others[other, 3]
    low, high = np.inf, -np.inf
    for stop in range(3):
        along = 0.0
        for i in range(3):
            turned = x * turns[stop, 0, i] + y * turns[stop, 1, i] + z * turns[stop, 2, i]
            along += turned * balls[one, 6 + i]
        away = x * work[stop, 0] + y * work[stop, 1] + z * work[stop, 2]
        away += along * balls[one, 9] - across * others[other, 9]
        tall = abs(along) * balls[one, 10] + math.sqrt(max(1.0 - along * along, 0.0)) * balls[one, 3]
        low, high = min(low, away - tall), max(high, away + tall)
    return max(low, -high) - reach


@inlined
def _along(corners: Floats, x: float, y: float, z: float, margin: float) -> bool:
    """Return whether a triangle stays farther than a margin from another one along a direction, as in `_stays`."""
    far = margin * math.sqrt(x * x + y * y + z * z)
    least, most, low, high = np.inf, -np.inf, np.inf, -np.inf
    for stop in range(4):
        for corner in range(3):
            at = x * corners[stop, corner, 0] + y * corners[stop, corner, 1] + z * corners[stop, corner, 2]
            if stop == 3:
                low, high = min(low, at), max(high, at)
            else:
                least, most = min(least, at), max(most, at)
    return least - high > far or low - most > far


@inlined
def _stays(corners: Floats, margin: float) -> bool:
    """Return whether a triangle certainly stays farther than a margin from another one.

    corners (4, 3, 3): the one where it is at the begin, in the middle and at the end, and the other.
    """
    for stop in range(1, 4, 2):
        face = corners[stop]
        a, b, c = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1], face[1, 2] - face[0, 2]
        d, e, f = face[2, 0] - face[0, 0], face[2, 1] - face[0, 1], face[2, 2] - face[0, 2]
        if _along(corners, b * f - c * e, c * d - a * f, a * e - b * d, margin):
            return True
    least, x, y, z = np.inf, 0.0, 0.0, 0.0
    for edges in range(9):
        u, v, w = between_edges(corners[1], edges // 3, corners[3], edges % 3)
        square = u * u + v * v + w * w
        if square < least:
            least, x, y, z = square, u, v, w
    return _along(corners, x, y, z, margin)


@inlined
def trees_stay_apart(
    balls: Floats,
    triangles: Floats,
    others: Floats,
    faces: Floats,
    turns: Floats,
    margin: float,
    most: float,
    last: Integers,
    side: int,
    waiting: Integers,
    corners: Floats,
    work: Floats,
) -> bool:
    """Return whether two trees are certainly farther than `margin` apart on two straight ways, one after the other.

    Args:
        balls: (m, 11) and `triangles` (n, 3, 3): the one tree.
        triangles: as told.
        others: (k, 11) and `faces` (l, 3, 3): the other.
        faces: as told.
        turns: (3, 3, 4) the first one's frame in that of the other at the begin, in the middle and at the end; between
            these each point is taken to go straight on: what it doesn't is a part of the margin.
        margin: in m.
        most: so many balls are near each other at the most; where there are more the answer is no.
        last: (2,) the balls that were near when this was asked last, looked at first; below 0 for none.
        side: which of `last` is of the one tree, 0 or 1.
        waiting: (w, 2) room; where there is too little the answer is no.
        corners: (4, 3, 3) room.
        work: (3, 3) room.
    """
    waiting[0, 0], waiting[0, 1], waiting[1, 0], waiting[1, 1] = 0, 0, last[side], last[1 - side]
    left, held, beside, looks = 2 if last[0] >= 0 else 1, -1, -1, 0
    while left:
        left -= 1
        one, other = waiting[left, 0], waiting[left, 1]
        for stop in range(3):
            for axis in range(3):
                work[stop, axis] = turns[stop, axis, 3] - others[other, axis]
                for i in range(3):
                    work[stop, axis] += turns[stop, axis, i] * balls[one, i]
        reach, nearest = balls[one, 3] + others[other, 3] + margin, np.inf
        for half in range(2):
            along, length = 0.0, 0.0
            for axis in range(3):
                gone = work[half + 1, axis] - work[half, axis]
                along -= gone * work[half, axis]
                length += gone * gone
            part, square = min(max(along / length, 0.0), 1.0) if length > 0.0 else 0.0, 0.0
            for axis in range(3):
                square += (work[half, axis] + part * (work[half + 1, axis] - work[half, axis])) ** 2
            nearest = min(nearest, square)
        if nearest > reach * reach:
            continue
        looks += 1
        if looks > most:
            last[side], last[1 - side] = one, other
            return False
        x, y, z = others[other, 6], others[other, 7], others[other, 8]
        if _beside(balls, one, others, other, turns, x, y, z, work) > margin:
            continue
        x, y, z = 0.0, 0.0, 0.0
        for i in range(3):
            x += turns[1, 0, i] * balls[one, 6 + i]
            y += turns[1, 1, i] * balls[one, 6 + i]
            z += turns[1, 2, i] * balls[one, 6 + i]
        if _beside(balls, one, others, other, turns, x, y, z, work) > margin:
            continue
        triangle, face = int(balls[one, 5]), int(others[other, 5])
        if triangle >= 0 and face >= 0:
            # Neighbours are often parts of the same two triangles.
            if triangle == held and face == beside:
                continue
            for stop in range(3):
                moved(triangles, triangle, turns[stop], corners[stop])
            for corner in range(3):
                for axis in range(3):
                    corners[3, corner, axis] = faces[face, corner, axis]
            if not _stays(corners, margin):
                last[side], last[1 - side] = one, other
                return False
            held, beside = triangle, face
            continue
        if left + 2 > waiting.shape[0]:
            return False
        left = halve(balls, others, one, other, waiting, left)
    return True
