"""Geometry of arms that have an arm angle: check of their axes, and their numbers for the compiled code."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, SerialChain

from virtualrobot_plugins.closed_form.geometry import ANGLE, Axes, axes_of, check_own_joints, idealised, upright_frames
from virtualrobot_plugins.closed_form.model import NAMED, NUMBERS, Model

JOINTS = 7
MEETING = 1e-9
"""Axes that pass each other by less than this (m) meet."""
SHOULDER, WRIST = (0, 1, 2), (4, 5, 6)


def arm_of(chain: SerialChain) -> tuple[Floats, Axes]:
    """Return the compiled code's numbers (42,) of an arm, and its axes as they were meant.

    The numbers: directions of the axes (7, 3), shoulder S, from S to elbow E, from E to wrist W, W in the tip's frame,
    all at position 0, and the transpose of the tip's rotation there (3, 3).

    Raises ArgumentError unless joints 1 to 3 turn about axes that meet in S, 5 to 7 about axes that meet in W, each at
    a right angle to the next, and axis 4 is parallel to axis 2 where joint 3 is at 0, with W beside neither.
    """
    if len(chain.joint_names) != JOINTS:
        raise ArgumentError(
            f"the arm has {len(chain.joint_names)} joints that move freely; an arm angle is for seven",
            joints=len(chain.joint_names),
        )
    check_own_joints(chain)
    axes, _ = idealised(axes_of(chain))
    h, names = axes.direction, chain.joint_names
    centres = []
    for what, joints in (("shoulder", SHOULDER), ("wrist", WRIST)):
        for first, second in pairwise(joints):
            if abs(h[first] @ h[second]) > ANGLE:
                raise _refused(f"the axes of {names[first]} and {names[second]} are not at a right angle")
        centre, off = _meeting(axes, joints)
        if off > MEETING:
            listed = ", ".join(names[i] for i in joints)
            raise _refused(f"the {what} is not spherical: the axes of {listed} pass by {off * 1e3:.3g} mm")
        centres.append(centre)
    s, w = centres
    if abs(abs(h[1] @ h[3]) - 1.0) > ANGLE:
        raise _refused(f"at position 0 the axes of {names[1]} and {names[3]} are not parallel")
    if abs((w - s) @ h[1]) > MEETING:
        raise _refused("at position 0 the wrist is beside the plane of the upper arm")
    # Where axis 4 crosses the plane of the arm.
    e = axes.point[3] + ((s - axes.point[3]) @ h[1]) * h[1]
    upper, fore = float(np.linalg.norm(e - s)), float(np.linalg.norm(w - e))
    if min(upper, fore) < 1e-3:
        raise _refused(f"upper arm and forearm are {upper * 1e3:.3g} and {fore * 1e3:.3g} mm long")
    tip = axes.base_t_tip[:3, :3]
    numbers = np.concatenate([h.ravel(), s, e - s, w - e, tip.T @ (w - axes.base_t_tip[:3, 3]), tip.T.ravel()])
    return numbers, axes


def model_of(chain: SerialChain, axes: Axes, numbers: Floats, reach: float) -> Model:
    """Return what the compiled code of `closed_form` needs to tell the branches apart.

    The first three numbers are where joints 2, 4 and 6 are straight, nearest to 0: their signs are those of the sine of
    the way from there.
    """
    h = axes.direction
    upper, fore = numbers[24:27], numbers[27:30]
    straight = [
        _angle_about(h[1], h[2], h[0]),
        _angle_about(h[3], fore, upper),
        _angle_about(h[5], h[6], h[4]),
    ]
    head = np.zeros(NUMBERS)
    head[:3] = [angle - np.pi * np.round(angle / np.pi) for angle in straight]
    head[4] = 1.0 / reach if reach > 0.0 else 1.0
    return Model(np.concatenate([head, np.ravel(upright_frames(chain))]), 0, 0, NAMED)


def _angle_about(axis: Floats, vector: Floats, onto: Floats) -> float:
    """Return by how much a vector is turned about an axis at a right angle to both until it points along `onto`."""
    return float(np.arctan2(np.cross(vector, onto) @ axis, vector @ onto))


def _meeting(axes: Axes, joints: tuple[int, ...]) -> tuple[Floats, float]:
    """Return the point nearest to some axes in the sense of least squares, and its greatest distance from one (m)."""
    across = [np.eye(3) - np.outer(axes.direction[i], axes.direction[i]) for i in joints]
    points = [axes.point[i] for i in joints]
    right = sum((p @ point for p, point in zip(across, points, strict=True)), np.zeros(3))
    centre = np.linalg.solve(sum(across, np.zeros((3, 3))), right)
    off = max(float(np.linalg.norm(p @ (centre - point))) for p, point in zip(across, points, strict=True))
    return np.asarray(centre, np.float64), off


def _refused(why: str) -> ArgumentError:
    return ArgumentError(f"the arm has no arm angle: {why}")
