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


class Distances:
    """Distances of cells from what stays and from what is seen besides: the first ones are measured once."""

    def __init__(self) -> None:
        """Begin with nothing measured."""
        self._staying, self._away = np.zeros((0, 0), bool), np.zeros((0, 0))

    def of(self, staying: Mask, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Floats:
        """Return how many cells each one is from the nearest of `staying` and of cells (n,); inf where there are none.

        Those from `staying` are measured anew where it differs from the last one.
        """
        if not np.array_equal(staying, self._staying):
            self._staying, self._away = staying.copy(), apart(staying)
        away = self._away.copy()
        if not len(rows):
            return away
        # A cell that is further from what is seen than any one is from what stays is as far as before.
        reach = int(min(away.max(), max(away.shape))) + 1
        low, left = max(int(rows.min()) - reach, 0), max(int(columns.min()) - reach, 0)
        near = away[low : int(rows.max()) + reach + 1, left : int(columns.max()) + reach + 1]
        seen = np.zeros(near.shape, bool)
        seen[rows - low, columns - left] = True
        np.minimum(near, apart(seen), out=near)
        return away


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
