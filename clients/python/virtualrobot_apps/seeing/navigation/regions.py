"""Regions of grids: how far cells are from others, which hang together, and which are beside some; by scipy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from virtualrobot_apps.seeing.navigation.poses import Floats

Mask = NDArray[np.bool_]
_ndimage: Any = ndimage


def apart(others: Mask) -> Floats:
    """Return how many cells each one (rows, columns) is from the nearest of others; inf where there are none."""
    return _ndimage.distance_transform_edt(~others) if others.any() else np.full(others.shape, np.inf)


def parts(mask: Mask) -> tuple[NDArray[np.int32], int]:
    """Return the numbers (rows, columns) of the parts that hang together, 0 outside, and how many there are."""
    labels, count = _ndimage.label(mask, np.ones((3, 3)))
    return labels, int(count)


def widened(mask: Mask) -> Mask:
    """Return a mask with the cells beside and across from its own."""
    return _ndimage.binary_dilation(mask, np.ones((3, 3))).astype(bool)


def blurred(mask: Mask, cells: float) -> Floats:
    """Return a mask blurred by a Gaussian of so many cells."""
    return _ndimage.gaussian_filter(mask.astype(np.float64), cells)
