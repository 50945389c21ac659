"""Poses and rotations: matrices, quaternions x y z w, rotation vectors, roll pitch yaw. Kernel and plugins share them.

Poses are rigid transforms (4, 4), rotations (3, 3); angles are in radians. Quaternions have length 1.
"""

from __future__ import annotations

import math

import numpy as np

from virtualrobot_sdk.kinematics import Floats


def inverse(pose: Floats) -> Floats:
    """Return the inverse of a rigid transform, shape (4, 4)."""
    result = np.eye(4)
    result[:3, :3] = pose[:3, :3].T
    result[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return result


def from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Floats:
    """Return Rz(yaw) Ry(pitch) Rx(roll), (3, 3)."""
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def from_quaternion(xyzw: Floats) -> Floats:
    """Return the rotation matrix (3, 3) of a unit quaternion x, y, z, w."""
    x, y, z, w = xyzw
    matrix = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return matrix + 0.0  # no -0.0: equal rotations have equal bits


def quaternion(rotation: Floats) -> tuple[float, float, float, float]:
    """Return the unit quaternion x, y, z, w with w >= 0 of a rotation matrix (3, 3).

    Shepperd, Quaternion from rotation matrix (1978): the largest of four squares is the pivot, so that no division is
    by a small number. In plain floats, because one matrix at a time is what most messages need.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    trace = xx + yy + zz
    if trace >= max(xx, yy, zz):
        x, y, z, w = zy - yz, xz - zx, yx - xy, 1.0 + trace
    elif xx >= max(yy, zz):
        x, y, z, w = 1.0 + xx - yy - zz, yx + xy, zx + xz, zy - yz
    elif yy >= zz:
        x, y, z, w = yx + xy, 1.0 + yy - zz - xx, zy + yz, xz - zx
    else:
        x, y, z, w = zx + xz, zy + yz, 1.0 + zz - xx - yy, yx - xy
    scale = math.copysign(1.0 / math.sqrt(x * x + y * y + z * z + w * w), w)
    return x * scale, y * scale, z * scale, w * scale


def rotation_matrix(vector: Floats) -> Floats:
    """Return the rotation (3, 3) about `vector` (3,) by its length (Rodrigues' formula)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3) + skew(vector)
    axis = skew(vector / angle)
    return np.eye(3) + np.sin(angle) * axis + (1.0 - np.cos(angle)) * (axis @ axis)


def rotation_vector(rotation: Floats) -> Floats:
    """Return axis times angle (3,), angle in [0, pi], of a rotation (3, 3).

    By way of the quaternion, so that it is exact to rounding at small angles and at pi.
    """
    x, y, z, w = quaternion(rotation)
    length = math.hypot(x, y, z)
    return np.zeros(3) if length == 0.0 else np.array([x, y, z]) * (2.0 * math.atan2(length, w) / length)


def left_jacobian(vector: Floats) -> Floats:
    """Return J (3, 3) with angular velocity = J d(vector)/dt of the rotation about `vector` (3,) by its length.

    Source: Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2 (2012), section 10.8.6.
    """
    angle = float(np.linalg.norm(vector))
    cross = skew(vector)
    if angle < 1e-2:
        square = angle * angle
        first, second = 0.5 - square / 24.0 + square**2 / 720.0, 1.0 / 6.0 - square / 120.0 + square**2 / 5040.0
    else:
        first, second = (1.0 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    return np.eye(3) + first * cross + second * (cross @ cross)


def skew(v: Floats) -> Floats:
    """Return the matrix (3, 3) that gives v x w when applied to w."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
