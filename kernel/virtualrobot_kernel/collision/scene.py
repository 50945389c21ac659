"""The collision scene of one thread: what touches in a snapshot, and how far things are apart."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair, ordered
from virtualrobot_kernel.collision.bodies import Bodies, bodies_of, made_of
from virtualrobot_kernel.collision.depth import Depth, depth_of
from virtualrobot_kernel.collision.distance_cache import DistanceCache
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.pairs import box_distances, is_near, pair_of, pair_within
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.touching import Contacts, touches
from virtualrobot_kernel.world.state import Snapshot, unchanged

Floats = NDArray[np.float64]


class Detail(Enum):
    """Amount of what is told of contacts."""

    FIRST = "first"
    PAIRS = "pairs"
    CONTACTS = "contacts"


@dataclass(frozen=True, slots=True, eq=False)
class Collision:
    """Two nodes that touch and may not.

    Attributes:
        first: a node (uid), and `second` another one.
        contacts: where, for each two figures that touch; empty where only pairs were asked for.
        depth: how deep their figures are in each other, the deepest ones; None where it was not asked for.
    """

    first: int
    second: int
    contacts: tuple[Contacts, ...] = ()
    depth: Depth | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """Two nodes (uids), how far they are apart without their paddings (m; 0 where they touch), and the nearest points.

    The points (2, 3) are on the true surface of each.
    """

    first: int
    second: int
    distance: float
    points: Floats


class CollisionScene:
    """Collision elements at their places, for FCL; used by one thread at a time. All scenes share the geometry."""

    def __init__(self, shapes: CollisionShapes) -> None:
        """Begin with nothing; `place` puts a world in."""
        self._shapes = shapes
        self._bodies: Bodies | None = None
        self._snapshot: Snapshot | None = None
        self._placed = Placed((), np.zeros((0, 4, 4)))
        self._remembered = DistanceCache(self._placed)
        self._world_t_node = np.zeros((0, 4, 4))
        self._uids: list[int] = []
        self._chosen: tuple[Bodies | None, frozenset[int], NDArray[np.bool_]] = None, frozenset(), np.zeros(0, np.bool_)

    @property
    def bodies(self) -> Bodies:
        """Return the elements of the world that was put in last."""
        assert self._bodies is not None, "nothing was placed"
        return self._bodies

    @property
    def world_t_element(self) -> Floats:
        """Return where the elements are in the world's frame, (e, 4, 4)."""
        return self._placed.world_t_element

    @property
    def placed(self) -> Placed:
        """Return the elements at their places; who puts some elsewhere puts them back."""
        return self._placed

    @property
    def remembered(self) -> DistanceCache:
        """Return the distances that were measured between these elements."""
        return self._remembered

    def place(self, snapshot: Snapshot, world_t_node: Floats | None = None) -> None:
        """Make this the scene of a snapshot: only what moved is put elsewhere, only what is new is made.

        With `world_t_node` (N, 4, 4) its nodes are there instead: a whole new snapshot would take longer than some
        checks.
        """
        before, world_t_node = self._bodies, snapshot.world_t_node if world_t_node is None else world_t_node
        if before is not None and (snapshot is self._snapshot or unchanged(before.made_of, made_of(snapshot))):
            if world_t_node is not self._world_t_node:
                self._placed.follow(world_t_node, self._world_t_node, before.rows, before.node_t_element)
        else:
            now = self._bodies = bodies_of(snapshot, self._shapes)
            self._uids = now.uids.tolist()
            poses = world_t_node[now.rows] @ now.node_t_element
            if before is not None and _same_elements(before, now):
                self._placed.move(poses)
            else:
                self._placed = Placed(now.solids, poses, self._placed, now.padding)
                self._remembered = DistanceCache(self._placed)
        self._snapshot, self._world_t_node = snapshot, world_t_node

    def collisions(
        self, detail: Detail, robots: Collection[int] | None = None, pairs: Collection[Pair] | None = None
    ) -> list[Collision]:
        """Return the pairs of nodes that touch and may not, at most one of them for Detail.FIRST.

        Asked are all pairs of an element of a robot and another element, but what may touch. Nodes with paddings touch
        where they are nearer than both together.

        Args:
            detail: how much is told.
            robots: only pairs with these robots (uids) are asked; None means all.
            pairs: of which contacts are asked; None means all.
        """
        if detail is not Detail.CONTACTS:
            return [Collision(*pair) for pair in sorted(self._touching(detail is Detail.FIRST, robots))]
        found: dict[Pair, list[Contacts]] = {}
        depths: dict[Pair, Depth] = {}
        uids = self.bodies.uids
        for one, other in dict.fromkeys(overlap[:2] for overlap in self._overlaps(robots)):
            pair = ordered(int(uids[one]), int(uids[other]))
            if pairs is not None and pair not in pairs:
                continue
            contacts = self._contacts(*((one, other) if uids[one] == pair[0] else (other, one)))
            if contacts is None:
                continue
            depth = depth_of(self._placed, self._placed, one, other)
            if pair in depths:
                # What is out of one figure may be in another still.
                depth = replace(max(depth, depths[pair], key=lambda one: one.meters), approximate=True)
            depths[pair] = depth
            found.setdefault(pair, []).append(contacts)
        return [Collision(*pair, tuple(contacts), depths[pair]) for pair, contacts in sorted(found.items())]

    def touching(self, robots: Collection[int] | None = None) -> set[Pair]:
        """Return the pairs of nodes (uids) that touch and may not, as `collisions` asks them."""
        return self._touching(False, robots)

    def first_touching(self, robots: Collection[int], counts: Callable[[Pair], bool]) -> Pair | None:
        """Return one pair of nodes (uids) that touch and may not, of those with these robots that count; or None."""
        return next(iter(self._touching(True, robots, counts=counts)), None)

    def first_of(self, overlaps: NDArray[np.int64], counts: Callable[[Pair], bool]) -> Pair | None:
        """Return the first pair of nodes (uids) that touch and count, of overlapping blocks (p, 4); or None."""
        return next(iter(self._touching_of(self._placed.pieces(overlaps), True, counts)), None)

    def self_collisions(self, robots: Collection[int]) -> set[Pair]:
        """Return the pairs of nodes of robots (uids), such as an arm and its grippers, that touch and may not."""
        return self._touching(False, robots, itself=True)

    def distances(self, ours: Collection[int], theirs: Collection[int], range_meters: float) -> list[Nearest]:
        """Return how far nodes are apart that may not touch, the nearest first.

        Args:
            ours: nodes (uids) of which each pair has one.
            theirs: nodes of which it has the other.
            range_meters: pairs farther apart are not told; 0 means that the nearest pair alone is, however far.
        """
        bodies, placed = self.bodies, self._placed
        first, second = (
            np.array([e for uid in uids for e in bodies.elements.get(uid, ())], np.int64) for uids in (ours, theirs)
        )
        boxes = ((placed.centre[side], placed.half[side]) for side in (first, second))
        bounds = box_distances(*boxes)
        found: dict[tuple[int, int], Nearest] = {}
        limit = range_meters or np.inf
        for at in np.argsort(bounds, axis=None).tolist():
            one, other = first[at // len(second)], second[at % len(second)]
            if bounds.flat[at] > limit:
                break
            uid, to = int(bodies.uids[one]), int(bodies.uids[other])
            pair = ordered(uid, to)
            if bodies.allowed.why(uid, to) or (pair in found and found[pair].distance <= bounds.flat[at]):
                continue
            near = pair_of(placed, placed, int(one), int(other))
            if near is None or near.distance > limit or (pair in found and near.distance >= found[pair].distance):
                continue
            found[pair] = Nearest(uid, to, near.distance, near.points)
            limit = limit if range_meters else near.distance
        nearest = sorted(found.values(), key=lambda one: one.distance)
        return nearest if range_meters else nearest[:1]

    def _touching(
        self,
        first: bool,
        robots: Collection[int] | None,
        itself: bool = False,
        counts: Callable[[Pair], bool] | None = None,
    ) -> set[Pair]:
        """Return the pairs of nodes that touch and may not; at most the first one that is found."""
        return self._touching_of(self._overlaps(robots, itself, first), first, counts)

    def _touching_of(
        self, overlaps: Iterable[tuple[int, int, int, int]], first: bool, counts: Callable[[Pair], bool] | None
    ) -> set[Pair]:
        uids, placed, found = self._uids, self._placed, set[Pair]()
        for one, other, row, to in overlaps:
            pair = ordered(uids[one], uids[other])
            if pair in found or (counts is not None and not counts(pair)):
                continue
            if touches(placed, one, other, row, to) or is_near(placed, one, other, row, to):
                found.add(pair)
                if first:
                    break
        return found

    def _contacts(self, one: int, other: int) -> Contacts | None:
        """Return where two elements touch, None where they don't."""
        near = pair_within(self._placed, self._placed, one, other, 0.0)
        return Contacts(near.contacts, near.normal) if near is not None and near.normal is not None else None

    def _overlaps(
        self, robots: Collection[int] | None, itself: bool = False, deepest_first: bool = False
    ) -> Iterator[tuple[int, int, int, int]]:
        """Yield the pairs of pieces that are asked and whose boxes overlap: element, element, row, row.

        Only pairs with these robots (None: all), or of these robots with themselves; of each robot's, perhaps the
        deepest first.
        """
        group, uids = self.bodies.allowed.groups, self._uids
        chosen = None if robots is None else self._elements_of(robots)
        for robot, own, asked in self.bodies.groups:
            ours = robots is None or robot in robots
            if chosen is not None and not ours:
                if itself or not (asked := asked & chosen).any():
                    continue
            for overlap in self._placed.overlaps(own, asked, deepest_first):
                theirs = robots is None or group[uids[overlap[1]]] in robots
                if (ours and theirs) if itself else (ours or theirs):
                    yield overlap

    def _elements_of(self, robots: Collection[int]) -> NDArray[np.bool_]:
        """Return which elements are of these robots (e,); the last answer is kept, as an arm asks again and again."""
        bodies, asked, chosen = self._chosen
        if bodies is not self._bodies or asked != robots:
            chosen = np.isin(self.bodies.robots, list(robots))
            self._chosen = self._bodies, frozenset(robots), chosen
        return chosen


def _same_elements(one: Bodies, other: Bodies) -> bool:
    same = one.figures == other.figures and np.array_equal(one.uids, other.uids)
    return same and np.array_equal(one.padding, other.padding)
