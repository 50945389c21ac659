"""Textures as pixels, with smaller copies of themselves for surfaces that are far away."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from virtualrobot_sdk.srgb import from_linear, to_linear

Pixels = NDArray[np.uint8]

_LINEAR = to_linear(np.arange(256) / 255.0).astype(np.float32)


def levels(texture: bytes) -> tuple[Pixels, ...]:
    """Return the picture of a file (h, w, 4) as sRGB and opacity, then each time half as large, down to one pixel.

    A pixel of a smaller one is the mean light of four (of an odd row or column, the last is left out). Raises whatever
    PIL does for a file that is none.
    """
    with Image.open(io.BytesIO(texture)) as image:
        pixels = np.asarray(image.convert("RGBA"))
    found = [pixels]
    light = np.concatenate([_LINEAR[pixels[..., :3]], pixels[..., 3:].astype(np.float32) / np.float32(255.0)], axis=-1)
    while max(light.shape[:2]) > 1:
        height, width = light.shape[:2]
        rows, columns = max(1, height // 2), max(1, width // 2)
        light = (
            light[: 2 * rows, : 2 * columns].reshape(rows, min(2, height), columns, min(2, width), 4).mean(axis=(1, 3))
        )
        shown = np.concatenate([from_linear(light[..., :3]), light[..., 3:]], axis=-1)
        found.append(np.round(255.0 * shown).astype(np.uint8))
    return tuple(found)
