"""Configurations and ways that certainly touch nothing, by trees of balls; compiled. The rest is in doubt.

A stretch of a way is certainly free where all pairs are, in its middle, farther apart than their points go against each
other on either half of it (F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive dynamic collision checking for single and
multiple articulated robots in complex environments, IEEE Transactions on Robotics 21, 2005), or stay apart by more than
their ways on either half are from straight (`straight_ways.py`); others are halved.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, int8, int32, int64, types
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.compiled.rigid import copy, multiply

from virtualrobot_kernel.numeric.balls import tree_and_box, two_trees
from virtualrobot_kernel.numeric.forest import REVOLUTE, ROOT, place_rows
from virtualrobot_kernel.numeric.memory import floats_at
from virtualrobot_kernel.numeric.motion_bounds import bow, corners_of, step_up
from virtualrobot_kernel.numeric.polynomials import bends_of, piece_at, scalar_state, strays, write_values
from virtualrobot_kernel.numeric.straight_ways import trees_stay_apart

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]
Rows = np.ndarray[Any, np.dtype[np.int32]]
Codes = np.ndarray[Any, np.dtype[np.int8]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]

_WAITING, _DEEP = 512, 64

EFFORT, TINY = 0.7, 1e-6
"""By how much (m) trees are to be apart for one ball of each to be compared; so much nearer, so many more are. Where
points go far, halving the stretch mostly tells sooner: the boxes are apart then."""

SLACK = 1e-6
"""Distance (m) by which pairs are to be farther apart than they must: more than rounding."""

STRAIGHT = 0.1
"""Greatest travel (m) of a pair on either half of a stretch for its way to be taken for straight, but for its bow."""

_MOST = 32
"""So many stretches in doubt that follow each other are told as one; then the next one is another."""


class Figures(NamedTuple):
    """Figures of e elements.

    centre and half (e, 3): the box around each core; thick (e,): how far what is round about it goes beyond, in m.
    box, solid (e,): whether a core is just its box, and whether it is solid; point (e, 3): any point of its surface.
    tree (e, 4): address and rows of its tree of balls, address and number of its triangles; 0 where it is not needed.
    """

    centre: Floats
    half: Floats
    thick: Floats
    box: Booleans
    solid: Booleans
    point: Floats
    tree: Integers


class Cell(NamedTuple):
    """Cell of n rows, e elements and p pairs, in which k coordinates move; all else stands.

    order (m,): rows that move, parents before children. The next seven are as `forward_forest` has them. moves (k,):
    where the coordinates are in q (nq,), and coordinate (n,) which of them moves a row's joint, or -1.
    rows (e,), node_t_element (e, 4, 4): each element's node and place; reach (e, 3): half the box around it, with all
    that is round about its core. moved (c,): the elements that move. pairs (p, 2): elements that are asked.
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
    reach: Floats
    moved: Integers
    pairs: Integers
    figures: Figures


class Way(NamedTuple):
    """Way of k coordinates over time: their path by its parameter, and a law that says the parameter at a time.

    breaks (p + 1,), terms (p, t, k): the path; law_breaks (l + 1,), law_terms (l, t, 1): the law, which never goes
    back. marks (c + 1,), gone (c + 1, k), slopes (c, k): places on the path, how far each coordinate has gone there,
    forth and back, and how fast it goes on from there at the most. wobble (k,): how far the true ones may be from this.
    """

    breaks: Floats
    terms: Floats
    law_breaks: Floats
    law_terms: Floats
    marks: Floats
    gone: Floats
    slopes: Floats
    wobble: Floats


class _Room(NamedTuple):
    """Room for a pair that is asked.

    What turns one element into the other one's frame at the begin, in the middle and at the end of a way (3, 3, 4), a
    point (3,), balls that wait (w, 2), triangles (4, 3, 3), and what these are asked with (3, 3).
    """

    turns: Floats
    point: Floats
    waiting: Integers
    both: Floats
    work: Floats


class Place(NamedTuple):
    """Place of all that moves: q (nq,), nodes (n, 4, 4), elements (e, 4, 4), their boxes' middles and halves (e, 3).

    last (p, 2): balls of each pair's trees that were near when it was asked last.
    """

    q: Floats
    nodes: Floats
    elements: Floats
    middle: Floats
    extent: Floats
    last: Integers
    room: _Room


