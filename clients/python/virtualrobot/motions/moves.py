"""Moves of robots that are not started: their options, and the messages that they are made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias, TypedDict

import numpy as np

from virtualrobot._wire.arguments import ArrayLike, PoseLike
from virtualrobot._wire.messages import (
    Wrapped,
    array_message,
    joint_map,
    pose_message,
    value_or_default,
    vector_message,
)
from virtualrobot._wire.signal_values import GivenValue, condition
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import checked_pose, pose
from virtualrobot.robots.redundancy import Lock, Prefer
from virtualrobot.v1 import motion_pb2

TIME_LAWS = {
    "jerk_limited": motion_pb2.TIME_LAW_JERK_LIMITED,
    "time_optimal": motion_pb2.TIME_LAW_TIME_OPTIMAL,
}
"""Time laws along the path of a move, by name."""

INTERPOLATIONS = {
    "smooth": motion_pb2.TRAJECTORY_INTERPOLATION_SMOOTH,
    "segments": motion_pb2.TRAJECTORY_INTERPOLATION_SEGMENTS,
}
"""Ways of joints from one row of a trajectory to the next, by name."""

Tolerance: TypeAlias = float | tuple[float, float]
"""Tolerance of a joint's position, or of its position and velocity."""

Tolerances: TypeAlias = Tolerance | Mapping[str, Tolerance]
"""Tolerance of all joints of a trajectory, or those of joints by name."""

_JOG_FRAMES = {
    "base": motion_pb2.JOG_FRAME_BASE,
    "tool": motion_pb2.JOG_FRAME_TOOL,
    "node": motion_pb2.JOG_FRAME_NODE,
    "world": motion_pb2.JOG_FRAME_NODE,
}

Until: TypeAlias = str | tuple[str, GivenValue] | tuple[str, str, GivenValue]
"""A signal that is on, a signal and the value that it has, or a signal, a comparison such as ">=" and a value."""


class MoveOptions(TypedDict, total=False):
    """Options of every move.

    Attributes:
        speed_factor: the part of the joints' greatest speed that is used, above 0, up to 1 (the default).
        time_law: `jerk_limited` (the default), or `time_optimal`, which keeps speeds and accelerations and no jerk.
        acceleration_factor: the part of the greatest acceleration that is used, above 0, up to 1 (the default), of
            point-to-point moves, lines, arcs and splines.
        jerk_factor: the same of the jerk.
    """

    speed_factor: float | None
    time_law: str | None
    acceleration_factor: float | None
    jerk_factor: float | None


class GoalOptions(MoveOptions, total=False):
    """Options of moves to poses.

    Attributes:
        reference: the node in whose frame poses and points are given.
        moving: the goal goes along when another move of the same step moves the reference.
        lock: joints that stand still, radians or meters by name, or a list of names: where they are now.
        prefer: what free joints are used for: `limits`, `manipulability`, `distance` (to things), or a posture to be
            near, by joint name.
        fixed_tool: a node that stands apart from the robot, such as a spindle, which is the tool of this move: the
            robot carries `reference`, and poses say where the tool is in that.
    """

    reference: str | None
    moving: bool | None
    fixed_tool: str | None
    lock: Lock | None
    prefer: Prefer | None


class PointToPointOptions(GoalOptions, total=False):
    """Options of point-to-point moves.

    Attributes:
        above: meters that a pose or target is stopped short of, back along its own z: before a tool that works along z.
        configuration: the only configuration that will do for a pose, such as `right up noflip`; see
            `InverseSolution.configurations`.
        arm_angle: angle of the elbow about the line from shoulder to wrist (rad), for arms such as the iiwa.
        velocity: the greatest speed of the tool centre point on the way (m/s); any by default.
        angular_velocity: how fast the tool turns at most (rad/s); any by default.
    """

    configuration: str | None
    arm_angle: float | None
    above: float | None
    velocity: float | None
    angular_velocity: float | None


class CartesianOptions(GoalOptions, total=False):
    """Options of moves of the tool centre point along a path.

    Attributes:
        velocity: its greatest speed (m/s), 0.25 by default.
        acceleration: its greatest acceleration (m/s^2), 1 by default.
        angular_velocity: the greatest angular velocity of the tool (rad/s), 2 by default.
    """

    velocity: float | None
    acceleration: float | None
    angular_velocity: float | None


class LinearOptions(CartesianOptions, total=False):
    """Options of lines.

    Attributes:
        above: as of `PointToPointOptions`.
    """

    above: float | None


