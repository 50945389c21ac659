"""Driving: crafts, whose base is moved by their drives, by twists and on planned ways."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Unpack

import numpy as np

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import array_message, value_or_default
from virtualrobot._wire.names import unknown_name
from virtualrobot.errors import CollisionError, InvalidArgumentError, UnreachableError, WrongStateError
from virtualrobot.geometry import checked_pose
from virtualrobot.motions.motion import Motion, StartOptions
from virtualrobot.motions.setpoints import SetpointStream, StreamState, by_name
from virtualrobot.robots.mechanism import JointPositions
from virtualrobot.robots.mover import Mover
from virtualrobot.robots.odometry import Odometry
from virtualrobot.robots.reaching import moved, places_round
from virtualrobot.robots.solver import Solver
from virtualrobot.robots.ways import Way
from virtualrobot.sensors.motion_sensors import EncoderReading
from virtualrobot.v1 import motion_pb2, physics_pb2, robot_pb2, scene_pb2


@checked
class Driving(Mover, Solver):
    """Motions of a craft as a whole; `Robot` has them, and a robot that is no craft refuses them."""

    def stream_twist(self, *, timeout: float = 0.2, preempt: bool = False) -> SetpointStream:
        """Open a stream of twists of a craft: its drives move it as this program says, within their limits.

        A setpoint is (vx, vy, omega): m/s along the axes of its base, forward and to the left, and rad/s to the left.
        Of the states that the stream tells, positions are x, y and heading of the base, and velocities its twist.

        Args:
            timeout: after how many seconds of simulation time without a setpoint it stops.
            preempt: cancel motions in the way instead of being refused.

        Raises:
            WrongStateError: when the robot is no craft.
            RobotBusyError: when a drive moves already.
            PluginFailedError: when its component has failed.
            LeasedError: when somebody else has leased the robot.

        Example:
            >>> with robot.stream_twist() as stream:
            ...     stream.send([0.3, 0.0, 0.5])
        """
        target = motion_pb2.SetpointTarget(
            robot=self.name,
            mode=motion_pb2.SETPOINT_MODE_TWIST,
            timeout_seconds=timeout,
            busy_policy=motion_pb2.BUSY_POLICY_PREEMPT if preempt else motion_pb2.BUSY_POLICY_REJECT,
        )
        return SetpointStream(self._services, target, by_name)

    def drive(
        self,
        forward: float = 0.0,
        turn: float = 0.0,
        *,
        left: float = 0.0,
        seconds: float,
        timeout: float = 0.5,
        preempt: bool = False,
    ) -> StreamState:
        """Drive a craft with a twist for some seconds of simulation time, brake, and return where it rests.

        Args:
            forward: m/s along the x axis of its base.
            turn: rad/s to the left.
            left: m/s along the y axis, for crafts that can.
            seconds: how long, the time for gathering speed included.
            timeout: after how many seconds of simulation time it stops when this program is gone.
            preempt: cancel motions in the way instead of being refused.

        Raises:
            InvalidArgumentError: for a twist that the craft never has, or no time.
            LimitError: when a drive would be too fast.
            WrongStateError: when its wheels turned in the air: in the end physics find that they touch nothing.
            MotionAbortedError: when the kernel had to end it, such as before a collision.

        And what `stream_twist` raises.

        Example:
            >>> robot.drive(0.3, 0.5, seconds=2.0)
        """
        if not 0.0 < seconds < math.inf:
            raise InvalidArgumentError(f"seconds is above 0 and finite, not {seconds:g}")
        with self.stream_twist(timeout=timeout, preempt=preempt) as stream:
            begin = stream.state.time
            stream.send([forward, left, turn])
            for state in stream:
                if state.time - begin >= seconds:
                    break
                stream.send([forward, left, turn])
        if forward or left or turn:
            self._check_wheels()
        return stream.state

    def _driven(self, way: Way, options: StartOptions) -> Motion:
        """Start a way; raise WrongStateError, once it has ended, where wheels turned in the air."""
        motion = way.start(**options)
        if options.get("wait", True):
            self._check_wheels()
        return motion

    def _check_wheels(self) -> None:
        """Raise WrongStateError where physics move the robot, and find that no link that a drive moves touches."""
        physics = self._services.physics.GetPhysics(physics_pb2.GetPhysicsRequest())
        if not physics.settings.engine or physics.fault:
            return
        nodes = {node.name: node for node in self._services.scene.GetScene(scene_pb2.GetSceneRequest()).nodes}
        if not nodes[self.name].robot.dynamic:
            return
        drives = set(self.way([]).joint_names)
        wheels = [
            name for name, node in nodes.items() if name.startswith(f"{self.name}.") and node.link.joint.name in drives
        ]
        if not {name for one in physics.contacts for name in (one.first, one.second)} & set(wheels):
            raise WrongStateError(
                f"the wheels of {self.name!r} turned in the air: none of {', '.join(wheels)} touches anything; put it "
                "on a floor the right way up ('virtualrobot physics' tells what touches)"
            )

    def drive_path(self, parts: ArrayLike, **options: Unpack[StartOptions]) -> Motion:
        """Drive a craft along lines and arcs, one after the other, as a planned motion; it stands between them.

        Args:
            parts: shape (n, 3): how far each goes forward and to the left along the axes of the base (m), and turns to
                the left meanwhile (rad). What steers is turned while the craft stands.
            options: of the start, as of any motion.

        Raises:
            InvalidArgumentError: for no part, and one that the craft never goes, such as a turn on the spot of a car.
            WrongStateError: when the robot is no craft.

        And what a start of a motion raises.

        Example:
            >>> robot.drive_path([[1.0, 0.0, 0.0], [0.0, 0.0, np.pi / 2]])
        """
        way = self.way(parts)
        if not len(way.parts):
            raise InvalidArgumentError("a way has a part at least: rows of forward (m), left (m) and turn (rad)")
        return self._driven(way, options)

    def drive_to(
        self,
        x: float,
        y: float,
        heading: float | None = None,
        *,
        reverse: bool = False,
        turning_radius: float | None = None,
        **options: Unpack[StartOptions],
    ) -> Motion:
        """Drive a craft to a place, by the shortest way of lines and arcs: that of `way_to`.

        Args:
            x: where to, in the frame of the robot (m).
            y: where to.
            heading: how far it is turned to the left in the end (rad); None leaves it as it comes.
            reverse: whether it may go back on its way, too.
            turning_radius: radius of the arcs (m); by default as narrow as it can turn.
            options: of the start, as of any motion.

        Raises what `way_to` does, and what a start of a motion raises.

        Example:
            >>> robot.drive_to(1.0, 0.5, heading=0.0)
        """
        return self._driven(self.way_to(x, y, heading, reverse=reverse, turning_radius=turning_radius), options)

    def way(self, parts: ArrayLike, *, joints: JointPositions | None = None) -> Way:
        """Return a way of a craft along lines and arcs, as `drive_path` drives it; nothing moves.

        Args:
            parts: as of `drive_path`.
            joints: other joints of the robot, such as those of an arm on it, and where they are in the end: they go
                along evenly with the way. The drives and the base are none of them.

        Raises what `drive_path` does, but for what a start raises.

        Example:
            >>> way = robot.way([[1.0, 0.0, 0.0], [0.5, 0.0, np.pi / 2]])
            >>> if way.check().ok:
            ...     way.start()
        """
        rows = np.array(parts, dtype=float)
        message = array_message(rows if rows.size else rows.reshape(0, 3))
        request = robot_pb2.SolveDrivesRequest(robot=self.name, parts=message)
        return self._solved_way(request, joints)

    def way_to(
        self,
        x: float,
        y: float,
        heading: float | None = None,
        *,
        reverse: bool = False,
        turning_radius: float | None = None,
        joints: JointPositions | None = None,
    ) -> Way:
        """Return the shortest way of a craft to a place; nothing moves.

        What turns on the spot turns, goes straight, and turns again, unless a radius is given. Otherwise it goes on
        arcs and lines: the shortest word of Dubins, and with `reverse` of Reeds and Shepp. Nothing that stands in the
        way is gone round; `Way.check` tells of it.

        Args:
            x: where to, in the frame of the robot (m).
            y: where to.
            heading: how far it is turned to the left in the end (rad); None leaves it as it comes.
            reverse: whether it may go back on its way, too.
            turning_radius: radius of the arcs (m); by default as narrow as its component can turn.
            joints: as of `way`.

        Raises:
            InvalidArgumentError: for a radius that is narrower than it can turn, and numbers that are not finite.
            WrongStateError: when the robot is no craft, or its base is tilted.
            CollisionError: when it would touch something at its goal that it does not touch now.
            PluginFailedError: when its component has failed.

        Example:
            >>> robot.way_to(2.0, 1.0, heading=np.pi / 2, reverse=True).word
            'LSR-'
        """
        goal = robot_pb2.DriveGoal(
            x_meters=x,
            y_meters=y,
            heading_radians=heading,
            may_reverse=reverse,
            turning_radius_meters=value_or_default(turning_radius, "turning_radius"),
        )
        request = robot_pb2.SolveDrivesRequest(robot=self.name, goal=goal)
        return self._solved_way(request, joints)

    def way_to_reach(self, world_t_tcp: PoseLike, *, reverse: bool = False, turning_radius: float | None = None) -> Way:
        """Return a way on which base and arm of a mobile manipulator bring its tool centre point to a pose together.

        Where the arm reaches the pose as the base stands, it moves alone. Otherwise the base goes to one of places
        round the pose, headed for it: the nearest from which the arm reaches it and on whose way nothing is touched.
        Both begin and end together.

        Args:
            world_t_tcp: the pose (4x4) in the world's frame.
            reverse: as of `way_to`.
            turning_radius: as of `way_to`.

        Raises:
            UnreachableError: when there is no such place.

        And what `way_to` raises.

        Example:
            >>> robot.way_to_reach(virtualrobot.pose(2.0, 1.0, 0.8, roll=np.pi)).start()
        """
        goal = checked_pose(world_t_tcp)
        here = next(iter(self.solve_forward().world_t_link.values()))
        begin, refused = self.way([]).begin, "the arm reaches it from nowhere round it"
        for base in places_round(np.linalg.inv(here) @ goal):
            found = self.solve_inverse(here @ np.linalg.inv(base) @ np.linalg.inv(here) @ goal)
            if not len(found.solutions):
                continue
            joints = dict(zip(found.joint_names, found.best.tolist(), strict=True))
            x, y, heading = moved(begin, base)
            try:
                if np.array_equal(base, np.eye(4)):
                    way = self.way([], joints=joints)
                else:
                    way = self.way_to(x, y, heading, reverse=reverse, turning_radius=turning_radius, joints=joints)
            except CollisionError as error:
                refused = str(error)
                continue
            if (checked := way.check()).ok:
                return way
            refused = checked.first_violation.message if checked.first_violation else refused
        raise UnreachableError(f"{self.name!r} reaches the pose from no place that it gets to: {refused}")

    def odometry(
        self,
        *,
        counts_per_turn: int | None = None,
        settings: Mapping[str, object] | None = None,
        variance_per_radian: float = 0.0,
        encoders: EncoderReading | None = None,
    ) -> Odometry:
        """Return what reckons the way of a craft from the angles of its drives, from now on.

        Args:
            counts_per_turn: whole counts alone are seen of each drive; None: all of its angle, or what encoders say.
            settings: what its component is thought to have otherwise than it has, such as the radius of a wheel.
            variance_per_radian: variance of what a drive is thought to have turned, for each radian (rad).
            encoders: what its encoders say now, where updates come from these; None: where the joints are.

        Raises:
            WrongStateError: when the robot is no craft.
            InvalidArgumentError: for numbers that make no sense.

        Example:
            >>> odometry = robot.odometry(counts_per_turn=64)
            >>> robot.drive(0.3, seconds=2.0)
            >>> odometry.update().pose
            array([...])
        """
        return Odometry(
            self._services,
            self.name,
            counts_per_turn=counts_per_turn,
            settings=settings,
            variance_per_radian=variance_per_radian,
            encoders=encoders,
        )

    def _solved_way(self, request: robot_pb2.SolveDrivesRequest, joints: JointPositions | None) -> Way:
        """Return a way along which other joints go; raise InvalidArgumentError for those that it moves itself."""
        given, now = self._named(joints), self._joints_now() if joints is not None else {}
        if unknown := [name for name in given if name not in now]:
            raise unknown_name(f"no joint of {self.name!r}", unknown[0], now)
        solved = self._services.robot.SolveDrives(request)
        own = {*solved.joint_names, *(name for name, joint in self.coordinates.items() if name != joint)}
        if taken := [name for name in given if name in own]:
            others = ", ".join(name for name in now if name not in own) or "none"
            raise InvalidArgumentError(
                f"{taken[0]!r} of {self.name!r} is moved by the way itself; joints that may go along: {others}"
            )
        return Way(self._services, self, solved, {name: (now[name], end) for name, end in given.items()})
