"""Boxes around elements and their pieces: moved with the nodes, and tested for overlap, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import boolean, float64, int8, int32, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import copy, multiply

from virtualrobot_kernel.numeric.forest import place_rows

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Rows = np.ndarray[Any, np.dtype[np.int32]]
Codes = np.ndarray[Any, np.dtype[np.int8]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]

SLACK = 1e-9
"""Boxes overlap that are so near (m): what rounding makes of them must part nothing that touches."""

GROUP = 8
"""Number of elements around which one box is put, after one around all: neighbours in a list are so in a robot."""


@inlined
def _bound(
    world_t_element: Floats, element: int, local_centre: Floats, local_half: Floats, centre: Floats, half: Floats
) -> None:
    """Write the box around an element along the world's axes."""
    for i in range(3):
        middle = world_t_element[element, i, 3]
        reach = 0.0
        for j in range(3):
            middle += world_t_element[element, i, j] * local_centre[element, j]
            reach += abs(world_t_element[element, i, j]) * local_half[element, j]
        centre[element, i] = middle
        half[element, i] = reach


@compiled(
    array_of(float64, 3),
    array_of(float64, 3),
    array_of(int64, 1),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 3),
    output_of(float64, 2),
    output_of(float64, 2),
    output_of(int64, 1),
)
def follow_nodes(
    world_t_node: Floats,
    before: Floats,
    rows: Integers,
    node_t_element: Floats,
    local_centre: Floats,
    local_half: Floats,
    world_t_element: Floats,
    centre: Floats,
    half: Floats,
    moved: Integers,
) -> int:
    """Put elements where their nodes are and return how many have moved.

    Args:
        world_t_node: (n, 4, 4) where the nodes are.
        before: (n, 4, 4) where they were.
        rows: (e,) the node of each element.
        node_t_element: (e, 4, 4).
        local_centre: (e, 3) the box around each element in its own frame.
        local_half: (e, 3) half of its edges.
        world_t_element: (e, 4, 4) written where a node has moved.
        centre: (e, 3) the box around each element along the world's axes, written likewise.
        half: (e, 3) half of its edges.
        moved: (e,) the elements that moved are written to its beginning.
    """
    count = 0
    for element in range(rows.shape[0]):
        row = rows[element]
        same = True
        for i in range(3):
            for j in range(4):
                if world_t_node[row, i, j] != before[row, i, j]:
                    same = False
        if same:
            continue
        multiply(world_t_node, row, node_t_element, element, world_t_element, element)
        _bound(world_t_element, element, local_centre, local_half, centre, half)
        moved[count] = element
        count += 1
    return count


@inlined
def _relate(poses: Floats, one: int, other: int, work: Floats) -> None:
    """Write how element `other` stands, seen from `one`, to `work` (8, 3).

    Its first rows hold the rotation between them, its absolute values with the slack and, last, the other's origin.
    """
    for i in range(3):
        work[7, i] = 0.0
        for k in range(3):
            work[7, i] += poses[one, k, i] * (poses[other, k, 3] - poses[one, k, 3])
        for j in range(3):
            turn = 0.0
            for k in range(3):
                turn += poses[one, k, i] * poses[other, k, j]
            work[i, j] = turn
            work[3 + i, j] = abs(turn) + SLACK


@inlined
def _depth(work: Floats, centre: Floats, half: Floats, a: int, b: int) -> float:
    """Return how deep boxes `a` of one element and `b` of another are in each other, -1 where they are apart.

    Whether they are, their 15 separating axes tell (S. Gottschalk, M. Lin, D. Manocha, OBBTree, SIGGRAPH 1996); the
    depth (m) is the least along the axes of their faces. `work` (8, 3) is of both elements, as `_relate` writes it; row
    6 gets the way from one centre to the other.
    """
    depth = np.inf
    for i in range(3):
        work[6, i] = work[7, i] - centre[a, i]
        for j in range(3):
            work[6, i] += work[i, j] * centre[b, j]
    for i in range(3):
        reach = half[a, i] + SLACK
        for j in range(3):
            reach += half[b, j] * work[3 + i, j]
        if abs(work[6, i]) > reach:
            return -1.0
        depth = min(depth, reach - abs(work[6, i]))
    for j in range(3):
        reach = half[b, j] + SLACK
        way = 0.0
        for i in range(3):
            reach += half[a, i] * work[3 + i, j]
            way += work[6, i] * work[i, j]
        if abs(way) > reach:
            return -1.0
        depth = min(depth, reach - abs(way))
    for i in range(3):
        after, last = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            next_j, last_j = (j + 1) % 3, (j + 2) % 3
            reach = SLACK + half[a, after] * work[3 + last, j] + half[a, last] * work[3 + after, j]
            reach += half[b, next_j] * work[3 + i, last_j] + half[b, last_j] * work[3 + i, next_j]
            if abs(work[6, last] * work[after, j] - work[6, after] * work[last, j]) > reach:
                return -1.0
    return depth


