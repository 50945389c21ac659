"""The passes over all rays of a scan: into the world, and from hits to what a sensor model is told."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import boolean, float32, float64, int32, int64, uint8
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of
from virtualrobot_sdk.compiled.rigid import multiply

Floats = np.ndarray[Any, np.dtype[np.float64]]
Singles = np.ndarray[Any, np.dtype[np.float32]]
Integers = np.ndarray[Any, np.dtype[np.int32]]
Bytes = np.ndarray[Any, np.dtype[np.uint8]]
Booleans = np.ndarray[Any, np.dtype[np.bool_]]

Rows = np.ndarray[Any, np.dtype[np.int64]]

SLACK = 1e-6
"""Largest difference of a normal's length from 1."""


@compiled(array_of(float64, 3), array_of(int64, 1), array_of(float64, 3), output_of(float64, 3))
def composed(world_t_node: Floats, rows: Rows, node_t_element: Floats, world_t_element: Floats) -> None:
    """Set `world_t_element` (e, 4, 4) to the poses of elements that hang on the nodes of `rows` (e,)."""
    for i in range(rows.shape[0]):
        multiply(world_t_node, rows[i], node_t_element, i, world_t_element, i)


@compiled(
    array_of(float64, 2), array_of(float64, 2), array_of(float64, 2), output_of(float64, 2), output_of(float64, 2)
)
def placed(pose: Floats, origins: Floats, directions: Floats, starts: Floats, along: Floats) -> None:
    """Set `starts` and `along` (n, 3) to rays in the frame that the sensor is at `pose` (4, 4) in.

    `origins` is (n, 3), or (1, 3) for all rays, in the sensor's frame, as `directions` (n, 3).
    """
    # Held in registers: the compiler cannot know that what is written is not `pose`.
    xx, xy, xz, px = pose[0, 0], pose[0, 1], pose[0, 2], pose[0, 3]
    yx, yy, yz, py = pose[1, 0], pose[1, 1], pose[1, 2], pose[1, 3]
    zx, zy, zz, pz = pose[2, 0], pose[2, 1], pose[2, 2], pose[2, 3]
    single = origins.shape[0] == 1
    for i in range(directions.shape[0]):
        o = 0 if single else i
        x, y, z = origins[o, 0], origins[o, 1], origins[o, 2]
        starts[i, 0] = xx * x + xy * y + xz * z + px
        starts[i, 1] = yx * x + yy * y + yz * z + py
        starts[i, 2] = zx * x + zy * y + zz * z + pz
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        along[i, 0] = xx * x + xy * y + xz * z
        along[i, 1] = yx * x + yy * y + yz * z
        along[i, 2] = zx * x + zy * y + zz * z


@compiled(
    array_of(float64, 2),
    array_of(float64, 1),
    array_of(int32, 1),
    array_of(float64, 2),
    array_of(float64, 1),
    output_of(float64, 1),
    output_of(float64, 1),
)
def looked_at(
    directions: Floats,
    distance: Floats,
    element: Integers,
    normal: Floats,
    reflectance_of: Floats,
    incidence: Floats,
    reflectance: Floats,
) -> int:
    """Set what a sensor model is told of n hits, and look whether they make sense.

    Args:
        directions: (n, 3) unit vectors of the rays.
        distance: (n,) in meters.
        element: (n,) rows of `reflectance_of`; -1 where a ray hits nothing.
        normal: (n, 3) as `Hits` has it, in the frame of the directions.
        reflectance_of: (e,) of each element.
        incidence: (n,) out: angle between ray and normal (rad), 0 to pi/2; 0 where a ray hits nothing.
        reflectance: (n,) out: 0 where a ray hits nothing.

    Returns the first ray whose hit makes no sense, -1 where all do: a distance that is NaN or below 0, infinite where
    there is an element or finite where there is none; an element that is not there; a normal that is not of unit length
    (to 1e-6) and turned to the ray's origin, or not 0 at a miss.

    The angle is by the polynomial 4.4.46 of M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 1964: to
    2e-8 rad, in a tenth of the time.
    """
    count, n = reflectance_of.shape[0], distance.shape[0]
    first = n
    # Loops that are never left, of few arrays each: the compiler takes several rays at once.
    for i in range(n):
        x, y, z = normal[i, 0], normal[i, 1], normal[i, 2]
        e, away = element[i], distance[i]
        squared = x * x + y * y + z * z
        cosine = -(directions[i, 0] * x + directions[i, 1] * y + directions[i, 2] * z)
        missed = (e == -1) & (away == np.inf) & (abs(x) + abs(y) + abs(z) == 0.0)
        # Written so that NaN, which compares as false, counts as wrong.
        met = (e >= 0) & (e < count) & (away >= 0.0) & (away < np.inf)
        met &= (abs(squared - 1.0) <= 2.0 * SLACK) & (cosine >= -SLACK)
        first = min(first, n if missed | met else i)
        incidence[i] = 1.0 if missed else min(max(cosine, 0.0), 1.0)
    if first < n:
        return first
    for i in range(n):
        c = incidence[i]
        p = -0.0012624911 * c + 0.0066700901
        p = p * c - 0.0170881256
        p = p * c + 0.0308918810
        p = p * c - 0.0501743046
        p = p * c + 0.0889789874
        p = p * c - 0.2145988016
        p = p * c + 1.5707963050
        incidence[i] = min(np.sqrt(1.0 - c) * p, 0.5 * np.pi)
    for i in range(n):
        reflectance[i] = reflectance_of[element[i]] if element[i] >= 0 else 0.0
    return -1


