"""Support of a machine that stands: the polygon of its feet, and how far its centre of mass is from the edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def support_polygon(feet: Floats) -> Floats:
    """Return the corners (h, 2) of the convex hull of feet (n, 2) in m, seen from above, to the left around it.

    Andrew's monotone chain (1979). Feet that lie on an edge are no corners.
    """
    points = np.unique(np.asarray(feet, dtype=np.float64), axis=0).tolist()
    if len(points) < 3:
        return np.array(points).reshape(-1, 2)
    return np.array(_half(points) + _half(points[::-1]))


def stability_margin(point: Floats, feet: Floats) -> float:
    """Return the distance (m) of `point` (2,) from the nearest edge of the polygon of feet (n, 2); negative outside.

    The static stability margin of McGhee and Frank (1968), where `point` is below the centre of mass. Fewer than three
    feet carry nothing statically: then it is the distance from the line or place, negative. Without feet it is -inf.
    """
    corners = support_polygon(feet)
    if not len(corners):
        return -np.inf
    ends = np.roll(corners, -1, axis=0)
    ways = ends - corners
    squares = np.maximum((ways**2).sum(axis=1), 1e-300)
    along = np.clip(((point - corners) * ways).sum(axis=1) / squares, 0.0, 1.0)
    distance = float(np.linalg.norm(point - (corners + along[:, None] * ways), axis=1).min())
    if len(corners) < 3:
        return -distance
    off = point - corners
    inside = bool((ways[:, 0] * off[:, 1] - ways[:, 1] * off[:, 0] >= 0.0).all())
    return distance if inside else -distance


def longitudinal_margin(point: Floats, heading: float, feet: Floats) -> float:
    """Return the distance (m) of `point` (2,) from the nearer edge, ahead or behind; negative outside.

    It is measured along `heading` (rad), as in the theory of wave gaits. Where the line misses the polygon it is -inf.
    """
    corners = support_polygon(feet)
    if len(corners) < 3:
        return -np.inf
    forward, left = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    x, y = (corners - point) @ forward, (corners - point) @ left
    crossings = []
    for i, j in zip(range(len(x)), np.roll(np.arange(len(x)), -1), strict=True):
        if min(y[i], y[j]) <= 0.0 <= max(y[i], y[j]) and y[i] != y[j]:
            crossings.append(x[i] + (x[j] - x[i]) * y[i] / (y[i] - y[j]))
    if not crossings:
        return -np.inf
    return float(min(max(crossings), -min(crossings)))


def _half(points: list[list[float]]) -> list[list[float]]:
    """Return the corners of one side of the hull of sorted points, without the last one."""
    side: list[list[float]] = []
    for point in points:
        while len(side) > 1 and _turn(side[-2], side[-1], point) <= 0.0:
            side.pop()
        side.append(point)
    return side[:-1]


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
