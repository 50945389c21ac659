"""Configurations and ways of an arm that certainly touch nothing, by trees of balls; compiled. The rest is in doubt.

A stretch of a way is certainly free where all pairs are, in its middle, farther apart than their points go against each
other on either half of it (F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive dynamic collision checking for single and
multiple articulated robots in complex environments, IEEE Transactions on Robotics 21, 2005); others are halved.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, int8, int32, int64, types
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import multiply

from virtualrobot_kernel.numeric.balls import tree_and_box, two_trees
from virtualrobot_kernel.numeric.forest import REVOLUTE, ROOT, place_rows
from virtualrobot_kernel.numeric.motion_bounds import corners_of, step_up
from virtualrobot_kernel.numeric.polynomials import piece_at, write_values

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Rows = np.ndarray[Any, np.dtype[np.int32]]
Codes = np.ndarray[Any, np.dtype[np.int8]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]

SHORTEST = 2e-3
"""Stretches on which a pair goes no farther than this (m) are in doubt, rather than halved: balls are larger."""

_WAITING, _DEEP = 512, 64


class Cell(NamedTuple):
    """Cell of n rows, e elements and p pairs, in which k coordinates move; all else stands.

    order (m,): rows that move, parents before children. The next seven are as `forward_forest` has them. moves (k,):
    where the coordinates are in q (nq,), and coordinate (n,) which of them moves a row's joint, or -1.
    rows (e,), node_t_element (e, 4, 4), centre and half (e, 3): each element's node, place and box around its core;
    reach (e, 3): half of that with all that is round about it. moved (c,): the elements that move.
    pairs (p, 2), apart (p,): elements that are asked, and how near (m) their cores may come.
    box, solid (e,): whether a core is just its box, and whether it is solid; point (e, 3): any point of its surface.
    tree (e,): its first ball among balls (b, 4) with skip (b,); -1 where there is none.
    """

    order: Rows
    parent: Rows
    joint_type: Codes
    axis: Floats
    q_index: Rows
    multiplier: Floats
    offset: Floats
    parent_t_node: Floats
    moves: Integers
    coordinate: Integers
    rows: Integers
    node_t_element: Floats
    centre: Floats
    half: Floats
    reach: Floats
    moved: Integers
    pairs: Integers
    apart: Floats
    box: Booleans
    solid: Booleans
    point: Floats
    tree: Integers
    balls: Floats
    skip: Integers


class Place(NamedTuple):
    """Place of all that moves: q (nq,), nodes (n, 4, 4), elements (e, 4, 4), their boxes' middles and halves (e, 3).

    Then room: what turns one element into another one's frame (3, 4), and for balls that wait (w, 2).
    """

    q: Floats
    nodes: Floats
    elements: Floats
    middle: Floats
    extent: Floats
    other_t_one: Floats
    waiting: Integers


_FLOATS, _POSES, _ROWS, _ONE = array_of(float64, 2), array_of(float64, 3), array_of(int32, 1), array_of(float64, 1)
_INTEGERS, _FLAGS = array_of(int64, 1), array_of(boolean, 1)
CELL = types.NamedTuple(
    (
        *(_ROWS, _ROWS, array_of(int8, 1), _FLOATS, _ROWS, _ONE, _ONE, _POSES, _INTEGERS, _INTEGERS),
        *(_INTEGERS, _POSES, _FLOATS, _FLOATS, _FLOATS, _INTEGERS, array_of(int64, 2), _ONE),
        *(_FLAGS, _FLAGS, _FLOATS, _INTEGERS, _FLOATS, _INTEGERS),
    ),
    Cell,
)


@inlined
def placed(cell: Cell, q: Floats, nodes: Floats, elements: Floats) -> Place:
    """Return where all is: what moves is written there, what stands is bounded now."""
    shape = cell.centre.shape
    place = Place(
        q.copy(),
        nodes.copy(),
        elements.copy(),
        np.empty(shape),
        np.empty(shape),
        np.empty((3, 4)),
        np.empty((_WAITING, 2), np.int64),
    )
    for element in range(shape[0]):
        _bound(cell, place, element)
    return place


@inlined
def _bound(cell: Cell, place: Place, element: int) -> None:
    for i in range(3):
        middle, extent = place.elements[element, i, 3], 0.0
        for j in range(3):
            middle += place.elements[element, i, j] * cell.centre[element, j]
            extent += abs(place.elements[element, i, j]) * cell.reach[element, j]
        place.middle[element, i], place.extent[element, i] = middle, extent


@inlined
def go(cell: Cell, place: Place, joints: Floats) -> None:
    """Move all to where the coordinates are `joints` (k,)."""
    for i in range(cell.moves.shape[0]):
        place.q[cell.moves[i]] = joints[i]
    place_rows(
        cell.order,
        cell.parent,
        cell.joint_type,
        cell.axis,
        cell.q_index,
        cell.multiplier,
        cell.offset,
        cell.parent_t_node,
        place.q,
        place.nodes,
    )
    for i in range(cell.moved.shape[0]):
        element: int = cell.moved[i]
        row: int = cell.rows[element]
        multiply(place.nodes, row, cell.node_t_element, element, place.elements, element)
        _bound(cell, place, element)


@inlined
def _in(cell: Cell, element: int, at: Floats) -> bool:
    """Return whether a point is in the box of a solid core, and so perhaps in the solid."""
    if not cell.solid[element]:
        return False
    for axis in range(3):
        if abs(at[axis] - cell.centre[element, axis]) > cell.half[element, axis]:
            return False
    return True


@inlined
def _boxes_apart(place: Place, one: int, other: int, margin: float) -> bool:
    square = 0.0
    for axis in range(3):
        gap = abs(place.middle[one, axis] - place.middle[other, axis])
        gap = max(gap - place.extent[one, axis] - place.extent[other, axis], 0.0)
        square += gap * gap
    return square > margin * margin


@inlined
def _certainly_apart(cell: Cell, place: Place, pair: int, margin: float) -> bool:
    """Return whether a pair's surfaces are certainly farther than `margin` from touching."""
    one: int = cell.pairs[pair, 0]
    other: int = cell.pairs[pair, 1]
    turn, poses = place.other_t_one, place.elements
    for i in range(3):
        for j in range(4):
            value = 0.0
            for m in range(3):
                shift = poses[other, m, 3] if j == 3 else 0.0
                value += poses[other, m, i] * (poses[one, m, j] - shift)
            turn[i, j] = value
    far: float = margin + cell.apart[pair]
    first: int = cell.tree[one]
    if cell.box[other]:
        end: int = first + cell.skip[first]
        return tree_and_box(cell.balls, cell.skip, first, end, turn, cell.half, other, far)
    second: int = cell.tree[other]
    return two_trees(cell.balls, cell.skip, first, second, turn, far, place.waiting)


