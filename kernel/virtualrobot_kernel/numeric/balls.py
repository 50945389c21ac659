"""Trees of balls around triangles, and whether two figures are certainly farther apart than a distance; compiled.

S. Quinlan, Efficient distance computation between non-convex objects, IEEE ICRA 1994: triangles are cut until each fits
into a small ball, and each ball of the tree holds those below it. Balls (m, 4), centre and radius, are in depth-first
order; skip (m,) says how many places on a ball's subtree is over, so that walking down a tree needs no stack.
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


@inlined
def _cut(triangles: Floats, size: float, cut: Floats) -> int:
    """Write triangles with edges of at most sqrt(3) sizes, which a ball of that radius holds each; return their number.

    To `cut` (m, 9) go as many as there is room for.
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


@compiled(array_of(float64, 3), float64)
def ball_tree(triangles: Floats, size: float) -> tuple[Floats, Integers]:
    """Return balls and skips of the tree around triangles (n, 3, 3), n > 0, whose leaves have a radius of about `size`.

    A ball is around the middle of the box that holds its triangles, and is halved where that is widest.
    """
    count = _cut(triangles, size, np.empty((0, 9)))
    cut = np.empty((count, 9))
    _cut(triangles, size, cut)
    order, balls, above = np.empty(count, np.int64), np.empty((2 * count, 4)), np.empty(2 * count, np.int64)
    for place in range(count):
        order[place] = place
    waiting = np.empty((2 * count, 3), np.int64)
    waiting[0, 0], waiting[0, 1], waiting[0, 2] = 0, count, -1
    left, made = 1, 0
    low, high = np.empty(3), np.empty(3)
    while left:
        left -= 1
        begin, end, ball = waiting[left, 0], waiting[left, 1], made
        above[ball] = waiting[left, 2]
        made += 1
        for axis in range(3):
            low[axis], high[axis] = np.inf, -np.inf
        for place in range(begin, end):
            for corner in range(3):
                for axis in range(3):
                    low[axis] = min(low[axis], cut[order[place], 3 * corner + axis])
                    high[axis] = max(high[axis], cut[order[place], 3 * corner + axis])
        widest, square = 0, 0.0
        for axis in range(3):
            balls[ball, axis] = 0.5 * (low[axis] + high[axis])
            if high[axis] - low[axis] > high[widest] - low[widest]:
                widest = axis
        for place in range(begin, end):
            for corner in range(3):
                apart = 0.0
                for axis in range(3):
                    apart += (cut[order[place], 3 * corner + axis] - balls[ball, axis]) ** 2
                square = max(square, apart)
        balls[ball, 3] = math.sqrt(square)
        if end - begin == 1 or balls[ball, 3] <= size:
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
    skip = np.ones(made, np.int64)
    for ball in range(made - 1, 0, -1):
        skip[above[ball]] += skip[ball]
    return balls[:made].copy(), skip


@inlined
def tree_and_box(
    balls: Floats, skip: Integers, begin: int, end: int, box_t_tree: Floats, half: Floats, box: int, margin: float
) -> bool:
    """Return whether a tree, the balls `begin` to `end`, is certainly farther than `margin` from a box half[box].

    box_t_tree (3, 4): the tree's frame in that of the box, whose middle is its origin. What is in it is not far.
    """
    ball = begin
    while ball < end:
        apart = 0.0
        for axis in range(3):
            at = box_t_tree[axis, 3]
            for i in range(3):
                at += box_t_tree[axis, i] * balls[ball, i]
            gap = max(abs(at) - half[box, axis], 0.0)
            apart += gap * gap
        reach = balls[ball, 3] + margin
        if apart > reach * reach:
            ball += skip[ball]
        elif skip[ball] == 1:
            return False
        else:
            ball += 1
    return True


@inlined
def two_trees(
    balls: Floats, skip: Integers, first: int, second: int, second_t_first: Floats, margin: float, waiting: Integers
) -> bool:
    """Return whether the trees below two balls are certainly farther than `margin` apart.

    second_t_first (3, 4): the first one's frame in that of the second; waiting (w, 2): room. Where there is too little
    the answer is no.
    """
    waiting[0, 0], waiting[0, 1] = first, second
    left = 1
    while left:
        left -= 1
        one, other = waiting[left, 0], waiting[left, 1]
        apart = 0.0
        for axis in range(3):
            at = second_t_first[axis, 3] - balls[other, axis]
            for i in range(3):
                at += second_t_first[axis, i] * balls[one, i]
            apart += at * at
        reach = balls[one, 3] + balls[other, 3] + margin
        if apart > reach * reach:
            continue
        leaf, leaf_too = skip[one] == 1, skip[other] == 1
        if (leaf and leaf_too) or left + 2 > waiting.shape[0]:
            return False
        if leaf_too or (not leaf and balls[one, 3] >= balls[other, 3]):
            waiting[left, 0], waiting[left + 1, 0] = one + 1, one + 1 + skip[one + 1]
            waiting[left, 1], waiting[left + 1, 1] = other, other
        else:
            waiting[left, 0], waiting[left + 1, 0] = one, one
            waiting[left, 1], waiting[left + 1, 1] = other + 1, other + 1 + skip[other + 1]
        left += 2
    return True
