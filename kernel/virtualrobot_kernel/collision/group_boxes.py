"""Boxes around all that groups of joints carry, on each part of their paths: those of two groups are often apart."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.bodies import Bodies
from virtualrobot_kernel.collision.joint_path import JointPath
from virtualrobot_kernel.collision.kinematic_groups import KinematicGroups
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import RESOLUTION
from virtualrobot_kernel.numeric.motion_bounds import element_travels, joint_travels
from virtualrobot_kernel.planning.robots import poses_of_rows
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

PART = 0.1
"""Distance (m) that anything goes on a part of a path, about; smaller parts have smaller boxes."""

MOST_PARTS = 24
"""Into how many parts a path is cut at the most."""


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Boxes of k elements on the s parts of a path.

    Attributes:
        elements: (k,).
        ends: (s,) up to where on the path each part is; inf for what stands.
        low: (s, k, 3) the least coordinates (m) of the box around each element on each part, along the world's axes.
        high: (s, k, 3) the greatest ones.
        around: the least and the greatest coordinates of all of them.
    """

    elements: Integers
    ends: Floats
    low: Floats
    high: Floats
    around: tuple[list[float], list[float]] = field(init=False)

    def __post_init__(self) -> None:
        """Derive the box around all."""
        around = self.low.min(axis=(0, 1)).tolist(), self.high.max(axis=(0, 1)).tolist()
        object.__setattr__(self, "around", around)

    def since(self, u: float) -> Boxes:
        """Return the boxes of a path from a place on; the parts before are over."""
        first = min(int(np.searchsorted(self.ends, u)), len(self.ends) - 1)
        return Boxes(self.elements, self.ends[first:], self.low[first:], self.high[first:]) if first else self


class GroupBoxes:
    """The boxes of the groups of one world, and which groups they keep apart. Used by one thread."""

    def __init__(self, scene: CollisionScene) -> None:
        """Know nothing yet; others may use the scene, too."""
        self._scene = scene
        self._boxes: dict[int, Boxes] = {}
        self._asked: dict[tuple[int, int], Booleans] = {}
        self._apart: dict[tuple[int, int], tuple[Boxes, Boxes, bool]] = {}
        self._known: tuple[frozenset[int], frozenset[int]] | None = None
        self._meeting: list[tuple[int, int]] = []

    def forget(self, group: int) -> None:
        """Take a group for elsewhere than it was."""
        self._boxes.pop(group, None)
        self._known = None

    def meeting(
        self,
        now: Snapshot,
        groups: KinematicGroups,
        robots: Collection[int],
        paths: Mapping[int, JointPath],
        reached: Callable[[int], float],
        left_out: Collection[int],
    ) -> list[tuple[int, int]]:
        """Return the pairs of groups, one of which at least goes along a path, whose boxes meet.

        Args:
            now: the world; what was not forgotten stands, or is on the path that it was on.
            groups: the groups of it.
            robots: pairs with one of these robots (uids) are asked, always the same.
            paths: of groups that move, the path to its end; all others stand.
            reached: tells where on its path a group is.
            left_out: groups that are not asked.
        """
        known = frozenset(paths), frozenset(left_out)
        if self._known != known:
            self._scene.place(now)
            carried = groups.rows[self._scene.bodies.rows]
            others = [group for group in np.unique(carried).tolist() if group and group not in left_out]
            for group in others:
                if group not in self._boxes:
                    elements = np.flatnonzero(carried == group)
                    if group in paths:
                        path = replace(paths[group], begin=reached(group))
                        self._boxes[group] = swept_boxes(self._scene, now, path, elements)
                    else:
                        self._boxes[group] = standing(self._scene, elements)
            pairs = ((one, other) for one in others for other in others if one < other)
            asked = (pair for pair in pairs if not paths.keys().isdisjoint(pair))
            self._known, self._meeting = known, [pair for pair in asked if not self._are_apart(pair, robots)]
        elif self._meeting:
            self._scene.place(now)
            near = {group for pair in self._meeting for group in pair}
            less = {group for group in near if self._shrinks(group, paths, reached)}
            kept = (pair for pair in self._meeting if less.isdisjoint(pair) or not self._are_apart(pair, robots))
            self._meeting = list(kept)
        return self._meeting

    def _shrinks(self, group: int, paths: Mapping[int, JointPath], reached: Callable[[int], float]) -> bool:
        """Return whether the boxes of a group have become fewer, because parts of its path are over."""
        boxes = self._boxes[group]
        if group in paths:
            self._boxes[group] = boxes.since(reached(group))
        elif boxes.ends[0] < np.inf:
            self._boxes[group] = standing(self._scene, boxes.elements)
        return self._boxes[group] is not boxes

    def _are_apart(self, pair: tuple[int, int], robots: Collection[int]) -> bool:
        one, other = self._boxes[pair[0]], self._boxes[pair[1]]
        if _far(one, other):
            return True
        known = self._apart.get(pair)
        if known is None or known[0] is not one or known[1] is not other:
            asked = self._asked.get(pair)
            if asked is None:
                asked = self._asked[pair] = asked_between(self._scene.bodies, one.elements, other.elements, robots)
            known = self._apart[pair] = one, other, apart(one, other, asked)
        return known[2]


