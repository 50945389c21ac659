"""Polygons in space cut into triangles; concave ones by clipping ears.

Method: G. H. Meisters, "Polygons have ears", American Mathematical Monthly 82 (1975) 648-651.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MAX_CONCAVE_CORNERS = 5_000
"""Clipping ears takes time with the square of the corners; polygons with more than these are cut as a fan."""


def triangulate(
    points: NDArray[np.float64], corners: NDArray[np.intp], lengths: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return triangles (m, 3) as places in `corners`, and for each the polygon (m,) that it is of, in their order.

    `points` (n, 3); `corners` (k,) are rows of `points`, polygon after polygon; `lengths` (p,) how many corners each
    polygon has. Those with fewer than three are left out. The sense of turning stays.
    """
    starts = np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.intp)
    triangles: list[NDArray[np.intp]] = []
    owners: list[NDArray[np.intp]] = []
    for length in np.unique(lengths):
        if length < 3:
            continue
        polygons = np.flatnonzero(lengths == length)
        places = starts[polygons][:, None] + np.arange(length)
        concave = _concave(points[corners[places]]) if length > 3 else np.zeros(len(polygons), bool)
        fan = np.column_stack([np.zeros(length - 2, np.intp), np.arange(1, length - 1), np.arange(2, length)])
        convex = places[~concave]
        triangles.append(convex[:, fan].reshape(-1, 3))
        owners.append(np.repeat(polygons[~concave], length - 2))
        for row, polygon in zip(places[concave], polygons[concave], strict=True):
            ears = _clip_ears(_flattened(points[corners[row]])) if length <= MAX_CONCAVE_CORNERS else fan
            triangles.append(row[ears])
            owners.append(np.full(len(ears), polygon))
    if not triangles:
        return np.zeros((0, 3), np.intp), np.zeros(0, np.intp)
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(triangles)[order], owner[order]


def triangulate_one(points: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the triangles (m, 3) of one polygon (n, 3), as rows of `points`."""
    return triangulate(points, np.arange(len(points)), np.array([len(points)]))[0]


def newell_normal(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return normals (..., 3) of polygons (..., n, 3), twice the area long, by Newell's method.

    M. E. Newell; in F. Tampieri, "Newell's method for the plane equation of a polygon", Graphics Gems III (1992).
    """
    following = np.roll(points, -1, axis=-2)
    return np.cross(points - points[..., :1, :], following - points[..., :1, :]).sum(axis=-2)


def _concave(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which polygons (p, n, 3) turn both ways."""
    normals = newell_normal(points)
    edges = np.roll(points, -1, axis=1) - points
    turns = np.einsum("pni,pi->pn", np.cross(np.roll(edges, 1, axis=1), edges), normals)
    scale = np.einsum("pi,pi->p", normals, normals)[:, None]
    return (turns < -1e-9 * scale).any(axis=1)


def _flattened(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a polygon (n, 3) as (n, 2), counter-clockwise."""
    normal = newell_normal(points)
    dropped = int(np.argmax(np.abs(normal)))
    first, second = (dropped + 1) % 3, (dropped + 2) % 3
    flat = points[:, [first, second]]
    return flat if normal[dropped] >= 0.0 else flat[:, ::-1]


def _clip_ears(points: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the triangles of a simple polygon (n, 2), counter-clockwise; of a crossed one, as many, wherever."""
    ring = list(range(len(points)))
    triangles: list[tuple[int, int, int]] = []
    place, waited = 0, 0
    while len(ring) > 3:
        count = len(ring)
        before, here, after = ring[(place - 1) % count], ring[place % count], ring[(place + 1) % count]
        # When no corner of a whole round is an ear the polygon crosses itself, and any cut is as good.
        if waited >= count or _is_ear(points, ring, before, here, after):
            triangles.append((before, here, after))
            del ring[place % count]
            place, waited = (place - 1) % (count - 1), 0
        else:
            place, waited = (place + 1) % count, waited + 1
    triangles.append((ring[0], ring[1], ring[2]))
    return np.array(triangles, np.intp)


def _is_ear(points: NDArray[np.float64], ring: list[int], before: int, here: int, after: int) -> bool:
    a, b, c = points[before], points[here], points[after]
    if _cross(b - a, c - b) <= 0.0:
        return False
    others = points[ring]
    # Corners that lie where the ear's own corners lie (polygons joined by a bridge) are no obstacle.
    inside = _left_of(a, b, others) & _left_of(b, c, others) & _left_of(c, a, others)
    own = (others == a).all(axis=1) | (others == b).all(axis=1) | (others == c).all(axis=1)
    return not bool((inside & ~own).any())


def _left_of(start: NDArray[np.float64], end: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    return _cross(end - start, points - start) >= 0.0


def _cross(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
