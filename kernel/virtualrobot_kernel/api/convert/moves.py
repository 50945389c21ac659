"""Moves: from the contract's messages to values of `planning`, an entry for each kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.jogs import cartesian_jog, joint_jog
from virtualrobot_kernel.api.convert.redundancy import requested_redundancy
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.robots import group_selection
from virtualrobot_kernel.messages.signals import condition_of
from virtualrobot_kernel.messages.values import array, by_name, check_enum, finite, pose, vector
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.circle import Center, Via
from virtualrobot_kernel.motion.spline import MOST_GOALS
from virtualrobot_kernel.planning.moves import (
    ActuatorGoal,
    CartesianJog,
    Circular,
    JointJog,
    JointTrajectory,
    Linear,
    Move,
    PointToPoint,
    Spline,
    ToolStateMove,
)
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.redundancy import FREE


def requested_move(message: motion_pb2.Move, what: str) -> Move:
    """Return the move of one robot; raise KernelError that names the field that is wrong."""
    kind = message.WhichOneof("move")
    if kind not in KINDS:
        raise KernelError(f"{what} does not say how to move; give one of {', '.join(KINDS)}", field=what)
    factor = finite(message.speed_factor, f"{what}.speed_factor")
    if factor and not 0.0 < factor <= 1.0:
        raise KernelError(f"{what}.speed_factor must be above 0 and at most 1, not {factor:g}", factor=factor)
    if kind == "joint_trajectory" and factor not in (0.0, 1.0):
        raise KernelError(f"{what}.{kind} has its own times; give no speed_factor", field="speed_factor")
    move = KINDS[kind](message.robot, getattr(message, kind), factor or 1.0, f"{what}.{kind}")
    move = _in_time(move, message, what)
    if message.HasField("group"):
        move = replace(move, group=group_selection(message.group, f"{what}.group"))
    redundancy = requested_redundancy(message.redundancy, f"{what}.redundancy")
    if redundancy is FREE:
        return move
    if not move.solved:
        raise KernelError(
            f"{what}.redundancy is for goals that are poses; this move says where its joints go, so leave it out",
            field=f"{what}.redundancy",
        )
    return replace(move, redundancy=redundancy)


def _in_time(move: Move, message: motion_pb2.Move, what: str) -> Move:
    """Return the move with the time law that the message says."""
    check_enum(message, "time_law")
    if message.time_law == motion_pb2.TIME_LAW_UNSPECIFIED:
        return move
    if move.timed:
        raise KernelError(f"{what}.joint_trajectory has its own times; give no time_law", field=f"{what}.time_law")
    if isinstance(move, JointJog | CartesianJog):
        if message.time_law == motion_pb2.TIME_LAW_JERK_LIMITED:
            return move
        raise KernelError(f"{what}.time_law is for other moves; a jog is jerk-limited", field=f"{what}.time_law")
    return replace(move, time_law=TimeLaw(motion_pb2.TimeLaw.Name(message.time_law).removeprefix("TIME_LAW_")))


def _point_to_point(robot: str, message: motion_pb2.PointToPoint, factor: float, what: str) -> PointToPoint:
    return PointToPoint(robot, point_goal(message, what), factor)


def _linear(robot: str, linear: motion_pb2.Linear, factor: float, what: str) -> Linear:
    goal = _path_goal(linear.goal, f"{what}.goal")
    until = None
    if linear.HasField("until"):
        until = condition_of(linear.until, f"{what}.until")
    return Linear(robot, goal, factor, *_rates(linear, what), until=until)


def _tool_state(robot: str, message: motion_pb2.ToolStateMove, factor: float, what: str) -> ToolStateMove:
    return ToolStateMove(robot, message.tool, message.state, factor)


def point_goal(message: motion_pb2.PointToPoint, what: str) -> dict[str, float] | PoseGoal | str | ActuatorGoal:
    """Return the goal of a point-to-point move; raise KernelError that names the field that is wrong."""
    kind = message.WhichOneof("goal")
    if kind == "joints":
        return by_name(message.joints.joint_positions, f"{what}.joints")
    if kind == "pose":
        return _pose_goal(message.pose, f"{what}.pose")
    if kind == "posture":
        return message.posture
    if kind == "actuators":
        return ActuatorGoal(by_name(message.actuators.actuator_positions, f"{what}.actuators"))
    raise KernelError(f"{what} has no goal; give joints, pose, posture or actuators", field=what)


def _pose_goal(message: motion_pb2.PoseGoal, what: str) -> PoseGoal:
    if not message.HasField("reference_t_tcp"):
        raise KernelError(f"{what}.reference_t_tcp is missing: where shall the tool centre point be?", field=what)
    reference_t_tcp = pose(message.reference_t_tcp, f"{what}.reference_t_tcp")
    return PoseGoal(reference_t_tcp, message.reference, message.configuration, message.moving)


def _path_goal(message: motion_pb2.PoseGoal, what: str) -> PoseGoal:
    """Return the goal of a path of the tool centre point; raise KernelError when it names a configuration."""
    if message.configuration:
        raise KernelError(
            f"{what}.configuration is {message.configuration!r}; a line, an arc or a spline keeps the configuration "
            "that it starts in, so leave it empty",
            field=f"{what}.configuration",
        )
    return _pose_goal(message, what)


def _circular(robot: str, circular: motion_pb2.Circular, factor: float, what: str) -> Circular:
    check_enum(circular, "orientation")
    kind = circular.WhichOneof("shape")
    if kind == "via":
        shape = Via(np.array(vector(circular.via, f"{what}.via")))
    elif kind == "center":
        shape = _center(circular.center, f"{what}.center")
    else:
        raise KernelError(f"{what} does not say which arc; give via or center", field=what)
    goal = None
    if circular.goal.HasField("reference_t_tcp") or not isinstance(shape, Center) or shape.angle is None:
        goal = _path_goal(circular.goal, f"{what}.goal").reference_t_tcp
    with_arc = circular.orientation == motion_pb2.ARC_ORIENTATION_WITH_ARC
    rates, moving = _rates(circular, what), circular.goal.moving
    return Circular(robot, shape, goal, circular.goal.reference, with_arc, factor, *rates, moving=moving)


def _center(message: motion_pb2.ArcCenter, what: str) -> Center:
    if not message.HasField("position"):
        raise KernelError(f"{what}.position is missing: where is the centre of the arc?", field=what)
    return Center(
        np.array(vector(message.position, f"{what}.position")),
        np.array(vector(message.axis, f"{what}.axis")) if message.HasField("axis") else None,
        finite(message.angle_radians, f"{what}.angle_radians") if message.HasField("angle_radians") else None,
    )


def _spline(robot: str, spline: motion_pb2.Spline, factor: float, what: str) -> Spline:
    if not 0 < len(spline.goals) <= MOST_GOALS:
        raise KernelError(f"{what}.goals has 1 to {MOST_GOALS} poses, not {len(spline.goals)}", field=f"{what}.goals")
    goals = tuple(_path_goal(goal, f"{what}.goals[{number}]") for number, goal in enumerate(spline.goals))
    return Spline(robot, goals, factor, *_rates(spline, what))


def _trajectory(robot: str, trajectory: motion_pb2.JointTrajectory, factor: float, what: str) -> JointTrajectory:
    names = tuple(trajectory.joint_names)
    times = array(trajectory.times, (None,), f"{what}.times")
    shape = (len(times), len(names))
    velocities = (
        array(trajectory.velocities, shape, f"{what}.velocities") if trajectory.HasField("velocities") else None
    )
    return JointTrajectory(robot, names, times, array(trajectory.positions, shape, f"{what}.positions"), velocities)


def _rates(message: motion_pb2.Linear | motion_pb2.Circular | motion_pb2.Spline, what: str) -> tuple[float, float]:
    """Return the greatest speed and acceleration of a line, an arc or a spline, 0 for the default."""
    return (
        _rate(message.max_velocity_meters_per_second, f"{what}.max_velocity_meters_per_second"),
        _rate(message.max_acceleration_meters_per_second_squared, f"{what}.max_acceleration_meters_per_second_squared"),
    )


def _rate(value: float, what: str) -> float:
    if finite(value, what) < 0.0:
        raise KernelError(f"{what} must be 0 (the default) or above, not {value:g}", field=what)
    return value


KINDS: dict[str, Callable[[str, Any, float, str], Move]] = {
    "point_to_point": _point_to_point,
    "linear": _linear,
    "circular": _circular,
    "spline": _spline,
    "joint_trajectory": _trajectory,
    "tool_state": _tool_state,
    "joint_jog": joint_jog,
    "cartesian_jog": cartesian_jog,
}
"""Converter of each kind of move, by its field in the contract's `Move`."""
