"""Times, headers, vectors and poses as messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import pose_from_quaternion, rows_from_poses
from virtualrobot.v1 import geometry_pb2

from virtualrobot_apps.bridges.ros.messages.types import make

RosValue: TypeAlias = Any
"""A message of ROS; each type is a class of its own."""

_LENGTH_TOLERANCE = 1e-3


def time_of(nanoseconds: int) -> RosValue:
    """Return an instant or a duration as `builtin_interfaces/Time`, from whole nanoseconds."""
    seconds, nanos = divmod(nanoseconds, 1_000_000_000)
    return make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanos)


def nanoseconds_of(time: RosValue) -> int:
    """Return the nanoseconds of a time or a duration."""
    return time.sec * 1_000_000_000 + time.nanosec


def header(nanoseconds: int, frame: str) -> RosValue:
    """Return a header with a time and a frame."""
    return make("std_msgs/msg/Header", stamp=time_of(nanoseconds), frame_id=frame)


def vector(x: float, y: float, z: float) -> RosValue:
    """Return a vector."""
    return make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def vector_of(message: geometry_pb2.Vector3) -> RosValue:
    """Return a vector of the contract."""
    return vector(message.x, message.y, message.z)


def quaternion(x: float, y: float, z: float, w: float) -> RosValue:
    """Return a quaternion."""
    return make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


def pose(row: Sequence[float]) -> RosValue:
    """Return a pose from x, y, z (m) and the quaternion x, y, z, w."""
    place = make("geometry_msgs/msg/Point", x=row[0], y=row[1], z=row[2])
    return make("geometry_msgs/msg/Pose", position=place, orientation=quaternion(*row[3:7]))


def pose_of(matrix: NDArray[np.float64]) -> RosValue:
    """Return a pose from a 4x4 matrix."""
    return pose(rows_from_poses(matrix)[0].tolist())


def matrix_of(value: RosValue, what: str = "pose") -> NDArray[np.float64]:
    """Return the 4x4 matrix of a pose; `what` is the field that the error names.

    A quaternion of zeros, as clients leave it that write JSON, turns nothing.

    Raises:
        ValueError: when it is not finite, or its quaternion is not of length 1.
    """
    place, turn = value.position, value.orientation
    xyz, xyzw = np.array([place.x, place.y, place.z]), np.array([turn.x, turn.y, turn.z, turn.w])
    if not xyzw.any():
        xyzw[3] = 1.0
    if not np.isfinite(xyz).all() or not abs(float(np.linalg.norm(xyzw)) - 1.0) < _LENGTH_TOLERANCE:
        raise ValueError(
            f"{what!r} has finite numbers and a quaternion of the length 1, not {xyz.tolist()} and {xyzw.tolist()}"
        )
    return pose_from_quaternion(xyz.tolist(), xyzw.tolist())


def twist(linear: Sequence[float], angular: Sequence[float]) -> RosValue:
    """Return a twist (m/s, rad/s)."""
    return make("geometry_msgs/msg/Twist", linear=vector(*linear), angular=vector(*angular))


def unknown_covariance(size: int) -> np.ndarray:
    """Return a covariance of zeros, which says that it is not known."""
    return np.zeros(size)


def no_estimate(size: int) -> np.ndarray:
    """Return the covariance of what is not measured at all: -1 in front (sensor_msgs/Imu)."""
    found = np.zeros(size)
    found[0] = -1.0
    return found
