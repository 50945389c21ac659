"""All postures of many poses at once, in NumPy: arms of six turning joints whose axes meet at both ends.

They meet in twos at one end and in threes at the other. Such is an arm of seven joints, one of which is held: the third
of one whose axes 1, 2, 3 and 5, 6, 7 meet as those of a shoulder and a wrist; the seventh where only axes 1, 2, 3 meet,
and 5 and 6. With h_i the direction of axis i, p_i a point on it, S the point where axes 1 and 2 meet and W that of axes
4, 5 and 6, all at position 0: joint 3 brings W to its distance from S, joints 1 and 2 bring it to its place, and joints
4, 5 and 6 are what is left of the rotation. Each of the three steps has two values: subproblems 3, 2 and 2 of B. Paden,
Kinematics and Control Robot Manipulators, 1986. An arm with the three axes first is solved from its tip.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import REVOLUTE, Floats, SerialChain
from virtualrobot_sdk.parallel_axes import LENGTH
from virtualrobot_sdk.subproblems import angle_about, axes_of, crossing, eight_postures, last_three, meeting, turned

SENSES = np.array([1.0, -1.0])


class MeetingAxes:
    """Postures of an arm of which axes 1 and 2 meet, and 4, 5 and 6; or 5 and 6, and 1, 2 and 3."""

    def __init__(self, chain: SerialChain) -> None:
        """Prepare an arm; raises ArgumentError with what it lacks."""
        names = chain.joint_names
        own = np.array_equal(chain.q_index, np.arange(6)) and (chain.multiplier == 1.0).all() and not chain.offset.any()
        if len(names) != 6 or not own or (chain.joint_type != REVOLUTE).any():
            raise ArgumentError("a closed form is known for six joints that turn, each by a coordinate of its own")
        h, p, base_t_tip = axes_of(chain)
        centres = _centres(h, p)
        self._reversed = centres is None
        if centres is None:
            turn = base_t_tip[:3, :3]
            h, p = -(h @ turn)[::-1], ((p - base_t_tip[:3, 3]) @ turn)[::-1]
            base_t_tip = np.linalg.inv(base_t_tip)
            centres = _centres(h, p)
        if centres is None:
            raise ArgumentError(
                f"the axes of {names[0]!r} and {names[1]!r} must meet in a point, and those of {names[3]!r}, "
                f"{names[4]!r} and {names[5]!r}, or the same from the other end"
            )
        self._h, self._p = h, p
        self._shoulder, self._wrist = centres
        self._tip_t_base = base_t_tip[:3, :3].T
        self._within = self._tip_t_base @ (self._wrist - base_t_tip[:3, 3])

    def postures(self, tips: Floats) -> tuple[Floats, Floats]:
        """Return the postures (m, 8, 6) that put the tip at poses (m, 4, 4), in -pi to pi, NaN where there is none.

        And (m, 8) how far axes 4, 5 and 6 (or 3, 2 and 1) are from one plane; 0 where they are in one, where postures
        are singular. Limits are not looked at. Of the bits of a posture's place, the first is that of joint 3 (4), then
        of joints 1 and 2 (6 and 5), and of joint 5 (2).
        """
        if self._reversed:
            turns = np.swapaxes(tips[:, :3, :3], 1, 2)
            tips = np.concatenate([turns, -(turns @ tips[:, :3, 3:])], axis=2)
        h, p = self._h, self._p
        # By axes: poses, two values of joint 3, of joints 1 and 2 together, of joint 5.
        turn = (tips[:, :3, :3] @ self._tip_t_base)[:, None, None, None]
        reach = (tips[:, :3, 3] + tips[:, :3, :3] @ self._within - self._shoulder)[:, None, None, None]
        with np.errstate(invalid="ignore", divide="ignore"):
            q3 = self._bent(reach)
            bent = p[2] + turned(h[2], q3, self._wrist - p[2]) - self._shoulder
            between = self._between(bent, reach)
            q2, q1 = angle_about(h[1], bent, between), angle_about(h[0], between, reach)

            def back(v: Floats) -> Floats:
                return turned(h[2], -q3, turned(h[1], -q2, turned(h[0], -q1, v)))

            q4, q5, q6, clear = last_three(h[3:], lambda v: back(turn @ v), SENSES)
        found, clear = eight_postures((q1, q2, q3, q4, q5, q6), clear)
        return (found[..., ::-1] if self._reversed else found), clear

    def _bent(self, reach: Floats) -> Floats:
        """Return q_3 that brings W as far from S as its place is, two values each."""
        h, u, v = self._h[2], self._wrist - self._p[2], self._shoulder - self._p[2]
        across = u - (u @ h) * h
        level = 0.5 * (u @ u + v @ v - np.sum(reach**2, axis=-1)) - float(u @ h) * float(v @ h)
        even, odd = np.array(across @ v), np.array(np.cross(h, across) @ v)
        return crossing(even, odd, level, SENSES[:, None, None])

    def _between(self, bent: Floats, reach: Floats) -> Floats:
        """Return where joint 2 turns `bent` so that joint 1 turns it to `reach`, both seen from S, two values each."""
        first, second = self._h[0], self._h[1]
        normal, cosine = np.cross(first, second), float(first @ second)
        level, height = bent @ second, reach @ first
        a, b = (cosine * level - height) / (cosine**2 - 1.0), (cosine * height - level) / (cosine**2 - 1.0)
        rest = (np.sum(bent**2, axis=-1) - a**2 - b**2 - 2.0 * a * b * cosine) / float(normal @ normal)
        scale = np.maximum(np.sum(bent**2, axis=-1), 1e-12)
        aside = SENSES[:, None] * np.sqrt(np.where(rest > -1e-12 * scale, np.maximum(rest, 0.0), np.nan))
        return a[..., None] * first + b[..., None] * second + aside[..., None] * normal


def _centres(h: Floats, p: Floats) -> tuple[Floats, Floats] | None:
    """Return where the first two and the last three axes (6, 3) through points (6, 3) meet, or None."""
    shoulder, wrist = _meeting(h[:2], p[:2]), _meeting(h[3:], p[3:])
    return None if shoulder is None or wrist is None else (shoulder, wrist)


def _meeting(h: Floats, p: Floats) -> Floats | None:
    """Return where axes (m, 3) through points (m, 3) meet, None where they don't, or one is along the next."""
    if min(float(np.linalg.norm(np.cross(a, b))) for a, b in pairwise(h)) < 0.1:
        return None
    centre, off = meeting(h, p)
    return centre if off <= LENGTH else None
