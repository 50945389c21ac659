"""Moves as messages: what a robot shall do, not started yet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot._wire.messages import array_message, joint_map, pose_message, vector_message
from virtualrobot._wire.signal_values import SignalValue, condition
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import motion_pb2

TIME_LAWS = {
    "": motion_pb2.TIME_LAW_UNSPECIFIED,
    "jerk_limited": motion_pb2.TIME_LAW_JERK_LIMITED,
    "time_optimal": motion_pb2.TIME_LAW_TIME_OPTIMAL,
}
"""Time laws along the path of a move, by name."""

_JOG_FRAMES = {
    "base": motion_pb2.JOG_FRAME_BASE,
    "tool": motion_pb2.JOG_FRAME_TOOL,
    "node": motion_pb2.JOG_FRAME_NODE,
    "world": motion_pb2.JOG_FRAME_NODE,
}

Until: TypeAlias = str | tuple[str, SignalValue] | tuple[str, str, SignalValue]
"""A signal that is on, a signal and the value that it has, or a signal, a comparison such as ">=" and a value."""


def until_condition(until: Until) -> motion_pb2.SignalCondition:
    """Return the condition of a search as a message."""
    if isinstance(until, str):
        return condition(until, True)
    if len(until) == 2:
        return condition(*until)
    signal, comparison, value = until
    return condition(signal, value, comparison)


def pose_goal(
    reference_t_tcp: ArrayLike, reference: str, configuration: str = "", moving: bool = False
) -> motion_pb2.PoseGoal:
    """Return a goal for the tool centre point: a 4x4 pose in the frame of the node `reference` (empty: world).

    `moving`: the goal goes along when another move of the same step moves the reference.
    """
    return motion_pb2.PoseGoal(
        reference_t_tcp=pose_message(reference_t_tcp),
        reference=reference,
        configuration=configuration,
        moving=moving,
    )


def unstarted(moves: Iterable[motion_pb2.Move]) -> list[motion_pb2.Move]:
    """Return moves that go together, after a look that they are moves and no motions that run already."""
    given = list(moves)
    for move in given:
        if not isinstance(move, motion_pb2.Move):
            raise InvalidArgumentError(
                f"moves that go together or are steps of a program are made by robot.ptp, robot.linear and their like, "
                f"which start nothing; not {move!r}"
            )
    return given


def time_law_number(name: str) -> motion_pb2.TimeLaw:
    """Return the enum value of a time law; empty means the kernel's usual one."""
    if name not in TIME_LAWS:
        names = ", ".join(repr(law) for law in TIME_LAWS if law)
        raise InvalidArgumentError(f"time_law is one of {names}, or empty for the first, not {name!r}")
    return TIME_LAWS[name]


def point_to_point(
    robot: str,
    goal: Mapping[str, float] | str | ArrayLike,
    *,
    reference: str = "",
    configuration: str = "",
    speed_factor: float = 0.0,
    time_law: str = "",
    moving: bool = False,
) -> motion_pb2.Move:
    """Return a move straight in joint space: to joints by name, to a posture by its name, or to a 4x4 pose.

    `configuration` names the only configuration that will do for a pose, and `moving` is as for `pose_goal`.
    """
    if configuration and isinstance(goal, str | Mapping):
        raise InvalidArgumentError(f"the configuration {configuration!r} is for a goal that is a pose, not {goal!r}")
    if isinstance(goal, str):
        target = motion_pb2.PointToPoint(posture=goal)
    elif isinstance(goal, Mapping):
        target = motion_pb2.PointToPoint(joints=motion_pb2.JointGoal(joint_positions=joint_map(goal)))
    else:
        target = motion_pb2.PointToPoint(pose=pose_goal(goal, reference, configuration, moving))
    law = time_law_number(time_law)
    return motion_pb2.Move(robot=robot, speed_factor=speed_factor, time_law=law, point_to_point=target)


def actuated(
    robot: str, actuators: Mapping[str, float], *, speed_factor: float = 0.0, time_law: str = ""
) -> motion_pb2.Move:
    """Return a move straight in joint space to where these actuators, by name and in their units, have the joints."""
    goal = motion_pb2.ActuatorGoal(actuator_positions=joint_map(actuators))
    move = motion_pb2.PointToPoint(actuators=goal)
    law = time_law_number(time_law)
    return motion_pb2.Move(robot=robot, speed_factor=speed_factor, time_law=law, point_to_point=move)


def linear(
    robot: str,
    reference_t_tcp: ArrayLike,
    reference: str = "",
    velocity: float = 0.0,
    acceleration: float = 0.0,
    speed_factor: float = 0.0,
    time_law: str = "",
    moving: bool = False,
    until: Until | None = None,
) -> motion_pb2.Move:
    """Return a move along a straight line; velocity in m/s, acceleration in m/s^2, 0 for the kernel's usual ones.

    `until` makes it a search: the signal at which it ends early, or signal and value, or signal, comparison and value.
    """
    line = motion_pb2.Linear(
        goal=pose_goal(reference_t_tcp, reference, moving=moving),
        max_velocity_meters_per_second=velocity,
        max_acceleration_meters_per_second_squared=acceleration,
        until=None if until is None else until_condition(until),
    )
    law = time_law_number(time_law)
    return motion_pb2.Move(robot=robot, speed_factor=speed_factor, time_law=law, linear=line)


