"""All postures of many poses at once, compiled: arms of six turning joints with a spherical wrist.

With h_i the direction of axis i, p_i a point on it and W the point where axes 4, 5 and 6 meet, all at position 0, and
axis 2 at a right angle to axis 1 and parallel to axis 3 (as in D. L. Pieper, The kinematics of manipulators under
computer control, 1968): q_1 turns W into the plane across h_2 in which it stays, q_3 brings it to its distance from
p_2, q_2 to its place, and q_4, q_5, q_6 are what is left of the rotation. Each of q_1, q_3 and q_5 has two values, from
a cos q + b sin q = c (R. M. Murray, Z. Li, S. S. Sastry, A Mathematical Introduction to Robotic Manipulation, 1994,
chapter 3.2).
"""

from __future__ import annotations

import math

import numpy as np
from numba import float64

from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import REVOLUTE, Floats, SerialChain
from virtualrobot_sdk.reference import chain_frames

BRANCHES = 8
"""Number of postures of a pose: two values each of joint 1, joint 3 and joint 5, in this order of their bits."""
ANGLE, LENGTH = 1e-4, 2e-5
"""Axes that are parallel, at a right angle (rad) or meet (m) up to this are meant to: model files round."""

Vector = tuple[float, float, float]


@inlined
def _at(arm: Floats, i: int) -> Vector:
    return arm[i], arm[i + 1], arm[i + 2]


@inlined
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def _turned(axis: Vector, angle: float, v: Vector) -> Vector:
    """Return v turned about a unit axis (Rodrigues' formula)."""
    sine, cosine = math.sin(angle), math.cos(angle)
    across, rest = _cross(axis, v), (1.0 - cosine) * _dot(axis, v)
    return (
        v[0] * cosine + across[0] * sine + axis[0] * rest,
        v[1] * cosine + across[1] * sine + axis[1] * rest,
        v[2] * cosine + across[2] * sine + axis[2] * rest,
    )


@inlined
def _angle(axis: Vector, a: Vector, b: Vector) -> float:
    """Return the angle about an axis by which what is across it of a turns to that of b."""
    return math.atan2(_dot(axis, _cross(a, b)), _dot(a, b) - _dot(axis, a) * _dot(axis, b))


@inlined
def _wrapped(angle: float) -> float:
    return angle - 2.0 * math.pi * np.round(angle / (2.0 * math.pi))


@inlined
def _back(arm: Floats, q1: float, q23: float, v: Vector) -> Vector:
    """Return v turned back by joints 2 and 3 together and joint 1: as it is seen from the forearm."""
    return _turned(_at(arm, 3), -q23, _turned(_at(arm, 0), -q1, v))


@compiled(array_of(float64, 1), array_of(float64, 3), output_of(float64, 3), output_of(float64, 2))
def inverse_many(arm: Floats, base_t_tip: Floats, q: Floats, wrist: Floats) -> None:
    """Write the postures q (m, 8, 6) that put an arm's tip at poses (m, 4, 4), in -pi to pi, NaN where there is none.

    arm (42,): of `spherical_wrist`. wrist (m, 8): (h_4 x h_5) . h_6 of each posture, 0 where it is singular. Limits are
    not looked at. Where joints 4 and 6 turn about one line, joint 6 does it all.
    """
    h1, h2, h4, h5, h6 = _at(arm, 0), _at(arm, 3), _at(arm, 9), _at(arm, 12), _at(arm, 15)
    p1, p2, p3, w0 = _at(arm, 18), _at(arm, 21), _at(arm, 24), _at(arm, 27)
    sense = 1.0 if _dot(h2, _at(arm, 6)) > 0.0 else -1.0
    side = _cross(h1, h2)
    lateral = _dot((w0[0] - p1[0], w0[1] - p1[1], w0[2] - p1[2]), h2)
    a = p3[0] - p2[0], p3[1] - p2[1], p3[2] - p2[2]
    b = w0[0] - p3[0], w0[1] - p3[1], w0[2] - p3[2]
    along = _dot(a, h2)
    a = a[0] - along * h2[0], a[1] - along * h2[1], a[2] - along * h2[2]
    along = _dot(b, h2)
    b = b[0] - along * h2[0], b[1] - along * h2[1], b[2] - along * h2[2]
    bent, odd = _dot(a, b), _dot(a, _cross(h2, b))
    lengths = math.hypot(bent, odd)
    tilted = _dot(h4, h5) * _dot(h5, h6)
    even5, odd5 = _dot(h4, h6) - tilted, _dot(h4, _cross(h5, h6))
    bend = math.hypot(even5, odd5)
    along = _dot(h5, h6)
    mark = h5[0] - along * h6[0], h5[1] - along * h6[1], h5[2] - along * h6[2]
    for i in range(base_t_tip.shape[0]):
        t = base_t_tip[i]
        for branch in range(BRANCHES):
            for j in range(6):
                q[i, branch, j] = np.nan
            wrist[i, branch] = 0.0
        # Columns of the rotation by which the tip is turned from where it is at position 0: t R_0^T.
        x = _row(t, 0, arm, 33)
        y = _row(t, 1, arm, 33)
        z = _row(t, 2, arm, 33)
        c = _at(arm, 30)
        w = (
            t[0, 3] + t[0, 0] * c[0] + t[0, 1] * c[1] + t[0, 2] * c[2] - p1[0],
            t[1, 3] + t[1, 0] * c[0] + t[1, 1] * c[1] + t[1, 2] * c[2] - p1[1],
            t[2, 3] + t[2, 0] * c[0] + t[2, 1] * c[1] + t[2, 2] * c[2] - p1[2],
        )
        radius = math.hypot(_dot(w, h2), _dot(w, side))
        if radius < abs(lateral) or radius == 0.0:
            continue
        base, off = math.atan2(_dot(w, side), _dot(w, h2)), math.acos(lateral / radius)
        for front in range(2):
            q1 = base + (off if front == 0 else -off)
            v = _turned(h1, -q1, w)
            v = v[0] + p1[0] - p2[0], v[1] + p1[1] - p2[1], v[2] + p1[2] - p2[2]
            along = _dot(v, h2)
            v = v[0] - along * h2[0], v[1] - along * h2[1], v[2] - along * h2[2]
            level = 0.5 * (_dot(v, v) - _dot(a, a) - _dot(b, b))
            if abs(level) > lengths or lengths == 0.0:
                continue
            for elbow in range(2):
                swing = math.acos(level / lengths)
                theta = math.atan2(odd, bent) + (swing if elbow == 0 else -swing)
                u = _turned(h2, theta, b)
                q2 = _angle(h2, (a[0] + u[0], a[1] + u[1], a[2] + u[2]), v)
                d = _back(arm, q1, q2 + theta, (_dot(x, h6), _dot(y, h6), _dot(z, h6)))
                m = _back(arm, q1, q2 + theta, (_dot(x, mark), _dot(y, mark), _dot(z, mark)))
                rest = min(1.0, max(-1.0, (_dot(h4, d) - tilted) / bend))
                for flip in range(2):
                    swing = math.acos(rest)
                    q5 = math.atan2(odd5, even5) + (swing if flip == 0 else -swing)
                    q4 = _angle(h4, _turned(h5, q5, h6), d)
                    seen = _turned(h5, -q5, _turned(h4, -q4, m))
                    branch = 4 * front + 2 * elbow + flip
                    q[i, branch, 0] = _wrapped(q1)
                    q[i, branch, 1] = _wrapped(q2)
                    q[i, branch, 2] = _wrapped(sense * theta)
                    q[i, branch, 3] = _wrapped(q4)
                    q[i, branch, 4] = _wrapped(q5)
                    q[i, branch, 5] = _angle(h6, mark, seen)
                    wrist[i, branch] = odd5 * math.cos(q5) - even5 * math.sin(q5)


