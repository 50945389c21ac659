"""Configuration space of an arm as a search sees it: free configurations, and free straight lines between them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.joint_path import JointPath, line
from virtualrobot_kernel.collision.node_pairs import ROUNDING, moves
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import SweptContact, first_contact
from virtualrobot_kernel.paths.query import PathQuery
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

_ELSEWHERE = 0.1
"""Displacement of each joint times its number (from 1), in rad or m, that shows which nodes the arm moves."""


class PathSpace:
    """Configurations of one arm in a world in which all else stands; used by one thread at a time.

    Pairs count of which the arm moves one node against the other: a base that stands in the floor is no matter, nor are
    fingers that are closed, at whatever posture rounding makes them touch.
    """

    def __init__(
        self, scene: CollisionScene, snapshot: Snapshot, query: PathQuery, given_up: Callable[[], bool]
    ) -> None:
        """Take the world at the start of the path, and what tells that nobody waits any more."""
        self._scene, self._snapshot, self._query, self._given_up = scene, snapshot, query, given_up
        self.start: Floats = snapshot.state.q[query.q_index]
        self.checks = 0
        """Number of configurations and lines checked."""
        scene.place(snapshot)
        moved = standing_at(snapshot, query.q_index, self.start + _ELSEWHERE * np.arange(1, len(self.start) + 1))
        rows = np.abs(moved.world_t_node - snapshot.world_t_node).max(axis=(1, 2)) > ROUNDING
        groups = scene.bodies.allowed.groups
        self._robots = {groups[uid] for uid, row in snapshot.structure.rows.items() if rows[row] and groups.get(uid)}
        self._counts = cache(partial(moves, snapshot, moved))

    def contact(self, q: Floats) -> Pair | None:
        """Return two nodes (uids) that touch at q (k,) and may not, or None."""
        self.checks += 1
        self._scene.place(standing_at(self._snapshot, self._query.q_index, q))
        return self._scene.first_touching(self._robots, self._counts)

    def within(self, q: Floats) -> bool:
        """Return whether joints and actuators are within their limits at q (k,)."""
        query, turned = self._query, self._query.ratios @ q
        inside = (query.lower <= q) & (q <= query.upper)
        return bool(inside.all() and ((query.least <= turned) & (turned <= query.most)).all())

    def free(self, q: Floats) -> bool:
        """Return whether a configuration (k,) is within limits and touches nothing."""
        return self.within(q) and self.contact(q) is None

    def looks_free(self, begin: Floats, end: Floats, step: float) -> bool:
        """Return whether configurations on a line are free, at most `step` (rad or m) apart, its begin left out."""
        count = max(1, int(np.ceil(np.abs(end - begin).max() / step)))
        if not self.free(end):
            return False
        # What collides does so for a while: places far apart find it soonest.
        stride = 1 << (count.bit_length() - 1)
        while stride:
            for place in range(stride, count, 2 * stride):
                if not self.free(begin + (end - begin) * (place / count)):
                    return False
            stride //= 2
        return True

    def is_free(self, begin: Floats, end: Floats, step: float) -> bool:
        """Return whether a line is free: proven, after a look at places on it, which refutes most lines sooner."""
        return self.looks_free(begin, end, step) and self.meets(begin, end) is None

    def meets(self, begin: Floats, end: Floats) -> SweptContact | None:
        """Return the first contact on the straight line between configurations (k,): proven, not sampled."""
        everything, index = self._snapshot.state.q, self._query.q_index
        ends = np.stack([everything, everything])
        ends[0, index], ends[1, index] = begin, end
        return self.meets_on(line(*ends))

    def meets_on(self, path: JointPath) -> SweptContact | None:
        """Return the first contact on a way of all joints: proven, not sampled."""
        self.checks += 1
        return first_contact(
            self._scene,
            self._snapshot,
            path,
            robots=self._robots,
            given_up=self._given_up,
        )
