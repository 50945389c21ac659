"""Path of a tool centre point with freedom: frames on a smooth curve, and how the tool is off them on its way.

Its parameter is the part of the frames' way that is done, by length, so that one law of it is one of the tool's speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from virtualrobot_sdk.poses import from_roll_pitch_yaw, skew

from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.spline import Spline

AXES = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")
"""Names of the six freedoms, in their order."""
#: Into how many parts the way between two frames is divided, and Gauss-Legendre's places and weights in each.
_PARTS = 4
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
#: Part of the way between two frames within which something is at one of them.
_ASIDE = 0.05
#: Places in a piece of a cubic that determine it, the part of its range by which a function goes on beyond it, and the
#: matrix from values at those places to coefficients.
_FOUR = np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])
_BEYOND = 1e-3
_TO_COEFFICIENTS = np.linalg.inv(_FOUR[:, None] ** np.arange(4))


@dataclass(frozen=True, eq=False)
class FramePath:
    """Curve through n frames by its length: `curve` at the parameter `u` of s, both from 0 to 1, and a little beyond.

    length (m). frames (n,): where each is passed.
    """

    curve: Spline
    u: PiecewisePolynomial
    length: float
    frames: Array

    def pose(self, s: float) -> Array:
        """Return base_t_frame (4, 4)."""
        return self.curve.pose(float(self.u.state(s, 0)[0, 0]))

    def poses(self, s: Array) -> Array:
        """Return base_t_frame (m, 4, 4) at parameters (m,)."""
        return self.curve.poses_at(self.u.states(s, 0)[0, :, 0])


def frame_path(curve: Spline) -> FramePath:
    """Return a curve, whose position never stands still, by its length."""
    position = PiecewisePolynomial(curve.u, curve.coefficients[:, :, :3])
    marks = np.concatenate([np.linspace(a, b, _PARTS, False) for a, b in zip(curve.u[:-1], curve.u[1:], strict=True)])
    marks = np.append(marks, 1.0)
    half = 0.5 * np.diff(marks)[:, None]
    places = marks[:-1, None] + half * (1.0 + _PLACES)
    speeds = np.linalg.norm(position.states(places.ravel(), 1)[1], axis=1).reshape(places.shape)
    done = np.concatenate([[0.0], np.cumsum((speeds * _WEIGHTS * half).sum(axis=1))])
    length, s = float(done[-1]), done / done[-1]
    s[-1] = 1.0
    _, rate, bend = position.states(marks, 2)
    speed = np.linalg.norm(rate, axis=1) / length
    slope = np.einsum("ij,ij->i", rate, bend) / (speed * length**2)
    u = quintic_hermite(s, marks[:, None], 1.0 / speed[:, None], (-slope / speed**3)[:, None])
    return FramePath(curve, beyond(u), length, s[::_PARTS])


@dataclass(frozen=True, eq=False)
class FreePath(CartesianPath):
    """Path of the tool along `frames`, with `freedoms` (6,) by the same parameter: m, and rad about x, y, z in turn."""

    kind: ClassVar[str] = "tool path"
    noun: ClassVar[str] = "tool path"

    frames: FramePath
    freedoms: PiecewisePolynomial

    @property
    def length(self) -> float:
        """Length of the frames' way in m."""
        return self.frames.length

    @property
    def angle(self) -> float:
        """Angle in rad that the frames turn in all, and the tool about z against them."""
        turn = np.abs(np.diff(self.freedoms.evaluate(np.clip(self.freedoms.breaks, 0.0, 1.0))[:, 3:], axis=0)).sum()
        return self.frames.curve.angle + float(turn)

    @property
    def knots(self) -> tuple[float, ...]:
        """Parameters in (0, 1) of the frames, and of the pieces of the freedoms that don't begin next to one."""
        frames, others = self.frames.frames, self.freedoms.breaks[1:-1]
        after = np.clip(np.searchsorted(frames, others), 1, len(frames) - 1)
        aside = np.minimum(np.abs(others - frames[after - 1]), np.abs(others - frames[after]))
        apart = aside > _ASIDE * (frames[after] - frames[after - 1])
        return tuple(np.union1d(frames[1:-1], others[apart]).tolist())

    def travelled(self, u: float) -> tuple[float, float]:
        """Return how much of length (m) and angle (rad) is done."""
        return u * self.length, u * self.angle

    def pose(self, u: float) -> Array:
        """Return base_t_tcp (4, 4)."""
        return self.frames.pose(u) @ frame_t_tool(self.freedoms.state(u, 0)[0])

    def poses(self, u: Array) -> Array:
        """Return base_t_tcp (m, 4, 4) at parameters (m,)."""
        return self.frames.poses(u) @ frame_t_tools(self.freedoms.states(u, 0)[0])

    def twist(self, u: float) -> Array:
        """Return the derivative (6,) of the pose: m, then rad, base frame, at the TCP."""
        at, rate = self.frames.u.state(u, 1)[:, 0].tolist()
        frame, twist = self.frames.curve.pose(at)[:3, :3], self.frames.curve.twist(at) * rate
        value, slope = self.freedoms.state(u, 1)
        about_x, about_y = value[3:5].tolist()
        axes = np.array(
            [
                [1.0, 0.0, math.sin(about_y)],
                [0.0, math.cos(about_x), -math.sin(about_x) * math.cos(about_y)],
                [0.0, math.sin(about_x), math.cos(about_x) * math.cos(about_y)],
            ]
        )
        twist[:3] += skew(twist[3:]) @ (frame @ value[:3]) + frame @ slope[:3]
        twist[3:] += frame @ (axes @ slope[3:])
        return twist

    def place(self, u: float) -> tuple[str, dict[str, object]]:
        """Return the place of `u`, as of every path, and the nearest frame."""
        words, metadata = super().place(u)
        nearest = int(np.argmin(np.abs(self.frames.frames - u)))
        return f"{words}, nearest to frames[{nearest}],", {**metadata, "frame": nearest}