@inlined
def _row(pose: Floats, row: int, arm: Floats, place: int) -> Vector:
    """Return a row of pose R_0^T, R_0 (3, 3) being in `arm` from `place` on."""
    a, b, c = pose[row, 0], pose[row, 1], pose[row, 2]
    return (
        a * arm[place] + b * arm[place + 1] + c * arm[place + 2],
        a * arm[place + 3] + b * arm[place + 4] + c * arm[place + 5],
        a * arm[place + 6] + b * arm[place + 7] + c * arm[place + 8],
    )


def spherical_wrist(chain: SerialChain) -> Floats:
    """Return what `inverse_many` needs of an arm (42,).

    They are the directions of its axes, p_1, p_2, p_3 and W in the base frame, W in the tip's frame, and the tip's
    rotation at position 0, all one after the other. Raises ArgumentError with what it lacks for arms of another kind.
    """
    names, count = chain.joint_names, len(chain.pre)
    own = np.array_equal(chain.q_index, np.arange(6)) and (chain.multiplier == 1.0).all() and not chain.offset.any()
    if count != 6 or len(names) != 6 or not own or (chain.joint_type != REVOLUTE).any():
        raise ArgumentError(
            f"the arm has {len(names)} joints ({', '.join(names)}); a closed form is known for six that turn, each by "
            "a coordinate of its own"
        )
    frames = chain_frames(chain, np.zeros(6))
    h = np.einsum("nij,nj->ni", frames[:6, :3, :3], chain.axis)
    p, base_t_tip = frames[:6, :3, 3], frames[6]
    if abs(h[0] @ h[1]) > ANGLE or np.linalg.norm(np.cross(h[1], h[2])) > ANGLE:
        raise ArgumentError(
            f"the axis of {names[1]!r} must be at a right angle to that of {names[0]!r} and parallel to that of "
            f"{names[2]!r}"
        )
    normal = np.cross(h[3], h[4])
    if np.linalg.norm(normal) < 0.1 or np.linalg.norm(np.cross(h[4], h[5])) < 0.1:
        raise ArgumentError(f"the axes of {names[3]!r}, {names[4]!r} and {names[5]!r} must not be parallel")
    centre = p[3] + h[3] * float(np.cross(p[4] - p[3], h[4]) @ normal) / float(normal @ normal)
    off = max(float(np.linalg.norm(np.cross(centre - point, axis))) for point, axis in zip(p[3:], h[3:], strict=True))
    if off > LENGTH:
        raise ArgumentError(
            f"the axes of {names[3]!r}, {names[4]!r} and {names[5]!r} must meet in a point, a spherical wrist; they "
            f"pass by {1e3 * off:.3g} mm from each other"
        )
    tip_t_base = base_t_tip[:3, :3].T
    within = tip_t_base @ (centre - base_t_tip[:3, 3])
    return np.concatenate([h.ravel(), p[:3].ravel(), centre, within, base_t_tip[:3, :3].ravel()])
