"""Textures of meshes as pixels."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image


def decoded(texture: bytes) -> NDArray[np.uint8]:
    """Return the picture of a file as sRGB and opacity, (h, w, 4) from the upper left.

    Raises whatever PIL does for a file that is no picture.
    """
    with Image.open(io.BytesIO(texture)) as image:
        return np.asarray(image.convert("RGBA"))
