"""At which arm angles a pose may meet a joint limit: there, and nowhere else, solutions come and go.

Upper arm and forearm turn as sin(psi) A + cos(psi) B + C, and so does, for a joint at a given position, what is 0
there. So each position is met at no more than two arm angles for each bend of the elbow (Shimizu et al. 2008, section
IV; here without a case for each kind of joint).
"""

from __future__ import annotations

import math

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.reference import joint_motion

from virtualrobot_plugins.arm_angle.angles import all_branches

_TOLERANCE = 1e-12


def ranges_between_limits(arm: Floats, target: Floats, lower: Floats, upper: Floats) -> list[tuple[float, float]]:
    """Return the ranges of the arm angle (rad) at whose ends some joint of some branch meets a limit or half a turn.

    They cover a whole turn, in order; the last one may end beyond pi. `lower` and `upper` are limits (7,), -inf and inf
    without.
    """
    seed = np.zeros(7)
    # psi = 0, pi / 2, pi: C + B, C + A, C - B
    zero, quarter, half = (all_branches(arm, target, angle, seed)[1][:, :3, :3] for angle in (0.0, np.pi / 2, np.pi))
    constant = (zero + half) / 2.0
    terms = np.stack([quarter - constant, (zero - half) / 2.0, constant])
    ends: list[float] = []
    for side in (0, 1):
        for first, turned in ((0, terms[:, 2 * side]), (4, terms[:, 2 * side + 1])):
            axes = arm[:21].reshape(7, 3)[first : first + 3]
            for joint in range(3):
                for position in _positions(lower[first + joint], upper[first + joint]):
                    ends.extend(_zeros(*_condition(axes, turned, joint, position)))
    ends.sort()
    return [(a, b) for a, b in zip(ends, [*ends[1:], ends[0] + 2.0 * np.pi], strict=True)] if ends else []


def _positions(lower: float, upper: float) -> set[float]:
    """Return where a joint's solutions come and go, less full turns."""
    limits = {math.remainder(limit, 2.0 * math.pi) for limit in (lower, upper) if math.isfinite(limit)}
    return limits | ({math.pi} if max(-lower, upper) > math.pi else set())


def _condition(axes: Floats, turned: Floats, joint: int, position: float) -> Floats:
    """Return a, b, c: the joint (of three) is at the position where a sin + b cos + c is 0.

    With T = e_1 e_2 e_3, e_i the turn of joint i about h_i: (T h_3) . e_1 h_2 = 0, h_1 . (T - e_2) h_3 = 0, and
    (T^T h_1) . e_3^-1 h_2 = 0. `turned` (3, 3, 3) holds the terms of T.
    """
    one, two, three = axes
    if joint == 0:
        return turned @ three @ (_turn(one, position) @ two)
    if joint == 1:
        a, b, c = turned @ three @ one
        return np.array([a, b, c - one @ _turn(two, position) @ three])
    return one @ turned @ (_turn(three, -position) @ two)


def _turn(axis: Floats, angle: float) -> Floats:
    return joint_motion(1, axis, np.array(angle))[:3, :3]


def _zeros(a: float, b: float, c: float) -> list[float]:
    size = math.hypot(a, b)
    if size < _TOLERANCE or abs(c) > size:
        return []
    middle, half = math.atan2(a, b), math.acos(-c / size)
    return [math.remainder(middle + way, 2.0 * math.pi) for way in (half, -half)]
