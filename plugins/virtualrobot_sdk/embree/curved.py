"""Curved surfaces as a geometry of ours in Embree: where it bounds them and meets them it calls compiled code.

Each of the three functions gets the address of a struct of rtcore_geometry.h: RTCBoundsFunctionArguments,
RTCIntersectFunctionNArguments and RTCOccludedFunctionNArguments. Of the surface they get what `surface_of` returns.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core.types import uint64, void
from numba.np.numpy_support import carray

from virtualrobot_sdk.compiled.cache import callback, inlined
from virtualrobot_sdk.embree.foreign import pointer
from virtualrobot_sdk.embree.quadrics import CAPSULE, SPHERE, nearest

Array = np.ndarray[Any, np.dtype[Any]]

_ORIGIN, _NEAREST, _DIRECTION, _FARTHEST = 0, 3, 4, 8
_NORMAL, _U, _V, _PRIMITIVE, _GEOMETRY, _INSTANCE, _ROWS = 12, 15, 16, 17, 18, 19, 20
_ROOM = 1.0 + 1e-6
"""Factor by which boxes are larger than what they bound, since rays are tested on them in single precision."""


@inlined
def _lane(surface: Array, rays: Array, j: int) -> tuple[float, float, float, float]:
    """Return what `nearest` does, of lane j of a packet."""
    return nearest(
        *(surface[0], surface[1], surface[2]),
        *(np.float64(rays[_ORIGIN, j]), np.float64(rays[_ORIGIN + 1, j]), np.float64(rays[_ORIGIN + 2, j])),
        *(np.float64(rays[_DIRECTION, j]), np.float64(rays[_DIRECTION + 1, j]), np.float64(rays[_DIRECTION + 2, j])),
        *(np.float64(rays[_NEAREST, j]), np.float64(rays[_FARTHEST, j])),
    )


@callback(void(uint64))
def bound(arguments: int) -> None:
    """Write the box around a surface: least and greatest x, y, z, each followed by a number without meaning."""
    fields = carray(pointer(arguments), 3, np.uint64)
    surface = carray(pointer(fields[0]), 3, np.float64)
    box = carray(pointer(fields[2]), 8, np.float32)
    radius = surface[1] * _ROOM
    along = surface[2] / 2.0 * _ROOM
    if surface[0] == SPHERE:
        along = radius
    elif surface[0] == CAPSULE:
        along += radius
    for axis in range(3):
        reach = along if axis == 2 else radius
        box[axis] = -reach
        box[4 + axis] = reach


@callback(void(uint64))
def intersect(arguments: int) -> None:
    """Write the first hit of each lane of a packet that is marked, where it is nearer than what was hit before."""
    fields = carray(pointer(arguments), 6, np.uint64)
    count = int(np.int64(fields[5] & np.uint64(0xFFFFFFFF)))
    valid = carray(pointer(fields[0]), count, np.int32)
    surface = carray(pointer(fields[1]), 3, np.float64)
    instance = carray(pointer(fields[3]), 1, np.uint32)
    rays = carray(pointer(fields[4]), (_ROWS, count), np.float32)
    integers = carray(pointer(fields[4]), (_ROWS, count), np.uint32)
    for j in range(count):
        if valid[j] == 0:
            continue
        t, a, b, c = _lane(surface, rays, j)
        if t < np.inf:
            rays[_FARTHEST, j] = t
            rays[_NORMAL, j] = a
            rays[_NORMAL + 1, j] = b
            rays[_NORMAL + 2, j] = c
            rays[_U, j] = 0.0
            rays[_V, j] = 0.0
            integers[_PRIMITIVE, j] = 0
            integers[_GEOMETRY, j] = 0
            integers[_INSTANCE, j] = instance[0]


@callback(void(uint64))
def occlude(arguments: int) -> None:
    """Mark each marked lane of a packet that meets the surface, by -inf as its end."""
    fields = carray(pointer(arguments), 6, np.uint64)
    count = int(np.int64(fields[5] & np.uint64(0xFFFFFFFF)))
    valid = carray(pointer(fields[0]), count, np.int32)
    surface = carray(pointer(fields[1]), 3, np.float64)
    rays = carray(pointer(fields[4]), (_FARTHEST + 1, count), np.float32)
    for j in range(count):
        if valid[j] == 0:
            continue
        t, _, _, _ = _lane(surface, rays, j)
        if t < np.inf:
            rays[_FARTHEST, j] = -np.inf
