"""Compiled steps of a film: which triangles a jet meets from each place of a gun, and how much of it each one takes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import boolean, float32, float64, int64
from numpy.typing import NDArray
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def cells_of(centres: Floats, edge: float) -> tuple[Integers, Integers, Floats, Integers]:
    """Return a grid of cells with triangles in it by their middles (f, 3).

    Returns:
        starts: (cells + 1,) the row of `faces` at which each cell begins, z fastest.
        faces: (f,) triangles, cell by cell.
        origin: (3,) of the first cell.
        shape: (3,) how many cells there are along each axis.
    """
    origin = centres.min(axis=0)
    places = ((centres - origin) / edge).astype(np.int64)
    shape = places.max(axis=0) + 1
    keys = (places[:, 0] * shape[1] + places[:, 1]) * shape[2] + places[:, 2]
    faces = np.argsort(keys, kind="stable")
    starts = np.searchsorted(keys[faces], np.arange(int(shape.prod()) + 1))
    return starts.astype(np.int64), faces.astype(np.int64), origin, shape


@compiled(
    *(array_of(float64, 3), array_of(float64, 1), int64, array_of(float64, 2), array_of(float64, 2)),
    *(array_of(int64, 1), array_of(int64, 1), array_of(float64, 1), array_of(int64, 1), float64),
    *(float64, float64, float64, output_of(int64, 1), output_of(float64, 1)),
    *(output_of(float32, 2), output_of(float32, 2), output_of(float32, 1)),
)
def meet(
    places: Floats,
    volumes: Floats,
    first: int,
    centres: Floats,
    normals: Floats,
    starts: Integers,
    faces: Integers,
    origin: Floats,
    shape: Integers,
    edge: float,
    slope: float,
    nearest: float,
    deepest: float,
    met: Integers,
    thickness: Floats,
    eyes: Any,  # noqa: ANN401 float32, which NumPy's type has no short name for
    rays: Any,  # noqa: ANN401
    lengths: Any,  # noqa: ANN401
) -> tuple[int, int]:
    """Write what a jet meets from places (n, 4, 4) that each spray a volume (n,), from the place `first` on.

    Nothing is before anything here. It goes on while there is room for all triangles. In a plane across the jet's axis
    the paint falls on a disc, as a parabola over its diameter; of that plane a triangle takes as much more as it faces
    the ray than the plane does.

    Args:
        places: of the gun, z along the jet.
        volumes: what leaves the gun at each.
        first: the first place.
        centres: (f, 3) middles of the triangles.
        normals: (f, 3)
        starts: see `cells_of`.
        faces: as above.
        origin: as above.
        shape: as above.
        edge: of a cell.
        slope: radius of the disc by its distance.
        nearest: distance from which on there is paint.
        deepest: distance to which there is.
        met: (m,) triangles, written.
        thickness: (m,) what each takes.
        eyes: (m, 3) where the ray to each begins.
        rays: (m, 3) its direction, of length 1.
        lengths: (m,) how far the triangle is.

    Returns:
        count: how many were written.
        next: the first place that was not looked at.
    """
    count = 0
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    for row in range(first, len(places)):
        begin = count
        reach = slope * deepest
        for axis in range(3):
            here = places[row, axis, 3]
            there = here + deepest * places[row, axis, 2]
            # The disc at the end leans against an axis by what the jet goes along it.
            wide = reach * math.sqrt(max(0.0, 1.0 - places[row, axis, 2] ** 2))
            low[axis] = max(0, math.floor((min(here, there - wide) - origin[axis]) / edge))
            high[axis] = min(shape[axis] - 1, math.floor((max(here, there + wide) - origin[axis]) / edge))
        if low[2] > high[2]:
            continue
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                cell = (i * shape[1] + j) * shape[2]
                for place in range(starts[cell + low[2]], starts[cell + high[2] + 1]):
                    face = faces[place]
                    x = centres[face, 0] - places[row, 0, 3]
                    y = centres[face, 1] - places[row, 1, 3]
                    z = centres[face, 2] - places[row, 2, 3]
                    depth = x * places[row, 0, 2] + y * places[row, 1, 2] + z * places[row, 2, 2]
                    if depth <= nearest or depth >= deepest:
                        continue
                    square = x * x + y * y + z * z
                    radius = (slope * depth) ** 2
                    off = (square - depth * depth) / radius
                    if off >= 1.0:
                        continue
                    facing = -(x * normals[face, 0] + y * normals[face, 1] + z * normals[face, 2])
                    if facing <= 0.0:
                        continue
                    if count == len(met):
                        return begin, row
                    length = math.sqrt(square)
                    met[count] = face
                    thickness[count] = volumes[row] * 2.0 / (math.pi * radius) * (1.0 - off) * facing / depth
                    eyes[count, 0] = places[row, 0, 3]
                    eyes[count, 1] = places[row, 1, 3]
                    eyes[count, 2] = places[row, 2, 3]
                    rays[count, 0] = x / length
                    rays[count, 1] = y / length
                    rays[count, 2] = z / length
                    lengths[count] = length
                    count += 1
    return count, len(places)


@compiled(output_of(float64, 1), int64, array_of(int64, 1), array_of(float64, 1), array_of(boolean, 1))
def add(total: Floats, count: int, met: Integers, thickness: Floats, hidden: NDArray[np.bool_]) -> None:
    """Add what the first `count` triangles take to the `total` of each, but of those that are hidden."""
    for row in range(count):
        if not hidden[row]:
            total[met[row]] += thickness[row]
