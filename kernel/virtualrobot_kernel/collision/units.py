"""Which joints hang together: what one unit of joints carries goes its own way, whatever the others do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.numeric.forest import FIXED
from virtualrobot_kernel.world.structure import JointType, Structure

WIDTHS = {kind.code: kind.coordinate_count for kind in JointType}
"""How many coordinates a joint has, by the code of its type."""


@dataclass(frozen=True, slots=True, eq=False)
class Units:
    """The units of a world's joints: 1 and on; 0 stands for what no joint carries.

    Attributes:
        count: how many there are, 0 included.
        rows: (n,) the unit that carries each row of the forest.
        coordinates: (nq,) the unit of each coordinate.
    """

    count: int
    rows: NDArray[np.int64]
    coordinates: NDArray[np.int64]


@lru_cache(maxsize=4)
def units_of(structure: Structure) -> Units:
    """Return the units: joints that are above one another or share a coordinate are of one."""
    forest = structure.forest
    rows, coordinates = np.zeros(len(forest.parent), np.int64), np.zeros(structure.q_count, np.int64)
    count = 1
    for row in forest.order.tolist():
        above, kind = int(forest.parent[row]), int(forest.joint_type[row])
        unit = int(rows[above]) if above >= 0 else 0
        if kind != FIXED:
            first = int(forest.q_index[row])
            shared = int(coordinates[first])
            if not unit and not shared:
                shared, count = count, count + 1
            if unit and shared and unit != shared:
                rows[rows == shared] = unit
                coordinates[coordinates == shared] = unit
            unit = unit or shared
            coordinates[first : first + WIDTHS[kind]] = unit
        rows[row] = unit
    return Units(count, rows, coordinates)
