"""Meshes that are height fields: one height above each place of an even grid, as ground is told."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SAME = 1e-3
"""Part of a cell by which a corner may be off its place on the grid."""


@dataclass(frozen=True, slots=True, eq=False)
class Heights:
    """Height field: rows lie along y, columns along x, a cell (x, y) apart (m), about a middle (x, y).

    heights: (rows, columns) along z (m).
    """

    cell: tuple[float, float]
    middle: tuple[float, float]
    heights: Floats


def heights_of(corners: Floats, faces: Integers) -> Heights | None:
    """Return the height field that triangles are; None where they are none.

    They are one where each cell of an even grid along x and y is two triangles that look upwards. By which of its
    diagonals a cell is parted is not kept.

    Args:
        corners: (n, 3) of the triangles (m); some may be at the same place.
        faces: (m, 3) three corners each, counterclockwise as seen from outside.
    """
    along = [_evenly(corners[:, axis]) for axis in (0, 1)] if len(faces) >= 2 else [None]
    if (x := along[0]) is None or (y := along[-1]) is None:
        return None
    columns, rows = x.places, y.places
    shape = int(rows.max()) + 1, int(columns.max()) + 1
    if len(faces) != 2 * (shape[0] - 1) * (shape[1] - 1) or shape[0] * shape[1] > len(corners):
        return None
    heights = np.full(shape, np.nan)
    heights[rows, columns] = corners[:, 2]
    off = np.abs(heights[rows, columns] - corners[:, 2]).max()
    if not (np.isfinite(heights).all() and off <= SAME * min(x.step, y.step)):
        return None
    column, row = columns[faces], rows[faces]
    twice = (column[:, 1] - column[:, 0]) * (row[:, 2] - row[:, 0])
    twice -= (column[:, 2] - column[:, 0]) * (row[:, 1] - row[:, 0])
    halves = (np.ptp(column, axis=1) == 1) & (np.ptp(row, axis=1) == 1) & (twice == 1)
    cells = row.min(axis=1) * (shape[1] - 1) + column.min(axis=1)
    if not (halves.all() and (np.bincount(cells) == 2).all()):
        return None
    return Heights((x.step, y.step), (x.middle, y.middle), heights)


@dataclass(frozen=True, slots=True, eq=False)
class _Even:
    """Values that are a step apart: which place each has (n,), and the middle of all."""

    step: float
    middle: float
    places: Integers


def _evenly(values: Floats) -> _Even | None:
    """Return where values (n,) are on an even row; None where they are on none."""
    first, last = float(values.min()), float(values.max())
    gaps = np.diff(np.unique(values))
    if not len(gaps) or not np.isfinite(last - first):
        return None
    step = (last - first) / int((gaps > 0.5 * gaps.max()).sum())
    places = np.rint((values - first) / step).astype(np.int64)
    if np.abs(first + places * step - values).max() > SAME * step:
        return None
    return _Even(step, 0.5 * (first + last), places)