class CircularOptions(CartesianOptions, total=False):
    """Options of arcs; the points are given in the frame of `reference`.

    Attributes:
        center: (3,) the point (m) that it turns about, instead of `via`.
        axis: (3,) the axis that it turns about by the right hand; without it, it goes the shorter way.
        angle: how far it turns (rad), up to ten turns; with it the goal may be left out: then the tool keeps its
            orientation.
        turn_with_arc: the tool turns as the arc does, not evenly from its orientation to the goal's.
    """

    center: ArrayLike | None
    axis: ArrayLike | None
    angle: float | None
    turn_with_arc: bool | None


class TrajectoryOptions(MoveOptions, total=False):
    """Options of joint trajectories; `MoveOptions` are no use to what has its own times.

    Attributes:
        accelerations: (n, k) in rad/s^2 or m/s^2, of `segments` with velocities.
        interpolation: `smooth` (the default), one curve from where the joints are; or `segments`, each by what both of
            its rows say, as the joint_trajectory_controller of ros2_control: straight, of the third degree with
            velocities, of the fifth with accelerations. Segments may begin after 0, also with the joints on their way
            (`replace` of `StartOptions`), and pass their last row at a velocity, after which it brakes.
        start_time: of `segments`: simulation time (s) of their time 0; without it, it is that of the start.
        path_tolerances: how far joints may be from where they are commanded to be: radians or meters, or these and
            rad/s or m/s; of all joints, or by their names. Beyond it the motion brakes, and is aborted.
        goal_tolerances: likewise how far they may be from the last row, at rest there, for the motion to succeed.
        goal_time_tolerance: how long that is waited for (s); without it as long as it takes.
    """

    accelerations: ArrayLike | None
    interpolation: str | None
    start_time: float | None
    path_tolerances: Tolerances | None
    goal_tolerances: Tolerances | None
    goal_time_tolerance: float | None


class JogOptions(TypedDict, total=False):
    """Options of jogs of the tool centre point.

    Attributes:
        rotation: (3,) the axis that it turns about, of any length, instead of a translation.
        frame: the axes of the direction: `base` (the robot's, the default), `tool` or `world`.
        node: the node whose axes these are instead.
        velocity: in m/s or rad/s, 0.1 or 0.25 by default.
        distance: in meters or radians; without it, it goes as far as the arm can, at most 2 m or a whole turn.
        lock: as of `GoalOptions`.
        prefer: as of `GoalOptions`.
    """

    rotation: ArrayLike | None
    frame: str | None
    node: str | None
    velocity: float | None
    distance: float | None
    lock: Lock | None
    prefer: Prefer | None


class Move(Wrapped[motion_pb2.Move]):
    """Move of one robot, or of a group of it, that is not started; `Robot.linear` and its like make it.

    It is for `Robot.start`, `Client.move_together`, `plan` and `check`, and steps of a `Program`.
    """

    __slots__ = ()
    _called = "a move, as robot.ptp, robot.linear and their like make it, which start nothing"

    @property
    def robot(self) -> str:
        """The robot that it moves."""
        return self._message.robot

    @property
    def kind(self) -> str:
        """Kind of the move, as in the contract: `point_to_point`, `linear`, `circular`, `spline`, ..."""
        return self._message.WhichOneof("move") or ""

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Move of {self.robot!r}: {self.kind}>"


def messages_of(moves: Iterable[Move]) -> list[motion_pb2.Move]:
    """Return moves that go together as messages, after a look that they are moves and no motions that run already."""
    given = list(moves)
    for move in given:
        if not isinstance(move, Move):
            raise InvalidArgumentError(
                f"moves that go together or are steps of a program are made by robot.ptp, robot.linear and their like, "
                f"which start nothing; not {move!r}"
            )
    return [move._message for move in given]


def time_law_number(name: str | None) -> motion_pb2.TimeLaw:
    """Return the enum value of a time law; None means the default."""
    if name is None:
        return motion_pb2.TIME_LAW_UNSPECIFIED
    if name not in TIME_LAWS:
        raise InvalidArgumentError(f"time_law is one of {', '.join(map(repr, TIME_LAWS))}, not {name!r}")
    return TIME_LAWS[name]


def until_condition(until: Until) -> motion_pb2.SignalCondition:
    """Return the condition of a search as a message."""
    if isinstance(until, str):
        return condition(until, True)
    if len(until) == 2:
        return condition(*until)
    signal, comparison, value = until
    return condition(signal, value, comparison)