def frame_t_tool(freedom: Array) -> Array:
    """Return the pose (4, 4) of a tool in its frame: shifted by x, y, z, turned about x, the new y, the new z."""
    pose = np.eye(4)
    pose[:3, 3] = freedom[:3]
    about_x, about_y, about_z = freedom[3:].tolist()
    # Rx Ry Rz is the inverse of Rz Ry Rx of the angles' negatives.
    pose[:3, :3] = from_roll_pitch_yaw(-about_x, -about_y, -about_z).T
    return pose


def frame_t_tools(freedoms: Array) -> Array:
    """Return the poses (m, 4, 4) of a tool in its frame, as `frame_t_tool` does one, of freedoms (m, 6)."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(freedoms[:, 3:]).T, np.sin(freedoms[:, 3:]).T
    found = np.tile(np.eye(4), (len(freedoms), 1, 1))
    found[:, :3, 3] = freedoms[:, :3]
    found[:, :3, :3] = np.array(
        [
            [cy * cz, -cy * sz, sy],
            [cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy],
            [sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy],
        ]
    ).transpose(2, 0, 1)
    return found


def within_hull(places: Array, control: Array) -> PiecewisePolynomial:
    """Return a cubic B-spline on the range of rising places (m,), m >= 3, and a little beyond it.

    control (m + 2, k): its control values, at the places, and one before and after them.
    It is twice continuously differentiable and near the values; on the range each component is between the least and
    the greatest of four in a row (de Boor, A Practical Guide to Splines, chapter IX).
    """
    before = 2.0 * places[0] - places[2:0:-1]
    after = 2.0 * places[-1] - places[-2:-4:-1]
    knots = np.concatenate([before, places, after])
    pieces = np.arange(len(places) - 1)
    width = np.diff(places)[:, None]
    x = places[:-1, None] + width * _FOUR
    # de Boor's algorithm at four places of all pieces; piece p lies between the knots p + 2 and p + 3.
    found = np.stack([control[pieces + i] for i in range(4)])[:, :, None, :].repeat(4, axis=2)
    for level in range(1, 4):
        for i in range(3, level - 1, -1):
            low, high = knots[pieces + i - 1][:, None], knots[pieces + i + 3 - level][:, None]
            share = ((x - low) / (high - low))[:, :, None]
            found[i] = (1.0 - share) * found[i - 1] + share * found[i]
    coefficients = np.einsum("ij,pjk->pik", _TO_COEFFICIENTS, found[3])
    return beyond(PiecewisePolynomial(places, coefficients / (width ** np.arange(4))[:, :, None]))


def beyond(function: PiecewisePolynomial) -> PiecewisePolynomial:
    """Return a function whose first and last piece go on a little before its start and after its end."""
    breaks, coefficients = function.breaks.copy(), function.coefficients.copy()
    margin = _BEYOND * (breaks[-1] - breaks[0])
    first = coefficients[0]
    for k in range(len(first) - 1):
        # Powers of x - start + margin, by repeated synthetic division (Horner).
        for i in range(len(first) - 2, k - 1, -1):
            first[i] -= margin * first[i + 1]
    breaks[0] -= margin
    breaks[-1] += margin
    return PiecewisePolynomial(breaks, coefficients)
