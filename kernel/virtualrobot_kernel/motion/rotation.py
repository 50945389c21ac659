"""Rotations of poses: rotation vectors to matrices and back, exact to rounding."""

from __future__ import annotations

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.polynomial import Array


def check_pose(pose: Array, what: str) -> None:
    """Raise KernelError unless `pose` is a finite rigid transform (4, 4), to 1e-6."""
    if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
        raise KernelError(f"{what} must be a finite pose (4, 4), not {pose.tolist()}")
    rotation = pose[:3, :3]
    skewness = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skewness > 1e-6 or np.linalg.det(rotation) < 0.0 or np.abs(pose[3] - (0.0, 0.0, 0.0, 1.0)).max() > 1e-9:
        raise KernelError(f"{what} must be a rigid transform; its rotation is off by {skewness:.3g}")


def rotation_matrix(vector: Array) -> Array:
    """Return the rotation (3, 3) about `vector` (3,) by its length (Rodrigues' formula)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3) + skew(vector)
    axis = skew(vector / angle)
    return np.eye(3) + np.sin(angle) * axis + (1.0 - np.cos(angle)) * (axis @ axis)


def rotation_vector(rotation: Array) -> Array:
    """Return axis times angle (3,), angle in [0, pi], of a rotation (3, 3).

    By way of the quaternion with its largest element taken from the diagonal (Shepperd, Quaternion from Rotation
    Matrix, Journal of Guidance and Control 1978), so that it is exact to rounding at small angles and at pi.
    """
    m = rotation
    diagonal = (float(np.trace(m)), float(m[0, 0]), float(m[1, 1]), float(m[2, 2]))
    largest = int(np.argmax(diagonal))
    quaternion = np.empty(4)  # w, x, y, z, unnormalised
    if largest == 0:
        quaternion[:] = 1.0 + diagonal[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        quaternion[0] = m[k, j] - m[j, k]
        quaternion[1 + i] = 1.0 + m[i, i] - m[j, j] - m[k, k]
        quaternion[1 + j] = m[j, i] + m[i, j]
        quaternion[1 + k] = m[k, i] + m[i, k]
    if quaternion[0] < 0.0:
        quaternion = -quaternion
    length = float(np.linalg.norm(quaternion[1:]))
    if length == 0.0:
        return np.zeros(3)
    return quaternion[1:] * (2.0 * np.arctan2(length, quaternion[0]) / length)


def left_jacobian(vector: Array) -> Array:
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


def skew(v: Array) -> Array:
    """Return the matrix (3, 3) that gives v x w when applied to w."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