def pose_goal(reference_t_tcp: PoseLike | None, options: Mapping[str, Any]) -> motion_pb2.PoseGoal:
    """Return a goal for the tool centre point: a 4x4 pose in the frame that `GoalOptions` say."""
    if reference_t_tcp is not None and (above := options.get("above")):
        reference_t_tcp = checked_pose(reference_t_tcp) @ pose(z=-above)
    return motion_pb2.PoseGoal(
        reference_t_tcp=None if reference_t_tcp is None else pose_message(reference_t_tcp),
        reference=options.get("reference") or "world",
        configuration=options.get("configuration"),
        moving=options.get("moving") or False,
    )


def goal_at(place: ArrayLike | str, options: Mapping[str, Any]) -> motion_pb2.PoseGoal:
    """Return a goal for the tool centre point: a target by its name, or a 4x4 pose."""
    return target_goal(place, options) if isinstance(place, str) else pose_goal(place, options)


def target_goal(name: str, options: Mapping[str, Any]) -> motion_pb2.PoseGoal:
    """Return a goal for the tool centre point: a target."""
    if "reference" in options:
        raise InvalidArgumentError(
            f"the target {name!r} says itself where it is; leave out the reference {options['reference']!r}"
        )
    goal = pose_goal(np.eye(4), {**options, "reference": name})
    if not options.get("above"):
        goal.ClearField("reference_t_tcp")
    return goal


def point_to_point(
    goal: Mapping[str, float] | str | ArrayLike, options: PointToPointOptions
) -> motion_pb2.PointToPoint:
    """Return a path straight in joint space: to joints by name, to a posture by its name, or to a 4x4 pose."""
    for option in ("configuration", "above"):
        if (given := options.get(option)) and isinstance(goal, str | Mapping):
            raise InvalidArgumentError(f"the {option} {given!r} is for a goal that is a pose or target, not {goal!r}")
    paced = tcp_rates(options)
    if isinstance(goal, str):
        return motion_pb2.PointToPoint(posture=goal, **paced)
    if isinstance(goal, Mapping):
        return motion_pb2.PointToPoint(joints=motion_pb2.JointGoal(joint_positions=joint_map(goal)), **paced)
    return motion_pb2.PointToPoint(pose=pose_goal(goal, options), **paced)


def linear(place: PoseLike | str, until: Until | None, options: LinearOptions) -> motion_pb2.Linear:
    """Return a straight line of the tool centre point to a 4x4 pose or a target; with `until` a search."""
    condition = None if until is None else until_condition(until)
    return motion_pb2.Linear(goal=goal_at(place, options), until=condition, **_rates(options))


def circular(
    via: ArrayLike | None, goal: ArrayLike | None, until: Until | None, options: CircularOptions
) -> motion_pb2.Circular:
    """Return an arc of the tool centre point through a point, or about a centre; with `until` a search."""
    center, axis, angle = options.get("center"), options.get("axis"), options.get("angle")
    if (via is None) == (center is None):
        raise InvalidArgumentError("an arc goes through a point or about a centre: give one of via and center")
    if via is not None and (axis is not None or angle is not None):
        raise InvalidArgumentError("axis and angle go with center, not with via")
    arc = motion_pb2.Circular(goal=pose_goal(goal, options), **_rates(options))
    if until is not None:
        arc.until.CopyFrom(until_condition(until))
    if options.get("turn_with_arc"):
        arc.orientation = motion_pb2.ARC_ORIENTATION_WITH_ARC
    if via is not None:
        arc.via.CopyFrom(vector_message(via, "the via point"))
    elif center is not None:
        arc.center.position.CopyFrom(vector_message(center, "the centre"))
        if axis is not None:
            arc.center.axis.CopyFrom(vector_message(axis, "the axis"))
        if angle is not None:
            arc.center.angle_radians = angle
    return arc


def spline(
    goals: Iterable[ArrayLike | str], references: Sequence[str] | None, options: CartesianOptions
) -> motion_pb2.Spline:
    """Return a smooth curve of the tool centre point through poses and targets, which are names."""
    places = list(goals)
    if references is not None and len(references) != len(places):
        raise InvalidArgumentError(f"{len(places)} poses need as many references, not {len(references)}")
    own = [options if references is None else {**options, "reference": name} for name in references or places]
    wanted = [goal_at(place, chosen) for place, chosen in zip(places, own, strict=True)]
    return motion_pb2.Spline(goals=wanted, **_rates(options))


