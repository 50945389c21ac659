"""Lines, discs and the grid of the floor, drawn over a picture where no surface is in front of them; compiled.

A pixel is a square about its middle (column, row). What is drawn covers it by how far it reaches beyond that middle,
so that edges are smooth. Along a line the inverse of the depth is linear in the picture.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float32, float64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

Array = np.ndarray[Any, np.dtype[Any]]

BIAS = 0.003
"""Distance behind a surface, in parts of the depth, up to which strokes are seen: so are those that lie on it."""


@inlined
def _blend(picture: Array, row: int, column: int, color: Array, opacity: float) -> None:
    for channel in range(3):
        before = picture[row, column, channel]
        picture[row, column, channel] = before + opacity * (color[channel] - before)


@compiled(
    *(output_of(float32, 3), array_of(float32, 2), array_of(float64, 3), array_of(float32, 2), array_of(float64, 1)),
    float64,
)
def draw_lines(picture: Array, depth: Array, ends: Array, colors: Array, widths: Array, bias: float) -> None:
    """Draw straight lines.

    Args:
        picture: (h, w, 3) red, green, blue; drawn on.
        depth: (h, w) of the surfaces in meters; inf where there is none.
        ends: (n, 2, 3) column, row and inverse depth (1/m) of both ends.
        colors: (n, 4) red, green, blue as in `picture`, and opacity from 0 to 1.
        widths: (n,) in pixels.
        bias: see BIAS.
    """
    height, width = depth.shape
    for i in range(len(ends)):
        x0, y0, w0 = ends[i, 0, 0], ends[i, 0, 1], ends[i, 0, 2]
        x1, y1, w1 = ends[i, 1, 0], ends[i, 1, 1], ends[i, 1, 2]
        across, down = x1 - x0, y1 - y0
        square = across * across + down * down
        half = 0.5 * widths[i]
        reach = half + 1.0
        steep = abs(down) > abs(across)
        # Go along the longer side; at each place only the pixels near the line are looked at.
        a0, a1, b0, b1 = (y0, y1, x0, x1) if steep else (x0, x1, y0, y1)
        if a0 > a1:
            a0, a1, b0, b1 = a1, a0, b1, b0
        slope = (b1 - b0) / (a1 - a0) if a1 > a0 else 0.0
        spread = reach * math.sqrt(1.0 + slope * slope)
        last, most = (height, width) if steep else (width, height)
        for along in range(max(0, math.ceil(max(a0 - reach, 0.0))), math.floor(min(a1 + reach, last - 1.0)) + 1):
            middle = b0 + slope * (min(max(float(along), a0), a1) - a0)
            for side in range(math.ceil(max(middle - spread, 0.0)), math.floor(min(middle + spread, most - 1.0)) + 1):
                column, row = (side, along) if steep else (along, side)
                t = ((column - x0) * across + (row - y0) * down) / square if square > 0.0 else 0.0
                t = min(max(t, 0.0), 1.0)
                cover = half + 0.5 - math.hypot(column - x0 - t * across, row - y0 - t * down)
                if cover <= 0.0 or 1.0 / (w0 + t * (w1 - w0)) > depth[row, column] * (1.0 + bias):
                    continue
                _blend(picture, row, column, colors[i], min(cover, 1.0, 2.0 * half + 0.2) * colors[i, 3])


@compiled(
    *(output_of(float32, 3), array_of(float32, 2), array_of(float64, 2), array_of(float32, 2), array_of(float64, 1)),
    float64,
)
def draw_discs(picture: Array, depth: Array, middles: Array, colors: Array, radii: Array, bias: float) -> None:
    """Draw discs that face the eye.

    Args:
        picture: (h, w, 3) red, green, blue; drawn on.
        depth: (h, w) of the surfaces in meters; inf where there is none.
        middles: (n, 3) column, row and inverse depth (1/m).
        colors: (n, 4) red, green, blue as in `picture`, and opacity from 0 to 1.
        radii: (n,) in pixels.
        bias: see BIAS.
    """
    height, width = depth.shape
    for i in range(len(middles)):
        x, y, w = middles[i]
        reach = radii[i] + 1.0
        for row in range(math.ceil(max(y - reach, 0.0)), math.floor(min(y + reach, height - 1.0)) + 1):
            for column in range(math.ceil(max(x - reach, 0.0)), math.floor(min(x + reach, width - 1.0)) + 1):
                cover = radii[i] + 0.5 - math.hypot(column - x, row - y)
                if cover > 0.0 and 1.0 / w <= depth[row, column] * (1.0 + bias):
                    _blend(picture, row, column, colors[i], min(cover, 1.0) * colors[i, 3])


@compiled(
    *(output_of(float32, 3), array_of(float32, 2), array_of(float64, 1), array_of(float64, 2), array_of(float64, 2)),
    *(array_of(float64, 1), float64, float64, float64),
)
def draw_floor(
    picture: Array,
    depth: Array,
    intrinsics: Array,
    world_t_camera: Array,
    colors: Array,
    thickness: Array,
    fade_distance: float,
    fade_strength: float,
    bias: float,
) -> None:
    """Draw a grid without end on the plane z = 0 of the world, fading with the distance from the eye.

    It looks as the viewer's, whose grid is that of three.js (drei, Grid): lines are so many pixels thick everywhere.

    Args:
        picture: (h, w, 3) red, green, blue; drawn on.
        depth: (h, w) of the surfaces along z in meters; inf where there is none.
        intrinsics: (4,) fx, fy, cx, cy of a camera without distortion.
        world_t_camera: (4, 4) where it is, an optical frame.
        colors: (2, 3) of the lines of cells of 0.25 m and of sections of 1 m.
        thickness: (2,) of both, in pixels.
        fade_distance: where nothing is left of it, in meters.
        fade_strength: the exponent of the fading.
        bias: see BIAS.
    """
    height, width = depth.shape
    eye, turn = world_t_camera[:3, 3], world_t_camera[:3, :3]
    color = np.empty(3, np.float32)
    for row in range(height):
        for column in range(width):
            a, b = (column - intrinsics[2]) / intrinsics[0], (row - intrinsics[3]) / intrinsics[1]
            fall = turn[2, 0] * a + turn[2, 1] * b + turn[2, 2]
            if fall * eye[2] >= 0.0:
                continue
            far = -eye[2] / fall
            if far > depth[row, column] * (1.0 + bias):
                continue
            along = turn[0, 0] * a + turn[0, 1] * b + turn[0, 2], turn[1, 0] * a + turn[1, 1] * b + turn[1, 2]
            distance = far * math.sqrt(along[0] * along[0] + along[1] * along[1] + fall * fall)
            if distance >= fade_distance:
                continue
            lines = 0.0
            section = 0.0
            for kind in range(2):
                cell = 0.25 if kind == 0 else 1.0
                nearest = np.inf
                for axis in range(2):
                    place = (eye[axis] + far * along[axis]) / cell
                    # By how much the place changes from pixel to pixel: far = -z / fall depends on both.
                    right = far / cell * (turn[axis, 0] - along[axis] * turn[2, 0] / fall) / intrinsics[0]
                    down = far / cell * (turn[axis, 1] - along[axis] * turn[2, 1] / fall) / intrinsics[1]
                    change = abs(right) + abs(down)
                    nearest = min(nearest, abs(place - math.floor(place + 0.5)) / max(change, 1e-12))
                strength = 1.0 - min(max(nearest + 1.0 - thickness[kind], 0.0), 1.0)
                lines += strength
                if kind == 1:
                    section = min(1.0, thickness[1] * strength)
            opacity = min(lines, 1.0) * (1.0 - distance / fade_distance) ** fade_strength
            if opacity > 0.0:
                for channel in range(3):
                    color[channel] = colors[0, channel] + section * (colors[1, channel] - colors[0, channel])
                _blend(picture, row, column, color, opacity)
