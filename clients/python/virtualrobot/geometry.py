"""Poses as 4x4 arrays: `a_t_b` takes coordinates given in frame b to frame a.

Meters, radians, quaternions x, y, z, w.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot.errors import InvalidArgumentError

Matrix: TypeAlias = NDArray[np.float64]

MOST_ANGLE = 4.0 * np.pi
"""Greatest angle (rad) that is taken for meant, and not for one in degrees."""


@checked
def pose(
    x: float = 0.0, y: float = 0.0, z: float = 0.0, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0
) -> Matrix:
    """Return a 4x4 pose from a position in meters and angles in radians.

    As in URDF the angles turn about the fixed axes x (roll), then y (pitch), then z (yaw).

    Raises:
        InvalidArgumentError: for what is not finite, and for an angle of more than two turns, which is one in degrees.

    Example:
        >>> pose(0.5, 0.0, 0.3, roll=np.pi)     # half a meter ahead, the tool pointing down
    """
    values = np.array([x, y, z, roll, pitch, yaw], dtype=float)
    if not np.isfinite(values).all():
        raise InvalidArgumentError(f"a pose needs finite numbers, not {values.tolist()}")
    for name, angle in zip(("roll", "pitch", "yaw"), values[3:].tolist(), strict=True):
        if abs(angle) > MOST_ANGLE:
            raise InvalidArgumentError(
                f"{name}={angle:g} is {abs(angle) / (2.0 * np.pi):.3g} turns: degrees? use math.radians({angle:g}); of "
                f"what has turned so far give math.remainder({angle:g}, math.tau)"
            )
    (cr, cp, cy), (sr, sp, sy) = np.cos(values[3:]), np.sin(values[3:])
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, x],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, y],
            [-sp, cp * sr, cp * cr, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


@checked
def pose_from_quaternion(position: Sequence[float], quaternion: Sequence[float]) -> Matrix:
    """Return a 4x4 pose from a position (3,) in meters and a quaternion x, y, z, w of any length but zero."""
    vector, turn = np.asarray(position, dtype=float), np.asarray(quaternion, dtype=float)
    if vector.shape != (3,) or turn.shape != (4,):
        raise InvalidArgumentError(
            f"a pose needs a position of 3 numbers and a quaternion of 4, not {vector.shape} and {turn.shape}"
        )
    return poses_from_rows(np.concatenate([vector, turn])[None])[0]


def poses_from_rows(rows: ArrayLike) -> Matrix:
    """Return (n, 4, 4) poses from (n, 7) rows x, y, z in meters and quaternion x, y, z, w."""
    rows = np.asarray(rows, dtype=float).reshape(-1, 7)
    length = np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    if not np.isfinite(rows).all() or (length < 1e-12).any():
        raise InvalidArgumentError("a pose needs finite numbers and a quaternion that is not zero")
    x, y, z, w = (rows[:, 3:] / length).T
    poses = np.zeros((len(rows), 4, 4))
    poses[:, 0, 0], poses[:, 0, 1], poses[:, 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    poses[:, 1, 0], poses[:, 1, 1], poses[:, 1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    poses[:, 2, 0], poses[:, 2, 1], poses[:, 2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    poses[:, :3, 3], poses[:, 3, 3] = rows[:, :3], 1.0
    return poses


def rows_from_poses(poses: ArrayLike) -> Matrix:
    """Return (n, 7) rows x, y, z in meters and unit quaternion x, y, z, w (w not negative) of (n, 4, 4) poses."""
    poses = np.asarray(poses, dtype=float).reshape(-1, 4, 4)
    return np.concatenate([poses[:, :3, 3], np.array([quaternion_of(pose) for pose in poses]).reshape(-1, 4)], axis=1)


@checked
def quaternion_of(matrix: ArrayLike) -> Matrix:
    """Return the unit quaternion x, y, z, w (w not negative) of a 4x4 pose or 3x3 rotation.

    Source: S. W. Shepperd, Quaternion from Rotation Matrix, 1978: divide by the largest of the four components.
    """
    r = np.asarray(matrix, dtype=float)[:3, :3]
    trace = np.trace(r)
    candidates = np.array([r[0, 0], r[1, 1], r[2, 2], trace])
    largest = int(np.argmax(candidates))
    if largest == 3:
        q = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1.0 + trace])
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        q = np.empty(4)
        q[i], q[j], q[k] = 1.0 - trace + 2.0 * r[i, i], r[j, i] + r[i, j], r[k, i] + r[i, k]
        q[3] = r[k, j] - r[j, k]
    q /= np.linalg.norm(q)
    return -q if q[3] < 0 else q


@checked
def roll_pitch_yaw_of(matrix: ArrayLike) -> Matrix:
    """Return roll, pitch, yaw in radians of a 4x4 pose or 3x3 rotation; roll is 0 where pitch is +-90 degrees.

    They are those of `pose`: pose(*position, *roll_pitch_yaw_of(m)) gives m again.
    """
    r = np.asarray(matrix, dtype=float)
    cosine = np.hypot(r[0, 0], r[1, 0])
    pitch = np.arctan2(-r[2, 0], cosine)
    if cosine < 1e-9:
        return np.array([0.0, pitch, np.arctan2(-r[0, 1], r[1, 1])])
    yaw = np.arctan2(r[1, 0], r[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    # Of Rz(-yaw) r, so that it makes up for a yaw that rounding decides, near +-90 degrees of pitch.
    roll = np.arctan2(s * r[0, 2] - c * r[1, 2], c * r[1, 1] - s * r[0, 1])
    return np.array([roll, pitch, yaw])


def rotation_from_vector(vector: ArrayLike) -> Matrix:
    """Return the rotation (3, 3) about a vector (3,) by its length (rad), by O. Rodrigues' formula."""
    x, y, z = np.asarray(vector, dtype=float)
    angle = math.hypot(x, y, z)
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # sin(angle) / angle, and that of the half, by which (1 - cos(angle)) / angle^2 is told: neither has a gap at 0.
    whole, half = float(np.sinc(angle / np.pi)), float(np.sinc(0.5 * angle / np.pi))
    return np.eye(3) + whole * across + 0.5 * half**2 * across @ across


