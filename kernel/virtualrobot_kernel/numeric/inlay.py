"""A flat picture that stands in the world, drawn over a picture of it where no surface is in front; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float32, float64, int32, uint8
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of

Array = np.ndarray[Any, np.dtype[Any]]


@compiled(
    *(output_of(float32, 3), output_of(float32, 2), array_of(float32, 2), array_of(int32, 1), array_of(float32, 1)),
    *(array_of(float64, 2), array_of(float64, 1), float64, array_of(uint8, 3), float64),
)
def draw_inlay(
    picture: Array,
    depth: Array,
    directions: Array,
    pixels: Array,
    slants: Array,
    plane_t_camera: Array,
    edges: Array,
    distance: float,
    image: Array,
    bias: float,
) -> None:
    """Draw an image that stands at z = `distance` of a frame, x to its right and y down.

    Args:
        picture: (h, w, 3) red, green, blue; drawn on.
        depth: (h, w) of the surfaces in meters, inf where there is none; the image is one from now on, so that what is
            drawn later is hidden by it too.
        directions: (n, 3) of the camera's rays, unit vectors; NaN where a pixel looks nowhere.
        pixels: (n,) the pixel of each.
        slants: (n,) by what a way along each ray is multiplied to be a depth.
        plane_t_camera: (4, 4) where the camera is in the frame of the image.
        edges: (4,) left, right, upper and lower edge of the image on the plane z = 1 of its frame.
        distance: see above, in meters.
        image: (r, c, 3) red, green, blue.
        bias: what is no farther than this behind a surface, in parts of the depth, is seen.
    """
    width = depth.shape[1]
    rows, columns = image.shape[0], image.shape[1]
    for i in range(len(directions)):
        a, b, c = float64(directions[i, 0]), float64(directions[i, 1]), float64(directions[i, 2])
        rise = plane_t_camera[2, 0] * a + plane_t_camera[2, 1] * b + plane_t_camera[2, 2] * c
        if not abs(rise) > 1e-9:
            continue
        way = (distance - plane_t_camera[2, 3]) / rise
        row, column = pixels[i] // width, pixels[i] % width
        deep = way * slants[i]
        if not 0.0 < deep <= depth[row, column] * (1.0 + bias):
            continue
        x = plane_t_camera[0, 0] * a + plane_t_camera[0, 1] * b + plane_t_camera[0, 2] * c
        y = plane_t_camera[1, 0] * a + plane_t_camera[1, 1] * b + plane_t_camera[1, 2] * c
        across = ((plane_t_camera[0, 3] + way * x) / distance - edges[0]) / (edges[1] - edges[0])
        down = ((plane_t_camera[1, 3] + way * y) / distance - edges[2]) / (edges[3] - edges[2])
        if 0.0 <= across < 1.0 and 0.0 <= down < 1.0:
            depth[row, column] = deep
            for channel in range(3):
                picture[row, column, channel] = image[int(down * rows), int(across * columns), channel]
