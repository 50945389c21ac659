"""Orientations of floating joints as paths: unit quaternions x, y, z, w, and the angular velocity that goes with them.

A path has a polynomial for each component of a quaternion. Its velocities are others: the derivatives of
quasi-coordinates (Greenwood, Advanced Dynamics, 2003, section 4.1), whose first three are the integrals of the angular
velocity about the axes of the turning body, and whose fourth is 0.
"""

from __future__ import annotations

import math

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial

UNIT_TOLERANCE = 1e-3
"""Greatest difference from 1 of the length of a quaternion that is taken for a unit one, rounded."""

_INVERSE = np.array([-1.0, -1.0, -1.0, 1.0])
"""Signs of the inverse of a unit quaternion."""

_PIECE, _TERMS = math.pi / 8.0, 12
"""Greatest half angle (rad) of a polynomial's piece, and its terms: what Taylor's theorem leaves is below 3e-14."""


def unit(quaternion: Array, what: str) -> Array:
    """Return a quaternion (4,) with length 1; raise KernelError when it is farther from that than `UNIT_TOLERANCE`."""
    length = float(np.linalg.norm(quaternion))
    if not abs(length - 1.0) <= UNIT_TOLERANCE:
        raise KernelError(
            f"{what} has the quaternion {quaternion.tolist()} of length {length:.6g}; it must have length 1, to "
            f"{UNIT_TOLERANCE:g}",
            value=length,
        )
    return quaternion / length


def product(a: Array, b: Array) -> Array:
    """Return the product a b of quaternions (4,): the rotation b, then a, seen from outside."""
    # In plain floats: an array at a time is slow for four numbers.
    (ax, ay, az, aw), (bx, by, bz, bw) = a.tolist(), b.tolist()
    return np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def turn_between(start: Array, goal: Array) -> Array:
    """Return the rotation vector (3,) in the axes of the start that leads to the goal the shorter way, in rad."""
    x, y, z, w = product(start * _INVERSE, goal).tolist()
    sine = math.hypot(x, y, z)
    scale = math.copysign(2.0, w) * math.atan2(sine, abs(w)) / sine if sine > 0.0 else 0.0
    return np.array([scale * x, scale * y, scale * z])


def turned(start: Array, turn: Array) -> Array:
    """Return the orientation (4,) after a turn by the rotation vector (3,) in the axes of the start."""
    x, y, z = turn.tolist()
    angle = math.hypot(x, y, z)
    scale = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    return product(start, np.array([scale * x, scale * y, scale * z, math.cos(0.5 * angle)]))


def slerp(start: Array, goal: Array) -> tuple[PiecewisePolynomial, PiecewisePolynomial]:
    """Return the turn at constant velocity between unit quaternions (4,), and its quasi-coordinates, by u in [0, 1].

    It goes the shorter way about one axis, so it ends at the goal or at its negative, which is the same orientation.
    Source: Shoemake, Animating rotation with quaternion curves (SIGGRAPH 1985).
    """
    turn = turn_between(start, goal)
    half = 0.5 * float(np.linalg.norm(turn))
    across = product(start, np.append(turn / (2.0 * half), 0.0)) if half > 0.0 else np.zeros(4)
    pieces = max(1, math.ceil(half / _PIECE))
    breaks, powers = np.linspace(0.0, 1.0, pieces + 1), np.arange(_TERMS)
    angles = half * breaks[:-1, None] + 0.5 * math.pi * powers
    scale = half**powers / np.array([math.factorial(power) for power in powers])
    coefficients = (scale * np.cos(angles))[..., None] * start + (scale * np.sin(angles))[..., None] * across
    quasi = np.stack([np.zeros(4), np.append(turn, 0.0)])[None]
    return PiecewisePolynomial(breaks, coefficients), PiecewisePolynomial(breaks[[0, -1]], quasi)
