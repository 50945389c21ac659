"""Contacts of an arm at configurations, in a world in which all else stands."""

from __future__ import annotations

from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.node_pairs import ROUNDING, moves
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.planning.robots import poses_of_rows, standing_at
from virtualrobot_kernel.world.state import Snapshot

_ELSEWHERE = 0.1
"""Displacement of each joint times its number (from 1), in rad or m, that shows which nodes the arm moves."""


class ArmContacts:
    """Contacts as an arm moves; used by one thread at a time.

    Pairs count of which the arm moves one node against the other: a base that stands in the floor is no matter, nor are
    fingers that are closed, at whatever posture rounding makes them touch.

    Attributes:
        robots: those (uids) that the arm moves.
    """

    def __init__(self, scene: CollisionScene, snapshot: Snapshot, q_index: NDArray[np.int32]) -> None:
        """Take a world, in which the arm's k coordinates are at these places of q."""
        self._scene, self._snapshot, self._q_index = scene, snapshot, q_index
        scene.place(snapshot)
        off = _ELSEWHERE * np.arange(1, len(q_index) + 1)
        moved = standing_at(snapshot, q_index, snapshot.state.q[q_index] + off)
        rows = np.abs(moved.world_t_node - snapshot.world_t_node).max(axis=(1, 2)) > ROUNDING
        groups = scene.bodies.allowed.groups
        self.robots = {groups[uid] for uid, row in snapshot.structure.rows.items() if rows[row] and groups.get(uid)}
        self.counts = cache(partial(moves, snapshot, moved))
        """True for a pair of nodes (uids) that counts."""

    def contact(self, q: NDArray[np.float64]) -> Pair | None:
        """Return two nodes (uids) that touch at q (k,) and may not, or None."""
        structure, state = self._snapshot.structure, self._snapshot.state
        everything = state.q.copy()
        everything[self._q_index] = q
        poses = poses_of_rows(structure, structure.forest.order, state.parent_t_node, everything)
        self._scene.place(self._snapshot, poses)
        return self._scene.first_touching(self.robots, self.counts)

    def standing(self) -> list[Pair]:
        """Return the pairs of nodes (uids) of these robots that touch and may not, wherever the arm is."""
        self._scene.place(self._snapshot)
        return sorted(pair for pair in self._scene.touching(self.robots) if not self.counts(pair))
