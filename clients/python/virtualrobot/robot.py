"""Robots: where they are, where they can go, and their motions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from virtualrobot import motion, moves
from virtualrobot.editor import Batch
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix, poses_from_rows
from virtualrobot.robot_values import ForwardSolution, InverseSolution, JointLimits, RobotState
from virtualrobot.services import Services
from virtualrobot.tool import Tool
from virtualrobot.v1 import motion_pb2, robot_pb2, scene_pb2
from virtualrobot.wire import array_of, joint_map, pose_message, pose_of

JointPositions: TypeAlias = Mapping[str, float] | ArrayLike


class Robot:
    """A robot by its name: an arm, a conveyor, a turntable, a vehicle, whatever has joints.

    Positions are radians or meters, poses 4x4 arrays. Motions block until they have ended unless `wait=False`, and then
    return a `Motion` that can be waited for, paused and cancelled. Their common options:

    - `speed_factor`: the part of the joints' greatest speed that is used, above 0, up to 1.
    - `wait`: whether to return only at the end.
    - `preempt`: cancel motions in the way instead of being refused with `RobotBusyError`.
    - `on_disconnect`: what the kernel does when this program vanishes, `stop` or `continue`.
    """

    def __init__(self, services: Services, name: str) -> None:
        """Handle the robot of this name; `Client.robot` checks that there is one."""
        self._services = services
        self.name = name

    @property
    def description(self) -> robot_pb2.GetRobotResponse:
        """Joints, links, tools and postures as the contract describes them."""
        return self._services.robot.GetRobot(robot_pb2.GetRobotRequest(name=self.name))

    @property
    def joint_names(self) -> list[str]:
        """The joints that can be moved, in the order of `positions`."""
        return [joint.name for joint in self.description.joints]

    @property
    def chain_joint_names(self) -> list[str]:
        """The joints that move the flange, in the order of inverse solutions; without a gripper's fingers."""
        return list(self.description.chain_joints)

    @property
    def limits(self) -> dict[str, JointLimits]:
        """How far and how fast each joint may move."""
        return {joint.name: JointLimits.of(joint.limits) for joint in self.description.joints}

    @property
    def links(self) -> list[str]:
        """The names of the links, parents before children."""
        return list(self.description.links)

    @property
    def flange(self) -> str:
        """The link that tools are mounted on."""
        return self.description.flange

    @property
    def postures(self) -> dict[str, dict[str, float]]:
        """Postures with a name, for `move_to`."""
        return {posture.name: dict(posture.joint_positions) for posture in self.description.postures}

    @property
    def state(self) -> RobotState:
        """Where joints, tool centre point and tools are now."""
        request = robot_pb2.GetRobotStatesRequest(names=[self.name])
        response = self._services.robot.GetRobotStates(request)
        return RobotState.of(response.robots[0], response.stamp)

    @property
    def positions(self) -> NDArray[np.float64]:
        """All joint coordinates now, in radians and meters."""
        return self.state.positions

    @property
    def tcp(self) -> Matrix:
        """`world_t_tcp`, 4x4: where the chosen tool centre point is (without a tool: the flange)."""
        return self.state.world_t_tcp

    def watch(self, max_rate_hertz: float = 0.0) -> Iterator[RobotState]:
        """Yield the state now and whenever it has changed, at most 30 times a second by default."""
        request = robot_pb2.WatchRobotStatesRequest(names=[self.name], max_rate_hertz=max_rate_hertz)
        with self._services.robot.WatchRobotStates(request) as stream:
            for response in stream:
                yield from (RobotState.of(robot, response.stamp) for robot in response.robots)

    # Moves: data that is not started yet, for Client.move_together.

    def ptp(self, goal: JointPositions | str, *, reference: str = "", speed_factor: float = 0.0) -> motion_pb2.Move:
        """Return a point-to-point move: all joints start and end together, straight in joint space.

        `goal` is joint values by name, joint values in order (all joints, or those of the chain), a 4x4 pose
        `reference_t_tcp` in the frame of the node `reference` (empty: world), or the name of a posture.
        """
        if not isinstance(goal, str | Mapping) and np.shape(goal) != (4, 4):
            goal = self._named(goal)
        return moves.point_to_point(self.name, goal, reference=reference, speed_factor=speed_factor)

    def linear(
        self,
        reference_t_tcp: ArrayLike,
        *,
        reference: str = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
    ) -> motion_pb2.Move:
        """Return a straight move of the tool centre point to a 4x4 pose; 0 means 0.25 m/s and 1 m/s^2."""
        return moves.linear(self.name, reference_t_tcp, reference, velocity, acceleration, speed_factor)

    def trajectory(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        *,
        joints: list[str] | None = None,
        speed_factor: float = 0.0,
    ) -> motion_pb2.Move:
        """Return a move through `positions` (n, k) at `times` (n,) in seconds from 0; the first row is where it is now.

        `velocities` (n, k) are 0 at both ends; without them the curve is smooth. `joints` names the columns; without
        it they are all joints, or those of the chain.
        """
        columns = np.asarray(positions, dtype=float)
        if columns.ndim != 2:
            raise InvalidArgumentError(f"positions have the shape (times, joints), not {columns.shape}")
        names = joints if joints is not None else self._joints_for(columns.shape[1])
        return moves.trajectory(self.name, names, times, columns, velocities, speed_factor)

    # Motions.

    def start(self, move: motion_pb2.Move, **options: Any) -> motion.Motion:  # noqa: ANN401 wait, preempt, on_disconnect
        """Start one move; see the options of the class."""
        return motion.start(self._services, [move], **options)

    def move_joints(self, goal: JointPositions, *, speed_factor: float = 0.0, **options: Any) -> motion.Motion:  # noqa: ANN401
        """Move joints to values by name, or in order (all joints, or those of the chain).

        Example:
            >>> robot.move_joints({"lbr_iiwa_joint_4": -1.57}, speed_factor=0.5)
        """
        named = goal if isinstance(goal, Mapping) else self._named(goal)
        return self.start(self.ptp(named, speed_factor=speed_factor), **options)

    def move_pose(
        self,
        reference_t_tcp: ArrayLike,
        *,
        reference: str = "",
        speed_factor: float = 0.0,
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move the tool centre point to a 4x4 pose, point to point, with the posture nearest to the present one."""
        move = moves.point_to_point(self.name, reference_t_tcp, reference=reference, speed_factor=speed_factor)
        return self.start(move, **options)

    def move_to(self, posture: str, *, speed_factor: float = 0.0, **options: Any) -> motion.Motion:  # noqa: ANN401
        """Move to a posture with a name, such as `home`."""
        return self.start(self.ptp(posture, speed_factor=speed_factor), **options)

    def move_linear(
        self,
        reference_t_tcp: ArrayLike,
        *,
        reference: str = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move the tool centre point straight to a 4x4 pose; 0 means 0.25 m/s and 1 m/s^2.

        Example:
            >>> robot.move_linear(robot.tcp @ virtualrobot.pose(z=0.1), velocity=0.1)     # 10 cm along the tool
        """
        return self.start(
            self.linear(
                reference_t_tcp,
                reference=reference,
                velocity=velocity,
                acceleration=acceleration,
                speed_factor=speed_factor,
            ),
            **options,
        )

    def follow(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        *,
        joints: list[str] | None = None,
        speed_factor: float = 0.0,
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Pass joint positions at given times; see `trajectory`."""
        move = self.trajectory(times, positions, velocities, joints=joints, speed_factor=speed_factor)
        return self.start(move, **options)

    def stop(self) -> list[motion.Motion]:
        """Cancel every motion of this robot; return them."""
        response = self._services.motion.Stop(motion_pb2.StopRequest(robots=[self.name]))
        return [motion.Motion(self._services, message) for message in response.motions]

    @property
    def speed_factor(self) -> float:
        """By what its motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
        return self.state.speed_factor

    @speed_factor.setter
    def speed_factor(self, factor: float) -> None:
        self._apply("set_speed_factor", factor, self.name)

    def set_positions(self, positions: JointPositions) -> None:
        """Put joints somewhere at once, without a motion; values by name, or all coordinates in order."""
        self._apply("set_joint_positions", self.name, positions)

    # Tools and parts.

    @property
    def tools(self) -> list[str]:
        """The names of the tools mounted on it."""
        return list(self.description.tools)

    def tool(self, name: str = "") -> Tool:
        """Return a handle for a tool of this robot; without a name the chosen one.

        Example:
            >>> robot.tool("hand").open()
        """
        return Tool.of(self._services, self.name, name)

    def pick(self, part: str = "", max_distance_meters: float = 0.0) -> None:
        """Fix a part to the chosen tool; without a name the one nearest to the tool centre point, within 0.2 m."""
        self._apply("pick", self.name, part, max_distance_meters)

    def place(self, part: str = "", parent: str = "") -> None:
        """Let a part go, or all; it stays where it is, fixed to `parent` (empty: world)."""
        self._apply("place", self.name, part, parent)

    # Kinematics; nothing moves.

    def solve_forward(self, positions: JointPositions | None = None) -> ForwardSolution:
        """Return where links and tool centre point would be; joints that are not named stand as they are now."""
        request = robot_pb2.SolveForwardRequest(robot=self.name, joint_positions=self._named(positions))
        response = self._services.robot.SolveForward(request)
        poses = poses_from_rows(array_of(response.world_t_link))
        return ForwardSolution(pose_of(response.world_t_tcp), dict(zip(response.links, poses, strict=True)))

    def solve_inverse(
        self, reference_t_tcp: ArrayLike, seed: JointPositions | None = None, reference: str = ""
    ) -> InverseSolution:
        """Return the joints that bring the tool centre point to a 4x4 pose, nearest to `seed` (default: now) first.

        Example:
            >>> robot.solve_inverse(virtualrobot.pose(0.5, 0.1, 0.6, roll=np.pi)).best
            array([ 0.2 , ...])
        """
        request = robot_pb2.SolveInverseRequest(
            robot=self.name, reference_t_tcp=pose_message(reference_t_tcp), reference=reference, seed=self._named(seed)
        )
        return InverseSolution.of(self._services.robot.SolveInverse(request))

    def _apply(self, change: str, *arguments: object) -> scene_pb2.ApplyResponse:
        batch = Batch()
        getattr(batch, change)(*arguments)
        return self._services.apply(batch.commands)

    def _named(self, positions: JointPositions | None) -> dict[str, float]:
        """Return joint values by name; values in order are those of all joints or of the chain."""
        if positions is None:
            return {}
        if isinstance(positions, Mapping):
            return joint_map(positions)
        values = np.asarray(positions, dtype=float)
        if values.ndim != 1:
            raise InvalidArgumentError(f"joint positions are one row of numbers, not an array of shape {values.shape}")
        return dict(zip(self._joints_for(len(values)), values.tolist(), strict=True))

    def _joints_for(self, count: int) -> list[str]:
        """Return the joints that `count` values in order belong to."""
        description = self.description
        every = [joint.name for joint in description.joints]
        for names in (every, list(description.chain_joints)):
            if len(names) == count:
                return names
        raise InvalidArgumentError(
            f"{count} values for the robot {self.name!r}: it has {len(every)} joints ({', '.join(every)}), "
            f"{len(description.chain_joints)} of them in its chain; give values by name for others"
        )

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Robot {self.name!r} at {self._services.address}>"

    def _repr_html_(self) -> str:
        """Return a table of the joints for notebooks."""
        from virtualrobot.tables import joint_table_html

        return joint_table_html(self.name, self.description, self.state)
