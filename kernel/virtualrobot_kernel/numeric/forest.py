"""The forward pass of the whole scene: one flat forest of nodes, one compiled pass for all world poses.

A node is a row of parallel arrays. Joint values are never stored per node: row `i` moves by
`multiplier[i] * q[q_index[i]] + offset[i]`, so that a mimic joint costs what any other costs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int8, int32
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import copy, multiply, shift, turn, turn_by_quaternion

FIXED, REVOLUTE, PRISMATIC, FLOATING, PLANAR = 0, 1, 2, 3, 4
"""Codes of joint types (int8); a continuous joint is REVOLUTE without limits."""

ROOT, UNUSED = -1, -2
"""Values of `parent` for a row that has no parent, and for a row that is not in use."""

Integers = np.ndarray[Any, np.dtype[np.int32]]
Codes = np.ndarray[Any, np.dtype[np.int8]]
Floats = np.ndarray[Any, np.dtype[np.float64]]

_TREE = (
    array_of(int32, 1),
    array_of(int32, 1),
    array_of(int8, 1),
    array_of(float64, 2),
    array_of(int32, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 3),
)
"""Types of what a tree is: from `order` to `parent_t_node`, as `forward_forest` has them."""


@inlined
def place_rows(
    order: Integers,
    parent: Integers,
    joint_type: Codes,
    axis: Floats,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    parent_t_node: Floats,
    q: Floats,
    world_t_node: Floats,
) -> None:
    """Write what `forward_forest` does."""
    for position in range(order.shape[0]):
        row: int = order[position]
        if parent[row] >= 0:
            multiply(world_t_node, parent[row], parent_t_node, row, world_t_node, row)
        else:
            copy(parent_t_node, row, world_t_node, row)
        kind = joint_type[row]
        if kind == FIXED:
            continue
        first: int = q_index[row]
        x = axis[row, 0]
        y = axis[row, 1]
        z = axis[row, 2]
        if kind == REVOLUTE:
            turn(world_t_node, row, x, y, z, multiplier[row] * q[first] + offset[row])
        elif kind == PRISMATIC:
            value = multiplier[row] * q[first] + offset[row]
            shift(world_t_node, row, x * value, y * value, z * value)
        elif kind == FLOATING:
            shift(world_t_node, row, q[first], q[first + 1], q[first + 2])
            turn_by_quaternion(world_t_node, row, q[first + 3], q[first + 4], q[first + 5], q[first + 6])
        elif kind == PLANAR:
            a = q[first]
            b = q[first + 1]
            across = x * x + y * y
            if across == 0.0:
                shift(world_t_node, row, a, b * z, 0.0)
            else:
                # Columns x and y of the rotation that takes +z to axis; f = 1 / (1 + z), exact near z = -1 too.
                f = 1.0 / (1.0 + z) if z > 0.0 else (1.0 - z) / across
                shift(
                    world_t_node,
                    row,
                    a * (1.0 - x * x * f) - b * x * y * f,
                    b * (1.0 - y * y * f) - a * x * y * f,
                    -a * x - b * y,
                )
            turn(world_t_node, row, x, y, z, q[first + 2])


@compiled(*_TREE, array_of(float64, 1), output_of(float64, 3))
def forward_forest(
    order: Integers,
    parent: Integers,
    joint_type: Codes,
    axis: Floats,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    parent_t_node: Floats,
    q: Floats,
    world_t_node: Floats,
) -> None:
    """Write the world pose of every row in `order`: world_t_parent @ parent_t_node @ joint(q), in metres and radians.

    Args:
        order: (m,) rows to compute, parents before children (see `topological_order`); other rows stay untouched.
        parent: (n,) row of the parent, ROOT for none (its frame is then the world).
        joint_type: (n,) FIXED, REVOLUTE, PRISMATIC, FLOATING or PLANAR.
        axis: (n, 3) unit axis in the joint's own frame; unused for FIXED and FLOATING.
        q_index: (n,) where the joint's coordinates start in `q`; unused for FIXED.
        multiplier: (n,) factor on the coordinate of a scalar joint; 1 except for a mimic joint.
        offset: (n,) added to it; 0 except for a mimic joint.
        parent_t_node: (n, 4, 4) pose of the joint's frame in its parent at zero.
        q: (nq,) coordinates. REVOLUTE and PRISMATIC take 1. FLOATING takes 7: x, y, z, qx, qy, qz, qw, the quaternion
            normalised before use, a zero one read as identity. PLANAR takes 3: x, y, theta; its plane is normal to
            `axis`, the plane's x and y are those of the smallest rotation that takes +z to `axis` (for -z: half a
            turn about x), and theta turns about `axis`.
        world_t_node: (n, 4, 4) the result, written in place.

    Indices are trusted, not checked.
    """
    place_rows(order, parent, joint_type, axis, q_index, multiplier, offset, parent_t_node, q, world_t_node)


@compiled(*_TREE, array_of(float64, 2), output_of(float64, 3), output_of(float64, 3))
def forward_tips(
    order: Integers,
    parent: Integers,
    joint_type: Codes,
    axis: Floats,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    parent_t_node: Floats,
    q: Floats,
    world_t_node: Floats,
    tips: Floats,
) -> None:
    """Write the poses (m, 4, 4) of the last row with coordinates q (m, nq); all else is as `forward_forest` has it."""
    for i in range(q.shape[0]):
        place_rows(order, parent, joint_type, axis, q_index, multiplier, offset, parent_t_node, q[i], world_t_node)
        copy(world_t_node, world_t_node.shape[0] - 1, tips, i)


@compiled(array_of(int32, 1))
def topological_order(parent: Integers) -> Integers:
    """Return the rows in use, parents before children: breadth first, siblings by row, as int32 (m,).

    Rows that hang on a loop or on a row that does not exist (or is UNUSED) have no place: each leaves a -1 at the
    end, so a good forest is one with `order.size == 0 or order[-1] >= 0`.
    """
    n = parent.shape[0]
    # Children of each row, by counting: first_child[i] .. first_child[i + 1] in `children`; the roots come first.
    first_child = np.zeros(n + 2, np.int32)
    used = 0
    for row in range(n):
        if parent[row] == UNUSED:
            continue
        used += 1
        if ROOT <= parent[row] < n:
            first_child[parent[row] + 2] += 1
    for row in range(n + 1):
        first_child[row + 1] += first_child[row]
    children = np.empty(n, np.int32)
    place = first_child.copy()
    for row in range(n):
        if ROOT <= parent[row] < n:
            children[place[parent[row] + 1]] = row
            place[parent[row] + 1] += 1
    order = np.full(used, -1, np.int32)
    found = first_child[1]
    for i in range(found):
        order[i] = children[i]
    read = 0
    while read < found:
        row: int = order[read]
        read += 1
        for i in range(first_child[row + 1], first_child[row + 2]):
            order[found] = children[i]
            found += 1
    return order
