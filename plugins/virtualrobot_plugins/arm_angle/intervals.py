"""Arm angles at which a pose may meet a joint limit: there, and nowhere else, solutions come and go.

Upper arm and forearm turn as sin(psi) A + cos(psi) B + C, and so does, for a joint at a given position, what is 0
there. So each position is met at no more than two arm angles for each bend of the elbow (Shimizu et al. 2008, section
IV; here without a case for each kind of joint).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.reference import joint_motion

from virtualrobot_plugins.arm_angle.angles import all_branches

_TOLERANCE = 1e-12


class Meetings(NamedTuple):
    """Linear conditions of m joint positions: weights times turn, less the constant, is 0 where the joint is there."""

    weights: Floats
    """(m, 9) factors of the entries of the turn, a rotation matrix, row by row."""
    constants: Floats
    """(m,) value of that product at the joint's position."""
    is_wrist: np.ndarray
    """(m,) true: the turn is that of the forearm by joints 5 to 7; false: that of the upper arm by joints 1 to 3."""


def meetings_of(arm: Floats, lower: Floats, upper: Floats) -> Meetings:
    """Return what tells where joints are at their limits (7,), -inf and inf without, or half a turn beyond one."""
    rows = []
    for first in (0, 4):
        axes = arm[:21].reshape(7, 3)[first : first + 3]
        for joint in range(3):
            for position in sorted(_positions(lower[first + joint], upper[first + joint])):
                rows.append((*_condition(axes, joint, position), first > 0))
    weights, constants, is_wrist = zip(*rows, strict=True) if rows else ((), (), ())
    return Meetings(np.array(weights).reshape(-1, 9), np.array(constants), np.array(is_wrist, bool))


def ranges_between_limits(arm: Floats, meetings: Meetings, target: Floats) -> list[tuple[float, float]]:
    """Return the ranges of the arm angle (rad) at whose ends some joint of some branch meets a limit or half a turn.

    They cover a whole turn, in order; the last one may end beyond pi.
    """
    seed = np.zeros(7)
    # psi = 0, pi / 2, pi: C + B, C + A, C - B
    zero, quarter, half = (
        all_branches(arm, target, angle, seed)[1][:, :3, :3].reshape(4, 9) for angle in (0.0, np.pi / 2, np.pi)
    )
    constant = (zero + half) / 2.0
    terms = quarter - constant, (zero - half) / 2.0, constant
    ends: list[Floats] = []
    for side in (0, 2):
        upper, fore = ([term[place] for term in terms] for place in (side, side + 1))
        a, b, c = np.where(
            meetings.is_wrist[:, None], meetings.weights @ np.array(fore).T, meetings.weights @ np.array(upper).T
        ).T
        c = c - meetings.constants
        size = np.hypot(a, b)
        met = (size > _TOLERANCE) & (np.abs(c) <= size)
        middle, way = np.arctan2(a[met], b[met]), np.arccos(-c[met] / size[met])
        ends += [middle + way, middle - way]
    every = np.sort(np.mod(np.concatenate(ends) + np.pi, 2.0 * np.pi) - np.pi).tolist()
    return [(a, b) for a, b in zip(every, [*every[1:], every[0] + 2.0 * np.pi], strict=True)] if every else []


def _positions(lower: float, upper: float) -> set[float]:
    """Return where a joint's solutions come and go, less full turns."""
    limits = {math.remainder(limit, 2.0 * math.pi) for limit in (lower, upper) if math.isfinite(limit)}
    return limits | ({math.pi} if max(-lower, upper) > math.pi else set())


def _condition(axes: Floats, joint: int, position: float) -> tuple[Floats, float]:
    """Return weights (9,) of T and a constant: the joint (of three) is at the position where they make 0.

    With T = e_1 e_2 e_3, e_i the turn of joint i about h_i: (T h_3) . e_1 h_2 = 0, h_1 . (T - e_2) h_3 = 0, and
    (T^T h_1) . e_3^-1 h_2 = 0.
    """
    one, two, three = axes
    if joint == 0:
        return np.outer(_turn(one, position) @ two, three).ravel(), 0.0
    if joint == 1:
        return np.outer(one, three).ravel(), float(one @ _turn(two, position) @ three)
    return np.outer(one, _turn(three, -position) @ two).ravel(), 0.0


def _turn(axis: Floats, angle: float) -> Floats:
    return joint_motion(1, axis, np.array(angle))[:3, :3]
