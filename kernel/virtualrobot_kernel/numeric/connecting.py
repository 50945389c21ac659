"""Search for a way by two trees that grow towards each other, through what certainly touches nothing; compiled.

J. Kuffner, S. LaValle, RRT-Connect: an efficient approach to single-query path planning, IEEE ICRA 2000.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64, types
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

from virtualrobot_kernel.numeric.certainty import CELL, Cell, Place, go, pair_in_doubt, placed
from virtualrobot_kernel.numeric.polynomials import write_all

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]

_ONE, _FLOATS, _POSES = array_of(float64, 1), array_of(float64, 2), array_of(float64, 3)


class Room(NamedTuple):
    """Room of k coordinates: lower and upper (k,), and ratios (a, k) of what is between least and most (a,)."""

    lower: Floats
    upper: Floats
    ratios: Floats
    least: Floats
    most: Floats


_ROOM = types.NamedTuple((_ONE, _ONE, _FLOATS, _ONE, _ONE), Room)


@inlined
def _holds(room: Room, q: Floats) -> bool:
    for i in range(q.shape[0]):
        if not room.lower[i] <= q[i] <= room.upper[i]:
            return False
    for row in range(room.least.shape[0]):
        value = 0.0
        for i in range(q.shape[0]):
            value += room.ratios[row, i] * q[i]
        if not room.least[row] <= value <= room.most[row]:
            return False
    return True


@inlined
def _free(
    cell: Cell,
    room: Room,
    place: Place,
    begin: Floats,
    end: Floats,
    step: float,
    margin: float,
    joints: Floats,
    seen: Integers,
) -> bool:
    """Return whether configurations on a line, at most a step apart, are in the room and certainly free by a margin.

    Its begin is left out. What collides does so for a while: places far apart find it soonest. margin: in m; joints
    (k,): room; seen (2,): the pair that was in doubt last, and how many configurations were looked at.
    """
    if not _holds(room, end):
        return False
    widest = 0.0
    for i in range(begin.shape[0]):
        widest = max(widest, abs(end[i] - begin[i]))
    count = max(1, math.ceil(widest / step))
    stride, at = 1, count
    while stride < count:
        stride *= 2
    while stride:
        while at < count or (at == count and 2 * stride > count):
            for i in range(begin.shape[0]):
                joints[i] = begin[i] + (end[i] - begin[i]) * (at / count)
            go(cell, place, joints)
            seen[1] += 1
            pair = pair_in_doubt(cell, place, margin, seen[0])
            if pair >= 0:
                seen[0] = pair
                return False
            at += 2 * stride
        stride //= 2
        at = stride
    return True


@inlined
def _nearest(tree: Floats, size: int, q: Floats) -> int:
    """Return the row of a tree (m, k), of which so many are in use, that is nearest to q (k,)."""
    best, found = np.inf, 0
    for row in range(size):
        apart = 0.0
        for i in range(q.shape[0]):
            apart += (tree[row, i] - q[i]) ** 2
        if apart < best:
            best, found = apart, row
    return found


@inlined
def _towards(begin: Floats, end: Floats, reach: float, new: Floats) -> bool:
    """Write where a way of length `reach` from a configuration to another one ends; return whether that is there."""
    length = 0.0
    for i in range(begin.shape[0]):
        length += (end[i] - begin[i]) ** 2
    length = math.sqrt(length)
    for i in range(begin.shape[0]):
        new[i] = end[i] if length <= reach else begin[i] + (end[i] - begin[i]) * (reach / length)
    return length <= reach


@compiled(CELL, _ONE, _POSES, _POSES, _ROOM, _ONE, _ONE, float64, float64)
def line_is_certain(
    cell: Cell,
    q: Floats,
    nodes: Floats,
    elements: Floats,
    room: Room,
    begin: Floats,
    end: Floats,
    step: float,
    margin: float,
) -> bool:
    """Return whether configurations on a line, at most `step` apart, are in the room and certainly free by a margin.

    Its begin (k,) is left out; the first four are as in `certain_places`.
    """
    place = placed(cell, q, nodes, elements)
    return _free(cell, room, place, begin, end, step, margin, np.empty(begin.shape[0]), np.zeros(2, np.int64))


@compiled(
    *(CELL, _ONE, _POSES, _POSES, _ROOM, _FLOATS, float64, float64, float64),
    *(output_of(float64, 3), output_of(int64, 2), output_of(int64, 1), output_of(int64, 1), output_of(int64, 1)),
)
def trees_meet(
    cell: Cell,
    q: Floats,
    nodes: Floats,
    elements: Floats,
    room: Room,
    samples: Floats,
    reach: float,
    step: float,
    margin: float,
    trees: Floats,
    parents: Integers,
    sizes: Integers,
    ends: Integers,
    seen: Integers,
) -> bool:
    """Grow two trees until they meet or the samples are used up; return whether they meet.

    Args:
        cell: as in `certain_places`, and the three after it.
        q: (nq,).
        nodes: (n, 4, 4).
        elements: (e, 4, 4).
        room: where the coordinates may be.
        samples: (s, k) towards which the smaller tree grows, one after the other.
        reach: the greatest length of an edge.
        step: the greatest distance of a coordinate between two places on an edge that are looked at.
        margin: in m, by which all is to be farther than touching there.
        trees: (2, m, k) configurations of both trees; they grow while there is room for more.
        parents: (2, m) the row from which each is reached; -1 where a tree begins.
        sizes: (2,) how many there are.
        ends: (2,) the rows in which the trees meet: one and the same configuration.
        seen: (2,) the pair of elements that was in doubt last, and how many configurations were looked at.
    """
    k, most = samples.shape[1], trees.shape[1]
    place, joints = placed(cell, q, nodes, elements), np.empty(k)
    new, there = np.empty(k), np.empty(k)
    for sample in range(samples.shape[0]):
        side = 0 if sizes[0] <= sizes[1] else 1
        near = _nearest(trees[side], sizes[side], samples[sample])
        _towards(trees[side, near], samples[sample], reach, new)
        if sizes[side] == most or not _free(cell, room, place, trees[side, near], new, step, margin, joints, seen):
            continue
        write_all(new, trees[side, sizes[side]])
        parents[side, sizes[side]] = near
        ends[side] = sizes[side]
        sizes[side] += 1
        other = 1 - side
        near = _nearest(trees[other], sizes[other], new)
        while sizes[other] < most:
            arrived = _towards(trees[other, near], new, reach, there)
            if not _free(cell, room, place, trees[other, near], there, step, margin, joints, seen):
                break
            write_all(there, trees[other, sizes[other]])
            parents[other, sizes[other]] = near
            near = sizes[other]
            sizes[other] += 1
            if arrived:
                ends[other] = near
                return True
    return False
