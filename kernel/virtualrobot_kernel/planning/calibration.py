"""Calibration of a robot: what its postures, and what was measured in them, say about tool, base and joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse, left_jacobian, rotation_matrix, skew

from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.planning.fitting import Fit, fit, pivot_fit, rigid_fit
from virtualrobot_kernel.planning.relative_frame import RelativeFrame, relative_frame
from virtualrobot_kernel.planning.robots import Arm, arm_of, tip_t_tcp
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

Floats = NDArray[np.float64]

LEAST_POSTURES = 4
"""Number of postures from which a tool's tip is computed: three determine it, the fourth tells how well."""


@dataclass(frozen=True, slots=True, eq=False)
class ToolFit:
    """Tip (3,) in the frame of the flange, the point (3,) in the world that it touched, and how well (n,), all in m."""

    tip: Floats
    tip_errors: Floats
    point: Floats
    residuals: Floats


@dataclass(frozen=True, slots=True, eq=False)
class BaseFit:
    """Pose of the robot in the world (4, 4), and how far each point is off then (n,), in m."""

    world_t_base: Pose
    residuals: Floats


@dataclass(frozen=True, slots=True, eq=False)
class JointFit:
    """Offsets of joints, and how far each of n points was off and is now, in m.

    Attributes:
        joint_names: the k joints that were fitted.
        offsets, errors: (k,) what to add to what the controller tells, and their standard errors, in rad or m.
        world_t_base: the robot's pose (4, 4) that goes with them; as it is where it was not fitted.
        tip: the tool centre point (3,) in the flange's frame that goes with them, likewise.
        before, residuals: (n,).
    """

    joint_names: tuple[str, ...]
    offsets: Floats
    errors: Floats
    world_t_base: Pose
    tip: Floats
    before: Floats
    residuals: Floats


def calibrate_tool(
    snapshot: Snapshot, robot: Node, joint_names: Sequence[str], postures: Floats, group: Group = WHOLE
) -> ToolFit:
    """Return where the tip of a tool is that touched one fixed point in n postures (n, k).

    Raises KernelError for fewer than four postures, and for postures that turn the tool about one axis alone.
    """
    if len(postures) < LEAST_POSTURES:
        raise KernelError(
            f"{len(postures)} postures don't tell a tip and how good it is; give at least {LEAST_POSTURES}, in which "
            "the tip touches the same point and the tool is turned differently",
            field="postures",
        )
    arm, rows = _arm(snapshot, robot, group), _rows(snapshot, robot, group, joint_names, postures)
    flange = _frame(snapshot, arm, np.eye(4))
    found = pivot_fit(np.array([flange.pose(row) for row in rows]))
    return ToolFit(found.parameters[:3], found.errors[:3], found.parameters[3:], found.residuals)


def calibrate_base(
    snapshot: Snapshot, robot: Node, joint_names: Sequence[str], postures: Floats, points: Floats, group: Group = WHOLE
) -> BaseFit:
    """Return where in the world a robot stands whose tool centre point was at points (n, 3) in n postures (n, k).

    Raises KernelError as `rigid_fit` does.
    """
    arm, rows = _arm(snapshot, robot, group), _rows(snapshot, robot, group, joint_names, postures)
    tcp = _frame(snapshot, arm, tip_t_tcp(snapshot, arm))
    base_t_world = inverse(snapshot.world_t(robot.uid))
    reached = np.array([(base_t_world @ tcp.pose(row))[:3, 3] for row in rows])
    world_t_base = rigid_fit(reached, points)
    off = reached @ world_t_base[:3, :3].T + world_t_base[:3, 3] - points
    return BaseFit(world_t_base, np.linalg.norm(off, axis=1))


