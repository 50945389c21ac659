"""Rays in packets of 16, traced by compiled code without the GIL.

A packet is Embree's RTCRayHit16: rows of 16 numbers of 4 bytes, a lane for each ray; of a library built for deeper
instances it has more rows at its end.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import boolean, float32, float64, int32, uint64

from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of
from virtualrobot_sdk.embree.foreign import call
from virtualrobot_sdk.embree.quadrics import FLAT, nearest
from virtualrobot_sdk.ray_checks import UNIT

LANES = 16
_ORIGIN, _NEAREST, _DIRECTION, _TIME, _FARTHEST, _MASK, _ID, _FLAGS = 0, 3, 4, 7, 8, 9, 10, 11
_NORMAL, _U, _V, _PRIMITIVE, _GEOMETRY, _INSTANCE = 12, 15, 16, 17, 18, 19
_ROWS = 32
"""More than any library's packet has."""
_NONE = np.uint32(0xFFFFFFFF)
_LINE = 64
"""Bytes to which packets must be aligned."""
_BUNDLE = np.float32(0.95)
"""Cosine of the angle within which a packet's directions make it a bundle: measured, there the ways cost the same."""
_BUNDLE_ORIGINS = np.float32(0.5**2)
"""Square of the distance within which its origins must be (m^2)."""
_REFINED = 1e-3
"""Largest distance of a hit in double precision from the one in single (m), and as much again per m of distance."""
_ARGUMENTS = np.uint64(40)
"""Bytes of RTCIntersectArguments and of RTCOccludedArguments."""

Array = np.ndarray[Any, np.dtype[Any]]