def cartesian_jog(translation: ArrayLike | None, options: JogOptions) -> motion_pb2.CartesianJog:
    """Return a way of the tool centre point along a direction or about an axis."""
    rotation, frame, node = options.get("rotation"), options.get("frame"), options.get("node")
    if (translation is None) == (rotation is None):
        raise InvalidArgumentError("a jog goes along a direction or about an axis: give either translation or rotation")
    velocity = value_or_default(options.get("velocity"), "the velocity of a jog")
    jog = motion_pb2.CartesianJog(velocity=velocity, distance=options.get("distance"), node=node)
    if translation is not None:
        jog.translation.CopyFrom(vector_message(translation, "the translation"))
    elif rotation is not None:
        jog.rotation.CopyFrom(vector_message(rotation, "the rotation"))
    jog.frame = jog_frame(frame, node)
    return jog


def jog_frame(frame: str | None, node: str | None) -> motion_pb2.JogFrame:
    """Return the frame whose axes a name or a node stands for; the robot's without either."""
    name = frame or ("node" if node else "base")
    if name not in _JOG_FRAMES or (name != "node" and node):
        raise InvalidArgumentError(
            f"the axes of a jog are those of the frame 'base', 'tool' or 'world', or of a node: not {frame!r}"
            + (f" with the node {node!r}" if node else "")
        )
    return _JOG_FRAMES[name]


def trajectory(
    joints: Sequence[str],
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike | None,
    options: TrajectoryOptions,
) -> motion_pb2.JointTrajectory:
    """Return positions (n, k) of joints at `times` (n,), with `velocities` (n, k) or along a smooth curve."""
    moments, columns = np.asarray(times, dtype=float), np.asarray(positions, dtype=float)
    if columns.shape != (len(moments), len(joints)):
        raise InvalidArgumentError(
            f"positions have the shape (times, joints) = ({len(moments)}, {len(joints)}), not {columns.shape}"
        )
    interpolation = options.get("interpolation") or "smooth"
    if interpolation not in INTERPOLATIONS:
        names = ", ".join(map(repr, INTERPOLATIONS))
        raise InvalidArgumentError(f"interpolation is one of {names}, not {interpolation!r}")
    path = motion_pb2.JointTrajectory(
        joint_names=joints,
        times=array_message(moments),
        positions=array_message(columns),
        interpolation=INTERPOLATIONS[interpolation],
        start_time_seconds=options.get("start_time"),
        path_tolerances=_tolerances(joints, options.get("path_tolerances"), "path_tolerances"),
        goal_tolerances=_tolerances(joints, options.get("goal_tolerances"), "goal_tolerances"),
        goal_time_tolerance_seconds=value_or_default(options.get("goal_time_tolerance"), "goal_time_tolerance"),
    )
    for name, given in (("velocities", velocities), ("accelerations", options.get("accelerations"))):
        if given is not None:
            rates = np.asarray(given, dtype=float)
            if rates.shape != columns.shape:
                raise InvalidArgumentError(f"{name} have the shape of positions, {columns.shape}, not {rates.shape}")
            getattr(path, name).CopyFrom(array_message(rates))
    return path


def _tolerances(joints: Sequence[str], given: Tolerances | None, what: str) -> list[motion_pb2.JointTolerance]:
    """Return tolerances of joints by name, or the same of all."""
    if given is None:
        return []
    found = []
    for joint, values in (given if isinstance(given, Mapping) else dict.fromkeys(joints, given)).items():
        position, velocity = values if isinstance(values, tuple) else (values, 0.0)
        if not (position >= 0.0 and velocity >= 0.0):
            raise InvalidArgumentError(f"{what} are 0 (any) or above, not {values!r} of {joint!r}")
        found.append(motion_pb2.JointTolerance(joint=joint, position=position, velocity=velocity))
    return found


def tcp_rates(options: CartesianOptions | PointToPointOptions) -> dict[str, Any]:
    """Return the greatest speeds of the tool centre point, as fields of a move."""
    return {
        "max_velocity_meters_per_second": value_or_default(options.get("velocity"), "velocity"),
        "max_angular_velocity_radians_per_second": value_or_default(
            options.get("angular_velocity"), "angular_velocity"
        ),
    }


def _rates(options: CartesianOptions) -> dict[str, Any]:
    acceleration = value_or_default(options.get("acceleration"), "acceleration")
    return {**tcp_rates(options), "max_acceleration_meters_per_second_squared": acceleration}
