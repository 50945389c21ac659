"""The tree of nodes as poses in the parents' frames: those that move, and the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.messages import array_of
from virtualrobot.recording import topics
from virtualrobot.v1 import nodes_pb2, scene_pb2

_NOISE = 1e-12
"""Difference between products of poses where nothing moves, in meters or parts of a quaternion."""

_STILL = (nodes_pb2.JOINT_TYPE_UNSPECIFIED, nodes_pb2.JOINT_TYPE_FIXED)


def relative(parents: NDArray[np.float64], children: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `parent_t_child` (n, 7) of poses in the world (n, 7), each x, y, z and the quaternion x, y, z, w."""
    # The inverse of a unit quaternion has the opposite axis.
    axis, w = -parents[:, 3:6], parents[:, 6:]
    shift, turn = children[:, :3] - parents[:, :3], children[:, 3:]
    out = np.empty_like(children)
    # v + 2 w (u x v) + 2 u x (u x v): v turned by the unit quaternion (u, w).
    twice = 2.0 * _cross(axis, shift)
    out[:, :3] = shift + w * twice + _cross(axis, twice)
    out[:, 3:6] = w * turn[:, :3] + turn[:, 3:] * axis + _cross(axis, turn[:, :3])
    out[:, 6] = w[:, 0] * turn[:, 3] - (axis * turn[:, :3]).sum(axis=1)
    return out


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cross products of rows (n, 3), in a fifth of the time that NumPy's own takes for few rows."""
    return a[:, _NEXT] * b[:, _AFTER] - a[:, _AFTER] * b[:, _NEXT]


_NEXT, _AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])


@dataclass(slots=True)
class _Frame:
    """A node: its name, the name of its parent, and whether it moves in its parent's frame."""

    name: str
    parent: str
    moves: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class FrameGroup:
    """Frames that are told together; another group of a topic takes its place where the tree changes.

    Attributes:
        topic: `/transforms` of those that move, `/transforms/fixed` of the rest.
        rows: their places in the arrays of `Frames`.
        children: their names.
        parents: those of their parents.
    """

    topic: str
    rows: list[int]
    children: tuple[str, ...]
    parents: tuple[str, ...]


class Frames:
    """The frames of a scene that is watched."""

    def __init__(self, *, joints: bool = False) -> None:
        """Begin with no frame; one moves once it has moved, and with `joints` where a joint can move it, too."""
        self._joints = joints
        self._frames: dict[int, _Frame] = {}
        self._world = np.empty((0, 7))
        self._local = np.empty((0, 7))
        self._rows: dict[int, int] = {}
        self._parents = np.empty(0, np.intp)
        self.groups: dict[str, FrameGroup] = {}

    def poses(self, group: FrameGroup) -> NDArray[np.float64]:
        """Return `parent_t_child` of a group's frames (n, 7), as they are now."""
        return self._local[group.rows]

    def update(self, change: scene_pb2.WatchSceneResponse) -> list[FrameGroup]:
        """Take a change of the scene, or a tick of one; return the groups that it changed."""
        known = {uid: (self._world[row], self._local[row]) for uid, row in self._rows.items()} if change.nodes else {}
        for uid in change.removed_uids:
            self._frames.pop(uid, None)
        for node in change.nodes:
            frame = self._frames.setdefault(node.uid, _Frame(node.name, node.parent))
            frame.name, frame.parent = node.name, node.parent
            frame.moves |= self._joints and node.link.joint.type not in _STILL
        structural = bool(change.nodes or change.removed_uids)
        if structural:
            self._arrange(known)
        moved = array_of(change.world_t_node).reshape(-1, 7)
        self._world[[self._rows[uid] for uid in change.moved_uids]] = moved
        local = relative(self._world[self._parents], self._world)
        # A quaternion and its negative are the same turn.
        local[(local[:, 3:] * self._local[:, 3:]).sum(axis=1) < 0.0, 3:] *= -1.0
        elsewhere = np.abs(local - self._local).max(axis=1, initial=0.0) > _NOISE
        self._local[elsewhere] = local[elsewhere]
        frames = list(self._frames.values())
        begun = structural
        for row in np.flatnonzero(elsewhere).tolist():
            if not structural and not frames[row].moves:
                frames[row].moves = begun = True
        if begun:
            self.groups = {
                topic: _group(
                    topic, [row for row, one in enumerate(frames) if one.parent and one.moves is moves], frames
                )
                for topic, moves in ((topics.FIXED_TRANSFORMS, False), (topics.TRANSFORMS, True))
            }
        return [
            group
            for topic, group in self.groups.items()
            if group.rows and (begun or (topic == topics.TRANSFORMS and elsewhere.any()))
        ]

    def _arrange(self, known: dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]]) -> None:
        """Give each frame its row, keeping the poses that are known."""
        self._rows = {uid: row for row, uid in enumerate(self._frames)}
        self._world, self._local = np.zeros((len(self._rows), 7)), np.zeros((len(self._rows), 7))
        self._world[:, 6] = 1.0
        for uid, row in self._rows.items():
            if uid in known:
                self._world[row], self._local[row] = known[uid]
        by_name = {frame.name: self._rows[uid] for uid, frame in self._frames.items()}
        # The root is its own parent.
        self._parents = np.array([by_name[frame.parent or frame.name] for frame in self._frames.values()], np.intp)


def _group(topic: str, rows: list[int], frames: list[_Frame]) -> FrameGroup:
    children = tuple(frames[row].name for row in rows)
    return FrameGroup(topic, rows, children, tuple(frames[row].parent for row in rows))
