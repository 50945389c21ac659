"""Light that arrives at a place, and the rays that tell whether something is in the way; compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float32, int32, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

POINT, SPOT, DIRECTIONAL, SKY = 1, 2, 3, 4
"""Codes of lights. A sky shines from a whole half of the world: all of it on what faces it, half on what stands across
and none on what is turned away; two opposite ones light everything alike."""
LIGHT_FIELDS = 12
"""Of a row of lights: code; place; direction; red, green, blue; cosines of the angles where a spot's light ends, and
where it begins to fade."""

Array = np.ndarray[Any, np.dtype[Any]]


@inlined
def arriving(lights: Array, k: int, x: float, y: float, z: float) -> tuple[float, float, float, float, float]:
    """Return the unit vector from (x, y, z) to light k, the distance, and the part of its strength that arrives."""
    if lights[k, 0] == DIRECTIONAL or lights[k, 0] == SKY:
        return -lights[k, 4], -lights[k, 5], -lights[k, 6], np.inf, 1.0
    a, b, c = lights[k, 1] - x, lights[k, 2] - y, lights[k, 3] - z
    distance = math.sqrt(a * a + b * b + c * c)
    if distance < 1e-6:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    a, b, c = a / distance, b / distance, c / distance
    strength = 1.0 / (distance * distance)
    if lights[k, 0] == SPOT:
        cosine = -(a * lights[k, 4] + b * lights[k, 5] + c * lights[k, 6])
        if cosine <= lights[k, 10]:
            return a, b, c, distance, 0.0
        if cosine < lights[k, 11]:
            part = (cosine - lights[k, 10]) / (lights[k, 11] - lights[k, 10])
            strength *= part * part * (3.0 - 2.0 * part)
    return a, b, c, distance, strength


@compiled(
    *(array_of(float32, 2), int64, array_of(float32, 2), array_of(float32, 2), array_of(float32, 1)),
    *(array_of(int32, 1), array_of(float32, 2)),
    *(output_of(float32, 2), output_of(float32, 2), output_of(float32, 1)),
)
def toward(
    lights: Array,
    k: int,
    origins: Array,
    directions: Array,
    distance: Array,
    element: Array,
    normal: Array,
    starts: Array,
    along: Array,
    until: Array,
) -> None:
    """Write the rays from what n rays met towards light k: a hair above the surface, on the side that was seen.

    `starts` (n, 3), `along` (n, 3) and `until` (n,) are the results; where there is nothing to light `until` is -1.
    """
    for i in range(len(directions)):
        until[i] = -1.0
        for axis in range(3):
            starts[i, axis] = 0.0
            along[i, axis] = 0.0
        along[i, 2] = 1.0
        if element[i] < 0:
            continue
        facing = 0.0
        for axis in range(3):
            facing -= directions[i, axis] * normal[i, axis]
        side = 1.0 if facing >= 0.0 else -1.0
        hair = side * 1e-4 * (1.0 + distance[i])
        x = origins[i, 0] + directions[i, 0] * distance[i] + hair * normal[i, 0]
        y = origins[i, 1] + directions[i, 1] * distance[i] + hair * normal[i, 1]
        z = origins[i, 2] + directions[i, 2] * distance[i] + hair * normal[i, 2]
        a, b, c, far, strength = arriving(lights, k, x, y, z)
        if strength <= 0.0 or side * (a * normal[i, 0] + b * normal[i, 1] + c * normal[i, 2]) <= 0.0:
            continue
        starts[i, 0], starts[i, 1], starts[i, 2] = x, y, z
        along[i, 0], along[i, 1], along[i, 2] = a, b, c
        until[i] = far
