"""All postures of many poses at once, in NumPy: arms of six turning joints whose axes 2, 3 and 4 are parallel.

Most arms for work beside people are of this kind. With h_i the direction of axis i, p_i a point on it and P the point
where axes 5 and 6 meet, all at position 0, and axis 2 at a right angle to axis 1: joints 2, 3 and 4 keep what P and h_6
have along h_2, so that q_1 and q_5 follow, of two values each, from a cos q + b sin q = c; what is left of the rotation
gives q_2 + q_3 + q_4 and q_6, and q_2 and q_3 bring axis 4 to its place in the plane, an elbow of two values.
(K. P. Hawkins, Analytic Inverse Kinematics for the Universal Robots UR-5/UR-10 Arms, 2013, for axes anywhere.)
"""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import REVOLUTE, Floats, SerialChain
from virtualrobot_sdk.subproblems import angle_about, axes_of, crossing, eight_postures, last_three, meeting, turned

ANGLE, LENGTH = 1e-4, 2e-5
"""Axes that are parallel, at a right angle (rad) or meet (m) up to this are meant to: model files round."""


def has_parallel_axes(chain: SerialChain) -> bool:
    """Return whether axes 2, 3 and 4 of an arm of six turning joints are parallel."""
    if len(chain.joint_type) != 6 or (chain.joint_type != REVOLUTE).any() or len(chain.joint_names) != 6:
        return False
    h = axes_of(chain)[0]
    return all(float(np.linalg.norm(np.cross(h[1], one))) <= ANGLE for one in h[2:4])


class ParallelAxes:
    """Postures of an arm whose axes 2, 3 and 4 are parallel."""

    def __init__(self, chain: SerialChain) -> None:
        """Prepare an arm; raises ArgumentError with what it lacks."""
        names = chain.joint_names
        if not np.array_equal(chain.q_index, np.arange(6)) or (chain.multiplier != 1.0).any() or chain.offset.any():
            raise ArgumentError("a closed form is known for joints that turn, each by a coordinate of its own")
        self._h, self._p, base_t_tip = axes_of(chain)
        h, p = self._h, self._p
        if abs(h[0] @ h[1]) > ANGLE:
            raise ArgumentError(f"the axis of {names[1]!r} must be at a right angle to that of {names[0]!r}")
        if min(np.linalg.norm(np.cross(a, b)) for a, b in ((h[1], h[4]), (h[4], h[5]))) < 0.1:
            raise ArgumentError(f"the axes of {names[3]!r}, {names[4]!r} and {names[5]!r} must not be parallel")
        self._meet, off = meeting(h[4:], p[4:])
        if off > LENGTH:
            raise ArgumentError(
                f"the axes of {names[4]!r} and {names[5]!r} must meet; they pass by {1e3 * off:.3g} mm from each other"
            )
        self._tip_t_base = base_t_tip[:3, :3].T
        self._within = self._tip_t_base @ (self._meet - base_t_tip[:3, 3])

    def postures(self, tips: Floats) -> tuple[Floats, Floats]:
        """Return the postures (m, 8, 6) that put the tip at poses (m, 4, 4), in -pi to pi, NaN where there is none.

        And (m, 8) how far axis 6 is from parallel to axes 2, 3 and 4, with the sense of joint 5; 0 where it is, where
        postures are singular. Limits are not looked at. Of the bits of a posture's place, the first is that of joint 1,
        then the elbow, and joint 5.
        """
        h, p = self._h, self._p
        k = h[1]
        # By axes: poses, two values of joint 1, of the elbow, of joint 5.
        turn = (tips[:, :3, :3] @ self._tip_t_base)[:, None, None, None]
        at = (tips[:, :3, 3] + tips[:, :3, :3] @ self._within - p[0])[:, None, None, None]
        senses = np.array([1.0, -1.0])
        with np.errstate(invalid="ignore", divide="ignore"):
            q1 = crossing(at @ k, at @ np.cross(h[0], k), (self._meet - p[0]) @ k, senses[:, None, None])
            q234, q5, q6, clear = last_three(h[[1, 4, 5]], lambda v: turned(h[0], -q1, turn @ v), senses)
            place = turned(h[0], -q1, at) + p[0] + turned(k, q234, p[3] - self._meet)
            upper, fore, reach = (one - (one @ k)[..., None] * k for one in (p[2] - p[1], p[3] - p[2], place - p[1]))
            level = 0.5 * (np.sum(reach**2, axis=-1) - upper @ upper - fore @ fore)
            bend = crossing(upper @ fore, upper @ np.cross(k, fore), level, senses[:, None])
            q2 = angle_about(k, upper + turned(k, bend, fore), reach)
        q3, q4 = (float(np.sign(one @ k)) * angle for one, angle in ((h[2], bend), (h[3], q234 - q2 - bend)))
        return eight_postures((q1, q2, q3, q4, q5, q6), clear)
