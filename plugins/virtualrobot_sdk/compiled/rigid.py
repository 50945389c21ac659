"""Steps on stacks of rigid transforms, compiled into the functions that call them, and the check of a single one.

A stack is a float64 array (m, 4, 4); each step reads and writes one entry, so that no slice is ever made.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64

from virtualrobot_sdk.compiled.cache import compiled, inlined, output_of

Stack = np.ndarray[Any, np.dtype[np.float64]]


@inlined
def multiply(a: Stack, i: int, b: Stack, j: int, out: Stack, k: int) -> None:
    """Write a[i] @ b[j] to out[k]; out[k] must be neither factor."""
    for row in range(3):
        x = a[i, row, 0]
        y = a[i, row, 1]
        z = a[i, row, 2]
        out[k, row, 0] = x * b[j, 0, 0] + y * b[j, 1, 0] + z * b[j, 2, 0]
        out[k, row, 1] = x * b[j, 0, 1] + y * b[j, 1, 1] + z * b[j, 2, 1]
        out[k, row, 2] = x * b[j, 0, 2] + y * b[j, 1, 2] + z * b[j, 2, 2]
        out[k, row, 3] = x * b[j, 0, 3] + y * b[j, 1, 3] + z * b[j, 2, 3] + a[i, row, 3]
    out[k, 3, 0] = 0.0
    out[k, 3, 1] = 0.0
    out[k, 3, 2] = 0.0
    out[k, 3, 3] = 1.0


@inlined
def copy(a: Stack, i: int, out: Stack, k: int) -> None:
    """Write a[i] to out[k]."""
    for row in range(4):
        for column in range(4):
            out[k, row, column] = a[i, row, column]


@inlined
def turn(out: Stack, k: int, x: float, y: float, z: float, angle: float) -> None:
    """Multiply out[k] from the right by the rotation by `angle` about the unit axis (x, y, z).

    Rodrigues' formula; about z, by far the most frequent axis, only two columns change.
    """
    sine = math.sin(angle)
    cosine = math.cos(angle)
    if x == 0.0 and y == 0.0:
        sine *= z
        for row in range(3):
            first = out[k, row, 0]
            second = out[k, row, 1]
            out[k, row, 0] = first * cosine + second * sine
            out[k, row, 1] = second * cosine - first * sine
        return
    versine = 1.0 - cosine
    r00 = cosine + x * x * versine
    r01 = x * y * versine - z * sine
    r02 = x * z * versine + y * sine
    r10 = x * y * versine + z * sine
    r11 = cosine + y * y * versine
    r12 = y * z * versine - x * sine
    r20 = x * z * versine - y * sine
    r21 = y * z * versine + x * sine
    r22 = cosine + z * z * versine
    for row in range(3):
        first = out[k, row, 0]
        second = out[k, row, 1]
        third = out[k, row, 2]
        out[k, row, 0] = first * r00 + second * r10 + third * r20
        out[k, row, 1] = first * r01 + second * r11 + third * r21
        out[k, row, 2] = first * r02 + second * r12 + third * r22


@inlined
def shift(out: Stack, k: int, x: float, y: float, z: float) -> None:
    """Multiply out[k] from the right by the translation (x, y, z)."""
    for row in range(3):
        out[k, row, 3] += out[k, row, 0] * x + out[k, row, 1] * y + out[k, row, 2] * z


@inlined
def turn_by_quaternion(out: Stack, k: int, x: float, y: float, z: float, w: float) -> None:
    """Multiply out[k] from the right by the rotation of the quaternion, normalised; zero is the identity."""
    norm = x * x + y * y + z * z + w * w
    if norm == 0.0:
        return
    s = 2.0 / norm
    r00 = 1.0 - s * (y * y + z * z)
    r01 = s * (x * y - z * w)
    r02 = s * (x * z + y * w)
    r10 = s * (x * y + z * w)
    r11 = 1.0 - s * (x * x + z * z)
    r12 = s * (y * z - x * w)
    r20 = s * (x * z - y * w)
    r21 = s * (y * z + x * w)
    r22 = 1.0 - s * (x * x + y * y)
    for row in range(3):
        first = out[k, row, 0]
        second = out[k, row, 1]
        third = out[k, row, 2]
        out[k, row, 0] = first * r00 + second * r10 + third * r20
        out[k, row, 1] = first * r01 + second * r11 + third * r21
        out[k, row, 2] = first * r02 + second * r12 + third * r22


@compiled(output_of(float64, 2))
def orthonormalise(pose: Stack) -> float:
    """Make the rotation of `pose` (4, 4) orthonormal in place, and return how far it was from a rigid transform.

    That is the largest entry of R^T R - I and of the last row less 0 0 0 1; inf when an entry is not finite or the
    rotation is a reflection. Above 1e-2 the pose stays as it is. Two steps R (3 I - R^T R) / 2 (A. Bjorck and C. Bowie,
    An iterative algorithm for computing the best estimate of an orthogonal matrix, SIAM J. Numer. Anal. 8, 1971).
    """
    for row in range(4):
        for column in range(4):
            if not math.isfinite(pose[row, column]):
                return math.inf
    off = max(abs(pose[3, 0]), abs(pose[3, 1]), abs(pose[3, 2]), abs(pose[3, 3] - 1.0))
    gram = np.empty((3, 3))
    rotation = np.empty((3, 3))
    for step in range(3):
        for i in range(3):
            for j in range(3):
                gram[i, j] = pose[0, i] * pose[0, j] + pose[1, i] * pose[1, j] + pose[2, i] * pose[2, j]
                rotation[i, j] = pose[i, j]
                if step == 0:
                    off = max(off, abs(gram[i, j] - (1.0 if i == j else 0.0)))
        if step == 2 or off > 1e-2:
            break
        for i in range(3):
            for j in range(3):
                value = 3.0 * rotation[i, j]
                for m in range(3):
                    value -= rotation[i, m] * gram[m, j]
                pose[i, j] = value / 2.0
    handedness = (
        pose[0, 0] * (pose[1, 1] * pose[2, 2] - pose[1, 2] * pose[2, 1])
        - pose[0, 1] * (pose[1, 0] * pose[2, 2] - pose[1, 2] * pose[2, 0])
        + pose[0, 2] * (pose[1, 0] * pose[2, 1] - pose[1, 1] * pose[2, 0])
    )
    return off if handedness > 0.0 else math.inf