@inlined
def _aligned(rows: int) -> Array:
    """Return a packet of this many rows: float32 (rows, 16), aligned."""
    room = np.empty(rows * LANES + _LINE // 4, np.float32)
    start = (-room.ctypes.data % _LINE) // 4
    return room[start : start + rows * LANES].reshape(rows, LANES)


@inlined
def _load(packet: Array, integers: Array, valid: Array, origins: Array, directions: Array, start: int) -> int:
    """Write the rays from row `start` on to the lanes of a packet and return how many there are, up to 16.

    Lanes beyond the last ray repeat it and are not valid.
    """
    count, last = min(LANES, len(directions) - start), len(directions) - 1
    step = 1 if len(origins) > 1 else 0
    # Loops over all lanes here and below: the compiler takes them at once.
    for j in range(LANES):
        i = min(start + j, last)
        packet[_ORIGIN, j] = origins[step * i, 0]
        packet[_ORIGIN + 1, j] = origins[step * i, 1]
        packet[_ORIGIN + 2, j] = origins[step * i, 2]
        packet[_DIRECTION, j] = directions[i, 0]
        packet[_DIRECTION + 1, j] = directions[i, 1]
        packet[_DIRECTION + 2, j] = directions[i, 2]
    if start == 0 or count < LANES:
        for j in range(LANES):
            valid[0, j] = -1 if j < count else 0
            packet[_NEAREST, j] = 0.0
            packet[_TIME, j] = 0.0
            integers[_MASK, j] = _NONE
            integers[_ID, j] = j
            integers[_FLAGS, j] = 0
    return count


@inlined
def _is_bundle(packet: Array) -> bool:
    """Tell whether a packet's rays go along with each other: then tracing them together is faster than each alone."""
    apart = 0
    x, y, z = packet[_DIRECTION, 0], packet[_DIRECTION + 1, 0], packet[_DIRECTION + 2, 0]
    for j in range(LANES):
        cosine = x * packet[_DIRECTION, j] + y * packet[_DIRECTION + 1, j] + z * packet[_DIRECTION + 2, j]
        apart += not cosine > _BUNDLE
    x, y, z = packet[_ORIGIN, 0], packet[_ORIGIN + 1, 0], packet[_ORIGIN + 2, 0]
    for j in range(LANES):
        a, b, c = packet[_ORIGIN, j] - x, packet[_ORIGIN + 1, j] - y, packet[_ORIGIN + 2, j] - z
        apart += not a * a + b * b + c * c < _BUNDLE_ORIGINS
    return apart == 0


@inlined
def _refine(
    e: int,
    i: int,
    origins: Array,
    directions: Array,
    poses: Array,
    surfaces: Array,
    max_range: float,
    distance: Array,
    normal: Array,
) -> None:
    """Write ray i's hit of the curved element e in double precision.

    Embree takes a ray into the frame of an instance in single precision. Where a ray touches the surface so closely
    that in double precision it misses, what Embree found stays.
    """
    o = i if len(origins) > 1 else 0
    x = origins[o, 0] - poses[e, 0, 3]
    y = origins[o, 1] - poses[e, 1, 3]
    z = origins[o, 2] - poses[e, 2, 3]
    dx = np.float64(directions[i, 0])
    dy = np.float64(directions[i, 1])
    dz = np.float64(directions[i, 2])
    t, a, b, c = nearest(
        *(surfaces[e, 0], surfaces[e, 1], surfaces[e, 2]),
        poses[e, 0, 0] * x + poses[e, 1, 0] * y + poses[e, 2, 0] * z,
        poses[e, 0, 1] * x + poses[e, 1, 1] * y + poses[e, 2, 1] * z,
        poses[e, 0, 2] * x + poses[e, 1, 2] * y + poses[e, 2, 2] * z,
        poses[e, 0, 0] * dx + poses[e, 1, 0] * dy + poses[e, 2, 0] * dz,
        poses[e, 0, 1] * dx + poses[e, 1, 1] * dy + poses[e, 2, 1] * dz,
        poses[e, 0, 2] * dx + poses[e, 1, 2] * dy + poses[e, 2, 2] * dz,
        *(0.0, max_range),
    )
    if abs(t - distance[i]) <= _REFINED * (1.0 + distance[i]):
        distance[i] = t
        for axis in range(3):
            normal[i, axis] = poses[e, axis, 0] * a + poses[e, axis, 1] * b + poses[e, axis, 2] * c


@inlined
def _trace(
    intersect: int,
    scene: int,
    arguments: int,
    origins: Array,
    directions: Array,
    max_range: float,
    rotations: Array,
    poses: Array,
    surfaces: Array,
    distance: Array,
    element: Array,
    triangle: Array,
    uv: Array,
    normal: Array,
    turned: bool,
) -> None:
    """Do what `trace` says, with rays and answers in single or double precision; `uv` may be empty.

    Where `turned`, normals are turned to the rays' origins.
    """
    packet = _aligned(_ROWS)
    integers = packet.view(np.uint32)
    valid = _aligned(1).view(np.int32)
    farthest = np.float32(max_range)
    has_uv = len(uv) > 0
    lengths = np.empty(LANES, np.float32)
    for start in range(0, len(directions), LANES):
        count = _load(packet, integers, valid, origins, directions, start)
        for j in range(LANES):
            packet[_FARTHEST, j] = farthest
            integers[_GEOMETRY, j] = _NONE
            integers[_INSTANCE, j] = _NONE
        how = arguments + _ARGUMENTS if _is_bundle(packet) else arguments
        call(intersect, np.uint64(valid.ctypes.data), scene, np.uint64(packet.ctypes.data), how)
        # Of lanes that meet nothing, these are any numbers.
        for j in range(LANES):
            a = packet[_NORMAL, j]
            b = packet[_NORMAL + 1, j]
            c = packet[_NORMAL + 2, j]
            length = np.float32(math.sqrt(a * a + b * b + c * c))
            packet[_NORMAL, j] = a / length
            packet[_NORMAL + 1, j] = b / length
            packet[_NORMAL + 2, j] = c / length
            lengths[j] = length
        for j in range(count):
            i = start + j
            # Of a packet in which a hit is found and given up again only the geometry is reset.
            if integers[_GEOMETRY, j] == _NONE or packet[_FARTHEST, j] > max_range:
                distance[i] = np.inf
                element[i] = -1
                triangle[i] = -1
                if has_uv:
                    uv[i, 0] = 0.0
                    uv[i, 1] = 0.0
                normal[i, 0] = 0.0
                normal[i, 1] = 0.0
                normal[i, 2] = 0.0
                continue
            e = integers[_INSTANCE, j]
            distance[i] = packet[_FARTHEST, j]
            element[i] = e
            triangle[i] = integers[_PRIMITIVE, j]
            if has_uv:
                uv[i, 0] = packet[_U, j]
                uv[i, 1] = packet[_V, j]
            if lengths[j] > 1e-30:
                a = packet[_NORMAL, j]
                b = packet[_NORMAL + 1, j]
                c = packet[_NORMAL + 2, j]
                normal[i, 0] = rotations[e, 0] * a + rotations[e, 1] * b + rotations[e, 2] * c
                normal[i, 1] = rotations[e, 3] * a + rotations[e, 4] * b + rotations[e, 5] * c
                normal[i, 2] = rotations[e, 6] * a + rotations[e, 7] * b + rotations[e, 8] * c
            else:  # so small a triangle that its normal is lost in single precision
                for axis in range(3):
                    normal[i, axis] = -directions[i, axis]
            if surfaces[e, 0] != FLAT:
                triangle[i] = -1
                _refine(e, i, origins, directions, poses, surfaces, max_range, distance, normal)
            if turned:
                slope = normal[i, 0] * directions[i, 0]
                slope += normal[i, 1] * directions[i, 1] + normal[i, 2] * directions[i, 2]
                if slope > 0.0:
                    for axis in range(3):
                        normal[i, axis] = -normal[i, axis]


@compiled(
    *(uint64, uint64, uint64, array_of(float32, 2), array_of(float32, 2), float64),
    *(array_of(float32, 2), array_of(float64, 3), array_of(float64, 2)),
    *(output_of(float32, 1), output_of(int32, 1), output_of(int32, 1), output_of(float32, 2), output_of(float32, 2)),
)
def trace(
    intersect: int,
    scene: int,
    arguments: int,
    origins: Array,
    directions: Array,
    max_range: float,
    rotations: Array,
    poses: Array,
    surfaces: Array,
    distance: Array,
    element: Array,
    triangle: Array,
    uv: Array,
    normal: Array,
) -> None:
    """Write the first hits of n rays within `max_range` (m) to `distance` and the arrays after it.

    Args:
        intersect: address of rtcIntersect16.
        scene: the scene.
        arguments: address of two RTCIntersectArguments: for rays anywhere, and for those that go along with each other.
        origins: (n, 3), or (1, 3) for all, in meters.
        directions: (n, 3), unit vectors.
        max_range: the greatest distance that counts; may be inf.
        rotations: (e, 9) of the elements, row by row.
        poses: (e, 4, 4) of the elements.
        surfaces: (e, 3) of the elements, as `surface_of` returns it.
        distance: (n,), see `Traced` for these.
        element: (n,)
        triangle: (n,)
        uv: (n, 2)
        normal: (n, 3)
    """
    _trace(
        *(intersect, scene, arguments, origins, directions, max_range, rotations, poses, surfaces),
        *(distance, element, triangle, uv, normal, False),
    )


@compiled(
    *(uint64, uint64, uint64, array_of(float64, 2), array_of(float64, 2), float64),
    *(array_of(float32, 2), array_of(float64, 3), array_of(float64, 2)),
    *(output_of(float64, 1), output_of(int32, 1), output_of(int32, 1), output_of(float64, 2)),
)
def trace_hits(
    intersect: int,
    scene: int,
    arguments: int,
    origins: Array,
    directions: Array,
    max_range: float,
    rotations: Array,
    poses: Array,
    surfaces: Array,
    distance: Array,
    element: Array,
    triangle: Array,
    normal: Array,
) -> None:
    """Do what `trace` does with rays in double precision, and turn the normals (n, 3) to the rays' origins."""
    _trace(
        *(intersect, scene, arguments, origins, directions, max_range, rotations, poses, surfaces),
        *(distance, element, triangle, np.empty((0, 2), np.float32), normal, True),
    )


@compiled(array_of(float64, 2), array_of(float64, 2))
def are_rays(origins: Array, directions: Array) -> bool:
    """Return whether origins and directions (n, 3) are finite, and the directions of unit length."""
    wrong = 0  # counted, for a loop that is left in its middle does one ray at a time
    for i in range(len(directions)):
        squared = directions[i, 0] ** 2 + directions[i, 1] ** 2 + directions[i, 2] ** 2
        # The error of the square is twice that of the length; what is not finite compares as false.
        wrong += not (abs(squared - 1.0) <= 2.0 * UNIT)
    for i in range(len(origins)):
        wrong += not (abs(origins[i, 0]) + abs(origins[i, 1]) + abs(origins[i, 2]) < np.inf)
    return wrong == 0


@compiled(
    *(uint64, uint64, uint64, array_of(float32, 2), array_of(float32, 2), array_of(float32, 1), output_of(boolean, 1))
)
def trace_shadows(
    occluded: int, scene: int, arguments: int, origins: Array, directions: Array, distances: Array, is_occluded: Array
) -> None:
    """Write to `is_occluded` (n,) whether each ray meets anything within its own `distances` (n,) in meters.

    `occluded` is the address of rtcOccluded16; for the other arguments see `trace`.
    """
    packet = _aligned(_ROWS)
    integers = packet.view(np.uint32)
    valid = _aligned(1).view(np.int32)
    for start in range(0, len(directions), LANES):
        count = _load(packet, integers, valid, origins, directions, start)
        for j in range(count):
            packet[_FARTHEST, j] = distances[start + j]
        how = arguments + _ARGUMENTS if _is_bundle(packet) else arguments
        call(occluded, np.uint64(valid.ctypes.data), scene, np.uint64(packet.ctypes.data), how)
        for j in range(count):
            is_occluded[start + j] = packet[_FARTHEST, j] == -np.inf
