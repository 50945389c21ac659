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
from virtualrobot_kernel.collision.touching import Contacts, touching

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
    for one, other, rows in _candidates(first, second, range_meters):
        bounds = _bounds(first, second, *rows)
        contacts = _contacts(first, second, one, other, bounds, rows)
        if contacts is not None:
            points = np.stack([contacts.points[0]] * 2)
            found.append(Pair(one, other, 0.0, points, contacts.points, contacts.normal))
        elif range_meters > 0.0:
            distance, points = _distance(first, second, one, other, _ordered(bounds, *rows))
            if distance <= range_meters:
                found.append(Pair(one, other, distance, points, np.zeros((0, 3)), None))
    return sorted(found, key=lambda pair: pair.distance)


Pieces = Iterable[tuple[float, int, int]]
"""Pairs of pieces by their rows: a lower bound of their distance (m) first, the least first."""


def _rows(placed: Placed, element: int) -> Integers:
    return np.arange(placed.first_piece[element], placed.first_piece[element + 1])


def _apart(centre: Floats, half: Floats, centres: Floats, halves: Floats) -> Floats:
    """Return how far boxes are apart, by the shapes of their centres and halves: a lower bound of their contents'."""
    return np.linalg.norm(np.maximum(np.abs(centre - centres) - half - halves, 0.0), axis=-1)


def _bounds(first: Placed, second: Placed, rows: Integers, others: Integers) -> Floats:
    """Return a lower bound (r, s) of the distance of each two pieces."""
    mine = first.centre[rows, None], first.half[rows, None]
    return _apart(*mine, second.centre[None, others], second.half[None, others])


def _ordered(bounds: Floats, rows: Integers, others: Integers) -> Iterator[tuple[float, int, int]]:
    """Yield pairs of pieces, made into Python's numbers a few at a time: most are never asked for."""
    order = np.argsort(bounds, axis=None, kind="stable")
    for start in range(0, len(order), FEW):
        some = order[start : start + FEW]
        row, other = np.unravel_index(some, bounds.shape)
        yield from zip(bounds.ravel()[some].tolist(), rows[row].tolist(), others[other].tolist(), strict=True)


def _candidates(first: Placed, second: Placed, range_meters: float) -> Iterator[tuple[int, int, list[Integers]]]:
    """Yield the elements whose boxes are within the range of each other, and the rows of their pieces that may be."""
    (centre, half), (centres, halves) = first.boxes(), second.boxes()
    close = _apart(centre[:, None], half[:, None], centres[None], halves[None]) <= range_meters
    for one, other in np.argwhere(close).tolist():
        rows, others = _rows(first, one), _rows(second, other)
        rows = rows[_apart(first.centre[rows], first.half[rows], centres[other], halves[other]) <= range_meters]
        others = others[_apart(second.centre[others], second.half[others], centre[one], half[one]) <= range_meters]
        if len(rows) and len(others):
            yield one, other, [rows, others]


def _contacts(
    first: Placed, second: Placed, one: int, other: int, bounds: Floats, rows: list[Integers]
) -> Contacts | None:
    """Return where two elements touch, None where they don't."""
    overlapping = np.argwhere(bounds == 0.0)
    if not len(overlapping):
        return None
    pieces = list(zip(rows[0][overlapping[:, 0]].tolist(), rows[1][overlapping[:, 1]].tolist(), strict=True))
    return touching(first, second, one, other, pieces)


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
