"""Relative frames: the pose of one frame of the world in another, and its Jacobian for joints of any robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.numeric.forest import FIXED, FLOATING, PLANAR, REVOLUTE
from virtualrobot_kernel.planning.robots import poses_of_rows
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class RelativeFrame:
    """Frame of a point on one node, in the frame of another node, for k coordinates.

    q_index (k,): where they are in all coordinates `q` of the world, which the others keep. order: the rows of all
    nodes above both. moved, row (m,): the coordinate, of k, and the row of each node that one of them moves, by the
    axis (m, 3), about which it `turns` (m, 1); sign (m,): 1 where it moves only the point, -1 where only the reference;
    what it does to both changes nothing between them.
    """

    structure: Structure
    parent_t_node: Floats
    q: Floats
    reference: int
    node: int
    node_t_point: Pose
    q_index: Integers
    order: Integers
    moved: Integers
    row: Integers
    axis: Floats
    turns: NDArray[np.bool_]
    sign: Floats

    def pose(self, q: Floats) -> Pose:
        """Return reference_t_point (4, 4) with the joints at q (k,)."""
        world = self._world(q)
        return inverse(world[self.reference]) @ world[self.node] @ self.node_t_point

    def jacobian(self, q: Floats) -> Floats:
        """Return the geometric Jacobian (6, k) at the point, linear rows first, in the frame of the reference."""
        world, forest = self._world(q), self.structure.forest
        point = (world[self.node] @ self.node_t_point)[:3, 3]
        after, before = world[self.row], world[forest.parent[self.row]] @ self.parent_t_node[self.row]
        axes = np.einsum("mij,mj->mi", np.where(self.turns[..., None], after, before)[:, :3, :3], self.axis)
        linear = np.where(self.turns, np.cross(axes, point - after[:, :3, 3]), axes)
        columns = np.concatenate([linear, np.where(self.turns, axes, 0.0)], axis=1)
        columns *= (self.sign * forest.multiplier[self.row])[:, None]
        result = np.zeros((6, len(self.q_index)))
        np.add.at(result.T, self.moved, columns)
        reference_r_world = world[self.reference, :3, :3].T
        return np.concatenate([reference_r_world @ result[:3], reference_r_world @ result[3:]])

    def _world(self, q: Floats) -> Floats:
        """Return world_t_node (N, 4, 4), of which only the rows of `order` are written."""
        everything = self.q.copy()
        everything[self.q_index] = q
        return poses_of_rows(self.structure, self.order, self.parent_t_node, everything)


def relative_frame(
    snapshot: Snapshot, reference: int, node: int, node_t_point: Pose, q_index: Integers
) -> RelativeFrame:
    """Return the pose of the point `node_t_point` (4, 4) of a node (uid) in the frame of `reference` (uid)."""
    structure = snapshot.structure
    above_reference, above_node = rows_above(structure, reference), rows_above(structure, node)
    order = [*above_reference, *(row for row in above_node if row not in above_reference)]
    forest = structure.forest
    places = {int(place): joint for joint, place in enumerate(q_index)}
    found = [
        (places[place], row, axis, turns, 1.0 if row in above_node else -1.0)
        for row in order
        if (row in above_node) != (row in above_reference)
        for place, (axis, turns) in enumerate(
            axes_of(int(forest.joint_type[row]), forest.axis[row]), int(forest.q_index[row])
        )
        if place in places
    ]
    return RelativeFrame(
        structure,
        snapshot.state.parent_t_node,
        snapshot.state.q,
        structure.rows[reference],
        structure.rows[node],
        node_t_point,
        np.asarray(q_index, np.int32),
        np.array(order, np.int32),
        np.array([joint for joint, *_ in found], np.int32),
        np.array([row for _, row, *_ in found], np.int32),
        np.array([axis for _, _, axis, _, _ in found]).reshape(-1, 3),
        np.array([turns for *_, turns, _ in found], np.bool_)[:, None],
        np.array([sign for *_, sign in found]),
    )


def axes_of(joint_type: int, axis: Floats) -> Sequence[tuple[Floats, bool]]:
    """Return for each coordinate of a joint the axis (3,) along which it shifts, or about which it turns (True).

    Axes of shifts are those of the frame before the joint, axes of turns those of the frame after it. A quaternion's
    components x, y, z have the axes of the angular velocity, and w has none.
    """
    if joint_type == FIXED:
        return ()
    if joint_type == FLOATING:
        return [(unit, turns) for turns in (False, True) for unit in np.eye(3)]
    if joint_type == PLANAR:
        return [(axes_in_plane(axis)[0], False), (axes_in_plane(axis)[1], False), (axis, True)]
    return [(axis, joint_type == REVOLUTE)]


def axes_in_plane(axis: Floats) -> Floats:
    """Return x and y (2, 3) of a planar joint: those of the smallest rotation that takes +z to its axis (3,)."""
    x, y, z = axis.tolist()
    across = x * x + y * y
    if across == 0.0:
        return np.array([[1.0, 0.0, 0.0], [0.0, z, 0.0]])
    share = 1.0 / (1.0 + z) if z > 0.0 else (1.0 - z) / across
    return np.array([[1.0 - x * x * share, -x * y * share, -x], [-x * y * share, 1.0 - y * y * share, -y]])


def rows_above(structure: Structure, uid: int) -> list[int]:
    """Return the rows of a node and of all nodes above it, the root first."""
    return [structure.rows[node.uid] for node in structure.ancestors(uid)][::-1]


@dataclass(frozen=True, slots=True, eq=False)
class RelativeTcp:
    """Tool centre point, `node_t_tcp` (4, 4) on a node (uid), that keeps Cartesian limits in another node's frame."""

    snapshot: Snapshot
    reference: int
    node: int
    node_t_tcp: Pose
    limits: CartesianLimits

    def by(self, q_index: Integers) -> RelativeFrame:
        """Return its pose in that frame, for joints at these places (k,) in all coordinates."""
        return relative_frame(self.snapshot, self.reference, self.node, self.node_t_tcp, q_index)
