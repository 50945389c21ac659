"""Which of two sets of placed elements touch or are near: boxes first, then exactly, pair by pair.

Each call of FCL is about two pieces of bounded size, so that none holds the interpreter's lock for long.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from virtualrobot_kernel.collision.nearest import Floats, Nearest
from virtualrobot_kernel.collision.placed import Placed, piece_distance
from virtualrobot_kernel.collision.touching import Contacts, touching

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

    A mesh is its surface: what is wholly inside one does not touch it. Distances are exact to rounding, but for
    cylinders and cones, to 2e-5 of the radius.
    """
    found = []
    for one, other, pieces in _candidates(first, second, range_meters):
        contacts = _contacts(first, second, one, other, pieces)
        if contacts is not None:
            points = np.stack([contacts.points[0]] * 2)
            found.append(Pair(one, other, 0.0, points, contacts.points, contacts.normal))
        elif range_meters > 0.0:
            distance, points = _distance(first, second, one, other, pieces)
            if distance <= range_meters:
                found.append(Pair(one, other, distance, points, np.zeros((0, 3)), None))
    return sorted(found, key=lambda pair: pair.distance)


def distance_between(first: Placed, second: Placed, one: int, other: int) -> tuple[float, Floats]:
    """Return the distance (m) of an element of each set that do not touch, and the nearest point (2, 3) of each."""
    rows = (_rows(first, one), _rows(second, other))
    bounds = _bounds(first, second, *rows)
    return _distance(first, second, one, other, _ordered(bounds, *rows))


Pieces = list[tuple[float, int, int]]
"""Pairs of pieces by their rows: a lower bound of their distance (m) first, the least first."""


def _rows(placed: Placed, element: int) -> Any:  # noqa: ANN401 a slice of integers
    return np.arange(placed.first_piece[element], placed.first_piece[element + 1])


def _bounds(first: Placed, second: Placed, rows: Any, others: Any) -> Floats:  # noqa: ANN401 index arrays
    """Return a lower bound (r, s) of the distance of each two pieces: that of their boxes."""
    apart = np.abs(first.centre[rows, None] - second.centre[None, others])
    return np.linalg.norm(np.maximum(apart - first.half[rows, None] - second.half[None, others], 0.0), axis=2)


def _ordered(bounds: Floats, rows: Any, others: Any) -> Pieces:  # noqa: ANN401 index arrays
    order = np.argsort(bounds, axis=None)
    at = np.unravel_index(order, bounds.shape)
    return list(zip(bounds.ravel()[order].tolist(), rows[at[0]].tolist(), others[at[1]].tolist(), strict=True))


def _candidates(first: Placed, second: Placed, range_meters: float) -> Iterator[tuple[int, int, Pieces]]:
    """Yield the elements whose boxes are within the range of each other, and their pieces that are."""
    if not (len(first.centre) and len(second.centre)):
        return
    whole = slice(None)
    bounds = _bounds(first, second, whole, whole)
    close = np.minimum.reduceat(bounds, _starts(first), axis=0)
    close = np.minimum.reduceat(close, _starts(second), axis=1)
    elements = np.flatnonzero(np.diff(first.first_piece)), np.flatnonzero(np.diff(second.first_piece))
    for at, to in np.argwhere(close <= range_meters).tolist():
        one, other = int(elements[0][at]), int(elements[1][to])
        rows, others = _rows(first, one), _rows(second, other)
        yield one, other, _ordered(bounds[rows[:, None], others[None]], rows, others)


def _starts(placed: Placed) -> Any:  # noqa: ANN401 an index array
    """Return where the pieces of each element that has some begin."""
    return placed.first_piece[:-1][np.diff(placed.first_piece) > 0]


def _contacts(first: Placed, second: Placed, one: int, other: int, pieces: Pieces) -> Contacts | None:
    """Return where two elements touch, None where they don't."""
    if not pieces or pieces[0][0] > 0.0:
        return None
    return touching(first, second, one, other, [(row, to) for bound, row, to in pieces if bound == 0.0])


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
