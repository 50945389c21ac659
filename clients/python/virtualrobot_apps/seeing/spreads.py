"""Spreads of points: which way a cloud lies around places, as the principal axes of their nearest neighbours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

Floats = NDArray[np.float64]


class Spreads(NamedTuple):
    """Spreads around k places.

    middles: (k, 3) means of the neighbours, m. squares: (k, 3) sums of the squares of their distances from these along
    each axis, the least first, m^2. axes: (k, 3, 3), columns: the first one is a surface's normal, of either sign.
    """

    middles: Floats
    squares: Floats
    axes: Floats


def spreads(tree: KDTree, cloud: Floats, places: Floats, count: int) -> Spreads:
    """Return the spreads of `count` neighbours around places (k, 3) in a cloud (n, 3), whose tree is given."""
    _, nearest = tree.query(places, k=min(count, len(cloud)))
    neighbours = cloud[nearest]
    middles = neighbours.mean(axis=1)
    off = neighbours - middles[:, None]
    squares, axes = np.linalg.eigh(off.transpose(0, 2, 1) @ off)
    return Spreads(middles, squares, axes)
