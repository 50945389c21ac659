"""Frames of RAPID: poses of millimetres and quaternions q1 (real) to q4, and the 4x4 matrices of the kernel."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from virtualrobot.geometry import Matrix, pose_from_quaternion, quaternion_of

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.support import linked, not_normalized


def unit(rotation: list[float]) -> list[float]:
    """Return an orientation of length 1; one that is not nearly so is refused."""
    if said := not_normalized(rotation):
        raise RapidFault("ERR_ARGVALERR", said)
    length = math.hypot(*rotation)
    return [one / length for one in rotation]


def rotated(rotation: list[float], vector: list[float]) -> list[float]:
    """Return a vector that is given in a frame of this orientation."""
    w, x, y, z = unit(rotation)
    turned = linked(linked([w, x, y, z], [0.0, *vector]), [w, -x, -y, -z])
    return turned[1:]


def product(first: list[Any], second: list[Any]) -> list[Any]:
    """Return a pose that is given in another one."""
    offset = rotated(first[1], second[0])
    return [[a + b for a, b in zip(first[0], offset, strict=True)], linked(unit(first[1]), unit(second[1]))]


def inverse(pose: list[Any]) -> list[Any]:
    """Return the inverse of a pose."""
    w, x, y, z = unit(pose[1])
    back = [w, -x, -y, -z]
    return [[-one for one in rotated(back, pose[0])], back]


def to_quaternion(z: float, y: float, x: float) -> list[float]:
    """Return the orientation that is turned by degrees about z, then its y, then its x."""
    turn = [1.0, 0.0, 0.0, 0.0]
    for axis, angle in ((3, z), (2, y), (1, x)):
        half = math.radians(angle) / 2.0
        one = [math.cos(half), 0.0, 0.0, 0.0]
        one[axis] = math.sin(half)
        turn = linked(turn, one)
    return turn


def to_euler_zyx(rotation: list[float]) -> tuple[float, float, float]:
    """Return the turns in degrees about z, y and x that `to_quaternion` takes; about x it is 0 where y is 90 or -90."""
    w, x, y, z = unit(rotation)
    sine = max(-1.0, min(1.0, 2.0 * (w * y - z * x)))
    if abs(sine) > 1.0 - 1e-12:
        about_z = math.copysign(1.0, sine) * -2.0 * math.atan2(x, w)
        return math.degrees(about_z), math.degrees(math.asin(sine)), 0.0
    about_z = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    about_x = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return math.degrees(about_z), math.degrees(math.asin(sine)), math.degrees(about_x)


def matrix_of(pose: list[Any]) -> Matrix:
    """Return a pose of RAPID as a 4x4 matrix in meters."""
    (x, y, z), (w, i, j, k) = pose[0], unit(pose[1])
    return pose_from_quaternion([x / 1000.0, y / 1000.0, z / 1000.0], [i, j, k, w])


def pose_of(matrix: Matrix) -> list[Any]:
    """Return a 4x4 matrix as a pose of RAPID."""
    i, j, k, w = quaternion_of(matrix).tolist()
    return [(1000.0 * np.asarray(matrix)[:3, 3]).tolist(), [w, i, j, k]]