_FLOATS, _POSES, _ROWS, _ONE = array_of(float64, 2), array_of(float64, 3), array_of(int32, 1), array_of(float64, 1)
_INTEGERS, _FLAGS = array_of(int64, 1), array_of(boolean, 1)
_FIGURES = types.NamedTuple((_FLOATS, _FLOATS, _ONE, _FLAGS, _FLAGS, _FLOATS, array_of(int64, 2)), Figures)
CELL = types.NamedTuple(
    (
        *(_ROWS, _ROWS, array_of(int8, 1), _FLOATS, _ROWS, _ONE, _ONE, _POSES, _INTEGERS, _INTEGERS),
        *(_INTEGERS, _POSES, _FLOATS, _INTEGERS, array_of(int64, 2), _FIGURES),
    ),
    Cell,
)
_WAY = types.NamedTuple((_ONE, _POSES, _ONE, _POSES, _ONE, _FLOATS, _FLOATS, _ONE), Way)


@inlined
def _room() -> _Room:
    return _Room(
        np.empty((3, 3, 4)), np.empty(3), np.empty((_WAITING, 2), np.int64), np.empty((4, 3, 3)), np.empty((3, 3))
    )


@inlined
def placed(cell: Cell, q: Floats, nodes: Floats, elements: Floats) -> Place:
    """Return where all is: what moves is written there, what stands is bounded now."""
    shape = cell.reach.shape
    place = Place(
        q.copy(),
        nodes.copy(),
        elements.copy(),
        np.empty(shape),
        np.empty(shape),
        np.full(cell.pairs.shape, -1, np.int64),
        _room(),
    )
    for element in range(shape[0]):
        _bound(cell, place, element)
    return place


@inlined
def _bound(cell: Cell, place: Place, element: int) -> None:
    for i in range(3):
        middle, extent = place.elements[element, i, 3], 0.0
        for j in range(3):
            middle += place.elements[element, i, j] * cell.figures.centre[element, j]
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
def _in(figures: Figures, element: int, at: Floats) -> bool:
    """Return whether a point is in the box of a solid core, and so perhaps in the solid."""
    if not figures.solid[element]:
        return False
    for axis in range(3):
        if abs(at[axis] - figures.centre[element, axis]) > figures.half[element, axis]:
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
def _tree(figures: Figures, element: int) -> tuple[Floats, Floats]:
    """Return the balls (m, 11) and triangles (n, 3, 3) of an element."""
    rows, count = figures.tree[element, 1], figures.tree[element, 3]
    balls = floats_at(figures.tree[element, 0], 11 * rows).reshape((rows, 11))
    return balls, floats_at(figures.tree[element, 2], 9 * count).reshape((count, 3, 3))


@inlined
def _relate(poses: Floats, one: int, other: int, turn: Floats) -> None:
    """Write one element's frame in that of another one (3, 4)."""
    for i in range(3):
        for j in range(4):
            turn[i, j] = 0.0
            for m in range(3):
                shift = poses[other, m, 3] if j == 3 else 0.0
                turn[i, j] += poses[other, m, i] * (poses[one, m, j] - shift)


@inlined
def _certainly_stay_apart(
    figures: Figures,
    ways: Floats,
    first: int,
    second: int,
    runner: int,
    margin: float,
    most: float,
    last: Integers,
    room: _Room,
) -> bool:
    """Return whether two elements' surfaces certainly stay farther than a margin (m) apart.

    ways (3, e, 4, 4): where elements are at the begin, in the middle and at the end of a way; runner: which of the two
    moves, seen from the other one, 0 or 1; most and last (2,): as in `trees_stay_apart`, the latter first the first's.
    """
    one: int = second if runner else first
    other: int = first + second - one
    for stop in range(3):
        _relate(ways[stop], one, other, room.turns[stop])
    far: float = margin + figures.thick[one] + figures.thick[other] + SLACK
    balls, triangles = _tree(figures, one)
    others, faces = _tree(figures, other)
    return trees_stay_apart(
        balls, triangles, others, faces, room.turns, far, most, last, runner, room.waiting, room.both, room.work
    )


@inlined
def _certainly_apart(
    figures: Figures,
    poses: Floats,
    first: int,
    second: int,
    margin: float,
    most: float,
    last: Integers,
    room: _Room,
) -> bool:
    """Return whether two elements' surfaces are certainly farther than `margin` from touching.

    poses (e, 4, 4): where the elements are; most and last (2,): as in `two_trees`, the latter of the second element and
    the first where the first is a box and the second is not.
    """
    # A box is asked as such, as the other one.
    one: int = second if figures.box[first] and not figures.box[second] else first
    other: int = first + second - one
    turn = room.turns[1]
    _relate(poses, one, other, turn)
    far: float = margin + figures.thick[one] + figures.thick[other] + SLACK
    balls, triangles = _tree(figures, one)
    if figures.box[other]:
        return tree_and_box(balls, triangles, turn, figures.half, other, far, room.both[0])
    others, faces = _tree(figures, other)
    return two_trees(balls, triangles, others, faces, turn, far, most, last, room.waiting, room.both, room.work)


