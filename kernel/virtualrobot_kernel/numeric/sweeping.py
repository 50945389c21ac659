"""How far joints carry elements along a way, and so which of these may meet: bounds, compiled.

F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive dynamic collision checking for single and multiple articulated robots in
complex environments, IEEE Transactions on Robotics 21, 2005: on a stretch of a way two bodies do not meet when their
points go less far together, seen from what carries both, than the sum of the bodies' distances at its ends.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import boolean, float64, int8, int32, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

from virtualrobot_kernel.numeric.forest import FIXED, FLOATING, PLANAR, REVOLUTE

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Rows = np.ndarray[Any, np.dtype[np.int32]]
Codes = np.ndarray[Any, np.dtype[np.int8]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]

SLACK = 1e-9
"""Boxes may meet that are so much farther apart than both go (m): more than rounding."""


@compiled(
    array_of(int32, 1),
    array_of(int32, 1),
    array_of(int8, 1),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    output_of(float64, 2),
    output_of(boolean, 1),
    output_of(int32, 1),
    output_of(int32, 1),
)
def joint_travels(
    order: Rows,
    parent: Rows,
    joint_type: Codes,
    q_index: Rows,
    multiplier: Floats,
    travel: Floats,
    q_from: Floats,
    q_to: Floats,
    joint: Floats,
    moving: Booleans,
    depth: Rows,
    found: Rows,
) -> int:
    """Write how far each row's own joint turns and shifts, and which rows move; return how many do.

    Args:
        order: (m,) rows, parents before children; the others are left alone.
        parent: (n,), `joint_type`, `q_index` and `multiplier` as `forward_forest` has them.
        joint_type: (n,).
        q_index: (n,).
        multiplier: (n,).
        travel: (nq,) the length of the way of each coordinate, rad or m.
        q_from: (nq,) coordinates at an end of the way, `q_to` at the other: a floating joint's quaternion is normalised
            before use, and turns the faster the shorter it is.
        q_to: (nq,).
        joint: (n, 2) written: by how much the joint turns (rad) and shifts (m) along the way.
        moving: (n,) written: whether this joint or one above moves.
        depth: (n,) written: how many rows are above.
        found: (n,) the rows that move are written to its beginning, parents before children.
    """
    count = 0
    for position in range(order.shape[0]):
        row = order[position]
        kind = joint_type[row]
        turned = 0.0
        shifted = 0.0
        if kind != FIXED:
            first = q_index[row]
            if kind == FLOATING:
                shifted = travel[first] + travel[first + 1] + travel[first + 2]
                way = 0.0
                size = 0.0
                other = 0.0
                for i in range(3, 7):
                    way += travel[first + i]
                    size += q_from[first + i] ** 2
                    other += q_to[first + i] ** 2
                if way > 0.0:
                    shortest = 0.5 * (math.sqrt(size) + math.sqrt(other) - way)
                    turned = 2.0 * way / shortest if shortest > 0.0 else np.inf
            elif kind == PLANAR:
                shifted = travel[first] + travel[first + 1]
                turned = travel[first + 2]
            elif kind == REVOLUTE:
                turned = abs(multiplier[row]) * travel[first]
            else:
                shifted = abs(multiplier[row]) * travel[first]
        joint[row, 0] = turned
        joint[row, 1] = shifted
        above = parent[row]
        depth[row] = depth[above] + 1 if above >= 0 else 0
        moving[row] = turned > 0.0 or shifted > 0.0 or (above >= 0 and moving[above])
        if moving[row]:
            found[count] = row
            count += 1
    return count


@inlined
def _corners(
    element: int, row: int, poses: Floats, elements: Floats, centre: Floats, half: Floats, corners: Floats, way: Floats
) -> None:
    """Write the corners (8, 3) of an element's box, and begin its way (2,): no travel, its reach about the row."""
    most = 0.0
    for corner in range(8):
        distance = 0.0
        for i in range(3):
            at = elements[element, i, 3]
            for j in range(3):
                side = half[element, j] if (corner >> j) & 1 else -half[element, j]
                at += elements[element, i, j] * (centre[element, j] + side)
            corners[corner, i] = at
            distance += (at - poses[row, i, 3]) ** 2
        most = max(most, distance)
    way[0] = 0.0
    way[1] = math.sqrt(most)


@inlined
def _step_up(
    row: int,
    poses: Floats,
    parent: Rows,
    joint_type: Codes,
    axis: Floats,
    joint: Floats,
    corners: Floats,
    way: Floats,
) -> None:
    """Add what the joint of `row` does to the way of points, and go on to the row above.

    `way` (2,): the length of the way of any of the points seen from the row's frame, and their greatest distance from
    its origin, wherever the joints below are meanwhile. A joint that turns carries a point by its distance from the
    axis: that of now and at most what the point's own way adds, and never more than the distance from the origin.
    """
    turned = joint[row, 0]
    if turned > 0.0:
        x = 0.0
        y = 0.0
        z = 0.0
        if joint_type[row] != FLOATING:
            x = poses[row, 0, 0] * axis[row, 0] + poses[row, 0, 1] * axis[row, 1] + poses[row, 0, 2] * axis[row, 2]
            y = poses[row, 1, 0] * axis[row, 0] + poses[row, 1, 1] * axis[row, 1] + poses[row, 1, 2] * axis[row, 2]
            z = poses[row, 2, 0] * axis[row, 0] + poses[row, 2, 1] * axis[row, 1] + poses[row, 2, 2] * axis[row, 2]
        most = 0.0
        for corner in range(8):
            a = corners[corner, 0] - poses[row, 0, 3]
            b = corners[corner, 1] - poses[row, 1, 3]
            c = corners[corner, 2] - poses[row, 2, 3]
            along = a * x + b * y + c * z
            most = max(most, a * a + b * b + c * c - along * along)
        reach = min(math.sqrt(most) + way[0], way[1])
        if reach > 0.0:
            way[0] += reach * turned
    way[0] += joint[row, 1]
    way[1] += joint[row, 1]
    above = parent[row]
    if above >= 0:
        apart = 0.0
        for i in range(3):
            apart += (poses[row, i, 3] - poses[above, i, 3]) ** 2
        way[1] += math.sqrt(apart)


