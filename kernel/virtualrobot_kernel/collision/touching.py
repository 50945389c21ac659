"""Contact points of two elements: by FCL's solids, and for meshes by the triangles that cut each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import fcl
import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.depth import depth_of
from virtualrobot_kernel.collision.nearest import Floats, segments_nearest
from virtualrobot_kernel.collision.placed import Placed, piece_distance

MOST = 256
"""The most contacts of two pieces."""

MOST_POINTS = 64
"""Number of points that are told of two things that touch: meshes meet in thousands."""

_ONE_CONTACT = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)

FLAT = 0.3
"""Points lie in a plane when they reach less than this out of it, as part of their second extent."""


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """Contacts of two elements: points (k, 3), k at least 1, and the unit normal (3,) from the first to the second."""

    points: Floats
    normal: Floats


def spread(count: int) -> NDArray[np.intp]:
    """Return which of so many points are told: all, or `MOST_POINTS` from the first to the last."""
    return np.arange(count) if count <= MOST_POINTS else np.linspace(0, count - 1, MOST_POINTS).astype(np.intp)


def touching(first: Placed, second: Placed, one: int, other: int, pieces: Sequence[tuple[int, int]]) -> Contacts | None:
    """Return where two elements touch; None where they don't.

    Whether they touch, FCL says of their solids: exactly, also where one is inside the other. Where they do, it tells
    the points of convex solids, whose normal is the way of their depth; spheres and capsules among themselves are in
    closed form. A sphere or a capsule touches a mesh at its points that are nearest to the core. The surfaces of
    meshes, and of boxes, cylinders and cones with them, meet in curves: the points are the middles of the pieces of
    these, and the normal is that of the plane through them.

    Args:
        first: holds the element `one`.
        second: holds the element `other`.
        one: which element of the first set.
        other: which one of the second.
        pieces: rows of the two elements' pieces whose boxes overlap.
    """
    if first.solids[one].radius and second.solids[other].radius:
        return _of_rounds(first, second, one, other)
    solid, against = first.whole(one), second.whole(other)
    if solid and against:
        return _of_solids(first, second, one, other, pieces)
    if first.solids[one].radius or second.solids[other].radius:
        contacts = _of_round(first, second, one, other, pieces)
        if contacts is None or contacts.points.size:
            return contacts
    lines: list[tuple[Floats, Floats]] = []
    told: list[tuple[Any, float]] = []
    for row, to in pieces:
        # Mesh first: FCL's normals are turned otherwise.
        if solid:
            told += [(contact, -1.0) for contact in _collide(second.piece(to), solid)]
        elif against:
            told += [(contact, 1.0) for contact in _collide(first.piece(row), against)]
        if told or not (solid or against):
            cuts = _collide(first.piece(row), second.piece(to))
            told += [(contact, 1.0) for contact in cuts]
            which = np.array([(contact.b1, contact.b2) for contact in cuts], np.int64).reshape(-1, 2)
            lines.append((first.triangles(row, which[:, 0]), second.triangles(to, which[:, 1])))
    if not told:
        return None
    if lines:
        ours, theirs = (np.concatenate(side) for side in zip(*lines, strict=True))
        points = _cut_points(ours, theirs)
        normal = _normal(points, ours, theirs)
        kept = points[np.isfinite(points).all(axis=1)]
        if len(kept) and normal is not None:
            return Contacts(kept, normal)
    deepest = max(told, key=lambda one: abs(one[0].penetration_depth))
    normal = deepest[1] * np.array(deepest[0].normal)
    if not normal.any():
        # Triangles without area have no normal: from the middle of one to that of the other will do.
        normal = second.centre[other] - first.centre[one] + (0.0, 0.0, 1e-12)
        normal /= np.linalg.norm(normal)
    return Contacts(np.array([contact.pos for contact, _ in told]), normal)


def touches(placed: Placed, one: int, other: int, row: int, to: int) -> bool:
    """Return whether a piece `row` of an element touches a piece `to` of another; those of solids are the whole solid.

    Over all pieces whose boxes overlap it is whether `touching` returns anything, sooner.
    """
    ours, theirs = placed.solids[one], placed.solids[other]
    if ours.solid is None and theirs.solid is None:
        return _meet(placed.piece_of(one, row), placed.piece_of(other, to))
    if ours.radius and theirs.radius:
        points = segments_nearest(placed.segment(one), placed.segment(other))
        return float(np.linalg.norm(points[1] - points[0])) <= ours.radius + theirs.radius
    if ours.solid is not None and theirs.solid is not None:
        return _meet(placed.whole(one), placed.whole(other))
    if ours.radius or theirs.radius:
        return piece_distance(placed, placed, row, to)[0] <= ours.radius + theirs.radius
    if ours.solid is not None:
        return _meet(placed.piece_of(other, to), placed.whole(one))
    return _meet(placed.piece_of(one, row), placed.whole(other))


def _meet(one: Any, other: Any) -> bool:  # noqa: ANN401 FCL has no types
    return fcl.collide(one, other, _ONE_CONTACT, fcl.CollisionResult()) > 0


def _collide(one: Any, other: Any) -> list[Any]:  # noqa: ANN401 FCL has no types
    result = fcl.CollisionResult()
    fcl.collide(one, other, fcl.CollisionRequest(num_max_contacts=MOST, enable_contact=True), result)
    return result.contacts


def _of_solids(
    first: Placed, second: Placed, one: int, other: int, pieces: Sequence[tuple[int, int]]
) -> Contacts | None:
    """Return where two convex solids touch, and the way in which they are out of each other the soonest.

    FCL's own normals come from the search whose depths are not used either: of a cone that stands on a box one in 800
    was off by up to 0.2.
    """
    solids = first.whole(one), second.whole(other)
    points = [contact.pos for contact in _collide(*solids)]
    if not points:
        # Asked for contacts, FCL tells none of every second box that stands on another one.
        if not _meet(*solids):
            return None
        _, nearest = min((piece_distance(first, second, row, to) for row, to in pieces), key=lambda found: found[0])
        points = [nearest.mean(axis=0)]
    return Contacts(np.array(points), depth_of(first, second, one, other).way)


def _of_rounds(first: Placed, second: Placed, one: int, other: int) -> Contacts | None:
    """Return where two that are round about cores touch: in the middle of where they are in each other."""
    radii = first.solids[one].radius, second.solids[other].radius
    cores = first.segment(one), second.segment(other)
    ours, theirs = segments_nearest(*cores)
    distance = float(np.linalg.norm(theirs - ours))
    if distance > sum(radii):
        return None
    normal = (
        (theirs - ours) / distance if distance > 0.0 else _across(cores[0][1] - cores[0][0], cores[1][1] - cores[1][0])
    )
    return Contacts((ours + 0.5 * (distance + radii[0] - radii[1]) * normal)[None], normal)


def _across(one: Floats, other: Floats) -> Floats:
    """Return a unit vector at right angles to two vectors, any of which may be zero or along the other."""
    candidates = [np.cross(one, other), *(np.cross(axis, one + other) for axis in np.eye(3)), np.eye(3)[2]]
    longest = max(candidates[:4], key=lambda vector: float(vector @ vector))
    chosen = next((each for each in (candidates[0], longest) if each @ each > 1e-12), candidates[4])
    return chosen / np.linalg.norm(chosen)


def _of_round(
    first: Placed, second: Placed, one: int, other: int, pieces: Sequence[tuple[int, int]]
) -> Contacts | None:
    """Return where a mesh touches what is round about a core; no points where the core itself is cut."""
    radius = first.solids[one].radius + second.solids[other].radius
    mesh = 0 if second.solids[other].radius else 1
    near = [piece_distance(first, second, row, to) for row, to in pieces]
    near = sorted((one for one in near if one[0] <= radius), key=lambda one: one[0])
    if not near:
        return None
    between = near[0][1][1] - near[0][1][0]
    length = float(np.linalg.norm(between))
    if near[0][0] <= 0.0 or length == 0.0:
        return Contacts(np.zeros((0, 3)), between)
    return Contacts(np.array([points[mesh] for _, points in near]), between / length)


def _cut_points(ours: Floats, theirs: Floats) -> Floats:
    """Return the middle (k, 3) of the line in which each two triangles (k, 3, 3) cut; NaN where they are in a plane.

    The ends of that line are where edges of one go through the other (T. Moeller, A fast triangle-triangle intersection
    test, 1997).
    """
    found = np.concatenate([_crossings(ours, theirs), _crossings(theirs, ours)], axis=1)
    crossed = np.isfinite(found[:, :, :1])
    count = crossed.sum(axis=1)
    total = np.where(crossed, found, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _crossings(edges_of: Floats, triangles: Floats) -> Floats:
    """Return where the three edges of k triangles go through k others: (k, 3, 3), NaN where they don't."""
    start, end = edges_of, np.roll(edges_of, -1, axis=1)
    normal = _cross_normals(triangles)[:, None]
    above = ((start - triangles[:, :1]) * normal).sum(axis=2)
    below = ((end - triangles[:, :1]) * normal).sum(axis=2)
    drop = above - below
    through = (above * below <= 0.0) & (drop != 0.0)
    share = np.where(through, above / np.where(through, drop, 1.0), np.nan)
    points = start + share[:, :, None] * (end - start)
    inside = through.copy()
    size = np.linalg.norm(normal, axis=2)
    for corner in range(3):
        a, b = triangles[:, corner], triangles[:, (corner + 1) % 3]
        side = (np.cross((b - a)[:, None], points - a[:, None]) * normal).sum(axis=2)
        inside &= side >= -1e-9 * size**2
    return np.where(inside[:, :, None], points, np.nan)


def _cross_normals(triangles: Floats) -> Floats:
    """Return the normals (k, 3) of triangles (k, 3, 3), as long as twice their areas."""
    return np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])


def _normal(points: Floats, ours: Floats, theirs: Floats) -> Floats | None:
    """Return the unit normal from ours to theirs: of the plane through the points, or else as the surfaces lean."""
    normals = [_cross_normals(side) for side in (ours, theirs)]
    units = [side / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-300) for side in normals]
    lean = (units[0] - units[1]).sum(axis=0)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) >= 3:
        _, extents, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
        if extents[2] < FLAT * extents[1]:
            return axes[2] if axes[2] @ lean >= 0.0 else -axes[2]
    length = float(np.linalg.norm(lean))
    return lean / length if length > 1e-9 else None
