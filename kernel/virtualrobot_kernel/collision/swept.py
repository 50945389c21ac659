"""Swept check of joint paths: free of collisions on all of it and not only at places on it, or where it first is not.

What trees of balls say is certainly free (`certain.py`) is not looked at here. The rest is, by adaptive bisection (F.
Schwarzer, M. Saha, J.-C. Latombe, Adaptive dynamic collision checking for single and multiple articulated robots in
complex environments, IEEE Transactions on Robotics 21, 2005): a pair cannot meet on a stretch where points of both go
less far together, seen from what carries both, than the sum of the pair's distances at the stretch's ends. Each pair is
dropped from all of a stretch where that is so; what is left is looked at in halves. Distances are bounded by turned
boxes and by what was measured before; FCL measures where that is not enough.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair, ordered
from virtualrobot_kernel.collision.certain import cell_of, doubts, is_told
from virtualrobot_kernel.collision.joint_path import JointPath
from virtualrobot_kernel.collision.pairs import least_distance, pair_of
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.numeric.boxes import follow_nodes
from virtualrobot_kernel.numeric.motion_bounds import element_travels, joint_travels
from virtualrobot_kernel.numeric.sweeping import boxes_in_reach, pairs_in_reach
from virtualrobot_kernel.planning.robots import poses_of_rows
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

RESOLUTION = 1e-4
"""Distance (m) below which a contact may be told; below half of it, it is."""

BLOCKS_WITHIN, MEASURED_WITHIN = 1.0, 0.1
"""On stretches where a pair goes farther than these (m) against each other, turned boxes are not compared, and nothing
is measured: it would seldom be enough."""

WORTH = 0.1
"""A pair whose bounds are at least this part of what they must be is rather looked at in halves than measured."""

MEASURED_BEYOND = 0.05
"""Distances are measured so much farther (m) than the stretch needs: what is known then holds for other places too."""


@dataclass(frozen=True, slots=True, eq=False)
class SweptContact:
    """The first contact on a way.

    Attributes:
        time: up to it no pair that is asked touches, and there, or by the resolution farther on, this pair does.
        first: a node (uid), and `second` another one, with a greater uid.
        distance: in m at that time; 0 where they touch.
        points: (2, 3) the nearest points of both at that time, in the world's frame.
        q: (nq,) where the joints are then.
    """

    time: float
    first: int
    second: int
    distance: float
    points: Floats
    q: Floats


def first_contact(
    scene: CollisionScene,
    snapshot: Snapshot,
    path: JointPath,
    *,
    robots: Collection[int] | None = None,
    tolerated: Collection[Pair] = (),
    resolution: float = RESOLUTION,
    given_up: Callable[[], bool] | None = None,
    asked: Callable[[Integers], Booleans] | None = None,
) -> SweptContact | None:
    """Return the first contact on a way; None: there is none, at any time of it.

    Asked are the pairs of the collision scene that move against each other on the way. What hangs together, what tools
    look like, and all joints that the way doesn't move are as in the snapshot, or as the way has them.

    Args:
        scene: is used for it; it stands at the snapshot afterwards.
        snapshot: the world.
        path: the way of all joints.
        robots: only pairs with one of these robots (uids) are asked; None means all.
        tolerated: pairs of nodes (uids, the smaller first) that are not asked, such as those that touch already.
        resolution: what comes nearer than this (m), and than four times as far as the way's wobble carries it, may be
            told as a contact.
        given_up: whether nobody waits for it any more; KernelError (WRONG_STATE) is raised then.
        asked: tells which pairs of nodes (k, 2), given by their rows, are asked at all; None means all.
    """
    scene.place(snapshot)
    sweep = _Sweep(scene, snapshot, path, resolution, given_up)
    try:
        return sweep.first(robots, frozenset(tolerated), asked)
    finally:
        sweep.put_back()


def free_until(
    scene: CollisionScene,
    snapshot: Snapshot,
    path: JointPath,
    robots: Collection[int],
    tolerated: Collection[Pair],
    asked: Callable[[Integers], Booleans],
) -> float:
    """Return up to when a way is certainly free: its end, or a time from which on `first_contact` may tell a contact.

    It is asked as that is, and is quicker where something is near.
    """
    scene.place(snapshot)
    sweep = _Sweep(scene, snapshot, path, RESOLUTION, None)
    try:
        return sweep.free(robots, frozenset(tolerated), asked)
    finally:
        sweep.put_back()


class _Instant:
    """The elements at one time of the way, and what is known of the distances of the pairs there.

    `bounds` (k,) are lower bounds (m), and `known` says what they are from: 0 nothing, 1 boxes along the world's axes,
    2 turned boxes and what was measured before, 3 measured.
    """

    __slots__ = ("bounds", "centre", "half", "known", "q", "time", "world_t_element", "world_t_node")

    def __init__(self, time: float, q: Floats, nodes: Floats, boxes: tuple[Floats, Floats, Floats]) -> None:
        self.time, self.q, self.world_t_node = time, q, nodes
        self.world_t_element, self.centre, self.half = boxes
        self.begin(0)

    def begin(self, pairs: int) -> None:
        """Know nothing of so many pairs."""
        self.bounds, self.known = np.zeros(pairs), np.zeros(pairs, np.int8)


class _Sweep:
    """One check of one way."""

    def __init__(
        self,
        scene: CollisionScene,
        snapshot: Snapshot,
        path: JointPath,
        resolution: float,
        given_up: Callable[[], bool] | None,
    ) -> None:
        self._scene, self._placed, self._bodies = scene, scene.placed, scene.bodies
        self._snapshot, self._path, self._given_up = snapshot, path, given_up
        self._resolution = resolution
        rows = len(snapshot.world_t_node)
        self._joint, self._moving = np.zeros((rows, 2)), np.zeros(rows, np.bool_)
        self._depth, self._moved_rows = np.zeros(rows, np.int32), np.zeros(rows, np.int32)
        self._moved = np.empty(len(self._bodies.rows), np.int64)
        self._wobble = 0.0 if path.wobble is None else path.wobble
        self._pairs, self._slots = np.zeros((0, 2), np.int64), np.zeros(0, np.int64)
        self._unsure = np.zeros(0)
        self._elsewhere: set[int] = set()
        placed = scene.placed
        self._stood, self._boxes = placed.world_t_element.copy(), (placed.centre.copy(), placed.half.copy())

    def first(
        self,
        robots: Collection[int] | None,
        tolerated: Collection[Pair],
        asked: Callable[[Integers], Booleans] | None,
    ) -> SweptContact | None:
        """Return the first contact."""
        pairs = self._near(robots, tolerated, asked)
        for begin, end in self._doubts(pairs) if len(pairs) else ():
            contact = self._first_between(begin, end, pairs)
            if contact is not None:
                return contact
        return None

    def free(
        self, robots: Collection[int], tolerated: Collection[Pair], asked: Callable[[Integers], Booleans]
    ) -> float:
        """Return up to when nothing touches for certain."""
        pairs = self._near(robots, tolerated, asked)
        for begin, end in self._doubts(pairs) if len(pairs) else ():
            if not is_told(self._snapshot, self._path):
                contact = self._first_between(begin, end, pairs)
                return end if contact is None else contact.time
            return begin
        return self._path.end

    def _near(
        self,
        robots: Collection[int] | None,
        tolerated: Collection[Pair],
        asked: Callable[[Integers], Booleans] | None,
    ) -> Integers:
        """Return which pairs (k,) of those that are asked may meet, by how far they are apart midway."""
        path, none = self._path, np.zeros(0, np.int64)
        middle = self._instant(0.5 * (path.begin + path.end))
        half_way = np.maximum(path.travel(path.begin, middle.time), path.travel(middle.time, path.end))
        if not self._go(middle, middle, half_way + self._wobble):
            return none
        pairs = self._asked(middle, robots, tolerated, asked)
        if not len(pairs):
            return none
        self._pairs, self._slots = pairs, self._scene.remembered.slots(pairs)
        middle.begin(len(pairs))
        self._unsure = np.zeros(len(pairs))
        if path.wobble is not None:
            self._go(middle, middle, 2.0 * path.wobble)
            wobbling, travel = self._in_reach(middle, middle, np.arange(len(pairs)), np.inf)
            self._unsure[wobbling] = 2.0 * travel
            self._go(middle, middle, half_way + self._wobble)
        # From the middle each end is on its own: twice its distance stands for the sum.
        return self._in_reach(middle, middle, np.arange(len(pairs)), 2.0)[0]

    def _doubts(self, pairs: Integers) -> Iterator[tuple[float, float]]:
        """Yield the stretches of the way on which pairs (k,) may meet: all of it, where balls do not tell of it."""
        path = self._path
        begin, chosen = self._instant(path.begin), self._pairs[pairs]
        if not is_told(self._snapshot, path) or self._inside(begin, chosen):
            yield path.begin, path.end
            return
        for piece in path.pieces:
            ends = max(path.begin, piece.begin), min(path.end, piece.end)
            if ends[0] < ends[1]:
                start = self._instant(ends[0])
                cell = cell_of(self._scene, self._snapshot, piece.columns, chosen)
                poses = start.q, start.world_t_node, start.world_t_element
                yield from doubts(cell, poses, piece, path.wobble, ends, 0.5 * self._resolution)

    def _inside(self, instant: _Instant, pairs: Integers) -> bool:
        """Return whether any two elements (k, 2) touch, one of which is solid and so may be around the other."""
        (one, other), solid = pairs.T, self._placed.figures.solid
        apart = np.abs(instant.centre[one] - instant.centre[other]) > instant.half[one] + instant.half[other]
        for first, second in pairs[(solid[one] | solid[other]) & ~apart.any(axis=1)].tolist():
            self._put(instant, first, second)
            if least_distance(self._placed, first, second, 0.0) == 0.0:
                return True
        return False

    def _first_between(self, first: float, last: float, pairs: Integers) -> SweptContact | None:
        """Return the first contact of pairs (k,) between two times."""
        begin, end = self._instant(first), self._instant(last)
        begin.begin(len(self._pairs))
        end.begin(len(self._pairs))
        waiting = [(begin, end, pairs)]
        while waiting:
            begin, end, pairs = waiting.pop()
            if self._given_up is not None and self._given_up():
                raise KernelError("nobody waits for this check any more", reason=Reason.WRONG_STATE)
            left, contact = self._left(begin, end, pairs)
            if contact is not None:
                return contact
            if len(left):
                between = self._instant(0.5 * (begin.time + end.time))
                between.begin(len(self._pairs))
                waiting += [(between, end, left), (begin, between, left)]
        return None

    def put_back(self) -> None:
        """Put the scene's elements back to where they were."""
        if self._elsewhere:
            elements = np.array(sorted(self._elsewhere), np.int64)
            self._placed.move_some(elements, self._stood[elements])

    def _instant(self, time: float) -> _Instant:
        snapshot, placed, bodies = self._snapshot, self._placed, self._bodies
        q = np.ascontiguousarray(self._path.at(time), np.float64)
        forest = snapshot.structure.forest
        nodes = poses_of_rows(snapshot.structure, forest.order, snapshot.state.parent_t_node, q)
        boxes = self._stood.copy(), self._boxes[0].copy(), self._boxes[1].copy()
        local = placed.core[0], placed.reach
        follow_nodes(nodes, snapshot.world_t_node, bodies.rows, bodies.node_t_element, *local, *boxes, self._moved)
        return _Instant(time, q, nodes, boxes)

    def _go(self, begin: _Instant, end: _Instant, travel: Floats) -> bool:
        """Take joints to go a way `travel` (nq,); return whether any does."""
        forest = self._snapshot.structure.forest
        tree = forest.order, forest.parent, forest.joint_type, forest.q_index, forest.multiplier
        found = self._joint, self._moving, self._depth, self._moved_rows
        return joint_travels(*tree, np.ascontiguousarray(travel), begin.q, end.q, *found) > 0

    def _asked(
        self,
        instant: _Instant,
        robots: Collection[int] | None,
        tolerated: Collection[Pair],
        asked: Callable[[Integers], Booleans] | None,
    ) -> Integers:
        """Return the pairs (k, 2) of elements that are asked and may meet by how far their boxes are apart there."""
        bodies, forest = self._bodies, self._snapshot.structure.forest
        travel = np.empty(len(bodies.rows))
        element_travels(
            instant.world_t_node,
            *(forest.parent, forest.joint_type, forest.axis),
            *(self._joint, self._moving),
            *(bodies.rows, instant.world_t_element, *self._placed.core, travel),
        )
        found, end = np.empty((256, 2), np.int64), 0
        for _, own, theirs in bodies.groups:
            begin = end
            end = boxes_in_reach(own, theirs, instant.centre, instant.half, travel, found, begin)
            if end > len(found):
                found = np.concatenate([found, np.empty((2 * end, 2), np.int64)])
                end = boxes_in_reach(own, theirs, instant.centre, instant.half, travel, found, begin)
        found = found[:end]
        if asked is not None:
            found = found[asked(bodies.rows[found])]
        if robots is not None:
            found = found[np.isin(bodies.robots[found], list(robots)).any(axis=1)]
        if tolerated:
            kept = [ordered(*pair) not in tolerated for pair in bodies.uids[found].tolist()]
            found = found[np.array(kept, np.bool_)]
        return np.ascontiguousarray(found)

    def _left(self, begin: _Instant, end: _Instant, pairs: Integers) -> tuple[Integers, SweptContact | None]:
        """Return which pairs (k,) are not proven apart on a stretch, and the contact that is told, if one is."""
        resolution = self._resolution
        self._go(begin, end, self._path.travel(begin.time, end.time) + 2.0 * self._wobble)
        pairs, travel = self._in_reach(begin, end, pairs, 1.0)
        last = not begin.time < 0.5 * (begin.time + end.time) < end.time
        left = []
        for pair, way in zip(pairs.tolist(), travel.tolist(), strict=True):
            small = way <= resolution + self._unsure[pair] or last
            if small or (way <= MEASURED_WITHIN and begin.bounds[pair] + end.bounds[pair] <= WORTH * way):
                if self._apart(begin, end, pair, way):
                    continue
                if small or begin.bounds[pair] <= 0.5 * resolution:
                    return pairs, self._contact(begin, pair)
            left.append(pair)
        return np.array(left, np.int64), None

    def _apart(self, begin: _Instant, end: _Instant, pair: int, travel: float) -> bool:
        """Return whether measuring proves a pair apart on a stretch; nothing is measured in vain."""
        for learn in (self._recall, self._measure):
            for instant in (begin, end):
                learn(instant, pair, travel)
                if begin.bounds[pair] + end.bounds[pair] > travel:
                    return True
                if begin.known[pair] == 3 and begin.bounds[pair] <= 0.5 * self._resolution:
                    return False
        return False

    def _in_reach(self, begin: _Instant, end: _Instant, pairs: Integers, far: float) -> tuple[Integers, Floats]:
        """Return which pairs (k,) may meet on a stretch by what is known of them, and how far each travels there (k,).

        They may when so many times their travel is no less than their distances at both ends together.
        """
        forest, bodies, placed = self._snapshot.structure.forest, self._bodies, self._placed
        left, travel = np.empty(len(pairs), np.int64), np.empty(len(pairs))
        count = pairs_in_reach(
            *(pairs, self._pairs, self._slots),
            *(begin.world_t_node, forest.parent, forest.joint_type, forest.axis),
            *(self._joint, self._moving, self._depth, bodies.rows),
            *(*placed.core, *placed.blocks, *self._scene.remembered.kept),
            *(begin.world_t_element, begin.centre, begin.half, begin.bounds, begin.known),
            *(end.world_t_element, end.centre, end.half, end.bounds, end.known),
            *(BLOCKS_WITHIN, far, left, travel),
        )
        return left[:count], travel[:count]

    def _recall(self, instant: _Instant, pair: int, travel: float) -> None:
        """Know the distance of a pair by what was measured since it was bounded."""
        del travel
        if instant.known[pair] < 3:
            one, other = self._pairs[pair].tolist()
            known = self._scene.remembered.bound(one, other, self._slots[pair], instant.world_t_element)
            instant.bounds[pair] = max(instant.bounds[pair], known)

    def _measure(self, instant: _Instant, pair: int, travel: float) -> None:
        """Know the distance of a pair, measured as far as it matters for so much travel (m)."""
        if instant.known[pair] < 3:
            one, other = self._pairs[pair].tolist()
            self._put(instant, one, other)
            distance = least_distance(self._placed, one, other, travel + MEASURED_BEYOND)
            self._slots[pair] = self._scene.remembered.add(one, other, instant.world_t_element, distance)
            instant.bounds[pair] = max(instant.bounds[pair], distance)
            instant.known[pair] = 3

    def _put(self, instant: _Instant, one: int, other: int) -> None:
        elements = np.array([one, other])
        self._elsewhere.update((one, other))
        self._placed.move_some(elements, instant.world_t_element[elements])

    def _contact(self, instant: _Instant, pair: int) -> SweptContact:
        one, other = self._pairs[pair].tolist()
        self._put(instant, one, other)
        near = pair_of(self._placed, self._placed, one, other)
        assert near is not None, "an element that has nothing is near to nothing"
        uids, points = self._bodies.uids[[one, other]].tolist(), near.points
        if uids[0] > uids[1]:
            uids, points = uids[::-1], points[::-1]
        return SweptContact(instant.time, uids[0], uids[1], near.distance, points, instant.q)