@inlined
def _near_any(
    own: Integers, begin: int, end: int, centre: Floats, half: Floats, among: Integers, count: int, nearby: Integers
) -> int:
    """Write which of `count` elements meet the one box around own[begin:end] to `nearby`'s beginning; return how many.

    `among` is where they are told.
    """
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(begin, end):
        for axis in range(3):
            low[axis] = min(low[axis], centre[own[i], axis] - half[own[i], axis])
            high[axis] = max(high[axis], centre[own[i], axis] + half[own[i], axis])
    found = 0
    for place in range(count):
        other = among[place]
        near = True
        for axis in range(3):
            reach = half[other, axis] + 2.0 * SLACK  # twice: these sums are rounded otherwise than those of two boxes
            if centre[other, axis] + reach < low[axis] or centre[other, axis] - reach > high[axis]:
                near = False
                break
        if near:
            nearby[found] = other
            found += 1
    return found


@inlined
def _overlaps(
    own: Integers,
    asked: Booleans,
    centre: Floats,
    half: Floats,
    world_t_element: Floats,
    first_block: Integers,
    block_centre: Floats,
    block_half: Floats,
    found: Integers,
    depths: Floats,
    count: int,
    among: Integers,
    nearby: Integers,
    work: Floats,
) -> int:
    """Write what `overlapping_boxes` does behind the first `count`, and return how many these are then.

    `among` (e,), `nearby` (e,) and `work` (8, 3) are written to.
    """
    for element in range(centre.shape[0]):
        among[element] = element
    # In place: an element is written no later than where it stands.
    among_count = _near_any(own, 0, own.shape[0], centre, half, among, centre.shape[0], among)
    for begin in range(0, own.shape[0], GROUP):
        end = min(begin + GROUP, own.shape[0])
        near_count = _near_any(own, begin, end, centre, half, among, among_count, nearby)
        for i in range(begin, end):
            one = own[i]
            for at in range(near_count):
                other = nearby[at]
                if not asked[i, other]:
                    continue
                near = True
                for axis in range(3):
                    reach = half[one, axis] + half[other, axis] + SLACK
                    if abs(centre[one, axis] - centre[other, axis]) > reach:
                        near = False
                if not near:
                    continue
                _relate(world_t_element, one, other, work)
                for a in range(first_block[one], first_block[one + 1]):
                    for b in range(first_block[other], first_block[other + 1]):
                        depth = _depth(work, block_centre, block_half, a, b)
                        if depth >= 0.0:
                            if count < found.shape[0]:
                                depths[count] = depth
                                found[count, 0] = one
                                found[count, 1] = other
                                found[count, 2] = a
                                found[count, 3] = b
                            count += 1
    return count


@compiled(
    array_of(int64, 1),
    array_of(boolean, 2),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 3),
    array_of(int64, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(int64, 2),
    output_of(float64, 1),
)
def overlapping_boxes(
    own: Integers,
    asked: Booleans,
    centre: Floats,
    half: Floats,
    world_t_element: Floats,
    first_block: Integers,
    block_centre: Floats,
    block_half: Floats,
    found: Integers,
    depths: Floats,
) -> int:
    """Write which blocks of elements overlap, and return how many do, more than `found` has room for perhaps.

    Args:
        own: (k,) elements.
        asked: (k, e) whether a pair of one of these and any element is asked.
        centre: (e, 3) the box around each element along the world's axes.
        half: (e, 3) half of its edges.
        world_t_element: (e, 4, 4) where the elements are.
        first_block: (e + 1,) the blocks of element i are first_block[i] to first_block[i + 1].
        block_centre: (b, 3) of each block's box, in its element's frame.
        block_half: (b, 3) half of its edges.
        found: (m, 4) element, element, block, block.
        depths: (m,) how deep these boxes are in each other at the least (m).
    """
    among, nearby = np.empty(centre.shape[0], np.int64), np.empty(centre.shape[0], np.int64)
    boxes = centre, half, world_t_element, first_block, block_centre, block_half
    return _overlaps(own, asked, *boxes, found, depths, 0, among, nearby, np.empty((8, 3)))


