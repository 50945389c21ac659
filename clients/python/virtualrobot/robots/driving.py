"""Driving: crafts, whose base is moved by their drives, by twists and on planned ways."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Unpack

import numpy as np

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import array_message, array_of
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot.motions.motion import Motion, StartOptions
from virtualrobot.motions.program import Program
from virtualrobot.motions.setpoints import SetpointStream, StreamState
from virtualrobot.robots.mover import Mover
from virtualrobot.v1 import motion_pb2, robot_pb2


@checked
class Driving(Mover):
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
        return SetpointStream(self._services, target, _named)

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
            MotionAbortedError: when the kernel had to end it, such as before a collision.

        And what `stream_twist` raises.

        Example:
            >>> robot.drive(0.3, 0.5, seconds=2.0)
        """
        if not seconds > 0.0:
            raise InvalidArgumentError(f"seconds is above 0, not {seconds:g}")
        with self.stream_twist(timeout=timeout, preempt=preempt) as stream:
            begin = stream.state.time
            stream.send([forward, left, turn])
            for state in stream:
                if state.time - begin >= seconds:
                    break
                stream.send([forward, left, turn])
        return stream.state

    def drive_path(self, parts: ArrayLike, **options: Unpack[StartOptions]) -> Motion:
        """Drive a craft along lines and arcs, one after the other, as a planned motion; it stands between them.

        Args:
            parts: shape (n, 3): how far each goes forward and to the left along the axes of the base (m), and turns to
                the left meanwhile (rad). What steers is turned while the craft stands.
            options: of the start, as of any motion.

        Raises:
            InvalidArgumentError: for a part that the craft never goes, such as a turn on the spot of a car.
            WrongStateError: when the robot is no craft.

        And what a start of a motion raises.

        Example:
            >>> robot.drive_path([[1.0, 0.0, 0.0], [0.0, 0.0, np.pi / 2]])
        """
        way = self._way(np.array(parts, dtype=float))
        return self._driven(way, **options)

    def drive_to(self, x: float, y: float, heading: float | None = None, **options: Unpack[StartOptions]) -> Motion:
        """Drive a craft that turns on the spot to a place: turn, go straight, and turn again.

        Args:
            x: where to, in the frame of the robot (m).
            y: where to.
            heading: how far it is turned to the left in the end (rad); None leaves it as it comes.
            options: of the start, as of any motion.

        Raises what `drive_path` does.

        Example:
            >>> robot.drive_to(1.0, 0.5, heading=0.0)
        """
        here = self._way(np.zeros((0, 3)))
        across, up = x - here.x_meters, y - here.y_meters
        distance = float(np.hypot(across, up))
        bearing = float(np.arctan2(up, across)) if distance > 0.0 else here.heading_radians
        first = float(np.remainder(bearing - here.heading_radians + np.pi, 2.0 * np.pi) - np.pi)
        last = 0.0 if heading is None else float(np.remainder(heading - bearing + np.pi, 2.0 * np.pi) - np.pi)
        return self.drive_path([[0.0, 0.0, first], [distance, 0.0, 0.0], [0.0, 0.0, last]], **options)

    def _way(self, parts: Matrix) -> robot_pb2.SolveDrivesResponse:
        request = robot_pb2.SolveDrivesRequest(robot=self.name, parts=array_message(parts))
        return self._services.robot.SolveDrives(request)

    def _driven(self, way: robot_pb2.SolveDrivesResponse, **options: Unpack[StartOptions]) -> Motion:
        """Start the moves of drives from row to row of a way."""
        program, before = Program(self._services), None
        for row in array_of(way.positions):
            if before is None or np.abs(row - before).max() > 0.0:
                program.move(self.ptp(dict(zip(way.joint_names, row.tolist(), strict=True))))
            before = row
        return program.start(**options)


def _named(setpoint: Mapping[str, float | ArrayLike]) -> Mapping[str, float]:
    """Return a twist by name: `vx`, `vy`, `omega`."""
    return {name: float(np.asarray(value)) for name, value in setpoint.items()}
