"""Poses in the plane: x, y (m) and heading (rad), in arrays (..., 3); they chain as homogeneous transforms do."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def wrapped(angle: ArrayLike) -> Floats:
    """Return angles (rad) within half a turn to either side."""
    return np.remainder(np.asarray(angle, np.float64) + np.pi, 2.0 * np.pi) - np.pi


def compose(first: ArrayLike, second: ArrayLike) -> Floats:
    """Return a_T_c of a_T_b and b_T_c, each (..., 3)."""
    a, b = np.asarray(first, np.float64), np.asarray(second, np.float64)
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = a[..., 0] + c * b[..., 0] - s * b[..., 1]
    y = a[..., 1] + s * b[..., 0] + c * b[..., 1]
    return np.stack([x, y, wrapped(a[..., 2] + b[..., 2])], axis=-1)


def between(first: ArrayLike, second: ArrayLike) -> Floats:
    """Return a_T_b of w_T_a and w_T_b, each (..., 3)."""
    a, b = np.asarray(first, np.float64), np.asarray(second, np.float64)
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    dx, dy = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    return np.stack([c * dx + s * dy, c * dy - s * dx, wrapped(b[..., 2] - a[..., 2])], axis=-1)


def moved(pose: ArrayLike, points: ArrayLike) -> Floats:
    """Return points (..., n, 2) of a frame in that in which its pose (..., 3) is."""
    a, p = np.asarray(pose, np.float64)[..., None, :], np.asarray(points, np.float64)
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    return np.stack([a[..., 0] + c * p[..., 0] - s * p[..., 1], a[..., 1] + s * p[..., 0] + c * p[..., 1]], axis=-1)


def arc(twist: ArrayLike, seconds: ArrayLike) -> Floats:
    """Return where a twist (..., 2), v (m/s) and omega (rad/s), leads after times (..., s): poses (..., 3)."""
    v, w = np.asarray(twist, np.float64)[..., 0], np.asarray(twist, np.float64)[..., 1]
    t = np.asarray(seconds, np.float64)
    turn, half = w * t, 0.5 * w * t
    chord = v * t * np.sinc(half / np.pi)  # sin(half) / half
    return np.stack([chord * np.cos(half), chord * np.sin(half), turn], axis=-1)


def planar(transform: ArrayLike) -> Floats:
    """Return the pose (3,) in the plane of a homogeneous transform (4, 4)."""
    t = np.asarray(transform, np.float64)
    return np.array([t[0, 3], t[1, 3], math.atan2(t[1, 0], t[0, 0])])


def distance(first: ArrayLike, second: ArrayLike) -> float:
    """Return how far two places (2,) or poses (3,) are apart (m)."""
    a, b = np.asarray(first, np.float64), np.asarray(second, np.float64)
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))
