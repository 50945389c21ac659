"""Geometric Jacobians of points on robots in the world's frame, of the tree as it stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.relative_frame import relative_frame
from virtualrobot_kernel.planning.robots import arm_of, standing_at, tcp_frame
from virtualrobot_kernel.world.change import with_positions
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE, Group, joints_of
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node
from virtualrobot_kernel.world.tcp import chosen_tcp

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """Point (3,) in m in the frame of the node `reference` that moves with `node` (uids)."""

    node: int
    reference: int
    place: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Jacobians:
    """Geometric Jacobians of a robot's tool centre point (6, k) and of n points (n, 6, k), linear rows above angular.

    In the world's frame, m and rad per rad or m of the joints.
    """

    joint_names: tuple[str, ...]
    world_t_tcp: Pose
    tcp: Floats
    points: Floats


def solve_jacobian(
    snapshot: Snapshot,
    robot: Node,
    positions: Mapping[str, float],
    points: Sequence[Point] = (),
    group: Group = WHOLE,
) -> Jacobians:
    """Return the Jacobians of a robot's tool centre point and of points on it, with some joints elsewhere.

    Columns are the joints of one coordinate in the robot's order, of a group only its own; what mimics one moves with
    it. Other joints and the robot's base stand still.

    Raises:
        UnknownNameError: for a joint that the robot has not.
        LimitError: for a position outside its joint's limits.
        KernelError: for a point on a node that the robot does not carry.
    """
    structure = snapshot.structure
    if positions:
        snapshot = standing_at(snapshot, ..., with_positions(structure, robot, snapshot.state.q, positions))
    index, world = structure.robots[robot.uid], structure.node("").uid
    single = [
        (joint.name, place)
        for joint, place in zip(index.joints, index.q_start, strict=True)
        if joint.type.coordinate_count == 1 and (group == WHOLE or joint.name in joints_of(structure, robot, group))
    ]
    q_index = np.array([place for _, place in single], np.int32)
    q = snapshot.state.q[q_index]

    def jacobian(node: int, world_t_point: Pose) -> Floats:
        node_t_point = inverse(snapshot.world_t(node)) @ world_t_point
        return relative_frame(snapshot, world, node, node_t_point, q_index).jacobian(q)

    found = np.empty((len(points), 6, len(single)))
    for row, point in enumerate(points):
        carrier = structure.nodes[point.node]
        if carrier is robot or robot not in structure.ancestors(point.node):
            raise KernelError(
                f"the robot {robot.name!r} does not carry {carrier.name!r}; name one of its links, or what hangs below "
                "them",
                robot=robot.name,
                node=carrier.name,
                field=f"points[{row}].node",
            )
        found[row] = jacobian(point.node, snapshot.world_t(point.reference) @ _at(point.place))
    arm = arm_of(snapshot, robot, group)
    tool, _ = chosen_tcp(structure, snapshot.state, robot, arm.tool_tip)
    tcp = tcp_frame(snapshot, robot, arm)
    names = tuple(name for name, _ in single)
    return Jacobians(names, tcp, jacobian(arm.tip if tool is None else tool.uid, tcp), found)


def _at(place: Floats) -> Pose:
    """Return the pose (4, 4) at a point, not turned."""
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose
