"""Error between two poses: translation and rotation vector, compiled into the functions that call it."""

from __future__ import annotations

import math

from virtualrobot_sdk.compiled.cache import inlined
from virtualrobot_sdk.kinematics import Floats


@inlined
def rotation_vector(
    r00: float, r01: float, r02: float, r10: float, r11: float, r12: float, r20: float, r21: float, r22: float
) -> tuple[float, float, float]:
    """Return axis times angle (rad, 0 to pi) of a rotation matrix given by its entries.

    The way leads over the quaternion, up to a factor, whose largest component is computed first, so that no angle
    loses digits, pi included (S. W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control, 1978).
    """
    trace = r00 + r11 + r22
    if trace > 0.0:
        w = 1.0 + trace
        x = r21 - r12
        y = r02 - r20
        z = r10 - r01
    elif r00 >= r11 and r00 >= r22:
        w = r21 - r12
        x = 1.0 + r00 - r11 - r22
        y = r01 + r10
        z = r02 + r20
    elif r11 >= r22:
        w = r02 - r20
        x = r01 + r10
        y = 1.0 + r11 - r00 - r22
        z = r12 + r21
    else:
        w = r10 - r01
        x = r02 + r20
        y = r12 + r21
        z = 1.0 + r22 - r00 - r11
    if w < 0.0:
        w = -w
        x = -x
        y = -y
        z = -z
    sine = math.sqrt(x * x + y * y + z * z)
    factor = 2.0 / w if sine < 1e-9 * w else 2.0 * math.atan2(sine, w) / sine
    return factor * x, factor * y, factor * z


@inlined
def pose_error(target: Floats, frames: Floats, k: int, error: Floats) -> None:
    """Write what takes frames[k] to `target` (4, 4) to `error` (6,): translation (m), then rotation vector (rad)."""
    f = frames
    t = target
    error[0] = t[0, 3] - f[k, 0, 3]
    error[1] = t[1, 3] - f[k, 1, 3]
    error[2] = t[2, 3] - f[k, 2, 3]
    error[3], error[4], error[5] = rotation_vector(
        t[0, 0] * f[k, 0, 0] + t[0, 1] * f[k, 0, 1] + t[0, 2] * f[k, 0, 2],
        t[0, 0] * f[k, 1, 0] + t[0, 1] * f[k, 1, 1] + t[0, 2] * f[k, 1, 2],
        t[0, 0] * f[k, 2, 0] + t[0, 1] * f[k, 2, 1] + t[0, 2] * f[k, 2, 2],
        t[1, 0] * f[k, 0, 0] + t[1, 1] * f[k, 0, 1] + t[1, 2] * f[k, 0, 2],
        t[1, 0] * f[k, 1, 0] + t[1, 1] * f[k, 1, 1] + t[1, 2] * f[k, 1, 2],
        t[1, 0] * f[k, 2, 0] + t[1, 1] * f[k, 2, 1] + t[1, 2] * f[k, 2, 2],
        t[2, 0] * f[k, 0, 0] + t[2, 1] * f[k, 0, 1] + t[2, 2] * f[k, 0, 2],
        t[2, 0] * f[k, 1, 0] + t[2, 1] * f[k, 1, 1] + t[2, 2] * f[k, 1, 2],
        t[2, 0] * f[k, 2, 0] + t[2, 1] * f[k, 2, 1] + t[2, 2] * f[k, 2, 2],
    )
