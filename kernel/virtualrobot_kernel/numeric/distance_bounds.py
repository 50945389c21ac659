"""Lower bounds of the distances of elements: by turned boxes, and by what was measured at other places; compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]

SLACK = 1e-9
"""Distances are told so much smaller than they are computed (m): more than rounding."""


@inlined
def _gap(
    poses: Floats,
    one: int,
    other: int,
    centre: Floats,
    half: Floats,
    a: int,
    centres: Floats,
    halves: Floats,
    b: int,
    work: Floats,
) -> float:
    """Return a lower bound of the distance of boxes `a` of element `one` and `b` of `other`, below 0 perhaps.

    It is the greatest of the distances along their 15 separating axes (S. Gottschalk, M. Lin, D. Manocha, OBBTree,
    SIGGRAPH 1996) and of each from the box around the other along its own axes. `work` (7, 3) holds the rotation
    between them, its absolute values and the way from one centre to the other.
    """
    for i in range(3):
        way = 0.0
        for k in range(3):
            at = poses[other, k, 3] - poses[one, k, 3]
            for j in range(3):
                at += poses[other, k, j] * centres[b, j] - poses[one, k, j] * centre[a, j]
            way += poses[one, k, i] * at
        work[6, i] = way
        for j in range(3):
            turn = 0.0
            for k in range(3):
                turn += poses[one, k, i] * poses[other, k, j]
            work[i, j] = turn
            work[3 + i, j] = abs(turn)
    first = 0.0
    for i in range(3):
        gap = abs(work[6, i]) - half[a, i]
        for j in range(3):
            gap -= halves[b, j] * work[3 + i, j]
        if gap > 0.0:
            first += gap * gap
    second = 0.0
    for j in range(3):
        gap = -halves[b, j]
        way = 0.0
        for i in range(3):
            gap -= half[a, i] * work[3 + i, j]
            way += work[6, i] * work[i, j]
        gap += abs(way)
        if gap > 0.0:
            second += gap * gap
    best = math.sqrt(max(first, second))
    for i in range(3):
        after, last = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            size = 1.0 - work[i, j] * work[i, j]
            if size < 1e-6:
                continue
            next_j, last_j = (j + 1) % 3, (j + 2) % 3
            gap = abs(work[6, last] * work[after, j] - work[6, after] * work[last, j])
            gap -= half[a, after] * work[3 + last, j] + half[a, last] * work[3 + after, j]
            gap -= halves[b, next_j] * work[3 + i, last_j] + halves[b, last_j] * work[3 + i, next_j]
            if gap > 0.0:
                best = max(best, gap / math.sqrt(size))
    return best


@compiled(
    int64,
    int64,
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 2),
)
def box_gaps(
    one: int,
    other: int,
    world_t_element: Floats,
    centre: Floats,
    half: Floats,
    centres: Floats,
    halves: Floats,
    found: Floats,
) -> None:
    """Write lower bounds of the distances of each two boxes of two elements.

    Args:
        one: the element of the first boxes.
        other: that of the others.
        world_t_element: (e, 4, 4) where the elements are.
        centre: (r, 3) of the first boxes, in their element's frame.
        half: (r, 3) half of their edges.
        centres: (s, 3) of the others, in theirs.
        halves: (s, 3).
        found: (r, s) the result in m, at least 0.
    """
    work = np.empty((7, 3))
    for a in range(centre.shape[0]):
        for b in range(centres.shape[0]):
            gap = _gap(world_t_element, one, other, centre, half, a, centres, halves, b, work)
            found[a, b] = max(gap - SLACK, 0.0)


@inlined
def block_distance(
    one: int,
    other: int,
    world_t_element: Floats,
    first_block: Integers,
    block_centre: Floats,
    block_half: Floats,
    work: Floats,
    place: Floats,
) -> float:
    """Return a lower bound of the distance of two elements, by the turned boxes around their blocks.

    Args:
        one: an element.
        other: another one.
        world_t_element: (e, 4, 4) where the elements are.
        first_block: (e + 1,) the blocks of element i are first_block[i] to first_block[i + 1].
        block_centre: (b, 3) of each block's box, in its element's frame.
        block_half: (b, 3) half of its edges.
        work: (7, 3) room.
        place: (3,) room.
    """
    best = np.inf
    for a in range(first_block[one], first_block[one + 1]):
        size = 0.0
        for i in range(3):
            place[i] = world_t_element[one, i, 3]
            for j in range(3):
                place[i] += world_t_element[one, i, j] * block_centre[a, j]
            size += block_half[a, i] ** 2
        size = math.sqrt(size)
        for b in range(first_block[other], first_block[other + 1]):
            apart = 0.0
            extent = 0.0
            for i in range(3):
                at = world_t_element[other, i, 3]
                for j in range(3):
                    at += world_t_element[other, i, j] * block_centre[b, j]
                apart += (at - place[i]) ** 2
                extent += block_half[b, i] ** 2
            apart = math.sqrt(apart) - size - math.sqrt(extent)
            if apart < best:
                boxes = block_centre, block_half
                gap = _gap(world_t_element, one, other, boxes[0], boxes[1], a, boxes[0], boxes[1], b, work)
                best = min(best, max(gap, apart))
    return max(best - SLACK, 0.0)


@inlined
def cached_distance_bound(
    one: int,
    other: int,
    slot: int,
    world_t_element: Floats,
    centre: Floats,
    half: Floats,
    first_t_second: Floats,
    distances: Floats,
    now: Floats,
    change: Floats,
) -> float:
    """Return a lower bound of the distance of two elements, by distances that were measured at other places.

    A distance changes by no more than any point of one goes, seen from the other; of a box no point goes farther than
    its farthest corner, whichever of both is held.

    Args:
        one: an element.
        other: another one.
        slot: where what is known of the two is kept; below 0 for nothing.
        world_t_element: (e, 4, 4) where the elements are.
        centre: (e, 3) the box around each element's core in its own frame.
        half: (e, 3) half of its edges.
        first_t_second: (s, c, 3, 4) where the second was, seen from the first, when the distance was measured.
        distances: (s, c) it, in m; negative where none is kept.
        now: (3, 4) room.
        change: (3, 4) room.
    """
    best = 0.0
    if slot < 0:
        return best
    for i in range(3):
        for j in range(4):
            value = 0.0
            for m in range(3):
                shift = world_t_element[one, m, 3] if j == 3 else 0.0
                value += world_t_element[one, m, i] * (world_t_element[other, m, j] - shift)
            now[i, j] = value
    for kept in range(distances.shape[1]):
        if distances[slot, kept] <= best:
            continue
        then = first_t_second[slot, kept]
        held = 0.0
        for corner in range(8):
            apart = 0.0
            for i in range(3):
                away = now[i, 3] - then[i, 3]
                for j in range(3):
                    side = half[other, j] if (corner >> j) & 1 else -half[other, j]
                    away += (now[i, j] - then[i, j]) * (centre[other, j] + side)
                apart += away * away
            held = max(held, apart)
        # Where a point of the first is, seen from the second: R^T (p - x), with R and x of now and of then.
        for i in range(3):
            shift = 0.0
            for j in range(3):
                change[i, j] = now[j, i] - then[j, i]
                shift -= now[j, i] * now[j, 3] - then[j, i] * then[j, 3]
            change[i, 3] = shift
        turned = 0.0
        for corner in range(8):
            apart = 0.0
            for i in range(3):
                away = change[i, 3]
                for j in range(3):
                    side = half[one, j] if (corner >> j) & 1 else -half[one, j]
                    away += change[i, j] * (centre[one, j] + side)
                apart += away * away
            turned = max(turned, apart)
        best = max(best, distances[slot, kept] - math.sqrt(min(held, turned)) - SLACK)
    return best


@compiled(
    array_of(int64, 2),
    array_of(int64, 1),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 4),
    array_of(float64, 2),
    output_of(float64, 1),
)
def cached_distance_bounds(
    pairs: Integers,
    slots: Integers,
    world_t_element: Floats,
    centre: Floats,
    half: Floats,
    first_t_second: Floats,
    distances: Floats,
    found: Floats,
) -> None:
    """Write what `cached_distance_bound` tells of pairs (k, 2), whose slots are (k,), to `found` (k,)."""
    now, change = np.empty((3, 4)), np.empty((3, 4))
    kept = first_t_second, distances
    for k in range(pairs.shape[0]):
        one, other = pairs[k, 0], pairs[k, 1]
        found[k] = cached_distance_bound(
            one, other, slots[k], world_t_element, centre, half, kept[0], kept[1], now, change
        )
