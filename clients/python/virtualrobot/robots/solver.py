"""Computations on a robot while nothing moves: poses, Jacobians, joint positions, torques."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import (
    array_message,
    array_of,
    pose_message,
    pose_of,
    settings_message,
    settings_of,
    vector_message,
)
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import poses_from_rows
from virtualrobot.robots.calibration import Calibration
from virtualrobot.robots.description import described_anew
from virtualrobot.robots.dynamics import InverseDynamics, Samples, movement_message
from virtualrobot.robots.kinematics_check import KinematicsCheck
from virtualrobot.robots.mechanism import JointPositions, Mechanism
from virtualrobot.robots.redundancy import Lock, Prefer, redundancy
from virtualrobot.robots.values import ForwardSolution, InverseSolution, Jacobians, PointSolution
from virtualrobot.v1 import robot_pb2

log = logging.getLogger(__name__)


@checked
class Solver(Mechanism):
    """Kinematics and dynamics of a robot; and which component solves its kinematics.

    Positions are radians or meters, poses 4x4 arrays.
    """

    def solve_forward(
        self, positions: JointPositions | None = None, with_configuration: bool = False
    ) -> ForwardSolution:
        """Return where links and tool centre point would be; joints that are not named stand as they are now.

        With `with_configuration` the answer has the name of the configuration that the joints are in, too.
        """
        request = robot_pb2.SolveForwardRequest(
            robot=self.name,
            joint_positions=self._named(positions),
            group=self._group,
            with_configuration=with_configuration,
        )
        response = self._services.robot.SolveForward(request)
        poses = dict(zip(response.links, poses_from_rows(array_of(response.world_t_link)), strict=True))
        return ForwardSolution(pose_of(response.world_t_tcp), poses, response.configuration)

    def solve_jacobian(
        self,
        positions: JointPositions | None = None,
        points: Iterable[tuple[str, ArrayLike]] = (),
        reference: str = "world",
    ) -> Jacobians:
        """Return how the tool centre point, and points fixed to links, tools or held parts, move with the joints.

        Args:
            positions: the joint positions (rad or m); joints that are not named stand as they are now.
            points: for each the node that it is fixed to, and its position x, y, z (m) with the joints there.
            reference: the node in whose frame the points are given.

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
            group=self._group,
        )
        return Jacobians.of(self._services.robot.SolveJacobian(request))

    def solve_inverse(
        self,
        reference_t_tcp: PoseLike,
        seed: JointPositions | None = None,
        reference: str = "world",
        configuration: str | None = None,
        *,
        lock: Lock = (),
        arm_angle: float | None = None,
        prefer: Prefer | None = None,
    ) -> InverseSolution:
        """Return the joints that bring the tool centre point to a 4x4 pose, nearest to `seed` (default: now) first.

        Args:
            reference_t_tcp: the pose.
            seed: the joint positions to start from; joints that are not named start as they are now.
            reference: the node in whose frame the pose is given.
            configuration: the only one that is wanted, as of moves (`motions.moves.PointToPointOptions`), like the
                wishes for joints that the pose does not need: `lock`, `arm_angle` and `prefer`.
            lock: as of moves.
            arm_angle: as of moves.
            prefer: as of moves.

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
            group=self._group,
        )
        return InverseSolution.of(self._services.robot.SolveInverse(request))

    def solve_points(
        self, points: ArrayLike, seed: JointPositions | None = None, reference: str = "world"
    ) -> PointSolution:
        """Return the joints that bring the tool centre point to each of many points, however it is turned there.

        So a leg of three joints gets its foot to places on the ground. Each point is solved from the one before, so
        that a row of near points gives a smooth path; where that fails, from other postures within limits.

        Args:
            points: (n, 3) in meters, at most 100,000.
            seed: the joint positions to start from; joints that are not named start as they are now.
            reference: the node in whose frame the points are given.

        Raises:
            UnknownNameError: when there is no such joint or node.
            LimitError: when the seed is outside limits.
            TooLargeError: for more points.

        Example:
            >>> leg.solve_points([[0.2, 0.1, -0.1], [0.21, 0.1, -0.1]], reference="body").all
            array([[...]])
        """
        places = np.asarray(points, dtype=float)
        if places.ndim != 2 or places.shape[1] != 3:
            raise InvalidArgumentError(f"points have the shape (n, 3), not {places.shape}")
        request = robot_pb2.SolvePointsRequest(
            robot=self.name,
            points=array_message(places),
            reference=reference,
            seed=self._named(seed),
            group=self._group,
        )
        return PointSolution.of(self._services.robot.SolvePoints(request, timeout=LONG_TIMEOUT_SECONDS))

    @property
    def calibration(self) -> Calibration:
        """Tool, base and joints as measurements at the real robot have them."""
        return Calibration(self)

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
            joint_names: the joints of the columns, when values are in order; without them all joints of one coordinate.

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
        """Return what holds each joint at rest, N m (sliding joints: N), now or with some joints elsewhere.

        A body without a mass weighs nothing here; the log warns of it, as `InverseDynamics.warnings` does.
        """
        found = self.solve_inverse_dynamics({**self._joints_now(), **(positions or {})})
        for warning in found.warnings:
            log.warning("%s", warning)  # where nobody sets up logging, Python prints it
        return dict(zip(found.joint_names, found.gravity_efforts[0].tolist(), strict=True))

    @property
    def kinematics(self) -> str:
        """The name of the component that solves its kinematics; `set_kinematics` gives it another one."""
        return self._described_anew().kinematics

    @property
    def kinematics_settings(self) -> dict[str, Any]:
        """The settings of that component; those that are not named have their defaults."""
        return settings_of(self._described_anew().kinematics_settings)

    @property
    def kinematics_fault(self) -> str:
        """The latest fault of that component since it was chosen; empty while there was none."""
        return self._described_anew().kinematics_fault

    def set_kinematics(
        self, name: str | None, settings: Mapping[str, object] | None = None, **named: object
    ) -> KinematicsCheck:
        """Give it another kinematics component, or make its own anew; return how well that fits.

        The component is tried on this robot first. A motion that runs goes on as it was planned.

        Args:
            name: the component, one of `client.plugins.components("kinematics")`; None leaves it to the kernel again.
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
        group = self._group
        if group is not None and not group.name:
            raise InvalidArgumentError(
                f"a chain that is chosen by links has the component that its geometry allows; give {self.name!r} a "
                "named group to choose another one"
            )
        wanted = settings_message({**(settings or {}), **named})
        chosen = group.name if group else ""
        command = robot_pb2.KinematicsChoice(robot=self.name, kinematics=name, settings=wanted, group=chosen)
        request = robot_pb2.SetKinematicsRequest(choice=command)
        # A process of its own has to start, which may compile.
        response = self._services.robot.SetKinematics(request, timeout=LONG_TIMEOUT_SECONDS)
        return KinematicsCheck.of(response.check)

    def _described_anew(self) -> robot_pb2.GetRobotResponse:
        """Return what the kernel says now: components are chosen and fail while the structure stays the same."""
        return described_anew(self._services, self.name, self._group)