@compiled(
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(boolean, 1),
    array_of(int32, 2),
    array_of(int32, 1),
    output_of(float32, 1),
    output_of(float32, 1),
    output_of(uint8, 1),
    output_of(int32, 1),
)
def told(
    distance: Floats,
    intensity: Floats,
    valid: Booleans,
    element: Integers,
    node_of: Integers,
    distances: Singles,
    intensities: Singles,
    valids: Bytes,
    nodes: Integers,
) -> int:
    """Set what a reading tells of n beams from what the model says, and look whether that makes sense.

    Args:
        distance: (n,) in meters, as `Readings` has it; so `intensity` and `valid`.
        intensity: (n,) 0 to 1.
        valid: (n,).
        element: (n, k) of each beam's rays; the first one's is told.
        node_of: (e,) of each element, what is told of it.
        distances: (n,) out.
        intensities: (n,) out.
        valids: (n,) out, 1 or 0.
        nodes: (n,) out: -1 where the first ray hits nothing.

    Returns the first beam whose reading makes no sense, -1 where all do: a distance that is NaN or below 0, a valid one
    that is not finite, an intensity that is not from 0 to 1.
    """
    n = distance.shape[0]
    first = n
    for i in range(n):
        right = (distance[i] >= 0.0) & ((distance[i] < np.inf) | (not valid[i]))
        right &= (intensity[i] >= 0.0) & (intensity[i] <= 1.0)
        first = min(first, n if right else i)
    if first < n:
        return first
    for i in range(n):
        distances[i] = distance[i]
        intensities[i] = intensity[i]
    for i in range(n):
        valids[i] = 1 if valid[i] else 0
        row = element[i, 0]
        nodes[i] = node_of[row] if row >= 0 else -1
    return -1


@compiled(
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float64, 2),
    array_of(float32, 1),
    array_of(uint8, 1),
    output_of(float32, 2),
)
def points_of(
    pose: Floats, origins: Floats, directions: Floats, distances: Singles, valids: Bytes, points: Singles
) -> None:
    """Set `points` (n, 3) to where echoes come from, in the frame that the sensor is at `pose` (4, 4) in; NaN if none.

    `origins` is (n, 3) or (1, 3) in the sensor's frame, as `directions` (n, 3); `distances` (n,) count where `valids`
    (n,) is 1.
    """
    single = origins.shape[0] == 1
    for i in range(distances.shape[0]):
        if valids[i] == 0:
            points[i, 0] = points[i, 1] = points[i, 2] = np.nan
            continue
        o = 0 if single else i
        x = origins[o, 0] + distances[i] * directions[i, 0]
        y = origins[o, 1] + distances[i] * directions[i, 1]
        z = origins[o, 2] + distances[i] * directions[i, 2]
        for j in range(3):
            points[i, j] = pose[j, 0] * x + pose[j, 1] * y + pose[j, 2] * z + pose[j, 3]
