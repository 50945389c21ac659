"""Pairs of placed elements that touch or are near: boxes first, then exactly, pair by pair.

Each call of FCL is about two pieces of bounded size, so that none holds the interpreter's lock for long.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.nearest import Floats, Nearest
from virtualrobot_kernel.collision.placed import Placed, piece_distance
from virtualrobot_kernel.collision.tessellation import SEGMENTS
from virtualrobot_kernel.collision.touching import touches, touching
from virtualrobot_kernel.numeric.boxes import SLACK
from virtualrobot_kernel.numeric.distance_bounds import box_gaps

Integers = NDArray[np.int64]

FEW = 256
"""Number of pairs of pieces that are looked at in one go."""

STAND_IN = (np.pi / SEGMENTS) ** 2
"""By how much, as part of their radii, triangles that stand for two curved surfaces are farther apart than these."""

ALTERNATIONS = 4
"""Number of times that the points of a pair are taken to the nearest ones of the true, curved surfaces."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two elements that are near or touch, by their places in the two sets; points are in the world's frame.

    Attributes:
        first: the element of the first set, and `second` that of the second.
        distance: in meters, without what both count as thicker; 0 where they touch.
        points: (2, 3) the nearest point of each true surface; where these touch, the first of `contacts` twice.
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
    cylinders and cones, to 2e-5 of the radius. Two that count as thicker touch where they are nearer than both
    paddings together; their contact is then in the middle of the nearest points.
    """
    found = []
    close = box_distances((first.centre, first.half), (second.centre, second.half)) <= range_meters
    for one, other in np.argwhere(close).tolist():
        pair = pair_within(first, second, one, other, range_meters)
        if pair is not None:
            found.append(pair)
    return sorted(found, key=lambda pair: pair.distance)


def pair_within(first: Placed, second: Placed, one: int, other: int, range_meters: float) -> Pair | None:
    """Return two elements that touch or are at most so far apart, None where they aren't."""
    padding = first.padding[one] + second.padding[other]
    rows, bounds = near_pieces(first, second, one, other, range_meters + padding)
    if not bounds.size:
        return None
    overlapping = np.argwhere(bounds == 0.0)
    if len(overlapping):
        pieces = list(zip(rows[0][overlapping[:, 0]].tolist(), rows[1][overlapping[:, 1]].tolist(), strict=True))
        contacts = touching(first, second, one, other, pieces)
        if contacts is not None:
            return Pair(one, other, 0.0, np.stack([contacts.points[0]] * 2), contacts.points, contacts.normal)
    if range_meters <= 0.0 and padding <= 0.0:
        return None
    distance, points = _distance(first, second, one, other, _ordered(bounds, *rows))
    if padding > 0.0 and distance <= padding:
        normal = (points[1] - points[0]) / distance if distance > 0.0 else np.array([0.0, 0.0, 1.0])
        return Pair(one, other, 0.0, points, points.mean(axis=0)[None], normal)
    if distance - padding <= range_meters:
        return Pair(one, other, distance - padding, points, np.zeros((0, 3)), None)
    return None


def is_near(placed: Placed, one: int, other: int, row: int, to: int) -> bool:
    """Return whether a block `row` of an element is nearer to a block `to` of another than both count as thicker.

    Over all blocks whose boxes overlap it is whether `pair_within` a range of 0 returns anything of two that don't
    touch, sooner.
    """
    padding = placed.padding[one] + placed.padding[other]
    if padding <= 0.0:
        return False
    solids = placed.solids[one], placed.solids[other]
    limit = padding + solids[0].radius + solids[1].radius
    # What is told of triangles that stand for a curved surface is too much by at most this.
    curved = STAND_IN * max(float(solid.half.max()) for solid in solids)
    for ours in placed.rows(one, row):
        for theirs in placed.rows(other, to):
            apart, points = piece_distance(placed, placed, ours, theirs)
            if apart <= limit:
                return True
            if apart <= limit + curved:
                points = _polished(points, placed, placed, one, other)
                if float(np.linalg.norm(points[1] - points[0])) <= limit:
                    return True
    return False