def rotation_vector_of(matrix: ArrayLike) -> Matrix:
    """Return axis times angle (3,), the angle 0 to pi (rad), of a 4x4 pose or 3x3 rotation.

    By way of the quaternion, so that it is exact to rounding at small angles and at half a turn.
    """
    x, y, z, w = quaternion_of(matrix)
    length = math.hypot(x, y, z)
    return np.array([x, y, z]) * (2.0 * math.atan2(length, w) / length if length else 0.0)


def turn_between(first: Matrix, second: Matrix) -> float:
    """Return the angle (rad), 0 to pi, by which two poses (4, 4) or rotations (3, 3) are turned against each other."""
    turn = first[:3, :3].T @ second[:3, :3]
    # By both sine and cosine: each alone loses half of the digits somewhere.
    sine = math.hypot(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
    return math.atan2(sine, float(np.trace(turn)) - 1.0)


def pose_between(first: Matrix, second: Matrix, share: float) -> Matrix:
    """Return the pose (4, 4) at a share of the way from one to another: on the line, turned evenly about one axis.

    Source: K. Shoemake, Animating rotation with quaternion curves, SIGGRAPH 1985 (slerp).
    """
    found = np.eye(4)
    turn = rotation_vector_of(second[:3, :3] @ first[:3, :3].T)
    found[:3, :3] = rotation_from_vector(share * turn) @ first[:3, :3]
    found[:3, 3] = (1.0 - share) * first[:3, 3] + share * second[:3, 3]
    return found


def checked_pose(value: ArrayLike) -> Matrix:
    """Return `value` as a 4x4 float64 pose.

    Raises:
        InvalidArgumentError: when it is not 4x4, not finite, or no rigid transform to 1e-6.
    """
    try:
        matrix = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InvalidArgumentError(f"a pose is a 4x4 array, not {value!r}; see virtualrobot.pose()") from None
    if matrix.shape != (4, 4):
        raise InvalidArgumentError(f"a pose is a 4x4 array, not one of shape {matrix.shape}; see virtualrobot.pose()")
    if len(bad := np.argwhere(~np.isfinite(matrix))):
        row, column = bad[0].tolist()
        raise InvalidArgumentError(f"a pose has finite numbers, not {matrix[row, column]} at [{row}, {column}]")
    rotation = matrix[:3, :3]
    if (
        np.abs(matrix[3] - (0, 0, 0, 1)).max() > 1e-9
        or np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-6
        or np.linalg.det(rotation) < 0
    ):
        raise InvalidArgumentError(
            f"a pose needs an orthonormal right-handed rotation and the last row 0 0 0 1, not\n{matrix}"
        )
    return matrix
