"""Groups of joints that hang together: what one of them carries goes its own way, whatever the others do."""

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
        above, kind = int(forest.parent[row]), int(forest.joint_type[row])
        group = int(rows[above]) if above >= 0 else 0
        if kind != FIXED:
            first = int(forest.q_index[row])
            shared = int(coordinates[first])
            if not group and not shared:
                shared, count = count, count + 1
            if group and shared and group != shared:
                rows[rows == shared] = group
                coordinates[coordinates == shared] = group
            group = group or shared
            coordinates[first : first + WIDTHS[kind]] = group
        rows[row] = group
    return KinematicGroups(count, rows, coordinates)
