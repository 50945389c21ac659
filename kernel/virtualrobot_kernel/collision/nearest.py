"""The nearest point of a convex core to another point, in closed form; cores are about the origin and along z."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Nearest = Callable[[Floats], Floats]
"""From a point (3,) to the nearest one (3,) of the core; a point inside is its own."""


def of_segment(length: float) -> Nearest:
    """Return what finds the nearest point of the segment from -length/2 to length/2 along z; 0 is the origin."""
    half = 0.5 * length
    return lambda point: np.array([0.0, 0.0, min(max(point[2], -half), half)])


def of_box(size: tuple[float, float, float]) -> Nearest:
    """Return what finds the nearest point of a box with these edge lengths."""
    half = 0.5 * np.array(size)
    return lambda point: np.clip(point, -half, half)


def of_cylinder(radius: float, length: float) -> Nearest:
    """Return what finds the nearest point of a solid cylinder."""
    half = 0.5 * length

    def nearest(point: Floats) -> Floats:
        across = float(np.hypot(point[0], point[1]))
        scale = radius / across if across > radius else 1.0
        return np.array([point[0] * scale, point[1] * scale, min(max(point[2], -half), half)])

    return nearest


def of_cone(radius: float, length: float) -> Nearest:
    """Return what finds the nearest point of a solid cone: base at -length/2, tip at length/2."""
    half = 0.5 * length
    side = np.array([-radius, length])  # from the base's rim to the tip, as (away from the axis, along it)

    def nearest(point: Floats) -> Floats:
        across = float(np.hypot(point[0], point[1]))
        rim = np.array([across - radius, point[2] + half])
        if point[2] >= -half and length * rim[0] + radius * rim[1] <= 0.0:
            return point.copy()
        along = min(max(float(rim @ side / (side @ side)), 0.0), 1.0)
        candidates = (np.array([radius, -half]) + along * side, np.array([min(across, radius), -half]))
        found = min(candidates, key=lambda one: float(np.hypot(one[0] - across, one[1] - point[2])))
        scale = found[0] / across if across > 0.0 else 0.0
        return np.array([point[0] * scale, point[1] * scale, found[1]])

    return nearest


def segments_nearest(one: Floats, other: Floats) -> Floats:
    """Return the nearest points (2, 3) of two segments (2, 3), each of which may be a point.

    C. Ericson, Real-Time Collision Detection, 2005, 5.1.9.
    """
    along, across, between = one[1] - one[0], other[1] - other[0], one[0] - other[0]
    a, e, f = float(along @ along), float(across @ across), float(across @ between)
    c, b = float(along @ between), float(along @ across)
    if a == 0.0:
        s, t = 0.0, float(np.clip(f / e, 0.0, 1.0)) if e else 0.0
    elif e == 0.0:
        s, t = float(np.clip(-c / a, 0.0, 1.0)), 0.0
    else:
        apart = a * e - b * b
        s = float(np.clip((b * f - c * e) / apart, 0.0, 1.0)) if apart > 1e-12 * a * e else 0.0
        t = (b * s + f) / e
        if not 0.0 <= t <= 1.0:
            t = float(np.clip(t, 0.0, 1.0))
            s = float(np.clip((b * t - c) / a, 0.0, 1.0))
    return np.array([one[0] + s * along, other[0] + t * across])
