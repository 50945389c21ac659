"""Spline through poses: the tool centre point passes each one; velocity and acceleration never jump on its way.

The parameter u grows with the chords, sqrt(distance² + (0.1 m/rad times turn)²) from pose to pose, so that a curve is
gone evenly. Velocities and accelerations at the poses are those of the cubic spline, which on chords approximates a
smooth curve to the fourth order (Floater, Chordal cubic spline interpolation is fourth-order accurate, IMA Journal of
Numerical Analysis 2006), position and orientation alike: the turn from pose to pose, a rotation vector in the base
frame, is for the angular velocity what the chord is for the velocity. Between two poses position and rotation vector
are quintics, the latter with the derivatives that make angular velocity and acceleration continuous (as in Park,
Ravani, Smooth invariant interpolation of rotations, ACM Transactions on Graphics 1997). So the curve is the same
whatever frame it is given in, and passes each pose exactly.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
from virtualrobot_sdk.poses import left_jacobian, rotation_matrix

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.cartesian_path import CartesianPath, turn_between
from virtualrobot_kernel.motion.path import hermite_pieces, quintic_hermite, solve_tridiagonal
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.pose_check import check_poses

#: The most goals of a spline.
MOST_GOALS = 1000
#: Poses nearer to each other than this are the same, in m and in rad.
SAME = 1e-5
#: Length in meters that a turn of one radian counts as.
TURN_LENGTH = 0.1
#: At a pose the velocity is at most this times the smaller of the mean ones before and after it, and the acceleration
#: this much of it by the longer of both times: else a curve would swing out where far poses follow near ones, or turn
#: where two poses in a row have the same orientation. Evenly spread poses on a smooth curve stay far below.
_FASTEST, _SHARPEST = 2.0, 4.0
#: Into how many parts the way between two poses is divided to tell its length.
_PARTS = 8


@dataclass(frozen=True, eq=False)
class Spline(CartesianPath):
    """Path through poses (n + 1, 4, 4), the first one being the start.

    u (n + 1,): where each one is passed, from 0 to 1. coefficients (n, 6, 6): between two of them, by ascending powers
    of u - u[k], the position in m and the rotation vector in rad by which the orientation is turned from pose k; base
    frame. ways (m, 3): rows of u, length in m and angle in rad so far.
    """

    kind: ClassVar[str] = "spline"
    noun: ClassVar[str] = "spline"

    poses: Array
    u: Array
    coefficients: Array
    ways: Array

    @property
    def length(self) -> float:
        """Length of the way of the position in m, to about a thousandth."""
        return float(self.ways[-1, 1])

    @property
    def angle(self) -> float:
        """Angle that the orientation turns in all in rad, to about a thousandth."""
        return float(self.ways[-1, 2])

    @property
    def stations(self) -> tuple[tuple[float, str], ...]:
        """Fractions of the goals, in order."""
        return tuple((float(u), f"goals[{k}]") for k, u in enumerate(self.u[1:]))

    @property
    def knots(self) -> tuple[float, ...]:
        """Fractions u of the path, in (0, 1), at which the poses between start and goal are passed."""
        return tuple(self.u[1:-1].tolist())

    def travelled(self, u: float) -> tuple[float, float]:
        """Return how much of length (m) and angle (rad) is done at the fraction `u`."""
        length, angle = (float(np.interp(u, self.ways[:, 0], self.ways[:, k])) for k in (1, 2))
        return length, angle

    def pose(self, u: float) -> Array:
        """Return base_t_tcp (4, 4) at the fraction `u`."""
        piece, powers, _ = self._located(u)
        values = powers @ self.coefficients[piece]
        pose = np.eye(4)
        pose[:3, 3] = values[:3]
        pose[:3, :3] = rotation_matrix(values[3:]) @ self.poses[piece, :3, :3]
        return pose

    def poses_at(self, u: Array) -> Array:
        """Return base_t_tcp (m, 4, 4) at fractions (m,), as `pose` does at one."""
        piece = np.clip(np.searchsorted(self.u, u, side="right") - 1, 0, len(self.u) - 2)
        powers = (u - self.u[piece])[:, None] ** np.arange(6.0)
        values = np.einsum("mi,mij->mj", powers, self.coefficients[piece])
        found = np.tile(np.eye(4), (len(u), 1, 1))
        found[:, :3, 3] = values[:, :3]
        found[:, :3, :3] = rotations(values[:, 3:]) @ self.poses[piece, :3, :3]
        return found

    def twist(self, u: float) -> Array:
        """Return the derivative (6,) of the pose by u: m, then rad, base frame, at the TCP."""
        piece, powers, slopes = self._located(u)
        turn = powers @ self.coefficients[piece, :, 3:]
        rates = slopes @ self.coefficients[piece]
        rates[3:] = left_jacobian(turn) @ rates[3:]
        return rates

    def place(self, u: float) -> tuple[str, dict[str, object]]:
        """Return the place of `u`, as of every path, and the nearest goal on the way."""
        words, metadata = super().place(u)
        nearest = int(np.argmin(np.abs(self.u - u)))
        goal = "the start" if nearest == 0 else f"goals[{nearest - 1}]"
        return f"{words}, nearest to {goal},", {**metadata, "goal": nearest - 1}

    def _located(self, u: float) -> tuple[int, Array, Array]:
        """Return the piece of `u`, the powers of its local parameter (6,) and their derivatives."""
        knots = self.u
        piece = min(max(bisect_right(knots, u) - 1, 0), len(knots) - 2)
        powers = (u - knots[piece]) ** np.arange(6.0)
        slopes = np.arange(6.0)
        slopes[1:] *= powers[:-1]
        return piece, powers, slopes


def spline(base_t_start: Array, base_t_goals: Sequence[Array]) -> Spline:
    """Return the spline from a pose (4, 4) through others, all in the base frame, the last one being its end.

    From pose to pose the orientation turns the shorter way. Raises KernelError when there is no goal or more than
    1,000, when one is not a pose, or one the same as the one before it.
    """
    if not 0 < len(base_t_goals) <= MOST_GOALS:
        raise KernelError(f"a spline has 1 to {MOST_GOALS} goals, not {len(base_t_goals)}", goals=len(base_t_goals))
    check_poses(base_t_goals, "goals[{}] of a spline")
    poses = np.array([base_t_start, *base_t_goals], dtype=np.float64)
    turns = np.array([turn_between(one, other) for one, other in pairwise(poses)])
    chords = np.diff(poses[:, :3, 3], axis=0)
    _check_apart(chords, turns)
    widths = np.hypot(np.linalg.norm(chords, axis=1), TURN_LENGTH * np.linalg.norm(turns, axis=1))
    widths /= widths.sum()
    u = np.concatenate([[0.0], np.cumsum(widths)])
    u[-1] = 1.0
    widths = np.diff(u)
    speeds, accelerations = _rates_at_knots(widths, chords)
    path = quintic_hermite(u, poses[:, :3, 3], speeds, accelerations)
    spins, spin_ups = _rates_at_knots(widths, turns)
    coefficients = np.concatenate([path.coefficients, _rotation_pieces(u, turns, spins, spin_ups)], axis=2)
    return Spline(poses[0], poses, u, coefficients, _ways(u, coefficients))


def rotations(vectors: Array) -> Array:
    """Return the rotations (m, 3, 3) about vectors (m, 3) by their lengths, as `rotation_matrix` does of one."""
    angles, cross = _angles_and_skews(vectors)
    # sin(a) / a and (1 - cos(a)) / a^2 = 0.5 (sin(a / 2) / (a / 2))^2, which are 1 and 0.5 at 0.
    first, second = np.sinc(angles / np.pi), 0.5 * np.sinc(0.5 * angles / np.pi) ** 2
    return np.eye(3) + first * cross + second * (cross @ cross)


def left_jacobians(vectors: Array) -> Array:
    """Return the left Jacobians (m, 3, 3) of rotations about vectors (m, 3), as `left_jacobian` does of one."""
    angles, cross = _angles_and_skews(vectors)
    square, safe = angles * angles, np.maximum(angles, 1e-2)
    first = 0.5 * np.sinc(0.5 * angles / np.pi) ** 2
    # The difference of a small angle and its sine is of too few digits.
    small = 1.0 / 6.0 - square / 120.0 + square**2 / 5040.0
    second = np.where(angles < 1e-2, small, (safe - np.sin(safe)) / safe**3)
    return np.eye(3) + first * cross + second * (cross @ cross)


def _angles_and_skews(vectors: Array) -> tuple[Array, Array]:
    """Return the lengths (m, 1, 1) of vectors (m, 3), and the matrices (m, 3, 3) that multiply across them."""
    x, y, z = vectors.T
    zero = np.zeros(len(vectors))
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    return np.linalg.norm(vectors, axis=1)[:, None, None], cross


def _check_apart(chords: Array, turns: Array) -> None:
    """Raise KernelError when a pose is the same as the one before it."""
    same = (np.linalg.norm(chords, axis=1) < SAME) & (np.linalg.norm(turns, axis=1) < SAME)
    for number in np.flatnonzero(same):
        before = "the start of the spline" if number == 0 else f"goals[{number - 1}]"
        raise KernelError(
            f"goals[{number}] of a spline is the same pose as {before}: {1e3 * np.linalg.norm(chords[number]):.3g} mm "
            f"and {np.linalg.norm(turns[number]):.3g} rad away; leave it out, or let them be {1e3 * SAME:g} mm or "
            f"{SAME:g} rad apart",
            goal=number,
        )


def _rates_at_knots(widths: Array, rises: Array) -> tuple[Array, Array]:
    """Return first and second derivatives (n + 1, 3) at the ends of n pieces of these widths (n,) and rises (n, 3).

    Those of the cubic spline (de Boor, A Practical Guide to Splines, chapter IV), within `_FASTEST` and `_SHARPEST`.
    At its ends the second derivative goes on as in the next piece, as if the first and last inner knot were none; but
    less and less of that the longer the piece is compared with the next, whose curve would be amplified.
    """
    h, slopes = widths[:, None], rises / widths[:, None]
    second = np.zeros((len(widths) + 1, 3))
    if len(widths) == 2:
        second[:] = 2.0 * (slopes[1] - slopes[0]) / (h[0] + h[1])
    elif len(widths) > 2:
        first, last = widths[0] / widths[1], widths[-1] / widths[-2]
        first, last = min(first, 1.0 / first), min(last, 1.0 / last)
        diagonal, above = 2.0 * (widths[:-1] + widths[1:]), widths[1:-1].copy()
        below = above.copy()
        diagonal[0] += widths[0] * (1.0 + first)
        above[0] -= widths[0] * first
        diagonal[-1] += widths[-1] * (1.0 + last)
        below[-1] -= widths[-1] * last
        second[1:-1] = solve_tridiagonal(below, diagonal, above, 6.0 * np.diff(slopes, axis=0))
        second[0] = second[1] + first * (second[1] - second[2])
        second[-1] = second[-2] + last * (second[-2] - second[-3])
    speeds = np.empty_like(second)
    speeds[:-1] = slopes - h * (2.0 * second[:-1] + second[1:]) / 6.0
    speeds[-1] = slopes[-1] + h[-1] * (second[-2] + 2.0 * second[-1]) / 6.0
    amounts = np.linalg.norm(slopes, axis=1)
    slowest = np.minimum(np.append(amounts, amounts[-1]), np.append(amounts[0], amounts))
    longest = np.maximum(np.append(widths, 0.0), np.append(0.0, widths))
    return _at_most(speeds, _FASTEST * slowest), _at_most(second, _SHARPEST * slowest / longest)


def _at_most(vectors: Array, greatest: Array) -> Array:
    """Return vectors (n, 3), those that are longer than `greatest` (n,) as long as that."""
    lengths = np.linalg.norm(vectors, axis=1)
    return vectors * np.minimum(1.0, greatest / np.maximum(lengths, 1e-300))[:, None]


def _rotation_pieces(u: Array, turns: Array, spins: Array, spin_ups: Array) -> Array:
    """Return the quintics (n, 6, 3) of rotation vectors from 0 to `turns` (n, 3) with given spins at both ends.

    spins, spin_ups (n + 1, 3): angular velocity and acceleration by u at the knots (n + 1,). With the rotation vector
    r, r' and r'' the angular velocity is J r' and its derivative J r'' + J' r', J being the left Jacobian of the
    rotations, which is 1 where a piece begins.
    """
    inverses = np.asarray(np.linalg.inv(left_jacobians(turns)), np.float64)
    rates = _times(inverses, spins[1:])
    # J' along r', by differences: J is smooth, and of the order of 1.
    step = 1e-3 / np.maximum(np.linalg.norm(rates, axis=1, keepdims=True), 1e-9)
    shift = step * rates
    one, two = (left_jacobians(turns + k * shift) - left_jacobians(turns - k * shift) for k in (1.0, 2.0))
    slopes: Array = (8.0 * one - two) / (12.0 * step[:, :, None])
    curvatures = _times(inverses, spin_ups[1:] - _times(slopes, rates))
    return hermite_pieces(np.diff(u)[:, None], turns, (spins[:-1], rates), (spin_ups[:-1], curvatures))


def _times(matrices: Array, vectors: Array) -> Array:
    """Return the products (n, 3) of matrices (n, 3, 3) and vectors (n, 3)."""
    return (matrices @ vectors[:, :, None])[:, :, 0]


def _ways(u: Array, coefficients: Array) -> Array:
    """Return rows of u, length and angle so far, by the midpoint rule, of the pieces of `Spline`."""
    marks = np.concatenate([begin + np.arange(_PARTS) / _PARTS * (end - begin) for begin, end in pairwise(u)])
    marks = np.append(marks, 1.0)
    values, rates = PiecewisePolynomial(u, coefficients).states(0.5 * (marks[:-1] + marks[1:]), 1)
    spin = _times(left_jacobians(values[:, 3:]), rates[:, 3:])
    speeds = np.stack([np.linalg.norm(rates[:, :3], axis=1), np.linalg.norm(spin, axis=1)], axis=1)
    done = np.cumsum(speeds * np.diff(marks)[:, None], axis=0)
    return np.column_stack([marks, np.concatenate([np.zeros((1, 2)), done])])
