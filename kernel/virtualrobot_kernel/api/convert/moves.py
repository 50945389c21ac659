"""Moves of the contract: to wishes that `planning` understands."""

from __future__ import annotations

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.values import array, by_name, finite, pose
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.moves import JointTrajectory, Linear, Move, PointToPoint, PoseGoal, ToolStateMove


def wished_move(message: motion_pb2.Move, what: str) -> Move:
    """Return what a client wishes one robot to do; raise KernelError that names the field that is wrong."""
    kind = message.WhichOneof("move")
    factor = finite(message.speed_factor, f"{what}.speed_factor")
    if factor and not 0.0 < factor <= 1.0:
        raise KernelError(f"{what}.speed_factor must be above 0 and at most 1, not {factor:g}", factor=factor)
    factor = factor or 1.0
    if kind == "point_to_point":
        return PointToPoint(message.robot, _goal(message.point_to_point, f"{what}.point_to_point"), factor)
    if kind == "linear":
        linear = message.linear
        if linear.goal.configuration:
            raise KernelError(
                f"{what}.linear.goal.configuration is {linear.goal.configuration!r}; a line keeps the configuration "
                "that it starts in, so leave it empty",
                field=f"{what}.linear.goal.configuration",
            )
        return Linear(
            message.robot,
            _pose_goal(linear.goal, f"{what}.linear.goal"),
            factor,
            _rate(linear.max_velocity_meters_per_second, f"{what}.linear.max_velocity_meters_per_second"),
            _rate(
                linear.max_acceleration_meters_per_second_squared,
                f"{what}.linear.max_acceleration_meters_per_second_squared",
            ),
        )
    if kind == "joint_trajectory":
        return _trajectory(message, what)
    if kind == "tool_state":
        return ToolStateMove(message.robot, message.tool_state.tool, message.tool_state.state, factor)
    names = ", ".join(field.name for field in message.DESCRIPTOR.oneofs_by_name["move"].fields)
    raise KernelError(f"{what} does not say how to move; give one of {names}", field=what)


def _goal(message: motion_pb2.PointToPoint, what: str) -> dict[str, float] | PoseGoal | str:
    kind = message.WhichOneof("goal")
    if kind == "joints":
        positions = by_name(message.joints.joint_positions)
        return {name: finite(value, f"{what}.joints[{name!r}]") for name, value in positions.items()}
    if kind == "pose":
        return _pose_goal(message.pose, f"{what}.pose")
    if kind == "posture":
        return message.posture
    raise KernelError(f"{what} has no goal; give joints, pose or posture", field=what)


def _pose_goal(message: motion_pb2.PoseGoal, what: str) -> PoseGoal:
    if not message.HasField("reference_t_tcp"):
        raise KernelError(f"{what}.reference_t_tcp is missing: where shall the tool centre point be?", field=what)
    return PoseGoal(pose(message.reference_t_tcp, f"{what}.reference_t_tcp"), message.reference, message.configuration)


def _trajectory(message: motion_pb2.Move, what: str) -> JointTrajectory:
    trajectory, what = message.joint_trajectory, f"{what}.joint_trajectory"
    if message.speed_factor not in (0.0, 1.0):
        raise KernelError(f"{what} has its own times; give no speed_factor", field="speed_factor")
    names = tuple(trajectory.joint_names)
    times = array(trajectory.times, (None,), f"{what}.times")
    shape = (len(times), len(names))
    velocities = (
        array(trajectory.velocities, shape, f"{what}.velocities") if trajectory.HasField("velocities") else None
    )
    return JointTrajectory(
        message.robot, names, times, array(trajectory.positions, shape, f"{what}.positions"), velocities
    )


def _rate(value: float, what: str) -> float:
    if finite(value, what) < 0.0:
        raise KernelError(f"{what} must be 0 (the default) or above, not {value:g}", field=what)
    return value