def circular(
    robot: str,
    via: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    *,
    center: ArrayLike | None = None,
    axis: ArrayLike | None = None,
    angle: float | None = None,
    turn_with_arc: bool = False,
    reference: str = "",
    velocity: float = 0.0,
    acceleration: float = 0.0,
    speed_factor: float = 0.0,
    time_law: str = "",
    moving: bool = False,
) -> motion_pb2.Move:
    """Return a move along an arc through the point `via`, or about `center`, (3,) in m each; see `Mover.circular`."""
    if (via is None) == (center is None):
        raise InvalidArgumentError("an arc goes through a point or about a centre: give one of via and center")
    if via is not None and (axis is not None or angle is not None):
        raise InvalidArgumentError("axis and angle go with center, not with via")
    arc = motion_pb2.Circular(
        goal=motion_pb2.PoseGoal(reference=reference, moving=moving)
        if goal is None
        else pose_goal(goal, reference, moving=moving),
        max_velocity_meters_per_second=velocity,
        max_acceleration_meters_per_second_squared=acceleration,
    )
    if turn_with_arc:
        arc.orientation = motion_pb2.ARC_ORIENTATION_WITH_ARC
    if via is not None:
        arc.via.CopyFrom(vector_message(via, "the via point"))
    elif center is not None:
        arc.center.position.CopyFrom(vector_message(center, "the centre"))
        if axis is not None:
            arc.center.axis.CopyFrom(vector_message(axis, "the axis"))
        if angle is not None:
            arc.center.angle_radians = angle
    law = time_law_number(time_law)
    return motion_pb2.Move(robot=robot, speed_factor=speed_factor, time_law=law, circular=arc)


def spline(
    robot: str,
    goals: Iterable[ArrayLike],
    reference: str | Sequence[str] = "",
    velocity: float = 0.0,
    acceleration: float = 0.0,
    speed_factor: float = 0.0,
    time_law: str = "",
    moving: bool = False,
) -> motion_pb2.Move:
    """Return a move along a smooth curve through 4x4 poses; `reference` is one node for all, or one for each."""
    poses = list(goals)
    references = [reference] * len(poses) if isinstance(reference, str) else list(reference)
    if len(references) != len(poses):
        raise InvalidArgumentError(f"{len(poses)} poses need one reference, or as many, not {len(references)}")
    curve = motion_pb2.Spline(
        goals=[pose_goal(pose, name, moving=moving) for pose, name in zip(poses, references, strict=True)],
        max_velocity_meters_per_second=velocity,
        max_acceleration_meters_per_second_squared=acceleration,
    )
    law = time_law_number(time_law)
    return motion_pb2.Move(robot=robot, speed_factor=speed_factor, time_law=law, spline=curve)


def joint_jog(robot: str, joint: str, velocity: float, distance: float | None = None) -> motion_pb2.Move:
    """Return a move of one joint at a velocity, whose sign says which way; see `Jogger.jog_joint`."""
    jog = motion_pb2.JointJog(joint=joint, velocity=velocity, distance=distance)
    return motion_pb2.Move(robot=robot, joint_jog=jog)


def cartesian_jog(
    robot: str,
    *,
    translation: ArrayLike | None = None,
    rotation: ArrayLike | None = None,
    frame: str = "",
    node: str = "",
    velocity: float = 0.0,
    distance: float | None = None,
) -> motion_pb2.Move:
    """Return a move of the tool centre point along `translation` or about `rotation`; see `Jogger.jog`."""
    if (translation is None) == (rotation is None):
        raise InvalidArgumentError("a jog goes along a direction or about an axis: give either translation or rotation")
    jog = motion_pb2.CartesianJog(velocity=velocity, distance=distance, node=node)
    if translation is not None:
        jog.translation.CopyFrom(vector_message(translation, "the translation"))
    elif rotation is not None:
        jog.rotation.CopyFrom(vector_message(rotation, "the rotation"))
    name = frame or ("node" if node else "base")
    if name not in _JOG_FRAMES or (name != "node" and node):
        raise InvalidArgumentError(
            f"the axes of a jog are those of the frame 'base', 'tool' or 'world', or of a node: not {frame!r}"
            + (f" with the node {node!r}" if node else "")
        )
    jog.frame = _JOG_FRAMES[name]
    return motion_pb2.Move(robot=robot, cartesian_jog=jog)


def trajectory(
    robot: str,
    joints: Sequence[str],
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike | None = None,
    speed_factor: float = 0.0,
) -> motion_pb2.Move:
    """Return a move through `positions` (n, k) at `times` (n,) seconds, with `velocities` (n, k) or a smooth curve."""
    moments, columns = np.asarray(times, dtype=float), np.asarray(positions, dtype=float)
    if columns.shape != (len(moments), len(joints)):
        raise InvalidArgumentError(
            f"positions have the shape (times, joints) = ({len(moments)}, {len(joints)}), not {columns.shape}"
        )
    path = motion_pb2.JointTrajectory(
        joint_names=joints, times=array_message(moments), positions=array_message(columns)
    )
    if velocities is not None:
        speeds = np.asarray(velocities, dtype=float)
        if speeds.shape != columns.shape:
            raise InvalidArgumentError(f"velocities have the shape of positions, {columns.shape}, not {speeds.shape}")
        path.velocities.CopyFrom(array_message(speeds))
    return motion_pb2.Move(robot=robot, speed_factor=speed_factor, joint_trajectory=path)