@inlined
def _outside(figures: Figures, poses: Floats, one: int, other: int, room: _Room) -> bool:
    """Return whether neither of two elements whose surfaces are apart is inside the other: any point tells."""
    at = room.point
    for side in range(2):
        inner, outer = (one, other) if side else (other, one)
        for i in range(3):
            at[i] = 0.0
            for m in range(3):
                world = poses[inner, m, 3] - poses[outer, m, 3]
                for j in range(3):
                    world += poses[inner, m, j] * figures.point[inner, j]
                at[i] += poses[outer, m, i] * world
        if _in(figures, outer, at):
            return False
    return True


@inlined
def pair_in_doubt(cell: Cell, place: Place, margin: float, first: int) -> int:
    """Return a pair that may be nearer than a margin (m) where all is, -1 where none is.

    The pair `first` is asked first, for it often is again.
    """
    for turn in range(cell.pairs.shape[0] + 1):
        pair = first if turn == 0 else turn - 1
        if pair == cell.pairs.shape[0]:
            continue
        one, other = cell.pairs[pair, 0], cell.pairs[pair, 1]
        if _boxes_apart(place, one, other, margin):
            continue
        if not (
            _certainly_apart(cell.figures, place.elements, one, other, margin, np.inf, place.last[pair], place.room)
            and _outside(cell.figures, place.elements, one, other, place.room)
        ):
            return pair
    return -1


@inlined
def _travel(cell: Cell, place: Place, element: int, until: int, joint: Floats, corners: Floats, way: Floats) -> float:
    """Return how far an element's points go at the most seen from the row `until` above it, -1 for the world."""
    row: int = cell.rows[element]
    corners_of(element, row, place.nodes, place.elements, cell.figures.centre, cell.figures.half, corners, way)
    while row != until:
        step_up(row, place.nodes, cell.parent, cell.joint_type, cell.axis, joint, corners, way)
        row = cell.parent[row]
    return way[0]


@inlined
def _bow(
    cell: Cell, place: Place, element: int, until: int, joint: Floats, stray: Floats, corners: Floats, way: Floats
) -> float:
    """Return how far an element's points go from straight lines, seen from the row `until`; the rest as in `bow`."""
    row: int = cell.rows[element]
    corners_of(element, row, place.nodes, place.elements, cell.figures.centre, cell.figures.half, corners, way)
    return bow(row, until, place.nodes, cell.parent, cell.joint_type, cell.axis, joint, stray, corners, way)


@inlined
def _follow(cell: Cell, place: Place, way: Way, stops: Floats, joints: Floats, ways: Floats) -> None:
    """Write where what moves is at three places of a way's path (3, e, 4, 4); it is left in the middle."""
    for turn in range(3):
        stop = (0, 2, 1)[turn]
        write_values(way.breaks, way.terms, stops[stop], joints, 0)
        go(cell, place, joints)
        for i in range(cell.moved.shape[0]):
            element: int = cell.moved[i]
            copy(place.elements, element, ways[stop], element)


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
        pair = pair_in_doubt(cell, place, 0.0, last)
        certain[row] = pair < 0
        last = max(pair, 0)


@inlined
def _goes(cell: Cell, way: Floats, joint: Floats) -> None:
    """Write how far each row's own joint turns and shifts (n, 2), where coordinates go a way (k,)."""
    for i in range(cell.order.shape[0]):
        row: int = cell.order[i]
        coordinate: int = cell.coordinate[row]
        if coordinate >= 0:
            joint[row, 0 if cell.joint_type[row] == REVOLUTE else 1] = abs(cell.multiplier[row]) * way[coordinate]


