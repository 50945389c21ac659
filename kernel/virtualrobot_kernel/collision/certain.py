"""Configurations and ways of one arm that certainly touch nothing, asked of trees of balls; what is in doubt FCL says.

What is certain here FCL confirms; the reverse is not so, for balls are a few millimetres larger than what they are
around.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair, ordered
from virtualrobot_kernel.collision.geometry import Solid
from virtualrobot_kernel.collision.joint_path import lengths_of
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.tessellation import SEGMENTS
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.numeric.certainty import Cell, certain_places, doubtful_stretches
from virtualrobot_kernel.numeric.connecting import Room, line_is_certain, trees_meet
from virtualrobot_kernel.numeric.motion_bounds import joint_travels
from virtualrobot_kernel.world.figures import Box
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

SLACK = 1e-6
"""Distance (m) by which pairs are to be farther apart than they must: more than rounding."""


DOUBTS = 64
"""Greatest number of stretches that are told."""


class CertainlyFree:
    """Certainly free configurations and ways of an arm, while all else stands; used by one thread at a time."""

    def __init__(
        self,
        scene: CollisionScene,
        snapshot: Snapshot,
        q_index: NDArray[np.int32],
        robots: Collection[int],
        counts: Callable[[Pair], bool],
    ) -> None:
        """Take a world that the scene stands at, and where the arm's k coordinates are in q.

        robots: only pairs with one of these (uids) are asked, and of those the pairs of nodes (uids) that count.
        """
        bodies, placed, forest = scene.bodies, scene.placed, snapshot.structure.forest
        travel = np.zeros(len(snapshot.state.q))
        travel[q_index] = 1.0
        rows = len(snapshot.world_t_node)
        joint, moving, found = np.zeros((rows, 2)), np.zeros(rows, np.bool_), np.zeros(rows, np.int32)
        tree = forest.order, forest.parent, forest.joint_type, forest.q_index, forest.multiplier
        q = snapshot.state.q
        count = joint_travels(*tree, travel, q, q, joint, moving, np.zeros(rows, np.int32), found)
        coordinate = np.full(rows, -1, np.int64)
        places = {int(place): i for i, place in enumerate(q_index)}
        for row in np.flatnonzero(joint.any(axis=1)).tolist():
            coordinate[row] = places[int(forest.q_index[row])]
        moved = moving[bodies.rows]
        solids, box = bodies.solids, np.array([isinstance(one.geometry, Box) for one in bodies.figures], np.bool_)
        pairs = self._pairs(scene, moved, box, robots, counts)
        first, balls, skip = _trees(solids, pairs, box)
        thick = np.array([solid.radius + _beyond(solid) for solid in solids]) + placed.padding
        values = (
            *(found[:count], forest.parent, forest.joint_type, forest.axis, forest.q_index),
            *(forest.multiplier, forest.offset, snapshot.state.parent_t_node),
            *(np.asarray(q_index, np.int64), coordinate),
            *(bodies.rows, bodies.node_t_element, *placed.core, placed.reach, np.flatnonzero(moved)),
            *(pairs, thick[pairs].sum(axis=1) + SLACK),
            *(box, np.array([solid.solid is not None for solid in solids], np.bool_)),
            *(np.array([_corner(solid) for solid in solids]).reshape(-1, 3), first, balls, skip),
        )
        start = q, snapshot.world_t_node, scene.world_t_element
        self.pairs: NDArray[np.int64] = pairs
        """Pairs of elements (p, 2) that are asked."""
        self._cell = Cell(*(_kept(value) for value in values)), *(_kept(value) for value in start)

    def places(self, configurations: Floats) -> NDArray[np.bool_]:
        """Return which configurations (m, k) are certainly free (m,)."""
        certain = np.empty(len(configurations), np.bool_)
        certain_places(*self._cell, configurations, certain)
        return certain

    def doubts(self, path: PiecewisePolynomial) -> tuple[Floats, NDArray[np.int64]]:
        """Return begins and ends (d, 2), in order, of the stretches of a path of the coordinates (k,) in doubt.

        With them come the pairs of elements (m, 2) that may meet there. All else of the path is certainly free, and of
        all other pairs the whole path, where its begin is.
        """
        lengths, doubts, unsure = lengths_of(path), np.empty((DOUBTS, 2)), np.zeros(len(self.pairs), np.bool_)
        count = doubtful_stretches(
            *(*self._cell, path.breaks, path.coefficients),
            *(np.array(lengths.breaks), np.ascontiguousarray(lengths.gone), np.ascontiguousarray(lengths.slopes)),
            *(doubts, unsure),
        )
        return doubts[:count], self.pairs[unsure]

    def line(self, room: Room, begin: Floats, end: Floats, step: float) -> bool:
        """Return whether configurations on a line, at most `step` apart, are in the room and certainly free."""
        return line_is_certain(*self._cell, room, begin, end, step)

    def meet(self, room: Room, samples: Floats, reach: float, step: float, *trees: NDArray[Any]) -> bool:
        """Return whether two trees meet that grow towards samples (s, k), as `numeric.connecting.trees_meet` does."""
        return trees_meet(*self._cell, room, samples, reach, step, *trees)

    @staticmethod
    def _pairs(
        scene: CollisionScene,
        moved: NDArray[np.bool_],
        box: NDArray[np.bool_],
        robots: Collection[int],
        counts: Callable[[Pair], bool],
    ) -> NDArray[np.int64]:
        """Return the pairs of elements (p, 2) that are asked, the one that is asked as a box second."""
        bodies, ours = scene.bodies, np.isin(scene.bodies.robots, list(robots))
        found = []
        for _, own, asked in bodies.groups:
            for one, other in zip(*np.nonzero(asked), strict=True):
                first, second = int(own[one]), int(other)
                if not (moved[first] or moved[second]) or not (ours[first] or ours[second]):
                    continue
                if not (bodies.solids[first].pieces and bodies.solids[second].pieces):
                    continue
                if not counts(ordered(int(bodies.uids[first]), int(bodies.uids[second]))):
                    continue
                boxes_first = box[first] and (not box[second] or not moved[first])
                found.append((second, first) if boxes_first else (first, second))
        return np.array(found, np.int64).reshape(-1, 2)


def room_of(*limits: Floats) -> Room:
    """Return the room in which coordinates are within limits, given as `Room` has them."""
    return Room(*map(_kept, limits))


def _trees(
    solids: tuple[Solid, ...], pairs: NDArray[np.int64], box: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], Floats, NDArray[np.int64]]:
    """Return where the tree of each element begins (e,), and the balls and skips of all trees; equal ones are one."""
    needed = {*pairs[:, 0].tolist(), *(int(other) for other in pairs[:, 1] if not box[other])}
    first, begins, trees, end = np.full(len(solids), -1, np.int64), {}, [(np.zeros((0, 4)), np.zeros(0, np.int64))], 0
    for element in sorted(needed):
        solid = solids[element]
        if solid not in begins:
            begins[solid] = end
            trees.append(solid.balls)
            end += len(solid.balls[0])
        first[element] = begins[solid]
    return first, np.concatenate([one for one, _ in trees]), np.concatenate([one for _, one in trees])


def _beyond(solid: Solid) -> float:
    """Return by how much a round solid stands out of the triangles of its core, in m."""
    return 0.0 if solid.circles is None else max(solid.circles[1:]) * (1.0 - float(np.cos(np.pi / SEGMENTS)))


def _corner(solid: Solid) -> Floats:
    return solid.pieces[0].triangles[0, 0] if solid.pieces else np.zeros(3)


def _kept(value: NDArray[Any]) -> NDArray[Any]:
    """Return a copy that nobody writes to, as compiled code takes it."""
    kept = np.array(value, order="C")
    kept.setflags(write=False)
    return kept
