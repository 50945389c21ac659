"""Robots: where they are, where they can go, and their motions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from virtualrobot.dynamics import InverseDynamics, Samples, movement_message
from virtualrobot.editor import Direct
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix, poses_from_rows
from virtualrobot.jogger import Jogger
from virtualrobot.kinematics_check import KinematicsCheck
from virtualrobot.leases import Lease, acquire
from virtualrobot.move_maker import JointPositions
from virtualrobot.newest import newest
from virtualrobot.redundancy import Lock, Prefer, redundancy
from virtualrobot.robot_values import (
    Actuator,
    ForwardSolution,
    InverseSolution,
    Jacobians,
    JointGroup,
    JointLimits,
    LinkPair,
    RobotState,
)
from virtualrobot.services import LONG_TIMEOUT_SECONDS
from virtualrobot.setpoints import MODES, SetpointStream
from virtualrobot.tool import Tool
from virtualrobot.v1 import motion_pb2, robot_pb2, scene_pb2
from virtualrobot.wire import array_of, pose_message, pose_of, settings_message, settings_of, vector_message


class Robot(Jogger):
    """A robot by its name: an arm, a conveyor, a turntable, a vehicle, whatever has joints.

    Positions are radians or meters, poses 4x4 arrays. The motions and their options are those of `Mover`
    and `Jogger`.
    """

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
    def groups(self) -> dict[str, JointGroup]:
        """Joints with a common name, by that name; from an SRDF file."""
        return {
            group.name: JointGroup(group.name, tuple(group.joint_names), group.base_link, group.tip_link)
            for group in self.description.groups
        }

    @property
    def actuators(self) -> list[Actuator]:
        """What drives the joints, in the order of `RobotState.actuator_positions`; empty where motors are joints."""
        return [Actuator.of(message) for message in self.description.actuators]

    @property
    def allowed_collisions(self) -> list[LinkPair]:
        """Pairs of links that may touch: adjacent ones, and those that the model says."""
        return [LinkPair(pair.first, pair.second, pair.reason) for pair in self.description.allowed_collisions]

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
        stream = self._services.robot.WatchRobotStates(request)
        with closing(newest(stream, lambda said: ((one.name, (one, said.stamp)) for one in said.robots))) as states:
            for robot, stamp in states:
                yield RobotState.of(robot, stamp)

    @property
    def speed_factor(self) -> float:
        """By what its motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
        return self.state.speed_factor

    @speed_factor.setter
    def speed_factor(self, factor: float) -> None:
        Direct(self._services).set_speed_factor(factor, self.name)

    def set_positions(self, positions: JointPositions) -> None:
        """Put joints somewhere at once, without a motion; values by name, or all coordinates in order."""
        Direct(self._services).set_joint_positions(self.name, positions)

    def lease(self, *, take: bool = False, owner: str = "") -> Lease:
        """Lease it, so that nobody but this client moves it; see `Client.lease`.

        Example:
            >>> with robot.lease():
            ...     robot.move_to("home")
        """
        return acquire(self._services, [self.name], owner, take)

    def stream(
        self,
        mode: str = "position",
        joints: Sequence[str] | None = None,
        *,
        timeout: float = 0.2,
        preempt: bool = False,
    ) -> SetpointStream:
        """Open a stream of setpoints, which moves joints as this program sends them.

        Args:
            mode: what setpoints are, `position` or `velocity`.
            joints: which joints, in the order of the values; without them all joints of one coordinate.
            timeout: after how many seconds of simulation time without a setpoint the joints stop.
            preempt: cancel motions in the way instead of being refused.

        Raises:
            RobotBusyError: when one of the joints moves already.
            UnknownNameError: when the robot has no such joint.
            LeasedError: when somebody else has leased the robot.

        Example:
            >>> with robot.stream("velocity", ["lbr_iiwa_joint_1"]) as stream:
            ...     stream.send([0.5])
        """
        if mode not in MODES:
            raise InvalidArgumentError(f"mode is 'position' or 'velocity', not {mode!r}")
        if joints is None:
            joints = [joint.name for joint in self.description.joints if joint.coordinate_count == 1]
        if not joints:
            raise InvalidArgumentError(f"a stream of {self.name!r} needs joints to move")
        target = motion_pb2.SetpointTarget(
            robot=self.name,
            joint_names=joints,
            mode=MODES[mode],
            timeout_seconds=timeout,
            busy_policy=motion_pb2.BUSY_POLICY_PREEMPT if preempt else motion_pb2.BUSY_POLICY_REJECT,
        )
        return SetpointStream(self._services, target)

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

    def pick(self, part: str = "", max_distance_meters: float = 0.0) -> str:
        """Fix a part to the chosen tool and return its name.

        Without a name it is the one nearest to the tool centre point, within 0.2 m.
        """
        command = scene_pb2.PickPart(robot=self.name, part=part, max_distance_meters=max_distance_meters)
        return self._services.apply([scene_pb2.Command(pick_part=command)]).picked_parts[0]

    def place(self, part: str = "", parent: str = "") -> None:
        """Let a part go, or all; it stays where it is, fixed to `parent` (empty: world)."""
        Direct(self._services).place(self.name, part, parent)

    # Kinematics; nothing moves.

    def solve_forward(self, positions: JointPositions | None = None) -> ForwardSolution:
        """Return where links and tool centre point would be; joints that are not named stand as they are now."""
        request = robot_pb2.SolveForwardRequest(robot=self.name, joint_positions=self._named(positions))
        response = self._services.robot.SolveForward(request)
        poses = poses_from_rows(array_of(response.world_t_link))
        return ForwardSolution(pose_of(response.world_t_tcp), dict(zip(response.links, poses, strict=True)))

    def solve_jacobian(
        self,
        positions: JointPositions | None = None,
        points: Iterable[tuple[str, ArrayLike]] = (),
        reference: str = "",
    ) -> Jacobians:
        """Return how the tool centre point, and points fixed to links, tools or held parts, move with the joints.

        Args:
            positions: where the joints are; those that are not named stand as they are now.
            points: what each is fixed to, and where it is with the joints there, x, y, z in meters.
            reference: the node in whose frame the points are given (empty: world).

        Raises:
            UnknownNameError: when there is no such joint or node.
            InvalidArgumentError: when the robot does not carry a node.

        Example:
            >>> near = client.collisions.distance("arm")
            >>> robot.solve_jacobian(points=[(near.first, near.points[0])]).points[0, :3]
            array([[...]])
        """
        request = robot_pb2.SolveJacobianRequest(
            robot=self.name,
            joint_positions=self._named(positions),
            points=[
                robot_pb2.RobotPoint(node=node, point=vector_message(point, f"point on {node}"), reference=reference)
                for node, point in points
            ],
        )
        return Jacobians.of(self._services.robot.SolveJacobian(request))

    def solve_inverse(
        self,
        reference_t_tcp: ArrayLike,
        seed: JointPositions | None = None,
        reference: str = "",
        configuration: str = "",
        *,
        lock: Lock = (),
        arm_angle: float | None = None,
        prefer: Prefer = "",
    ) -> InverseSolution:
        """Return the joints that bring the tool centre point to a 4x4 pose, nearest to `seed` (default: now) first.

        Args:
            reference_t_tcp: the pose.
            seed: where to start from; joints that are not named start as they are now.
            reference: the node in whose frame the pose is given (empty: world).
            configuration: the name of the only one that is wanted, such as `right up noflip`.
            lock: joints that stand still, radians or meters by name, or a list of names: where they are now.
            arm_angle: where the elbow is about the line from shoulder to wrist, radians, for arms such as the iiwa.
            prefer: what free joints are used for: `limits`, `manipulability` or `distance` (to stay away from limits,
                from singularities or from things), or a posture to be near, by joint name.

        Example:
            >>> robot.solve_inverse(virtualrobot.pose(0.5, 0.1, 0.6, roll=np.pi)).best
            array([ 0.2 , ...])
        """
        request = robot_pb2.SolveInverseRequest(
            robot=self.name,
            reference_t_tcp=pose_message(reference_t_tcp),
            reference=reference,
            seed=self._named(seed),
            configuration=configuration,
            redundancy=redundancy(lock, arm_angle, prefer, joints_now=self._joints_now),
        )
        return InverseSolution.of(self._services.robot.SolveInverse(request))

    # Dynamics; nothing moves.

    def solve_inverse_dynamics(
        self,
        positions: Samples | None = None,
        velocities: Samples | None = None,
        accelerations: Samples | None = None,
        joint_names: list[str] | None = None,
    ) -> InverseDynamics:
        """Return which torques a movement takes, tools and held parts included; gravity is 9.81 m/s^2.

        Values are by joint name, a number or one for each sample, or in order: (k,) or (n, k). Joints that are not
        named stand as they are now.

        Args:
            positions: radians or meters, within limits; without them where the joints are now.
            velocities: rad/s or m/s; without them 0.
            accelerations: rad/s^2 or m/s^2; without them 0.
            joint_names: what the columns are, when values are in order; without them all joints of one coordinate.

        Raises:
            InvalidArgumentError: when shapes don't fit or a number is not finite.
            LimitError: when a position is outside its joint's limits.
            UnknownNameError: when the robot has no such joint.

        Example:
            >>> robot.solve_inverse_dynamics(accelerations={"lbr_iiwa_joint_2": 5.0}).efforts
            array([[...]])
        """
        request = movement_message(self.name, joint_names or [], positions, velocities, accelerations)
        return InverseDynamics.of(self._services.robot.SolveInverseDynamics(request))

    def gravity_torques(self, positions: Mapping[str, float] | None = None) -> dict[str, float]:
        """Return what holds each joint at rest, N m (sliding joints: N), now or with some joints elsewhere."""
        found = self.solve_inverse_dynamics({**self._joints_now(), **(positions or {})})
        return dict(zip(found.joint_names, found.gravity_efforts[0].tolist(), strict=True))

    @property
    def kinematics(self) -> str:
        """The name of the component that solves its kinematics; `set_kinematics` gives it another one."""
        return self.description.kinematics

    @property
    def kinematics_settings(self) -> dict[str, Any]:
        """The settings of that component; those that are not named have their defaults."""
        return settings_of(self.description.kinematics_settings)

    @property
    def kinematics_fault(self) -> str:
        """Why that component is not asked any more; empty while it is well."""
        return self.description.kinematics_fault

    def set_kinematics(
        self, name: str, settings: Mapping[str, object] | None = None, **named: object
    ) -> KinematicsCheck:
        """Give it another kinematics component, or make its own anew; return how well that fits.

        The component is tried on this robot first. A motion that runs goes on as it was planned.

        Args:
            name: the component, one of `client.plugins.components("kinematics")`.
            settings: the component's settings; those that are not named get their defaults.
            named: settings too, as keywords.

        Raises:
            PluginFailedError: when the component does not fit the robot; the message has the numbers.
            UnknownNameError: when there is no such component.
            InvalidArgumentError: when it has no such setting, or refuses its value.

        Example:
            >>> robot.set_kinematics("my_arm", branch="elbow up")
            8 postures          position     rotation    a call
            forward            1.1e-16 m  2.2e-16 rad  0.002 ms
            ...
        """
        request = robot_pb2.SetKinematicsRequest(robot=self.name, kinematics=name)
        request.settings.CopyFrom(settings_message({**(settings or {}), **named}))
        # A process of its own has to start, which may compile.
        response = self._services.robot.SetKinematics(request, timeout=LONG_TIMEOUT_SECONDS)
        return KinematicsCheck.of(response.check)

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Robot {self.name!r} at {self._services.address}>"

    def _repr_html_(self) -> str:
        """Return a table of the joints for notebooks."""
        from virtualrobot.tables import joint_table_html

        return joint_table_html(self.name, self.description, self.state)
