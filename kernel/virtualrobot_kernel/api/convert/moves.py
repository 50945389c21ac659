"""Moves: from the contract's messages to values of `planning`, an entry for each kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import geometry_pb2, motion_pb2

from virtualrobot_kernel.api.convert.jogs import cartesian_jog, joint_jog
from virtualrobot_kernel.api.convert.redundancy import requested_redundancy
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import NOT_NEGATIVE, EnumTable, Pair, same
from virtualrobot_kernel.messages.robots import group_selection
from virtualrobot_kernel.messages.signals import condition_of
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import array, by_name, check_enum, not_negative, vector, vector_message
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
    PathMove,
    PointToPoint,
    Spline,
    Tolerances,
    ToolStateMove,
)
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.redundancy import FREE
from virtualrobot_kernel.world.structure import WORLD_NAME
from virtualrobot_kernel.world.tolerances import tolerance_rows


def requested_move(message: motion_pb2.Move, what: str) -> Move:
    """Return the move of one robot; raise KernelError that names the field that is wrong."""
    kind = message.WhichOneof("move")
    if kind not in KINDS:
        raise KernelError(f"{what} does not say how to move; give one of {', '.join(KINDS)}", field=what)
    factor = speed_factor(message.speed_factor, f"{what}.speed_factor")
    if kind == "joint_trajectory" and factor != 1.0:
        raise KernelError(f"{what}.{kind} has its own times; give no speed_factor", field="speed_factor")
    move = KINDS[kind](message.robot, getattr(message, kind), factor, f"{what}.{kind}")
    move = _gently(_in_time(move, message, what), message, kind, what)
    if message.fixed_tool:
        move = _apart(move, message.fixed_tool, what)
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


def speed_factor(value: float, what: str) -> float:
    """Return the factor, 1 for 0; raise KernelError, which names the field `what`, unless it is above 0, to 1."""
    if not 0.0 <= value <= 1.0:
        raise KernelError(f"{what} must be above 0 and at most 1, not {value:g}", field=what, value=value)
    return value or 1.0


def _gently(move: Move, message: motion_pb2.Move, kind: str, what: str) -> Move:
    """Return the move with the shares of acceleration and jerk that the message says."""
    shares = {name: speed_factor(getattr(message, name), f"{what}.{name}") for name in GENTLE}
    wanted = next((name for name in GENTLE if getattr(message, name)), None)
    if wanted is None:
        return move
    if kind not in GENTLE_KINDS:
        raise KernelError(
            f"{what}.{wanted} is for {', '.join(GENTLE_KINDS)}; a {kind} takes none", field=f"{what}.{wanted}"
        )
    return replace(move, **shares)


def _apart(move: Move, tool: str, what: str) -> Move:
    """Return the move with a tool that stands apart from its robot."""
    if not isinstance(move, PathMove | PointToPoint) or not move.solved:
        raise KernelError(
            f"{what}.fixed_tool is for moves to poses, lines, arcs and splines; this one leads no tool",
            field=f"{what}.fixed_tool",
        )
    if move.moving_reference is not None:
        raise KernelError(
            f"{what}.fixed_tool goes with a goal in what the robot carries, which moves anyway; leave out moving",
            field=f"{what}.fixed_tool",
        )
    return replace(move, fixed_tool=tool)


def _in_time(move: Move, message: motion_pb2.Move, what: str) -> Move:
    """Return the move with the time law that the message says."""
    if message.time_law == motion_pb2.TIME_LAW_UNSPECIFIED:
        return move
    if move.timed:
        raise KernelError(f"{what}.joint_trajectory has its own times; give no time_law", field=f"{what}.time_law")
    law = TIME_LAWS.read(message.time_law, f"{what}.time_law")
    if not isinstance(move, JointJog | CartesianJog):
        return replace(move, time_law=law)
    if law is not TimeLaw.JERK_LIMITED:
        raise KernelError(f"{what}.time_law is for other moves; a jog is jerk-limited", field=f"{what}.time_law")
    return move


def point_goal(message: motion_pb2.PointToPoint, what: str) -> dict[str, float] | PoseGoal | str | ActuatorGoal:
    """Return the goal of a point-to-point move; raise KernelError that names the field that is wrong."""
    kind = message.WhichOneof("goal")
    if kind == "joints":
        return by_name(message.joints.joint_positions, f"{what}.joints")
    if kind == "pose":
        return POSE_GOAL.read(message.pose, f"{what}.pose")
    if kind == "posture":
        return message.posture
    if kind == "actuators":
        return ActuatorGoal(by_name(message.actuators.actuator_positions, f"{what}.actuators"))
    raise KernelError(f"{what} has no goal; give joints, pose, posture or actuators", field=what)


def _point_to_point(robot: str, message: motion_pb2.PointToPoint, factor: float, what: str) -> PointToPoint:
    speed, turning = (not_negative(getattr(message, name), f"{what}.{name}") for name in (RATES[0], RATES[2]))
    return PointToPoint(robot, point_goal(message, what), factor, max_velocity=speed, max_angular_velocity=turning)


def _circular(robot: str, circular: motion_pb2.Circular, factor: float, what: str) -> Circular:
    check_enum(circular, "orientation")
    kind = circular.WhichOneof("shape")
    if kind == "via":
        shape = Via(_point(circular.via, f"{what}.via"))
    elif kind == "center":
        shape = CENTER.read(circular.center, f"{what}.center")
    else:
        raise KernelError(f"{what} does not say which arc; give via or center", field=what)
    goal = None
    if circular.goal.HasField("reference_t_tcp") or not isinstance(shape, Center) or shape.angle is None:
        goal = PATH_GOAL.read(circular.goal, f"{what}.goal").reference_t_tcp
    with_arc = circular.orientation == motion_pb2.ARC_ORIENTATION_WITH_ARC
    speed, acceleration, turning = (not_negative(getattr(circular, name), f"{what}.{name}") for name in RATES)
    reference, moving = circular.goal.reference, circular.goal.moving
    until = condition_of(circular.until, f"{what}.until") if circular.HasField("until") else None
    return Circular(
        *(robot, shape, goal, reference, with_arc, factor, speed, acceleration, turning), moving=moving, until=until
    )


def _trajectory(robot: str, trajectory: motion_pb2.JointTrajectory, factor: float, what: str) -> JointTrajectory:
    names = tuple(trajectory.joint_names)
    times = array(trajectory.times, (None,), f"{what}.times")
    shape = (len(times), len(names))
    check_enum(trajectory, "interpolation")
    segments = trajectory.interpolation == motion_pb2.TRAJECTORY_INTERPOLATION_SEGMENTS
    for field in ("accelerations", "start_time_seconds"):
        if trajectory.HasField(field) and not segments:
            raise KernelError(f"{what}.{field} is for the interpolation SEGMENTS alone", field=f"{what}.{field}")

    def rows(field: str) -> NDArray[np.float64] | None:
        return array(getattr(trajectory, field), shape, f"{what}.{field}") if trajectory.HasField(field) else None

    return JointTrajectory(
        robot,
        names,
        times,
        array(trajectory.positions, shape, f"{what}.positions"),
        rows("velocities"),
        rows("accelerations"),
        segments,
        _start_time(trajectory, what),
        _tolerances(names, trajectory, what),
    )


def _start_time(trajectory: motion_pb2.JointTrajectory, what: str) -> float | None:
    if not trajectory.HasField("start_time_seconds"):
        return None
    return not_negative(trajectory.start_time_seconds, f"{what}.start_time_seconds")


def _tolerances(names: Sequence[str], trajectory: motion_pb2.JointTrajectory, what: str) -> Tolerances:
    def of(field: str) -> NDArray[np.float64] | None:
        given: list[tuple[str, float, float]] = []
        for place, one in enumerate(getattr(trajectory, field)):
            position, velocity = (
                not_negative(getattr(one, name), f"{what}.{field}[{place}].{name}") for name in ("position", "velocity")
            )
            given.append((one.joint, position, velocity))
        return tolerance_rows(names, given, f"{what}.{field}")

    seconds = not_negative(trajectory.goal_time_tolerance_seconds, f"{what}.goal_time_tolerance_seconds")
    return Tolerances(of("path_tolerances"), of("goal_tolerances"), seconds)


def _point(message: geometry_pb2.Vector3, what: str) -> NDArray[np.float64]:
    return np.array(vector(message, what))


def _goals(table: Table[PoseGoal, motion_pb2.PoseGoal]) -> Pair:
    """Return the codec of goals that say a pose, or name their reference, which then is the place itself."""

    def read(message: motion_pb2.PoseGoal, what: str) -> PoseGoal:
        if not message.HasField("reference_t_tcp") and message.reference in ("", WORLD_NAME):
            field = f"{what}.reference_t_tcp"
            raise KernelError(f"{field} is missing; give it, or a target as the goal's reference", field=field)
        return table.read(message, what)

    return Pair(read, table.write)


def _check_path_goal(goal: PoseGoal, what: str) -> None:
    if goal.configuration:
        raise KernelError(
            f"{what}.configuration is {goal.configuration!r}; a line, an arc or a spline keeps the configuration that "
            "it starts in, so leave it empty",
            field=f"{what}.configuration",
        )


def _check_spline(spline: Spline, what: str) -> None:
    if not 0 < len(spline.goals) <= MOST_GOALS:
        raise KernelError(f"{what}.goals has 1 to {MOST_GOALS} poses, not {len(spline.goals)}", field=f"{what}.goals")


def _check_tool(move: ToolStateMove, what: str) -> None:
    if (move.width is None) == (not move.state):
        raise KernelError(f"{what} needs a state or a width, and not both", field=f"{what}.state")


def _rows(table: Table[Any, Any]) -> Callable[[str, Any, float, str], Move]:
    """Return the converter of a kind of move that is a table."""
    return lambda robot, message, factor, what: table.read(message, what, robot=robot, speed_factor=factor)


COMMON = (
    "robot",
    "group",
    "speed_factor",
    "redundancy",
    "time_law",
    "acceleration_factor",
    "jerk_factor",
    "fixed_tool",
)
"""Attributes that all moves share, and that `Move` says beside the kind."""
RATES = (
    "max_velocity_meters_per_second",
    "max_acceleration_meters_per_second_squared",
    "max_angular_velocity_radians_per_second",
)
GENTLE, GENTLE_KINDS = ("acceleration_factor", "jerk_factor"), ("point_to_point", "linear", "circular", "spline")
"""Shares of a move that is gentle, and kinds of moves that can be."""
TIME_LAWS = EnumTable(TimeLaw, motion_pb2.TimeLaw)
POINT = Pair(_point, vector_message)
POSE_GOAL = _goals(Table(PoseGoal, motion_pb2.PoseGoal))
PATH_GOAL = _goals(Table(PoseGoal, motion_pb2.PoseGoal, check=_check_path_goal))
CENTER = Table(Center, motion_pb2.ArcCenter, names={"point": "position"}, point=POINT, axis=POINT)
LINEAR = Table(
    Linear, motion_pb2.Linear, goal=PATH_GOAL, until=Pair(condition_of, same), without=COMMON, numbers=NOT_NEGATIVE
)
SPLINE = Table(Spline, motion_pb2.Spline, goals=PATH_GOAL, without=COMMON, numbers=NOT_NEGATIVE, check=_check_spline)
TOOL_STATE = Table(ToolStateMove, motion_pb2.ToolStateMove, without=COMMON, check=_check_tool)

KINDS: dict[str, Callable[[str, Any, float, str], Move]] = {
    "point_to_point": _point_to_point,
    "linear": _rows(LINEAR),
    "circular": _circular,
    "spline": _rows(SPLINE),
    "joint_trajectory": _trajectory,
    "tool_state": _rows(TOOL_STATE),
    "joint_jog": joint_jog,
    "cartesian_jog": cartesian_jog,
}
"""Converter of each kind of move, by its field in the contract's `Move`."""
