"""Compiled steps of chips: from where to where a cutter has been in each column along its axis, and what was there.

A column is a place of a grid across the axis. Each row of the grid is shifted by another part of its pitch, so that no
edge that is straight lies the same way beside all places.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float32, float64
from numpy.typing import NDArray
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

Floats = NDArray[np.float64]

GOLDEN = 0.6180339887498949
"""Part of the pitch by which a row is shifted from the one before: of all, rows come least near to each other by it."""


@inlined
def _first(row: int, begin: float, pitch: float, low: float) -> int:
    """Return the first place of a row of the grid that begins at `begin` which is not below `low`."""
    return math.ceil((low - begin) / pitch - GOLDEN * row % 1.0)


@compiled(
    *(array_of(float64, 2), float64, float64, float64, float64, float64),
    *(output_of(float32, 2), output_of(float32, 2)),
)
def cut(
    tips: Floats,
    radius: float,
    length: float,
    x0: float,
    y0: float,
    pitch: float,
    above: Any,  # noqa: ANN401 float32, which NumPy's type has no short name for
    below: Any,  # noqa: ANN401
) -> None:
    """Note where a cutter has been, which goes straight from tip to tip.

    Args:
        tips: (n, 3) across the axis, and along it.
        radius: of the cutter.
        length: of it, from the tip back.
        x0: of the grid's first column.
        y0: of its first row.
        pitch: of the grid.
        above: (rows, columns) the least place along the axis that was cut; it grows less.
        below: (rows, columns) the greatest one; it grows.
    """
    rows, columns = above.shape
    for step in range(len(tips) - 1):
        ax, ay, aw = tips[step, 0], tips[step, 1], tips[step, 2]
        bx, by, bw = tips[step + 1, 0], tips[step + 1, 1], tips[step + 1, 2]
        way = math.hypot(bx - ax, by - ay)
        ux, uy = 0.0, 0.0
        if way > 0.0:
            ux, uy = (bx - ax) / way, (by - ay) / way
        first = max(0, math.ceil((min(ay, by) - radius - y0) / pitch))
        last = min(rows - 1, math.floor((max(ay, by) + radius - y0) / pitch))
        for row in range(first, last + 1):
            y = y0 + row * pitch
            low, high = math.inf, -math.inf
            square = radius * radius - (y - ay) ** 2
            if square >= 0.0:
                low = min(low, ax - math.sqrt(square))
                high = max(high, ax + math.sqrt(square))
            square = radius * radius - (y - by) ** 2
            if square >= 0.0:
                low = min(low, bx - math.sqrt(square))
                high = max(high, bx + math.sqrt(square))
            if uy != 0.0:
                for side in (-1.0, 1.0):
                    along = (y - ay - side * radius * ux) / uy
                    if 0.0 <= along <= way:
                        x = ax - side * radius * uy + along * ux
                        low = min(low, x)
                        high = max(high, x)
            if low > high:
                continue
            begin = max(0, _first(row, x0, pitch, low))
            end = min(columns, _first(row, x0, pitch, high))
            if aw == bw or way == 0.0:
                top, bottom = min(aw, bw) - length, max(aw, bw)
                for column in range(begin, end):
                    above[row, column] = min(above[row, column], top)
                    below[row, column] = max(below[row, column], bottom)
                continue
            shift = x0 + GOLDEN * row % 1.0 * pitch
            for column in range(begin, end):
                x = shift + column * pitch
                along = (x - ax) * ux + (y - ay) * uy
                beside = (x - ax) * uy - (y - ay) * ux
                half = math.sqrt(max(0.0, radius * radius - beside * beside))
                one = aw + (bw - aw) * min(1.0, max(0.0, (along - half) / way))
                other = aw + (bw - aw) * min(1.0, max(0.0, (along + half) / way))
                above[row, column] = min(above[row, column], min(one, other) - length)
                below[row, column] = max(below[row, column], max(one, other))


@compiled(array_of(float64, 3), float64, float64, float64, *(array_of(float32, 2), array_of(float32, 2)))
def taken(
    triangles: Floats,
    x0: float,
    y0: float,
    pitch: float,
    above: Any,  # noqa: ANN401
    below: Any,  # noqa: ANN401
) -> float:
    """Return the volume of a closed body (f, 3, 3) in what was cut of each column; the grid is that of `cut`.

    What is in a column between two places is how far all the faces are along it that it goes out by, less those by
    which it comes in, each at the nearer of the two places where it is beyond.
    """
    rows, columns = above.shape
    total = 0.0
    crossing = np.empty(2)
    for face in range(len(triangles)):
        ax, ay, aw = triangles[face, 0, 0], triangles[face, 0, 1], triangles[face, 0, 2]
        bx, by, bw = triangles[face, 1, 0], triangles[face, 1, 1], triangles[face, 1, 2]
        cx, cy, cw = triangles[face, 2, 0], triangles[face, 2, 1], triangles[face, 2, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        slope_x = ((bw - aw) * (cy - ay) - (cw - aw) * (by - ay)) / area
        slope_y = ((cw - aw) * (bx - ax) - (bw - aw) * (cx - ax)) / area
        first = max(0, math.ceil((min(ay, by, cy) - y0) / pitch))
        last = min(rows - 1, math.floor((max(ay, by, cy) - y0) / pitch))
        for row in range(first, last + 1):
            y = y0 + row * pitch
            found = 0
            for edge in range(3):
                following = (edge + 1) % 3
                px, py = triangles[face, edge, 0], triangles[face, edge, 1]
                qx, qy = triangles[face, following, 0], triangles[face, following, 1]
                if (py <= y) == (qy <= y) or found == 2:
                    continue
                # From its lower end, so that both triangles at an edge have the same place on it.
                if py > qy:
                    px, py, qx, qy = qx, qy, px, py
                crossing[found] = px + (qx - px) * ((y - py) / (qy - py))
                found += 1
            if found < 2:
                continue
            begin = max(0, _first(row, x0, pitch, min(crossing[0], crossing[1])))
            end = min(columns, _first(row, x0, pitch, max(crossing[0], crossing[1])))
            shift = x0 + GOLDEN * row % 1.0 * pitch
            part = 0.0
            for column in range(begin, end):
                top, bottom = above[row, column], below[row, column]
                if top < bottom:
                    w = aw + slope_x * (shift + column * pitch - ax) + slope_y * (y - ay)
                    part += min(max(w, top), bottom) - top
            total += part if area > 0.0 else -part
    return total * pitch * pitch
