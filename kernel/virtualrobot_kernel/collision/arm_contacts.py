"""Contacts of an arm at configurations, in a world in which all else stands."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.node_pairs import ROUNDING, moves
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.numeric.boxes import overlapping_boxes_at_each
from virtualrobot_kernel.planning.robots import poses_of_rows, standing_at
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_ELSEWHERE = 0.1
"""Displacement of each joint times its number (from 1), in rad or m, that shows which nodes the arm moves."""

_AT_ONCE, _ROOM = 512, 4096
"""Number of configurations whose boxes are compared at once, and of overlaps for which there is room at first."""


class _Asked(NamedTuple):
    """Elements that an arm moves, and the pairs that are asked of it.

    moving (r,): rows of nodes that move, parents first. moved (c,): elements. own (o,), asked (o, e): as
    `overlapping_boxes` has them, and group (e,): the place of each own element's robot among those that are asked.
    """

    moving: NDArray[np.int32]
    moved: Integers
    own: Integers
    asked: NDArray[np.bool_]
    group: Integers


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
        self._off, self._moves_row = moved.world_t_node, rows
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

    def contacts(self, configurations: Floats) -> list[Pair | None]:
        """Return what `contact` does for each of m configurations (m, k), all of whose boxes are compared at once."""
        found: list[Pair | None] = []
        for begin in range(0, len(configurations), _AT_ONCE):
            found.extend(self._some_contacts(configurations[begin : begin + _AT_ONCE]))
        return found

    def _some_contacts(self, configurations: Floats) -> Sequence[Pair | None]:
        scene, about = self._scene, self._asked
        scene.place(self._snapshot)
        placed, last = np.empty((len(configurations), len(about.moved), 4, 4)), np.empty(len(configurations), np.int64)
        overlaps, depths = self._overlaps(configurations, placed, last)
        found: list[Pair | None] = [None] * len(configurations)
        first = np.concatenate([[0], last[:-1]])
        there, moved = scene.placed.world_t_element[about.moved], about.moved.tolist()
        for number in np.flatnonzero(last > first).tolist():
            these = slice(first[number], last[number])
            # As `first_touching` asks them: robot after robot, the deepest boxes first.
            nearest = np.lexsort((-depths[these], about.group[overlaps[these, 0]]))
            scene.placed.put(moved, placed[number])
            found[number] = scene.first_of(overlaps[these][nearest], self.counts)
        scene.placed.put(moved, there)
        return found

    def _overlaps(self, configurations: Floats, placed: Floats, last: Integers) -> tuple[Integers, Floats]:
        """Return overlaps (p, 4) and depths (p,), and write where elements are and where overlaps end: see there."""
        snapshot, about, scene = self._snapshot, self._asked, self._scene
        forest, bodies, state = snapshot.structure.forest, scene.bodies, snapshot.state
        tree = forest.parent, forest.joint_type, forest.axis, forest.q_index, forest.multiplier, forest.offset
        given = about.moving, *tree, state.parent_t_node, state.q, self._q_index.astype(np.int64), configurations
        elements = bodies.rows, bodies.node_t_element, scene.placed.core[0], scene.placed.reach, about.moved
        boxes = about.own, about.asked, scene.world_t_element, *scene.placed.blocks
        room, count = _ROOM, _ROOM + 1
        while count > room:
            room = max(room, count)
            found, depths = np.empty((room, 4), np.int64), np.empty(room)
            count = overlapping_boxes_at_each(
                *given, snapshot.world_t_node, *elements, *boxes, placed, last, found, depths
            )
        return found[:count], depths[:count]

    @cached_property
    def _asked(self) -> _Asked:
        bodies, snapshot = self._scene.bodies, self._snapshot
        moved = self._moves_row[bodies.rows]
        chosen = np.isin(bodies.robots, list(self.robots))
        owns, rows, group = (
            [np.zeros(0, np.int64)],
            [np.zeros((0, len(moved)), np.bool_)],
            np.zeros(len(moved), np.int64),
        )
        for place, (robot, own, asked) in enumerate(bodies.groups):
            owns.append(own)
            rows.append(asked if robot in self.robots else asked & chosen)
            group[own] = place
        own = np.concatenate(owns)
        asked = np.concatenate(rows) & (moved[own][:, None] | moved)
        # What moves together, as fingers on a hand do, counts as little as what stands.
        one, other = np.nonzero(asked & moved[own][:, None] & moved)
        was, now = (
            np.linalg.solve(poses[bodies.rows[own[one]]], poses[bodies.rows[other]])
            for poses in (snapshot.world_t_node, self._off)
        )
        together = np.abs(was - now).max(axis=(1, 2), initial=0.0) <= ROUNDING
        asked[one[together], other[together]] = False
        some = asked.any(axis=1)
        order = snapshot.structure.forest.order
        return _Asked(order[self._moves_row[order]], np.flatnonzero(moved), own[some], asked[some], group)

    def standing(self) -> list[Pair]:
        """Return the pairs of nodes (uids) of these robots that touch and may not, wherever the arm is."""
        self._scene.place(self._snapshot)
        return sorted(pair for pair in self._scene.touching(self.robots) if not self.counts(pair))
