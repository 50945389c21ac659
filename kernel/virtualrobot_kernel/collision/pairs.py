"""Which of two sets of placed elements touch or are near: boxes first, then exactly, pair by pair.

Each call of FCL is about two pieces of bounded size, so that none holds the interpreter's lock for long.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.nearest import Floats, Nearest
from virtualrobot_kernel.collision.placed import Placed, piece_distance
from virtualrobot_kernel.collision.touching import touching

Integers = NDArray[np.int64]

FEW = 256
"""How many pairs of pieces are looked at in one go."""

ALTERNATIONS = 4
"""How often the points of a pair are taken to the nearest ones of the true, curved surfaces."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two elements that are near or touch, by their places in the two sets; points are in the world's frame.

    Attributes:
        first: the element of the first set, and `second` that of the second.
        distance: in meters; 0 where they touch.
        points: (2, 3) the nearest point of each; where they touch, the first of `contacts` twice.
        contacts: (k, 3) where they touch; k is 0 where they don't.
        normal: (3,) from the first to the second where they touch; None where they don't.
    """

    first: int
    second: int
    distance: float
    points: Floats
    contacts: Floats
    normal: Floats | None


def near_pairs(first: Placed, second: Placed, range_meters: float = 0.0) -> list[Pair]:
    """Return the pairs of an element of each set that touch or are at most `range_meters` apart, the nearest first.

    The range may be inf: then these are all pairs.

    A mesh is its surface: what is wholly inside one does not touch it. Distances are exact to rounding, but for
    cylinders and cones, to 2e-5 of the radius.
    """
    found = []
    close = box_distances((first.centre, first.half), (second.centre, second.half)) <= range_meters
    for one, other in np.argwhere(close).tolist():
        pair = _pair(first, second, one, other, range_meters)
        if pair is not None:
            found.append(pair)
    return sorted(found, key=lambda pair: pair.distance)


def _pair(first: Placed, second: Placed, one: int, other: int, range_meters: float) -> Pair | None:
    """Return two elements that touch or are near, None where they aren't."""
    rows, bounds = near_pieces(first, second, one, other, range_meters)
    if not bounds.size:
        return None
    overlapping = np.argwhere(bounds == 0.0)
    if len(overlapping):
        pieces = list(zip(rows[0][overlapping[:, 0]].tolist(), rows[1][overlapping[:, 1]].tolist(), strict=True))
        contacts = touching(first, second, one, other, pieces)
        if contacts is not None:
            return Pair(one, other, 0.0, np.stack([contacts.points[0]] * 2), contacts.points, contacts.normal)
    if range_meters > 0.0:
        distance, points = _distance(first, second, one, other, _ordered(bounds, *rows))
        if distance <= range_meters:
            return Pair(one, other, distance, points, np.zeros((0, 3)), None)
    return None


def pair_of(first: Placed, second: Placed, one: int, other: int) -> Pair | None:
    """Return how an element of each set stands to the other, however far; None where one has no pieces."""
    return _pair(first, second, one, other, np.inf)


Pieces = Iterable[tuple[float, int, int]]
"""Pairs of pieces by their rows: a lower bound of their distance (m) first, the least first."""


def near_pieces(
    first: Placed, second: Placed, one: int, other: int, range_meters: float
) -> tuple[tuple[Integers, Integers], Floats]:
    """Return the rows (r,) and (s,) of two elements' pieces near the other, and lower bounds (r, s) of their distances.

    Left out are pieces whose boxes are farther than the range from the box around the other element.
    """
    sides = []
    for (ours, at), (theirs, to) in (((first, one), (second, other)), ((second, other), (first, one))):
        centre, half = ours.boxes(at)
        near = _apart(centre, half, theirs.centre[to], theirs.half[to]) <= range_meters
        sides.append((ours.first_piece[at] + np.flatnonzero(near), centre[near], half[near]))
    (rows, *boxes), (others, *to_boxes) = sides
    return (rows, others), box_distances((boxes[0], boxes[1]), (to_boxes[0], to_boxes[1]))


def box_distances(boxes: tuple[Floats, Floats], others: tuple[Floats, Floats]) -> Floats:
    """Return the distance (r, s) of each two boxes along the axes, given as centres (n, 3) and halves (n, 3)."""
    return _apart(boxes[0][:, None], boxes[1][:, None], others[0][None], others[1][None])


def _apart(centre: Floats, half: Floats, centres: Floats, halves: Floats) -> Floats:
    """Return how far boxes are apart, by the shapes of their centres and halves: a lower bound of their contents'."""
    return np.linalg.norm(np.maximum(np.abs(centre - centres) - half - halves, 0.0), axis=-1)


def _ordered(bounds: Floats, rows: Integers, others: Integers) -> Iterator[tuple[float, int, int]]:
    """Yield pairs of pieces, made into Python's numbers a few at a time: most are never asked for."""
    order = np.argsort(bounds, axis=None, kind="stable")
    for start in range(0, len(order), FEW):
        some = order[start : start + FEW]
        row, other = np.unravel_index(some, bounds.shape)
        yield from zip(bounds.ravel()[some].tolist(), rows[row].tolist(), others[other].tolist(), strict=True)


def _distance(first: Placed, second: Placed, one: int, other: int, pieces: Pieces) -> tuple[float, Floats]:
    """Return the least distance of two elements' pieces, and the points (2, 3) that are so far apart."""
    best, points = np.inf, np.zeros((2, 3))
    radii = first.solids[one].radius, second.solids[other].radius
    for bound, row, to in pieces:
        if bound >= best - sum(radii):
            break
        apart, between = piece_distance(first, second, row, to)
        if apart < best:
            best, points = apart, between
    points = _polished(points, first, second, one, other)
    between = points[1] - points[0]
    apart = float(np.linalg.norm(between))
    along = between / apart if apart > 0.0 else np.zeros(3)
    points = points + np.stack([radii[0] * along, -radii[1] * along])
    return max(apart - sum(radii), 0.0), points


def _polished(points: Floats, first: Placed, second: Placed, one: int, other: int) -> Floats:
    """Return nearer points of two cores, where curved surfaces were triangles: each the nearest to the other in turn.

    Every step gives points of the true cores, no farther apart than before (J. von Neumann's alternating projections).
    """
    sides = (
        (first.solids[one].nearest, first.world_t_element[one]),
        (second.solids[other].nearest, second.world_t_element[other]),
    )
    points = points.copy()
    for _ in range(ALTERNATIONS):
        for side, (nearest, pose) in enumerate(sides):
            if nearest is not None:
                points[side] = _nearest(nearest, pose, points[1 - side])
    return points


def _nearest(nearest: Nearest, world_t_core: Floats, point: Floats) -> Floats:
    turn, place = world_t_core[:3, :3], world_t_core[:3, 3]
    return turn @ nearest(turn.T @ (point - place)) + place