def pair_of(first: Placed, second: Placed, one: int, other: int) -> Pair | None:
    """Return how an element of each set stands to the other, however far; None where one has no pieces."""
    return pair_within(first, second, one, other, np.inf)


def least_distance(placed: Placed, one: int, other: int, most: float) -> float:
    """Return a lower bound of two elements' distance (m), 0 where they touch: exact but for `STAND_IN`, sooner.

    It is told up to `most`: farther pieces are not asked. Paddings count.
    """
    solids = placed.solids[one], placed.solids[other]
    thick = sum(solid.radius for solid in solids) + placed.padding[one] + placed.padding[other]
    bounds = np.empty((len(solids[0].pieces), len(solids[1].pieces)))
    boxes = ((solid.piece_centre, solid.piece_half) for solid in solids)
    box_gaps(one, other, placed.world_t_element, *next(boxes), *next(boxes), bounds)
    rows = [np.arange(placed.first_piece[each], placed.first_piece[each + 1]) for each in (one, other)]
    if any(solid.solid is not None for solid in solids):
        # One may be inside the other, where surfaces are far from each other.
        both = all(solid.solid is not None for solid in solids)
        for row, to in np.argwhere(bounds <= thick).tolist():
            if touches(placed, one, other, int(rows[0][row]), int(rows[1][to])):
                return 0.0
            if both:
                break
    if any(solid.nearest is not None and not solid.radius for solid in solids):
        thick += STAND_IN * max(float(solid.half.max()) for solid in solids)
    least = _between_cores(placed, placed, _ordered(bounds, *rows), most + thick)[0]
    return max(least - thick, 0.0)


Pieces = Iterable[tuple[float, int, int]]
"""Pairs of pieces by their rows: a lower bound of their distance (m) first, the least first."""


def near_pieces(
    first: Placed, second: Placed, one: int, other: int, range_meters: float
) -> tuple[tuple[Integers, Integers], Floats]:
    """Return the rows (r,) and (s,) of two elements' pieces near the other, and lower bounds (r, s) of their distances.

    These are distances without paddings. Left out are pieces whose boxes are farther than the range from the box around
    the other element.
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
    """Return how far boxes are apart, by the shapes of their centres and halves: a lower bound of their contents'.

    Like the boxes of `numeric/`, so that what stands on something is near it for both, whatever rounding makes of it.
    """
    return np.linalg.norm(np.maximum(np.abs(centre - centres) - half - halves - SLACK, 0.0), axis=-1)


def _ordered(bounds: Floats, rows: Integers, others: Integers) -> Iterator[tuple[float, int, int]]:
    """Yield pairs of pieces, made into Python's numbers a few at a time: most are never asked for."""
    order = np.argsort(bounds, axis=None, kind="stable")
    for start in range(0, len(order), FEW):
        some = order[start : start + FEW]
        row, other = np.unravel_index(some, bounds.shape)
        yield from zip(bounds.ravel()[some].tolist(), rows[row].tolist(), others[other].tolist(), strict=True)


def _distance(first: Placed, second: Placed, one: int, other: int, pieces: Pieces) -> tuple[float, Floats]:
    """Return the least distance of two elements' true surfaces, and the points (2, 3) that are so far apart."""
    radii = first.solids[one].radius, second.solids[other].radius
    cores = ((bound + sum(radii) if bound else 0.0, row, to) for bound, row, to in pieces)
    points = _polished(_between_cores(first, second, cores, np.inf)[1], first, second, one, other)
    between = points[1] - points[0]
    apart = float(np.linalg.norm(between))
    along = between / apart if apart > 0.0 else np.zeros(3)
    points = points + np.stack([radii[0] * along, -radii[1] * along])
    return max(apart - sum(radii), 0.0), points


def _between_cores(first: Placed, second: Placed, pieces: Pieces, most: float) -> tuple[float, Floats]:
    """Return the least distance of two elements' cores, as far as it is below `most`, and the points (2, 3) there."""
    best, points = most, np.zeros((2, 3))
    for bound, row, to in pieces:
        if bound >= best:
            break
        apart, between = piece_distance(first, second, row, to)
        if apart < best:
            best, points = apart, between
    return best, points


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
