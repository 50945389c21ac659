"""Regions of grids: how far cells are from others, which hang together, and which are beside some; by scipy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from virtualrobot_apps.seeing.navigation.poses import Floats

Mask = NDArray[np.bool_]
Cells = NDArray[np.float32]
_ndimage: Any = ndimage


def apart(others: Mask) -> Cells:
    """Return how many cells each one (rows, columns) is from the nearest of others; inf where there are none."""
    if not others.any():
        return np.full(others.shape, np.inf, np.float32)
    # Which one is nearest is asked for, and whole numbers are squared: half the time that scipy needs for distances.
    off = np.empty((2, *others.shape), np.int32)
    _ndimage.distance_transform_edt(~others, return_distances=False, return_indices=True, indices=off)
    rows, columns = off
    rows -= np.arange(others.shape[0], dtype=np.int32)[:, None]
    columns -= np.arange(others.shape[1], dtype=np.int32)
    np.square(off, out=off)
    rows += columns
    return np.sqrt(rows, dtype=np.float32)


class Distances:
    """Distances of cells from what stays and from what is seen besides: the first ones are measured once."""

    def __init__(self, staying: Mask | None = None) -> None:
        """Measure those from what stays; None: nothing yet."""
        self._staying = np.zeros((0, 0), bool) if staying is None else staying
        self._away = apart(self._staying)

    def of(self, staying: Mask, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Cells:
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


def ways_from(mask: Mask, row: int, column: int) -> Floats:
    """Return how long ways in a mask from its cell nearest to one are, in cells; inf where there is none."""
    rows, columns = np.nonzero(mask)
    numbers = np.full(mask.shape, -1)
    numbers[rows, columns] = np.arange(len(rows))
    pairs, lengths = [], []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        begin = (slice(0, mask.shape[0] - down), slice(max(0, -right), mask.shape[1] - max(0, right)))
        end = (slice(down, None), slice(max(0, right), mask.shape[1] + min(0, right)))
        both = mask[begin] & mask[end]
        pairs.append(np.stack([numbers[begin][both], numbers[end][both]]))
        lengths.append(np.full(int(both.sum()), np.hypot(down, right)))
    (first, second), weights = np.hstack(pairs), np.concatenate(lengths)
    graph = sparse.csr_array((weights, (first, second)), (len(rows), len(rows)))
    nearest = int(np.argmin((rows - row) ** 2 + (columns - column) ** 2))
    ways = np.full(mask.shape, np.inf)
    ways[rows, columns] = csgraph.dijkstra(graph, directed=False, indices=nearest)
    return ways