@inlined
def _outside(cell: Cell, place: Place, pair: int, at: Floats) -> bool:
    """Return whether neither of two whose surfaces are apart is inside the other: any point tells; at (3,): room."""
    for side in range(2):
        inner, outer = cell.pairs[pair, side], cell.pairs[pair, 1 - side]
        for i in range(3):
            at[i] = 0.0
            for m in range(3):
                world = place.elements[inner, m, 3] - place.elements[outer, m, 3]
                for j in range(3):
                    world += place.elements[inner, m, j] * cell.point[inner, j]
                at[i] += place.elements[outer, m, i] * world
        if _in(cell, outer, at):
            return False
    return True


@inlined
def pair_in_doubt(cell: Cell, place: Place, first: int) -> int:
    """Return a pair that may touch where all is, -1 where none does: `first` is asked first, for it often is again."""
    at = np.empty(3)
    for turn in range(cell.pairs.shape[0] + 1):
        pair = first if turn == 0 else turn - 1
        if pair == cell.pairs.shape[0] or _boxes_apart(place, cell.pairs[pair, 0], cell.pairs[pair, 1], 0.0):
            continue
        if not (_certainly_apart(cell, place, pair, 0.0) and _outside(cell, place, pair, at)):
            return pair
    return -1


@inlined
def _travel(cell: Cell, place: Place, element: int, until: int, joint: Floats, corners: Floats, way: Floats) -> float:
    """Return how far an element's points go at the most seen from the row `until` above it, -1 for the world."""
    row: int = cell.rows[element]
    corners_of(element, row, place.nodes, place.elements, cell.centre, cell.half, corners, way)
    while row != until:
        step_up(row, place.nodes, cell.parent, cell.joint_type, cell.axis, joint, corners, way)
        row = cell.parent[row]
    return way[0]


@inlined
def _carrier(cell: Cell, depth: Integers, pair: int) -> int:
    """Return the lowest row that carries both elements of a pair; -1 where none does."""
    first: int = cell.pairs[pair, 0]
    second: int = cell.pairs[pair, 1]
    one: int = cell.rows[first]
    other: int = cell.rows[second]
    while one != other:
        if one < 0 or (other >= 0 and depth[other] > depth[one]):
            other = cell.parent[other]
        else:
            one = cell.parent[one]
    return one


@compiled(CELL, _ONE, _POSES, _POSES, _FLOATS, output_of(boolean, 1))
def certain_places(cell: Cell, q: Floats, nodes: Floats, elements: Floats, joints: Floats, certain: Booleans) -> None:
    """Write which configurations (m, k) certainly touch nothing (m,).

    q (nq,), nodes (n, 4, 4) and elements (e, 4, 4): where all is to begin with, what stands for good.
    """
    place, last = placed(cell, q, nodes, elements), 0
    for row in range(joints.shape[0]):
        go(cell, place, joints[row])
        pair = pair_in_doubt(cell, place, last)
        certain[row] = pair < 0
        last = max(pair, 0)


