"""Textures as pixels, with smaller copies of themselves for surfaces that are far away."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.srgb import from_linear, to_linear

from virtualrobot_kernel.numeric.shading import STEPS
from virtualrobot_kernel.numeric.textures import halve
from virtualrobot_kernel.shapes.textures import decoded

Pixels = NDArray[np.uint8]

TO_LIGHT = to_linear(np.arange(256) / 255.0).astype(np.float32)
"""(256,) the linear light of what screens show."""
TO_SCREEN = np.round(255.0 * from_linear(np.arange(STEPS) / (STEPS - 1.0))).astype(np.uint8)
"""(STEPS,) what screens show of linear light."""


def levels(texture: bytes) -> tuple[Pixels, ...]:
    """Return the picture of a file (h, w, 4) as sRGB and opacity, then each time half as large, down to one pixel.

    Raises whatever PIL does for a file that is no picture.
    """
    found = [decoded(texture)]
    while max(found[-1].shape[:2]) > 1:
        height, width = found[-1].shape[:2]
        smaller = np.empty((max(1, height // 2), max(1, width // 2), 4), np.uint8)
        halve(found[-1], TO_LIGHT, TO_SCREEN, smaller)
        found.append(smaller)
    return tuple(found)