@compiled(
    array_of(int32, 1),
    array_of(int32, 1),
    array_of(int8, 1),
    array_of(float64, 2),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 3),
    array_of(float64, 1),
    array_of(int64, 1),
    array_of(float64, 2),
    array_of(float64, 3),
    array_of(int64, 1),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(int64, 1),
    array_of(int64, 1),
    array_of(boolean, 2),
    array_of(float64, 3),
    array_of(int64, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 4),
    output_of(int64, 1),
    output_of(int64, 2),
    output_of(float64, 1),
)
def overlapping_boxes_at_each(
    order: Rows,
    parent: Rows,
    joint_type: Codes,
    axis: Floats,
    q_index: Rows,
    multiplier: Floats,
    offset: Floats,
    parent_t_node: Floats,
    q: Floats,
    moves: Integers,
    configurations: Floats,
    world_t_node: Floats,
    rows: Integers,
    node_t_element: Floats,
    local_centre: Floats,
    local_half: Floats,
    moved: Integers,
    own: Integers,
    asked: Booleans,
    world_t_element: Floats,
    first_block: Integers,
    block_centre: Floats,
    block_half: Floats,
    placed: Floats,
    last: Integers,
    found: Integers,
    depths: Floats,
) -> int:
    """Write which blocks overlap at each of m configurations, and return how many do, more than `found` has room for.

    Args:
        order: (r,) the rows that move, parents before children; up to q as `forward_forest` has them.
        parent: (n,).
        joint_type: (n,).
        axis: (n, 3).
        q_index: (n,).
        multiplier: (n,).
        offset: (n,).
        parent_t_node: (n, 4, 4).
        q: (nq,) coordinates, of which those that don't move count.
        moves: (k,) where the coordinates that move are in q.
        configurations: (m, k) rad or m.
        world_t_node: (n, 4, 4) where the nodes are, of which those that don't move count.
        rows: up to local_half as `follow_nodes` has them.
        node_t_element: (e, 4, 4).
        local_centre: (e, 3).
        local_half: (e, 3).
        moved: (c,) the elements that move.
        own: up to block_half as `overlapping_boxes` has them; of elements those that don't move are where they are.
        asked: (o, e).
        world_t_element: (e, 4, 4).
        first_block: (e + 1,).
        block_centre: (b, 3).
        block_half: (b, 3).
        placed: (m, c, 4, 4) where the elements that move are.
        last: (m,) the end of each configuration's overlaps among all.
        found: (p, 4) as `overlapping_boxes` has them, one configuration after the other.
        depths: (p,).
    """
    at, nodes, elements = q.copy(), world_t_node.copy(), world_t_element.copy()
    centre, half = np.empty(local_centre.shape), np.empty(local_centre.shape)
    for element in range(elements.shape[0]):
        _bound(elements, element, local_centre, local_half, centre, half)
    among, nearby = np.empty(centre.shape[0], np.int64), np.empty(centre.shape[0], np.int64)
    work, count = np.empty((8, 3)), 0
    for number in range(configurations.shape[0]):
        for i in range(moves.shape[0]):
            at[moves[i]] = configurations[number, i]
        place_rows(order, parent, joint_type, axis, q_index, multiplier, offset, parent_t_node, at, nodes)
        for i in range(moved.shape[0]):
            element: int = moved[i]
            row: int = rows[element]
            multiply(nodes, row, node_t_element, element, elements, element)
            copy(elements, element, placed[number], i)
            _bound(elements, element, local_centre, local_half, centre, half)
        boxes = centre, half, elements, first_block, block_centre, block_half
        count = _overlaps(own, asked, *boxes, found, depths, count, among, nearby, work)
        last[number] = count
    return count
