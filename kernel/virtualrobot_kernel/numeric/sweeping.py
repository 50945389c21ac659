"""Pairs of elements that may meet while joints go a way: bounds of travels against bounds of distances, compiled.

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

from virtualrobot_kernel.numeric.distance_bounds import SLACK, block_distance, cached_distance_bound
from virtualrobot_kernel.numeric.motion_bounds import corners_of, step_up

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Rows = np.ndarray[Any, np.dtype[np.int32]]
Codes = np.ndarray[Any, np.dtype[np.int8]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]


@inlined
def _box_distance(one: int, other: int, centre: Floats, half: Floats) -> float:
    """Return how far two boxes along the world's axes are apart, in m."""
    apart = 0.0
    for axis in range(3):
        gap = abs(centre[one, axis] - centre[other, axis]) - half[one, axis] - half[other, axis]
        if gap > 0.0:
            apart += gap * gap
    return max(math.sqrt(apart) - SLACK, 0.0)


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
            if _box_distance(one, other, centre, half) <= both:
                if end < found.shape[0]:
                    found[end, 0] = one
                    found[end, 1] = other
                end += 1
    return end


@compiled(
    array_of(int64, 1),
    array_of(int64, 2),
    array_of(int64, 1),
    array_of(float64, 3),
    array_of(int32, 1),
    array_of(int8, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(boolean, 1),
    array_of(int32, 1),
    array_of(int64, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(int64, 1),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 4),
    array_of(float64, 2),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 1),
    output_of(int8, 1),
    array_of(float64, 3),
    array_of(float64, 2),
    array_of(float64, 2),
    output_of(float64, 1),
    output_of(int8, 1),
    float64,
    float64,
    output_of(int64, 1),
    output_of(float64, 1),
)
def pairs_in_reach(
    asked: Integers,
    pairs: Integers,
    slots: Integers,
    world_t_node: Floats,
    parent: Rows,
    joint_type: Codes,
    axis: Floats,
    joint: Floats,
    moving: Booleans,
    depth: Rows,
    rows: Integers,
    core_centre: Floats,
    core_half: Floats,
    first_block: Integers,
    block_centre: Floats,
    block_half: Floats,
    first_t_second: Floats,
    distances: Floats,
    begin_t_element: Floats,
    begin_centre: Floats,
    begin_half: Floats,
    begin_bounds: Floats,
    begin_known: Codes,
    end_t_element: Floats,
    end_centre: Floats,
    end_half: Floats,
    end_bounds: Floats,
    end_known: Codes,
    near: float,
    far: float,
    left: Integers,
    travels: Floats,
) -> int:
    """Write which pairs may meet on a stretch of a way, and return how many do.

    A pair may when the sum of its distances' bounds at both ends is no more than its travel: how far a point of one
    element and one of the other go together at the most, seen from what carries both. Joints above both do not count;
    nor does a pair that doesn't travel.

    Args:
        asked: (m,) which pairs are asked.
        pairs: (k, 2) elements.
        slots: (k,) where what was measured of them is kept, as `cached_distance_bound` says.
        world_t_node: (n, 4, 4) at the begin.
        parent: (n,), `joint_type`, `axis`, `joint`, `moving` as in `element_travels`, `depth` as in `joint_travels`.
        joint_type: (n,).
        axis: (n, 3).
        joint: (n, 2).
        moving: (n,).
        depth: (n,).
        rows: (e,) the node of each element.
        core_centre: (e, 3) the box around each element's core in its own frame.
        core_half: (e, 3) half of its edges.
        first_block: (e + 1,), `block_centre` and `block_half` as in `block_distance`.
        block_centre: (b, 3).
        block_half: (b, 3).
        first_t_second: (s, c, 3, 4) and `distances` as in `cached_distance_bound`.
        distances: (s, c).
        begin_t_element: (e, 4, 4) where the elements are at the begin.
        begin_centre: (e, 3) the box around each element along the world's axes there.
        begin_half: (e, 3) half of its edges.
        begin_bounds: (k,) lower bounds of the pairs' distances there in m, written where more is found out.
        begin_known: (k,) what they are from, likewise: 0 nothing, 1 boxes along the world's axes, 2 turned boxes and
            what was measured before; more where more is known.
        end_t_element: (e, 4, 4), `end_centre`, `end_half`, `end_bounds` and `end_known` likewise at the end.
        end_centre: (e, 3).
        end_half: (e, 3).
        end_bounds: (k,).
        end_known: (k,).
        near: turned boxes are asked of pairs that travel no more than this (m).
        far: by how much travels count, a factor.
        left: (m,) the pairs that may meet are written to its begin.
        travels: (m,) their travels in m.
    """
    sides = np.empty((2, 8, 3))
    ways = np.empty((2, 2))
    at = np.empty(2, np.int64)
    work, place, now, change = np.empty((7, 3)), np.empty(3), np.empty((3, 4)), np.empty((3, 4))
    count = 0
    for k in range(asked.shape[0]):
        pair: int = asked[k]
        one = pairs[pair, 0]
        other = pairs[pair, 1]
        slot: int = slots[pair]
        for side in range(2):
            element = pairs[pair, side]
            at[side] = rows[element]
            ways[side, 0] = 0.0
            if moving[at[side]]:
                elements = begin_t_element, core_centre, core_half
                corners_of(
                    element, at[side], world_t_node, elements[0], elements[1], elements[2], sides[side], ways[side]
                )
        while at[0] != at[1]:
            side = 1 if at[0] < 0 or (at[1] >= 0 and depth[at[1]] > depth[at[0]]) else 0
            row = at[side]
            if moving[row]:
                step_up(row, world_t_node, parent, joint_type, axis, joint, sides[side], ways[side])
            at[side] = parent[row]
        travel = ways[0, 0] + ways[1, 0]
        if travel == 0.0:
            continue
        for level in range(1, 3):
            if begin_bounds[pair] + end_bounds[pair] > far * travel or (level == 2 and travel > near):
                break
            if level == 1:
                if begin_known[pair] < 1:
                    begin_bounds[pair] = _box_distance(one, other, begin_centre, begin_half)
                    begin_known[pair] = 1
                if end_known[pair] < 1:
                    end_bounds[pair] = _box_distance(one, other, end_centre, end_half)
                    end_known[pair] = 1
                continue
            for end in range(2):
                known, bounds = (end_known, end_bounds) if end else (begin_known, begin_bounds)
                poses = end_t_element if end else begin_t_element
                if known[pair] < 2:
                    known[pair] = 2
                    blocks = block_distance(one, other, poses, first_block, block_centre, block_half, work, place)
                    kept = cached_distance_bound(
                        one, other, slot, poses, core_centre, core_half, first_t_second, distances, now, change
                    )
                    bounds[pair] = max(bounds[pair], max(blocks, kept))
        if begin_bounds[pair] + end_bounds[pair] <= far * travel:
            left[count] = pair
            travels[count] = travel
            count += 1
    return count
