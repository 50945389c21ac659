"""Part that a program waits for: what it stands for among the orders of a motion, and whether it is there. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.apply_robots import REACH_OF_A_PICK, holder
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import WORLD_NAME, Kind, Structure


@dataclass(frozen=True, slots=True)
class AwaitedPart:
    """Part (empty: any that no tool holds) whose origin comes within a distance (m) of a place.

    position: the place in the frame of the node `reference` (empty: the world), in meters.
    """

    part: str = ""
    reference: str = ""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    max_distance: float = REACH_OF_A_PICK

    def __str__(self) -> str:
        """Return what is amiss while it is not there, for people."""
        part = f"part {self.part!r}" if self.part else "part"
        x, y, z = self.position
        where = f"x {x:g}, y {y:g}, z {z:g} m in the frame of {self.reference or WORLD_NAME!r}"
        return f"no {part} was within {self.max_distance:g} m of {where}"

    def check(self, structure: Structure) -> None:
        """Raise UnknownNameError unless its frame is there, and the part that it names."""
        structure.node(self.reference)
        if self.part:
            structure.node(self.part, Kind.PART)

    def is_there(self, snapshot: Snapshot) -> bool:
        """Return whether such a part is there now; False as well while its frame or the part is gone."""
        structure, named = snapshot.structure, snapshot.structure.uid_by_name
        reference = named.get(self.reference or WORLD_NAME)
        if reference is None:
            return False
        rows = _free_parts(structure)
        if self.part:
            row = structure.rows.get(named.get(self.part, -1), -1)
            rows = rows[rows == row]
        frame = snapshot.world_t(reference)
        place = frame[:3, :3] @ np.array(self.position) + frame[:3, 3]
        return bool((np.linalg.norm(snapshot.world_t_node[rows, :3, 3] - place, axis=1) <= self.max_distance).any())


@lru_cache(maxsize=4)
def _free_parts(structure: Structure) -> NDArray[np.int64]:
    """Return the rows (k,) of the parts that no tool holds."""
    nodes = structure.nodes.values()
    found = [node.uid for node in nodes if node.kind is Kind.PART and holder(structure, node.uid) is None]
    return np.array([structure.rows[uid] for uid in found], np.int64)
