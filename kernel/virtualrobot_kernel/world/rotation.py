"""Rotation matrices as quaternions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def quaternion(rotation: NDArray[np.float64]) -> tuple[float, float, float, float]:
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
