"""Smaller copies of textures, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float32, uint8
from virtualrobot_sdk.compiled.cache import array_of, compiled, output_of

Array = np.ndarray[Any, np.dtype[Any]]


@compiled(array_of(uint8, 3), array_of(float32, 1), array_of(uint8, 1), output_of(uint8, 3))
def halve(pixels: Array, to_light: Array, to_screen: Array, halved: Array) -> None:
    """Write a picture half as large: each pixel is the mean light and opacity of four (where there is one row, of two).

    Args:
        pixels: (h, w, 4) sRGB and opacity.
        to_light: (256,) linear light of what screens show.
        to_screen: (n,) what screens show of linear light, in n equal steps.
        halved: (max(1, h // 2), max(1, w // 2), 4) result; the last of an odd number of rows or columns is left out.
    """
    rows, columns = min(2, pixels.shape[0]), min(2, pixels.shape[1])
    count = rows * columns
    for row in range(halved.shape[0]):
        for column in range(halved.shape[1]):
            for channel in range(4):
                total = 0.0
                for i in range(rows):
                    for j in range(columns):
                        value = pixels[2 * row + i, 2 * column + j, channel]
                        total += to_light[value] if channel < 3 else float(value)
                mean = total / count
                if channel < 3:
                    halved[row, column, channel] = to_screen[int(mean * (len(to_screen) - 1) + 0.5)]
                else:
                    halved[row, column, channel] = int(mean + 0.5)