def standing(scene: CollisionScene, elements: Integers) -> Boxes:
    """Return the boxes of elements where they are in a scene."""
    centre, half = scene.placed.centre[elements], scene.placed.half[elements]
    return Boxes(elements, np.array([np.inf]), (centre - half)[None], (centre + half)[None])


def swept_boxes(scene: CollisionScene, snapshot: Snapshot, path: JointPath, elements: Integers) -> Boxes:
    """Return the boxes of elements of a scene that a path of joints, told exactly, carries through a snapshot.

    Each is the box in the middle of a part, grown by how far the joints carry the element from there at the most.
    """
    bodies, placed, structure = scene.bodies, scene.placed, snapshot.structure
    forest, count = structure.forest, len(snapshot.world_t_node)
    joint, moving = np.zeros((count, 2)), np.zeros(count, np.bool_)
    room = np.zeros(count, np.int32), np.zeros(count, np.int32)
    rows, node_t_element = bodies.rows[elements], bodies.node_t_element[elements]
    core, reach = (placed.core[0][elements], placed.core[1][elements]), placed.reach[elements]
    tree = forest.order, forest.parent, forest.joint_type, forest.q_index, forest.multiplier

    def part(begin: float, end: float) -> tuple[Floats, Floats, Floats]:
        middle = 0.5 * (begin + end)
        first, q, last = (np.ascontiguousarray(path.at(u)) for u in (begin, middle, end))
        nodes = poses_of_rows(structure, forest.order, snapshot.state.parent_t_node, q)
        way = np.maximum(path.travel(begin, middle), path.travel(middle, end))
        joint_travels(*tree, np.ascontiguousarray(way), first, last, joint, moving, *room)
        poses, travel = nodes[rows] @ node_t_element, np.empty(len(elements))
        about = nodes, forest.parent, forest.joint_type, forest.axis, joint, moving
        element_travels(*about, rows, poses, *core, travel)
        turn = poses[:, :3, :3]
        centre = np.einsum("kij,kj->ki", turn, core[0]) + poses[:, :3, 3]
        half = np.einsum("kij,kj->ki", np.abs(turn), reach) + travel[:, None]
        return centre - half, centre + half, travel

    farthest = float(part(path.begin, path.end)[2].max(initial=0.0))
    parts = min(max(int(np.ceil(2.0 * farthest / PART)), 1), MOST_PARTS)
    breaks = np.linspace(path.begin, path.end, parts + 1)
    boxes = [part(begin, end) for begin, end in zip(breaks[:-1].tolist(), breaks[1:].tolist(), strict=True)]
    return Boxes(elements, breaks[1:], np.array([one[0] for one in boxes]), np.array([one[1] for one in boxes]))


def asked_between(bodies: Bodies, ours: Integers, theirs: Integers, robots: Collection[int]) -> Booleans:
    """Return which pairs (k, l) of one of our elements (k,) and one of theirs (l,) are asked, if of these robots."""
    found = np.zeros((len(ours), len(theirs)), np.bool_)
    for _, own, asked in bodies.groups:
        for one, other, way in ((ours, theirs, found), (theirs, ours, found.T)):
            _, places, rows = np.intersect1d(own, one, assume_unique=True, return_indices=True)
            way[rows] |= asked[places][:, other]
    guarded = np.isin(bodies.robots, list(robots))
    return found & (guarded[ours][:, None] | guarded[theirs][None])


def apart(one: Boxes, other: Boxes, asked: Booleans) -> bool:
    """Return whether no two boxes of pairs that are asked (k, l) meet, or come nearer than can be told apart."""
    ours, theirs = np.flatnonzero(asked.any(axis=1)), np.flatnonzero(asked.any(axis=0))
    if not len(ours):
        return True
    low, high = one.low[:, ours], one.high[:, ours]
    lows, highs = other.low[:, theirs], other.high[:, theirs]
    outer = low.min(axis=1)[:, None], high.max(axis=1)[:, None], lows.min(axis=1)[None], highs.max(axis=1)[None]
    pairs = asked[np.ix_(ours, theirs)]
    for row, to in zip(*np.nonzero(~_gaps(*outer)), strict=True):
        gaps = _gaps(low[row][:, None], high[row][:, None], lows[to][None], highs[to][None])
        if (~gaps & pairs).any():
            return False
    return True


def _far(one: Boxes, other: Boxes) -> bool:
    (low, high), (lows, highs) = one.around, other.around
    return any(lows[i] - high[i] > RESOLUTION or low[i] - highs[i] > RESOLUTION for i in range(3))


def _gaps(low: Floats, high: Floats, lows: Floats, highs: Floats) -> Booleans:
    return np.asarray(np.maximum(lows - high, low - highs).max(axis=-1) > RESOLUTION)
