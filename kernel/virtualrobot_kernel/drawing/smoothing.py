"""Smooth edges: where colours jump from pixel to pixel, more rays are cast through the pixel."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.sensing.lenses import Lens

JUMP = 20
"""Of 255: colours of neighbours that differ by more are an edge."""
OFFSETS = np.array([[-0.375, -0.125], [0.125, -0.375], [0.375, 0.125], [-0.125, 0.375]])
"""Of the rays through a pixel, in pixels: a grid turned so that no two share a column or a row."""

BUNDLE = 1 << 20
"""So many rays are cast at a time."""

Pixels = NDArray[np.uint8]


def smoothed(picture: Pixels, lens: Lens, taken: Callable[[Lens], Pixels]) -> Pixels:
    """Return a picture (h, w, 3) with its edges taken anew by several rays a pixel.

    Args:
        picture: as one ray a pixel has it.
        lens: a pinhole without distortion.
        taken: gives the colours (1, n, 3) of a lens with n pixels in one row.
    """
    rows, columns = np.nonzero(_edges(picture))
    if not len(rows) or lens.intrinsics is None:
        return picture
    eye = lens.intrinsics
    places = np.stack([columns, rows], axis=1)[:, None, :] + OFFSETS
    along = np.ones((len(rows) * len(OFFSETS), 3))
    along[:, :2] = (places.reshape(-1, 2) - (eye.cx, eye.cy)) / (eye.fx, eye.fy)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    colors = [taken(lens.narrowed(along[start : start + BUNDLE])) for start in range(0, len(along), BUNDLE)]
    means = np.concatenate(colors, axis=1).reshape(-1, len(OFFSETS), 3).mean(axis=1, dtype=np.float32)
    result = picture.copy()
    result[rows, columns] = np.rint(means)
    return result


def _edges(picture: Pixels) -> NDArray[np.bool_]:
    """Return (h, w) which pixels have a neighbour of quite another colour."""
    signed = picture.astype(np.int16)
    edges = np.zeros(picture.shape[:2], np.bool_)
    across = (np.abs(np.diff(signed, axis=1)) > JUMP).any(axis=2)
    down = (np.abs(np.diff(signed, axis=0)) > JUMP).any(axis=2)
    edges[:, 1:] |= across
    edges[:, :-1] |= across
    edges[1:] |= down
    edges[:-1] |= down
    return edges
