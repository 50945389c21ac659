"""Configurations and ways that certainly touch nothing, asked of trees of balls; what is in doubt FCL says.

What is certain here FCL confirms; the reverse is not so: of solids, what is in the box around one may be in it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair, ordered
from virtualrobot_kernel.collision.joint_path import JointPath, Piece
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.numeric.certainty import Cell, Way, certain_places, first_doubt
from virtualrobot_kernel.numeric.connecting import Room, line_is_certain, trees_meet
from virtualrobot_kernel.numeric.forest import FLOATING
from virtualrobot_kernel.numeric.memory import read_only
from virtualrobot_kernel.numeric.motion_bounds import joint_travels
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def cell_of(scene: CollisionScene, snapshot: Snapshot, q_index: NDArray[np.integer], pairs: Integers) -> Cell:
    """Return pairs (p, 2) of a scene's elements as compiled code asks them, while k coordinates of a snapshot move.

    q_index (k,): where in q these are; each is a joint's only one. The scene keeps what this has the addresses of.
    """
    bodies, placed, forest = scene.bodies, scene.placed, snapshot.structure.forest
    joint, moving, found = _moving(snapshot, q_index)
    own, moved, places = np.flatnonzero(joint.any(axis=1)), moving[bodies.rows], np.full(len(snapshot.state.q), -1)
    places[q_index] = np.arange(len(q_index))
    coordinate = np.full(len(moving), -1, np.int64)
    coordinate[own] = places[forest.q_index[own]]
    placed.make_trees(np.unique(pairs).tolist())
    values = (
        *(found, forest.parent, forest.joint_type, forest.axis, forest.q_index),
        *(forest.multiplier, forest.offset, snapshot.state.parent_t_node, q_index.astype(np.int64), coordinate),
        *(bodies.rows, bodies.node_t_element, placed.reach, np.flatnonzero(moved), pairs),
    )
    return Cell(*(_kept(value) for value in values), figures=placed.figures)


def is_told(snapshot: Snapshot, path: JointPath) -> bool:
    """Return whether `doubts` tells of a way: it has pieces, and what goes on them are joints of one coordinate."""
    forest = snapshot.structure.forest
    first = forest.q_index[np.flatnonzero(forest.joint_type >= FLOATING)]
    places = (first[:, None] + np.arange(JointType.FLOATING.coordinate_count)).ravel() if len(first) else first
    return bool(path.pieces) and not any(np.isin(places, one.columns).any() for one in path.pieces)


def doubts(
    cell: Cell,
    start: Sequence[Floats],
    piece: Piece,
    wobble: Floats | None,
    ends: tuple[float, float],
    shortest: float,
) -> Iterator[tuple[float, float]]:
    """Yield the stretches of a piece of a way, between two times, that are in doubt; all else of it is certainly free.

    Args:
        cell: the pairs that are asked; the coordinates that move are the piece's.
        start: q, the poses of nodes and of elements somewhere on the piece: what is outside of a solid there stays so.
        piece: the piece.
        wobble: (nq,) how far the true coordinates may be from what it says; None: they are not.
        ends: the first time, and the last one.
        shortest: as in `first_doubt`.
    """
    lengths, columns = piece.lengths, piece.columns
    way = (
        *(piece.path.breaks, piece.path.coefficients, piece.law.breaks, piece.law.coefficients),
        *(np.array(lengths.breaks), lengths.gone, lengths.slopes),
        np.zeros(len(columns)) if wobble is None else wobble[columns],
    )
    made = Way(*(_kept(value) for value in way))
    poses = tuple(_kept(value) for value in start)
    begin, end = max(ends[0], piece.begin), min(ends[1], piece.end)
    while begin < end:
        first, last = first_doubt(cell, *poses, made, begin - piece.after, end - piece.after, shortest)
        if first == np.inf:
            return
        first, begin = first + piece.after, min(max(last + piece.after, np.nextafter(begin, np.inf)), end)
        yield first, begin


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
        self.pairs = self._pairs(scene, snapshot, q_index, robots, counts)
        """Pairs of elements (p, 2) that are asked."""
        self._placed = scene.placed  # keeps the trees that the cell names by addresses
        start = snapshot.state.q, snapshot.world_t_node, scene.world_t_element
        self._cell = cell_of(scene, snapshot, q_index, self.pairs), *(_kept(value) for value in start)

    def places(self, configurations: Floats) -> NDArray[np.bool_]:
        """Return which configurations (m, k) are certainly free (m,)."""
        certain = np.empty(len(configurations), np.bool_)
        certain_places(*self._cell, configurations, certain)
        return certain

    def doubts(self, path: JointPath, shortest: float) -> Iterator[tuple[float, float]]:
        """Yield the stretches of a way on which the arm's coordinates go, and nothing else does, that are in doubt.

        All else of it is certainly free where its begin is; `shortest` is as in `first_doubt`.
        """
        cell, *start = self._cell
        for piece in path.pieces:
            yield from doubts(cell, start, piece, path.wobble, (path.begin, path.end), shortest)

    def line(self, room: Room, begin: Floats, end: Floats, step: float, margin: float) -> bool:
        """Return whether configurations on a line, at most `step` apart, are in the room and free by a margin (m)."""
        return line_is_certain(*self._cell, room, begin, end, step, margin)

    def meet(self, room: Room, samples: Floats, reach: float, step: float, margin: float, *trees: NDArray[Any]) -> bool:
        """Return whether two trees meet that grow towards samples (s, k), as `numeric.connecting.trees_meet` does."""
        return trees_meet(*self._cell, room, samples, reach, step, margin, *trees)

    @staticmethod
    def _pairs(
        scene: CollisionScene,
        snapshot: Snapshot,
        q_index: NDArray[np.integer],
        robots: Collection[int],
        counts: Callable[[Pair], bool],
    ) -> Integers:
        bodies, ours = scene.bodies, np.isin(scene.bodies.robots, list(robots))
        moved = _moving(snapshot, q_index)[1][bodies.rows]
        there = np.array([len(solid.pieces) > 0 for solid in bodies.solids], np.bool_)
        found = []
        for _, own, asked in bodies.groups:
            which = asked & (moved[own][:, None] | moved) & (ours[own][:, None] | ours) & there[own][:, None] & there
            for one, second in zip(*np.nonzero(which), strict=True):
                first = int(own[one])
                if counts(ordered(int(bodies.uids[first]), int(bodies.uids[second]))):
                    found.append((first, int(second)))
        return np.array(found, np.int64).reshape(-1, 2)


def room_of(*limits: Floats) -> Room:
    """Return the room in which coordinates are within limits, given as `Room` has them."""
    return Room(*map(_kept, limits))


def _moving(snapshot: Snapshot, q_index: NDArray[np.integer]) -> tuple[Floats, NDArray[np.bool_], NDArray[np.int32]]:
    """Return by how much joints (n, 2) move where coordinates do by 1, which rows do (n,), and these (m,) in order."""
    forest, q, rows = snapshot.structure.forest, snapshot.state.q, len(snapshot.world_t_node)
    travel = np.zeros(len(q))
    travel[q_index] = 1.0
    joint, moving, found = np.zeros((rows, 2)), np.zeros(rows, np.bool_), np.zeros(rows, np.int32)
    tree = forest.order, forest.parent, forest.joint_type, forest.q_index, forest.multiplier
    count = joint_travels(*tree, travel, q, q, joint, moving, np.zeros(rows, np.int32), found)
    return joint, moving, found[:count]


def _kept(value: NDArray[Any]) -> NDArray[Any]:
    """Return a copy that nobody writes to, as compiled code takes it."""
    return read_only(np.array(value, order="C"))
