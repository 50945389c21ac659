"""Viewing ray of each pixel of a camera, compiled: the inverse of OpenCV's camera models.

Source: OpenCV, calib3d module: "Camera Calibration and 3D Reconstruction" (pinhole, distortion by Brown and Conrady,
with the rational factor) and "Fisheye camera model" (Kannala and Brandt).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import boolean, float32, float64, int32, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

PINHOLE, FISHEYE, SPHERICAL = 1, 2, 3
"""Codes of projections."""

TILE = 4
"""Rays follow each other in tiles of 4 x 4 pixels, so that the 16 of a packet go along with each other."""

_STEPS = 50
_NEAR_ENOUGH = 1e-12
_FLATTEST = 1e12
"""A direction of a pinhole that takes so many meters for one forward is across it, and sees nothing."""

Array = np.ndarray[Any, np.dtype[Any]]


@compiled(
    *(int64, int64, int64, array_of(float64, 1), array_of(float64, 1), float64),
    *(output_of(float32, 2), output_of(int32, 1)),
)
def look(
    projection: int,
    width: int,
    height: int,
    intrinsics: Array,
    distortion: Array,
    limit: float,
    along: Array,
    pixels: Array,
) -> None:
    """Write where the pixels of a picture look, tile by tile.

    Args:
        projection: PINHOLE, FISHEYE or SPHERICAL.
        width: of the picture.
        height: of the picture.
        intrinsics: (4,) fx, fy, cx, cy in pixels; spherical: fx and fy are pixels per radian.
        distortion: (8,) k1 k2 p1 p2 k3 k4 k5 k6 for a pinhole, k1 k2 k3 k4 and zeros for a fisheye.
        limit: up to where the distortion is one to one: the radius on the plane z = 1 for a pinhole, the angle from the
            axis for a fisheye. What lies beyond has no direction.
        along: (width * height, 3) result: unit vectors (x right, y down, z forward); NaN where a pixel looks nowhere.
        pixels: (width * height,) result: the pixel of each, row by row from the upper left.
    """
    i = 0
    for top in range(0, height, TILE):
        for left in range(0, width, TILE):
            for row in range(top, min(top + TILE, height)):
                for column in range(left, min(left + TILE, width)):
                    x = (column - intrinsics[2]) / intrinsics[0]
                    y = (row - intrinsics[3]) / intrinsics[1]
                    if projection == PINHOLE:
                        a, b, c = _pinhole(x, y, distortion, limit)
                    elif projection == FISHEYE:
                        a, b, c = _fisheye(x, y, distortion, limit)
                    elif abs(y) <= 0.5 * math.pi:
                        a, b, c = math.cos(y) * math.sin(x), math.sin(y), math.cos(y) * math.cos(x)
                    else:
                        a, b, c = np.nan, np.nan, np.nan
                    along[i, 0] = a
                    along[i, 1] = b
                    along[i, 2] = c
                    pixels[i] = row * width + column
                    i += 1


@compiled(*(array_of(float64, 2), array_of(float32, 2), float64, boolean, output_of(float32, 2), output_of(float32, 2)))
def start_rays(
    world_t_camera: Array, directions: Array, near: float, along_z: bool, origins: Array, along: Array
) -> None:
    """Write where the rays of a camera's `directions` (n, 3) begin, `near` in front of it, and go in the world.

    `along_z` says whether `near` is measured along z or along the ray; both results have shape (n, 3).
    """
    for i in range(len(directions)):
        a, b, c = float64(directions[i, 0]), float64(directions[i, 1]), float64(directions[i, 2])
        start = near / c if along_z else near
        for row in range(3):
            value = world_t_camera[row, 0] * a + world_t_camera[row, 1] * b + world_t_camera[row, 2] * c
            along[i, row] = value
            origins[i, row] = world_t_camera[row, 3] + start * value


@inlined
def _pinhole(u: float, v: float, k: Array, limit: float) -> tuple[float, float, float]:
    """Return the direction whose distorted place on the plane z = 1 is (u, v), by Newton's method.

    From the middle outwards, in steps that each bring it nearer: a whole one may leap over the fold.
    """
    x, y, step_x, step_y = 0.0, 0.0, u, v
    miss = u * u + v * v
    for _ in range(_STEPS):
        tried_x, tried_y = x + step_x, y + step_y
        r2 = tried_x * tried_x + tried_y * tried_y
        above = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
        below = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))
        factor = above / below
        # The slope of the factor by the square of the radius.
        slope = (k[0] + r2 * (2.0 * k[1] + 3.0 * r2 * k[4])) / below
        slope -= factor * (k[5] + r2 * (2.0 * k[6] + 3.0 * r2 * k[7])) / below
        a = tried_x * factor + 2.0 * k[2] * tried_x * tried_y + k[3] * (r2 + 2.0 * tried_x * tried_x) - u
        b = tried_y * factor + k[2] * (r2 + 2.0 * tried_y * tried_y) + 2.0 * k[3] * tried_x * tried_y - v
        xx = factor + 2.0 * tried_x * tried_x * slope + 2.0 * k[2] * tried_y + 6.0 * k[3] * tried_x
        xy = 2.0 * tried_x * tried_y * slope + 2.0 * k[2] * tried_x + 2.0 * k[3] * tried_y
        yy = factor + 2.0 * tried_y * tried_y * slope + 6.0 * k[2] * tried_y + 2.0 * k[3] * tried_x
        determinant = xx * yy - xy * xy
        if not (r2 <= limit * limit and determinant > 0.0 and a * a + b * b <= miss):
            step_x, step_y = 0.5 * step_x, 0.5 * step_y
            continue
        x, y, miss = tried_x, tried_y, a * a + b * b
        if miss < _NEAR_ENOUGH * _NEAR_ENOUGH:
            break
        step_x, step_y = (xy * b - yy * a) / determinant, (xy * a - xx * b) / determinant
    length = math.sqrt(x * x + y * y + 1.0)
    if not (miss < 1e-16 and length < _FLATTEST):
        return np.nan, np.nan, np.nan
    return x / length, y / length, 1.0 / length


@inlined
def _fisheye(u: float, v: float, k: Array, limit: float) -> tuple[float, float, float]:
    """Return the direction whose distorted angle from the axis, as a distance from the middle, is at (u, v)."""
    radius = math.sqrt(u * u + v * v)
    if radius == 0.0:
        return 0.0, 0.0, 1.0
    # The angle grows with the radius up to the limit: bisection steps in wherever Newton's would leave the bracket.
    low, high = 0.0, limit
    t2 = limit * limit
    if limit * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) < radius - _NEAR_ENOUGH:
        return np.nan, np.nan, np.nan
    angle = min(radius, limit)
    miss = np.inf
    for _ in range(_STEPS):
        t2 = angle * angle
        miss = angle * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) - radius
        if abs(miss) < _NEAR_ENOUGH:
            break
        if miss > 0.0:
            high = angle
        else:
            low = angle
        slope = 1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])))
        angle = angle - miss / slope if slope > 0.0 else -1.0
        if not low <= angle <= high:
            angle = 0.5 * (low + high)
    if not abs(miss) < 1e-8:
        return np.nan, np.nan, np.nan
    side = math.sin(angle) / radius
    return u * side, v * side, math.cos(angle)
