"""Bounds of how far joints turn and shift along a way, and so how far they carry elements at the most; compiled."""

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
def corners_of(
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
def step_up(
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


@inlined
def bow(
    row: int,
    until: int,
    poses: Floats,
    parent: Rows,
    joint_type: Codes,
    axis: Floats,
    joint: Floats,
    stray: Floats,
    corners: Floats,
    way: Floats,
) -> float:
    """Return how far points of a row go from straight lines at the most, seen from the row `until` above it, in m.

    What `corners_of` has begun is gone up here. stray (n, 2): by how much joints turn and shift apart from going
    evenly. Where they go evenly, two joints, of which the one above turns by a and the one below carries a point by w,
    add at most a w to the second derivative of its place, in each order of the two. A chord is apart from its curve by
    no more than an eighth of that (C. de Boor, A Practical Guide to Splines, 1978, III).
    """
    bent, astray = 0.0, 0.0
    while row != until:
        before: float = way[0]
        turned: float = joint[row, 0]
        step_up(row, poses, parent, joint_type, axis, joint, corners, way)
        bent += turned * (before + way[0])
        if turned > 0.0:
            astray += (way[0] - before - joint[row, 1]) * stray[row, 0] / turned
        astray += stray[row, 1]
        row = parent[row]
    return 0.125 * bent + astray


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
        corners_of(element, row, world_t_node, world_t_element, centre, half, corners, way)
        while row >= 0 and moving[row]:
            step_up(row, world_t_node, parent, joint_type, axis, joint, corners, way)
            row = parent[row]
        found[element] = way[0]
