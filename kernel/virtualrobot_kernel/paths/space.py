"""Configuration space of an arm as a search sees it: free configurations, and free straight lines between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.certain import CertainlyFree
from virtualrobot_kernel.collision.joint_path import JointPath, line, of_program
from virtualrobot_kernel.collision.node_pairs import ROUNDING, moves
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import SweptContact, first_contact
from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.paths.query import PathQuery
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

_ELSEWHERE = 0.1
"""Displacement of each joint times its number (from 1), in rad or m, that shows which nodes the arm moves."""


_TIMES = 2000
"""Number of times at which a law is asked where it is."""


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
        self._certain = CertainlyFree(scene, snapshot, query.q_index, self._robots, self._counts)

    def contact(self, q: Floats) -> Pair | None:
        """Return two nodes (uids) that touch at q (k,) and may not, or None."""
        self.checks += 1
        self._scene.place(standing_at(self._snapshot, self._query.q_index, q))
        return self._scene.first_touching(self._robots, self._counts)

    def within(self, q: Floats) -> bool:
        """Return whether joints and actuators are within their limits at q, (k,) or (m, k)."""
        query, turned = self._query, q @ self._query.ratios.T
        inside = ((query.lower <= q) & (q <= query.upper)).all()
        return bool(inside and ((query.least <= turned) & (turned <= query.most)).all())

    def free(self, q: Floats) -> bool:
        """Return whether a configuration (k,) is within limits and touches nothing."""
        return self._are_free(q[None])

    def looks_free(self, begin: Floats, end: Floats, step: float) -> bool:
        """Return whether configurations on a line are free, at most `step` (rad or m) apart, its begin left out."""
        count = max(1, int(np.ceil(np.abs(end - begin).max() / step)))
        # What collides does so for a while: places far apart find it soonest.
        order, stride = [], 1 << (count.bit_length() - 1)
        while stride:
            order += range(stride, count, 2 * stride)
            stride //= 2
        between = begin + (end - begin) * (np.array(order, np.float64) / count)[:, None]
        return self._are_free(np.concatenate([end[None], between]))

    def _are_free(self, configurations: Floats) -> bool:
        """Return whether configurations (m, k) are within limits and touch nothing."""
        if not self.within(configurations):
            return False
        certain = self._certain.places(configurations)
        self.checks += int(certain.sum())
        return not any(self.contact(q) for q in configurations[~certain])

    def is_free(self, begin: Floats, end: Floats, step: float) -> bool:
        """Return whether a line is free: proven, after a look at places on it, which refutes most lines sooner."""
        return self.looks_free(begin, end, step) and self.meets(begin, end) is None

    def meets(self, begin: Floats, end: Floats) -> SweptContact | None:
        """Return the first contact on the straight line between configurations (k,): proven, not sampled.

        Its begin is free: what is not inside of something gets there only through its surface.
        """
        self.checks += 1
        everything, index = self._snapshot.state.q, self._query.q_index
        ends = np.stack([everything, everything])
        ends[0, index], ends[1, index] = begin, end
        return self._first_of(line(*ends), self._certain.doubts(joint_line(begin, end)))

    def meets_program(self, program: Program, index: NDArray[np.int32]) -> SweptContact | None:
        """Return the first contact of a program from the start, whose columns are at `index` in q: proven."""
        self.checks += 1
        path = of_program(self._snapshot.state.q, index, program)
        for begin, stage in zip(program.begins, program.stages, strict=False):
            if stage.plan is None:
                continue
            stretches = np.array([[0.0, stage.duration]])
            if np.array_equal(index[list(stage.columns)], self._query.q_index):
                (track,) = stage.plan.tracks
                stretches = _times(track.time_law, self._certain.doubts(track.path))
            contact = self._first_of(path, begin + stretches)
            if contact is not None:
                return contact
        return None

    def _first_of(self, path: JointPath, stretches: Floats) -> SweptContact | None:
        """Return the first contact on stretches (d, 2) of a way of all joints."""
        for begin, end in stretches.tolist():
            contact = first_contact(
                self._scene,
                self._snapshot,
                replace(path, begin=begin, end=end),
                robots=self._robots,
                given_up=self._given_up,
            )
            if contact is not None:
                return contact
        return None


def _times(law: PiecewisePolynomial, stretches: Floats) -> Floats:
    """Return the times of a law, which never runs back, between which it is on stretches (d, 2) of its values."""
    times = np.linspace(0.0, law.end, _TIMES)
    values = law.states(times, 0)[0, :, 0]
    first = np.searchsorted(values, stretches[:, 0], side="left") - 1
    last = np.searchsorted(values, stretches[:, 1], side="right")
    return times[np.clip(np.stack([first, last], axis=1), 0, _TIMES - 1)]