@compiled(
    array_of(float64, 3),
    array_of(int32, 1),
    array_of(int8, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(boolean, 1),
    array_of(int64, 1),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 1),
)
def element_travels(
    world_t_node: Floats,
    parent: Rows,
    joint_type: Codes,
    axis: Floats,
    joint: Floats,
    moving: Booleans,
    rows: Integers,
    world_t_element: Floats,
    centre: Floats,
    half: Floats,
    found: Floats,
) -> None:
    """Write how far any point of each element goes in the world at the most, while the joints go a way.

    Args:
        world_t_node: (n, 4, 4) at any one place of the way.
        parent: (n,), `joint_type` and `axis` as `forward_forest` has them.
        joint_type: (n,).
        axis: (n, 3).
        joint: (n, 2) how far joints turn (rad) and shift (m) along the way, forth and back, as `joint_travels` says.
        moving: (n,) which rows move.
        rows: (e,) the node of each element.
        world_t_element: (e, 4, 4) at the same place of the way.
        centre: (e, 3) the box around each element's core in its own frame: what is round about a core goes as far.
        half: (e, 3) half of its edges; negative for an element that has nothing.
        found: (e,) the result in m.
    """
    corners = np.empty((8, 3))
    way = np.empty(2)
    for element in range(rows.shape[0]):
        row: int = rows[element]
        found[element] = 0.0
        if not moving[row] or half[element, 0] < 0.0:
            continue
        _corners(element, row, world_t_node, world_t_element, centre, half, corners, way)
        while row >= 0 and moving[row]:
            _step_up(row, world_t_node, parent, joint_type, axis, joint, corners, way)
            row = parent[row]
        found[element] = way[0]


@compiled(
    array_of(int64, 2),
    array_of(float64, 3),
    array_of(int32, 1),
    array_of(int8, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(boolean, 1),
    array_of(int32, 1),
    array_of(int64, 1),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 1),
)
def pair_travels(
    pairs: Integers,
    world_t_node: Floats,
    parent: Rows,
    joint_type: Codes,
    axis: Floats,
    joint: Floats,
    moving: Booleans,
    depth: Rows,
    rows: Integers,
    world_t_element: Floats,
    centre: Floats,
    half: Floats,
    found: Floats,
) -> None:
    """Write how far a point of one element of each pair and one of the other go together at the most.

    They are seen from what carries both: joints above both do not count. The arguments are those of `element_travels`,
    and `pairs` (k, 2) of elements, `depth` (n,) how many rows are above each, `found` (k,) the result in m.
    """
    sides = np.empty((2, 8, 3))
    ways = np.empty((2, 2))
    at = np.empty(2, np.int64)
    for k in range(pairs.shape[0]):
        for side in range(2):
            element = pairs[k, side]
            at[side] = rows[element]
            ways[side, 0] = 0.0
            if moving[at[side]]:
                _corners(element, at[side], world_t_node, world_t_element, centre, half, sides[side], ways[side])
        while at[0] != at[1]:
            side = 1 if at[0] < 0 or (at[1] >= 0 and depth[at[1]] > depth[at[0]]) else 0
            row = at[side]
            if moving[row]:
                _step_up(row, world_t_node, parent, joint_type, axis, joint, sides[side], ways[side])
            at[side] = parent[row]
        found[k] = ways[0, 0] + ways[1, 0]


@compiled(
    array_of(int64, 1),
    array_of(boolean, 2),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 1),
    output_of(int64, 2),
    int64,
)
def boxes_in_reach(
    own: Integers, asked: Booleans, centre: Floats, half: Floats, travel: Floats, found: Integers, begin: int
) -> int:
    """Write which pairs of elements may meet while each goes its way, and return the end of what was written.

    Left out are pairs whose boxes are farther apart than both go together, and those that stand still.

    Args:
        own: (k,) elements.
        asked: (k, e) whether a pair of one of these and any element is asked.
        centre: (e, 3) the box around each element along the world's axes.
        half: (e, 3) half of its edges.
        travel: (e,) how far each goes at the most, in m.
        found: (m, 2) the pairs are written to it from `begin` on, as far as there is room; where there is too little
            the returned end tells how much it would take.
        begin: where to begin.
    """
    end = begin
    for i in range(own.shape[0]):
        one = own[i]
        for other in range(centre.shape[0]):
            both = travel[one] + travel[other]
            if both == 0.0 or not asked[i, other]:
                continue
            apart = 0.0
            for axis in range(3):
                gap = abs(centre[one, axis] - centre[other, axis]) - half[one, axis] - half[other, axis]
                if gap > 0.0:
                    apart += gap * gap
            reach = both + SLACK
            if apart <= reach * reach:
                if end < found.shape[0]:
                    found[end, 0] = one
                    found[end, 1] = other
                end += 1
    return end