def calibrate_joints(
    snapshot: Snapshot,
    robot: Node,
    joint_names: Sequence[str],
    postures: Floats,
    points: Floats,
    fixed: Sequence[str] = (),
    with_base: bool = False,
    with_tip: bool = False,
    group: Group = WHOLE,
) -> JointFit:
    """Return the offsets of joints with which the tool centre point is where it was measured in n postures (n, k).

    Args:
        snapshot: the world with the robot as it is modelled.
        robot: the robot.
        joint_names: of the columns of `postures`.
        postures: what the controller told, (n, k).
        points: where the tool centre point was measured then, in the world's frame.
        fixed: joints whose offsets are 0.
        with_base: whether the robot's pose is fitted, too.
        with_tip: whether the tool centre point is.
        group: the chain that is fitted.

    Raises:
        KernelError: where the measurements can't tell the parameters apart, with their names: a base that may turn
            about the first joint's axis, a tip that may turn about the last one's.
        UnknownNameError: for a joint that the arm has not.
    """
    arm, rows = _arm(snapshot, robot, group), _rows(snapshot, robot, group, joint_names, postures)
    for name in fixed:
        if name not in arm.joint_names:
            raise UnknownNameError(f"joint of {robot.name!r}{group}", name, arm.joint_names)
    free = [place for place, name in enumerate(arm.joint_names) if name not in fixed]
    names = tuple(arm.joint_names[place] for place in free)
    world_t_base, tip = snapshot.world_t(robot.uid), tip_t_tcp(snapshot, arm)[:3, 3]
    frame = _frame(snapshot, arm, np.eye(4))
    joints = len(free)
    tip_at = joints + 6 * with_base
    called = (*names, *(("base x", "y", "z", "roll", "pitch", "yaw") if with_base else ()))
    called = (*called, *(("tip x", "tip y", "tip z") if with_tip else ()))

    def moved(parameters: Floats) -> Pose:
        return _moved(parameters[joints:tip_at]) if with_base else np.eye(4)

    def residuals(parameters: Floats) -> tuple[Floats, Floats]:
        off, slopes = np.empty((len(rows), 3)), np.empty((len(rows), 3, len(parameters)))
        offsets, base = np.zeros(len(arm.joint_names)), moved(parameters)
        offsets[free] = parameters[:joints]
        here = tip + parameters[tip_at:] if with_tip else tip
        for row, posture in enumerate(rows):
            pose, geometric = frame.pose(posture + offsets), frame.jacobian(posture + offsets)
            arm_to_tip = pose[:3, :3] @ here
            place = pose[:3, 3] + arm_to_tip
            linear = geometric[:3] + np.cross(geometric[3:].T, arm_to_tip).T
            off[row] = base[:3, :3] @ (place - world_t_base[:3, 3]) + base[:3, 3] + world_t_base[:3, 3] - points[row]
            slopes[row, :, :joints] = base[:3, :3] @ linear[:, free]
            if with_base:
                slopes[row, :, joints : joints + 3] = np.eye(3)
                turned = base[:3, :3] @ (place - world_t_base[:3, 3])
                slopes[row, :, joints + 3 : tip_at] = -skew(turned) @ left_jacobian(parameters[joints + 3 : tip_at])
            if with_tip:
                slopes[row, :, tip_at:] = base[:3, :3] @ pose[:3, :3]
        return off, slopes

    start = np.zeros(len(called))
    before = np.linalg.norm(residuals(start)[0], axis=1)
    found: Fit = fit(residuals, start, called)
    base = moved(found.parameters)
    there = np.eye(4)
    there[:3, :3] = base[:3, :3] @ world_t_base[:3, :3]
    there[:3, 3] = world_t_base[:3, 3] + base[:3, 3]
    return JointFit(
        names,
        found.parameters[:joints],
        found.errors[:joints],
        there,
        tip + found.parameters[tip_at:] if with_tip else tip,
        before,
        found.residuals,
    )


def _moved(parameters: Floats) -> Pose:
    """Return the pose (4, 4) of a shift, and a turn about a vector by its length (6,)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_matrix(parameters[3:]), parameters[:3]
    return pose


def _arm(snapshot: Snapshot, robot: Node, group: Group) -> Arm:
    """Return the arm; raise KernelError when it is no chain."""
    arm = arm_of(snapshot, robot, group)
    arm.serial()
    return arm


def _frame(snapshot: Snapshot, arm: Arm, tip_t_point: Pose) -> RelativeFrame:
    """Return the frame of a point on the arm's tip in the world's."""
    return relative_frame(snapshot, snapshot.structure.node("").uid, arm.tip, tip_t_point, arm.q_index)


def _rows(snapshot: Snapshot, robot: Node, group: Group, joint_names: Sequence[str], postures: Floats) -> Floats:
    """Return postures in the order of the arm's joints (n, k), those that aren't named as they are now.

    Limits don't count: what was measured is what is. Raises UnknownNameError for a joint that the arm has not, and
    KernelError for one that is named twice.
    """
    arm = _arm(snapshot, robot, group)
    rows = np.tile(snapshot.state.q[arm.q_index], (len(postures), 1))
    names = list(joint_names) or list(arm.joint_names)
    if postures.shape[1] != len(names):
        raise KernelError(
            f"postures have {postures.shape[1]} columns; they must have {len(names)}, for {', '.join(names)}",
            field="postures",
        )
    for column, name in enumerate(names):
        if name not in arm.joint_names:
            raise UnknownNameError(f"joint of {robot.name!r}{group}", name, arm.joint_names)
        if name in names[:column]:
            raise KernelError(f"the joint {name!r} is named twice", field="joint_names", joint=name)
        rows[:, arm.joint_names.index(name)] = postures[:, column]
    return rows