@compiled(CELL, _ONE, _POSES, _POSES, _WAY, float64, float64, float64)
def first_doubt(
    cell: Cell, q: Floats, nodes: Floats, elements: Floats, way: Way, begin: float, end: float, shortest: float
) -> tuple[float, float]:
    """Return the first stretch of a way on which surfaces may meet, (inf, inf) for none; what is outside stays outside.

    Args:
        cell: the cell.
        q: as `nodes` and `elements` in `certain_places`.
        nodes: (n, 4, 4).
        elements: (e, 4, 4).
        way: where the coordinates go.
        begin: the time from which on it is looked at.
        end: the time up to which it is.
        shortest: stretches on either half of which a pair goes no farther than this (m), and than twice as far as the
            way wobbles, are in doubt rather than halved.
    """
    pairs, k, rows = cell.pairs.shape[0], cell.moves.shape[0], nodes.shape[0]
    place, joint, wobbling = placed(cell, q, nodes, elements), np.zeros((rows, 2)), np.zeros((rows, 2))
    depth = np.zeros(rows, np.int64)
    for i in range(cell.order.shape[0]):
        parent = cell.parent[cell.order[i]]
        depth[cell.order[i]] = depth[parent] + 1 if parent >= 0 else 1
    carrier, corners, reach = np.empty(pairs, np.int64), np.empty((8, 3)), np.empty(2)
    for pair in range(pairs):
        carrier[pair] = _carrier(cell, depth, pair)
    _goes(cell, way.wobble, wobbling)
    asked = np.empty((_DEEP, pairs), np.int64)
    ends, counts = np.empty((_DEEP, 2)), np.empty(_DEEP, np.int64)
    ends[0, 0], ends[0, 1], counts[0] = begin, end, pairs
    for pair in range(pairs):
        asked[0, pair] = pair
    bends, stray, straying = np.empty((way.terms.shape[0], 2, k)), np.empty(k), np.zeros((rows, 2))
    bends_of(way.breaks, way.terms, bends)
    ways, stops = np.empty((3, *elements.shape)), np.empty(3)
    for stop in range(3):
        for element in range(elements.shape[0]):
            copy(elements, element, ways[stop], element)
    joints, done, farthest, travel = np.empty(k), np.empty((3, k)), np.empty(k), np.zeros(elements.shape[0])
    left, found, since, until = 1, 0, np.inf, np.inf
    while left:
        left -= 1
        first, last = ends[left, 0], ends[left, 1]
        if found and (first > until or found == _MOST):
            break
        middle = 0.5 * (first + last)
        for stop in range(3):
            place_on: float = scalar_state(way.law_breaks, way.law_terms, (first, middle, last)[stop])[0]
            u: float = min(max(place_on, way.breaks[0]), float(way.breaks[way.breaks.shape[0] - 1]))
            if stop == 1:
                write_values(way.breaks, way.terms, u, joints, 0)
            stops[stop] = u
            piece = piece_at(way.marks, u)
            for i in range(k):
                done[stop, i] = way.gone[piece, i] + (u - way.marks[piece]) * way.slopes[piece, i]
        for i in range(k):
            farthest[i] = max(done[1, i] - done[0, i], done[2, i] - done[1, i]) + way.wobble[i]
        go(cell, place, joints)
        _goes(cell, farthest, joint)
        for i in range(cell.moved.shape[0]):
            travel[cell.moved[i]] = _travel(cell, place, cell.moved[i], ROOT, joint, corners, reach)
        kept, doubtful, followed = 0, False, False
        for i in range(counts[left]):
            pair: int = asked[left, i]
            one: int = cell.pairs[pair, 0]
            other: int = cell.pairs[pair, 1]
            both: float = travel[one] + travel[other]
            if _boxes_apart(place, one, other, both):
                continue
            above: int = ROOT
            if travel[one] > 0.0 and travel[other] > 0.0:
                above = carrier[pair]
                both = _travel(cell, place, one, above, joint, corners, reach)
                both += _travel(cell, place, other, above, joint, corners, reach)
                if both == 0.0 or _boxes_apart(place, one, other, both):
                    continue
            astray: float = _travel(cell, place, one, above, wobbling, corners, reach)
            astray += _travel(cell, place, other, above, wobbling, corners, reach)
            figures, hints, small = cell.figures, place.last[pair], both <= shortest + 2.0 * astray
            most = EFFORT / max(both, TINY)
            if _certainly_apart(figures, place.elements, one, other, both, most, hints, place.room):
                continue
            if not small and both <= STRAIGHT and not (figures.box[one] or figures.box[other]):
                if not followed:
                    followed = True
                    strays(way.breaks, bends, stops, way.wobble, stray)
                    _goes(cell, stray, straying)
                    _follow(cell, place, way, stops, joints, ways)
                one_goes: float = _travel(cell, place, one, above, joint, corners, reach)
                runner, margin = 0 if one_goes > 0.0 else 1, np.inf
                if one_goes == 0.0 or one_goes == both:
                    margin = shortest + 2.0 * astray
                    margin += _bow(cell, place, other if runner else one, above, joint, straying, corners, reach)
                most = EFFORT / max(margin, TINY)
                if margin < both and _certainly_stay_apart(
                    figures, ways, one, other, runner, margin, most, hints, place.room
                ):
                    continue
            if small or left + 2 > _DEEP or not first < middle < last:
                doubtful = True
                break
            asked[left, kept] = pair
            kept += 1
        if doubtful:
            since, until = min(since, first), last
            found += 1
        elif kept:
            for i in range(kept):
                asked[left + 1, i] = asked[left, i]
            ends[left, 0], ends[left, 1], counts[left] = middle, last, kept
            ends[left + 1, 0], ends[left + 1, 1], counts[left + 1] = first, middle, kept
            left += 2
    return since, until
