"""Poses: their products, sums and angles. A pose is p[x, y, z, rx, ry, rz], m and the rotation vector in rad."""

from __future__ import annotations

import math

import numpy as np
from virtualrobot.geometry import pose_between, rotation_from_vector, rotation_vector_of

from virtualrobot_apps.emulators.ur.kinematics import Floats, matrix_of, pose_of
from virtualrobot_apps.languages.urscript.builtin.arithmetic import number, numbers
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Pose, Value


def matrix(value: Value, name: str) -> Floats:
    """Return the matrix (4, 4) of a pose."""
    return matrix_of(np.array(numbers(value, name, 6)))


def pose(of: Floats) -> Pose:
    """Return the pose of a matrix (4, 4)."""
    return Pose(pose_of(of).tolist())


@function("pose_trans", "p_from, p_from_to")
def _pose_trans(task: object, first: Value, second: Value) -> Pose:
    """Pose that the second one is where it is given in the frame of the first one."""
    return pose(matrix(first, "p_from") @ matrix(second, "p_from_to"))


@function("pose_inv", "p_from")
def _pose_inv(task: object, value: Value) -> Pose:
    """Inverse of a pose."""
    given, made = matrix(value, "p_from"), np.eye(4)
    made[:3, :3], made[:3, 3] = given[:3, :3].T, -given[:3, :3].T @ given[:3, 3]
    return pose(made)


@function("pose_add", "p_1, p_2")
def _pose_add(task: object, first: Value, second: Value) -> Pose:
    """Pose with the sum of the positions, and the first rotation times the second."""
    one, other = matrix(first, "p_1"), matrix(second, "p_2")
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = one[:3, :3] @ other[:3, :3], one[:3, 3] + other[:3, 3]
    return pose(made)


@function("pose_sub", "p_to, p_from")
def _pose_sub(task: object, first: Value, second: Value) -> Pose:
    """Pose with the difference of the positions, and the rotation about axes of the base that leads to the first."""
    one, other = matrix(first, "p_to"), matrix(second, "p_from")
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = one[:3, :3] @ other[:3, :3].T, one[:3, 3] - other[:3, 3]
    return pose(made)


@function("point_dist", "p_from, p_to")
def _point_dist(task: object, first: Value, second: Value) -> float:
    """Distance of the positions of two poses (m)."""
    return math.dist(numbers(first, "p_from", 6)[:3], numbers(second, "p_to", 6)[:3])


@function("interpolate_pose", "p_from, p_to, alpha")
def _interpolate_pose(task: object, first: Value, second: Value, share: Value) -> Pose:
    """Pose between two, at the share alpha of the line, and of the turn about one axis."""
    return pose(pose_between(matrix(first, "p_from"), matrix(second, "p_to"), number(share, "alpha")))


@function("rpy2rotvec", "rpy_vector")
def _rpy2rotvec(task: object, angles: Value) -> list[float]:
    """Rotation vector of roll, pitch and yaw, which turn about the fixed axes x, y and z one after the other."""
    made = np.eye(3)
    for axis, angle in zip(np.eye(3), numbers(angles, "rpy_vector", 3), strict=True):
        made = rotation_from_vector(angle * axis) @ made
    return rotation_vector_of(made).tolist()


@function("rotvec2rpy", "rotation_vector")
def _rotvec2rpy(task: object, vector: Value) -> list[float]:
    """Roll, pitch and yaw of a rotation vector."""
    turned = rotation_from_vector(np.array(numbers(vector, "rotation_vector", 3)))
    flat = math.hypot(turned[0, 0], turned[1, 0])
    pitch = math.atan2(-turned[2, 0], flat)
    if flat < 1e-9:  # the axes of roll and yaw are one: all of it is roll
        return [math.atan2(-turned[1, 2], turned[1, 1]), pitch, 0.0]
    return [math.atan2(turned[2, 1], turned[2, 2]), pitch, math.atan2(turned[1, 0], turned[0, 0])]
