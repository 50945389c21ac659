"""Groups of joints that hang together: what one of them carries goes its own way, whatever the others do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.structure import Structure


@dataclass(frozen=True, slots=True, eq=False)
class KinematicGroups:
    """The groups of a world's joints: 1 and on; 0 stands for what no joint carries.

    Attributes:
        count: how many there are, 0 included.
        rows: (n,) the group that carries each row of the forest.
        coordinates: (nq,) the group of each coordinate.
    """

    count: int
    rows: NDArray[np.int64]
    coordinates: NDArray[np.int64]


@lru_cache(maxsize=4)
def kinematic_groups_of(structure: Structure) -> KinematicGroups:
    """Return the groups: joints that are above one another or share a coordinate are of one."""
    forest = structure.forest
    rows, coordinates = np.zeros(len(forest.parent), np.int64), np.zeros(structure.q_count, np.int64)
    count = 1
    for row in forest.order.tolist():
        above, own = int(forest.parent[row]), structure.coordinates_at(row)
        group = int(rows[above]) if above >= 0 else 0
        if own:
            shared = int(coordinates[own.start])
            if not group and not shared:
                shared, count = count, count + 1
            if group and shared and group != shared:
                rows[rows == shared] = group
                coordinates[coordinates == shared] = group
            group = group or shared
            coordinates[own] = group
        rows[row] = group
    return KinematicGroups(count, rows, coordinates)