@compiled(
    *(CELL, _ONE, _POSES, _POSES, _ONE, _POSES, _ONE, _FLOATS, _FLOATS),
    *(output_of(float64, 2), output_of(boolean, 1)),
)
def doubtful_stretches(
    cell: Cell,
    q: Floats,
    nodes: Floats,
    elements: Floats,
    breaks: Floats,
    terms: Floats,
    marks: Floats,
    gone: Floats,
    slopes: Floats,
    doubts: Floats,
    unsure: Booleans,
) -> int:
    """Write the stretches of a way on which surfaces may meet, and return their number; what is outside stays outside.

    Args:
        cell: the cell.
        q: as `nodes` and `elements` in `certain_places`.
        nodes: (n, 4, 4).
        elements: (e, 4, 4).
        breaks: (b + 1,) and `terms` (b, t, k): the way of the coordinates, piecewise polynomials.
        terms: as told.
        marks: (c + 1,) places on the way, and `gone` (c + 1, k) how far each coordinate has gone there, forth and back.
        gone: as told.
        slopes: (c, k) how fast it goes on from there at the most.
        doubts: (d, 2) begins and ends of stretches, which follow each other; the last one goes on to the end where
            there is no room for more.
        unsure: (p,) becomes true of the pairs that may meet on them.
    """
    pairs, k = cell.pairs.shape[0], cell.moves.shape[0]
    place, joint, depth = (
        placed(cell, q, nodes, elements),
        np.zeros((nodes.shape[0], 2)),
        np.zeros(nodes.shape[0], np.int64),
    )
    for i in range(cell.order.shape[0]):
        parent = cell.parent[cell.order[i]]
        depth[cell.order[i]] = depth[parent] + 1 if parent >= 0 else 1
    carrier, corners, way = np.empty(pairs, np.int64), np.empty((8, 3)), np.empty(2)
    for pair in range(pairs):
        carrier[pair] = _carrier(cell, depth, pair)
    asked = np.empty((_DEEP, pairs), np.int64)
    ends, counts = np.empty((_DEEP, 2)), np.empty(_DEEP, np.int64)
    ends[0, 0], ends[0, 1], counts[0] = breaks[0], breaks[breaks.shape[0] - 1], pairs
    for pair in range(pairs):
        asked[0, pair] = pair
    joints, done, travel = np.empty(k), np.empty((3, k)), np.zeros(elements.shape[0])
    left, found = 1, 0
    while left:
        left -= 1
        begin, end = ends[left, 0], ends[left, 1]
        middle = 0.5 * (begin + end)
        write_values(breaks, terms, middle, joints, 0)
        go(cell, place, joints)
        for stop in range(3):
            u = (begin, middle, end)[stop]
            piece = piece_at(marks, u)
            for i in range(k):
                done[stop, i] = gone[piece, i] + (u - marks[piece]) * slopes[piece, i]
        for i in range(cell.order.shape[0]):
            row, coordinate = cell.order[i], cell.coordinate[cell.order[i]]
            if coordinate >= 0:
                goes = max(done[1, coordinate] - done[0, coordinate], done[2, coordinate] - done[1, coordinate])
                joint[row, 0 if cell.joint_type[row] == REVOLUTE else 1] = abs(cell.multiplier[row]) * goes
        for i in range(cell.moved.shape[0]):
            travel[cell.moved[i]] = _travel(cell, place, cell.moved[i], ROOT, joint, corners, way)
        kept = 0
        for i in range(counts[left]):
            pair: int = asked[left, i]
            one: int = cell.pairs[pair, 0]
            other: int = cell.pairs[pair, 1]
            both: float = travel[one] + travel[other]
            if _boxes_apart(place, one, other, both):
                continue
            if travel[one] > 0.0 and travel[other] > 0.0:
                above: int = carrier[pair]
                both = _travel(cell, place, one, above, joint, corners, way)
                both += _travel(cell, place, other, above, joint, corners, way)
                if both == 0.0 or _boxes_apart(place, one, other, both):
                    continue
            if _certainly_apart(cell, place, pair, both):
                continue
            if both <= SHORTEST or left + 2 > _DEEP:
                unsure[pair] = True
                if found and (begin <= doubts[found - 1, 1] or found == doubts.shape[0]):
                    doubts[found - 1, 1] = max(doubts[found - 1, 1], end)
                else:
                    doubts[found, 0], doubts[found, 1] = begin, end
                    found += 1
                continue
            asked[left, kept] = pair
            kept += 1
        if kept:
            for i in range(kept):
                asked[left + 1, i] = asked[left, i]
            ends[left, 0], ends[left, 1], counts[left] = middle, end, kept
            ends[left + 1, 0], ends[left + 1, 1], counts[left + 1] = begin, middle, kept
            left += 2
    return found
