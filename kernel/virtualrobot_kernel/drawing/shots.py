"""From where and how a picture is taken."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from virtualrobot_kernel.drawing.view import Camera

WIDTH, HEIGHT = 1280, 720
"""Of a picture whose size is not said, in pixels."""
LARGEST = 4096
"""The greatest width and height in pixels."""
JPEG_QUALITY = 90
STRIP = 1 << 18
"""So many pixels are handed to Pillow at a time."""


class ImageFormat(Enum):
    """Format of a picture; the values are the contract's numbers."""

    PNG = 1
    JPEG = 2
    RAW = 3


@dataclass(frozen=True, slots=True)
class Shot:
    """Settings of one picture.

    Attributes:
        camera: where it is looked from; None means as the view's camera does.
        sensor: the uid of a camera of the scene to look through; 0 means none.
        width: in pixels; 0 means WIDTH, or the sensor's.
        height: in pixels; 0 means HEIGHT, or the sensor's.
        format: how it is packed.
        plain: leaves out what is not of the world itself, the grid excepted.
    """

    camera: Camera | None = None
    sensor: int = 0
    width: int = 0
    height: int = 0
    format: ImageFormat = ImageFormat.PNG
    plain: bool = False


class _Checked(io.BytesIO):
    """Bytes in memory; `check` is called before each part is written."""

    def __init__(self, check: Callable[[], None]) -> None:
        super().__init__()
        self._check = check

    def write(self, data: bytes, /) -> int:  # pyright: ignore[reportIncompatibleMethodOverride] Pillow gives bytes
        self._check()
        return super().write(data)


def packed(picture: NDArray[np.uint8], format: ImageFormat, check: Callable[[], None] = lambda: None) -> bytes:
    """Return a picture (h, w, 3) as the bytes of a file; what `check` raises on the way ends it."""
    if format is ImageFormat.RAW:
        return picture.tobytes()
    height, width = picture.shape[:2]
    image, file = Image.new("RGB", (width, height)), _Checked(check)
    # Pillow takes pixels over with the GIL held: a few rows at a time, or all calls would wait.
    rows = max(1, STRIP // width)
    for top in range(0, height, rows):
        image.paste(Image.fromarray(picture[top : top + rows]), (0, top))
    if format is ImageFormat.JPEG:
        image.save(file, "JPEG", quality=JPEG_QUALITY, subsampling=0)
    else:
        image.save(file, "PNG", compress_level=3)
    return file.getvalue()
