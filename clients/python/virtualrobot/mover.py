"""What robots can be told to do: moves as data, and motions that run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot import motion, moves, plans
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.redundancy import Lock, Prefer, redundancy
from virtualrobot.services import Services
from virtualrobot.v1 import motion_pb2, robot_pb2
from virtualrobot.wire import joint_map

JointPositions: TypeAlias = Mapping[str, float] | ArrayLike


class Mover:
    """The motions of a robot; positions are radians or meters, poses 4x4 arrays.

    Motions block until they have ended unless `wait=False`, and return a `Motion` that can be waited for, paused and
    cancelled. Their common options:

    - `speed_factor`: the part of the joints' greatest speed that is used, above 0, up to 1.
    - `time_law`: `jerk_limited`, the default, or `time_optimal`, which keeps speeds and accelerations and no jerk.
    - `wait`: whether to return only at the end.
    - `preempt`: cancel motions in the way instead of being refused with `RobotBusyError`.
    - `on_disconnect`: what the kernel does when this program vanishes, `stop` or `continue`.
    - `tracking`: what it goes along with, a `virtualrobot.Tracking`.

    Moves to poses take wishes for joints that the pose does not need, as `solve_inverse` does:

    - `lock`: joints that stand still, radians or meters by name, or a list of names: where they are now.
    - `prefer`: what free joints are used for: `limits`, `manipulability`, or a posture to be near, by joint name.
    """

    def __init__(self, services: Services, name: str) -> None:
        """Handle the robot of this name; `Client.robot` checks that there is one."""
        self._services = services
        self.name = name

    @property
    def description(self) -> robot_pb2.GetRobotResponse:
        """Joints, links, tools and postures as the contract describes them."""
        return self._services.robot.GetRobot(robot_pb2.GetRobotRequest(name=self.name))

    # Moves: data that is not started yet, for Client.move_together.

    def ptp(
        self,
        goal: JointPositions | str,
        *,
        reference: str = "",
        configuration: str = "",
        speed_factor: float = 0.0,
        time_law: str = "",
        moving: bool = False,
        lock: Lock = (),
        arm_angle: float | None = None,
        prefer: Prefer = "",
    ) -> motion_pb2.Move:
        """Return a point-to-point move: all joints start and end together, straight in joint space.

        `goal` is joint values by name, joint values in order (all joints, or those of the chain), a 4x4 pose
        `reference_t_tcp` in the frame of the node `reference` (empty: world), or the name of a posture.
        `configuration` names the only configuration that will do for a pose, such as `right up noflip`, and
        `arm_angle` says where the elbow shall be, in radians. With `moving` the pose goes along when another move of
        the same step moves the reference.
        """
        if not isinstance(goal, str | Mapping) and np.shape(goal) != (4, 4):
            goal = self._named(goal)
        move = moves.point_to_point(
            self.name,
            goal,
            reference=reference,
            configuration=configuration,
            speed_factor=speed_factor,
            time_law=time_law,
            moving=moving,
        )
        return self._wished(move, lock, prefer, arm_angle)

    def linear(
        self,
        reference_t_tcp: ArrayLike,
        *,
        reference: str = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        time_law: str = "",
        moving: bool = False,
        lock: Lock = (),
        prefer: Prefer = "",
        until: moves.Until | None = None,
    ) -> motion_pb2.Move:
        """Return a straight move of the tool centre point to a 4x4 pose; 0 means 0.25 m/s and 1 m/s^2.

        With `moving` the line is one in the frame of `reference` while another move of the same step moves that. With
        `until` it is a search; see `search`.
        """
        rates = velocity, acceleration, speed_factor
        move = moves.linear(self.name, reference_t_tcp, reference, *rates, time_law, moving, until)
        return self._wished(move, lock, prefer)

    def circular(
        self,
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
        lock: Lock = (),
        prefer: Prefer = "",
    ) -> motion_pb2.Move:
        """Return a move of the tool centre point along an arc of a circle to the 4x4 pose `goal`.

        The arc passes the point `via`, or turns about the point `center` (3 numbers each, in m). Keywords:

        - `center`, `axis`, `angle`: instead of `via`. Without `axis` it goes the shorter way; with it, by the right
          hand, `angle` radians or, without an angle, until the goal. With an angle, up to ten turns, the goal may be
          left out; then the tool keeps its orientation.
        - `turn_with_arc`: the tool turns as the arc does, not evenly from its orientation to the goal's.
        - `reference`: the node in whose frame all this is given (empty: world).
        - `velocity`, `acceleration`, `speed_factor`, `moving`: as for `linear`.
        """
        move = moves.circular(
            self.name,
            via,
            goal,
            center=center,
            axis=axis,
            angle=angle,
            turn_with_arc=turn_with_arc,
            reference=reference,
            velocity=velocity,
            acceleration=acceleration,
            speed_factor=speed_factor,
            time_law=time_law,
            moving=moving,
        )
        return self._wished(move, lock, prefer)

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

    def move_joints(
        self,
        goal: JointPositions,
        *,
        speed_factor: float = 0.0,
        time_law: str = "",
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move joints to values by name, or in order (all joints, or those of the chain).

        Example:
            >>> robot.move_joints({"lbr_iiwa_joint_4": -1.57}, speed_factor=0.5)
        """
        named = goal if isinstance(goal, Mapping) else self._named(goal)
        return self.start(self.ptp(named, speed_factor=speed_factor, time_law=time_law), **options)

    def move_pose(
        self,
        reference_t_tcp: ArrayLike,
        *,
        reference: str = "",
        configuration: str = "",
        speed_factor: float = 0.0,
        time_law: str = "",
        lock: Lock = (),
        arm_angle: float | None = None,
        prefer: Prefer = "",
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move the tool centre point to a 4x4 pose, point to point, with the posture nearest to the present one.

        With `configuration` it is the nearest of that name; see `InverseSolution.configurations`. `arm_angle` says
        where the elbow shall be about the line from shoulder to wrist, in radians, for arms such as the iiwa.

        Example:
            >>> panda.move_pose(goal, lock={"panda_joint7": 0.5})
            >>> iiwa.move_pose(goal, arm_angle=0.3)
        """
        move = moves.point_to_point(
            self.name,
            reference_t_tcp,
            reference=reference,
            configuration=configuration,
            speed_factor=speed_factor,
            time_law=time_law,
        )
        return self.start(self._wished(move, lock, prefer, arm_angle), **options)

    def move_to(
        self,
        posture: str,
        *,
        speed_factor: float = 0.0,
        time_law: str = "",
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move to a posture with a name, such as `home`."""
        return self.start(self.ptp(posture, speed_factor=speed_factor, time_law=time_law), **options)

    def move_actuators(
        self,
        positions: Mapping[str, float],
        *,
        speed_factor: float = 0.0,
        time_law: str = "",
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move to where actuators, by name and in their own units, have the joints; see `Robot.actuators`.

        Example:
            >>> palletizer.move_actuators({"motor_2": 30.0, "motor_3": 75.0})
        """
        return self.start(moves.actuated(self.name, positions, speed_factor=speed_factor, time_law=time_law), **options)

    def move_linear(
        self,
        reference_t_tcp: ArrayLike,
        *,
        reference: str = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        time_law: str = "",
        lock: Lock = (),
        prefer: Prefer = "",
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
                time_law=time_law,
                lock=lock,
                prefer=prefer,
            ),
            **options,
        )

    def search(
        self,
        reference_t_tcp: ArrayLike,
        until: moves.Until,
        *,
        reference: str = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move straight to a 4x4 pose, or until a signal is on; `Motion.search` tells where that was.

        `until` is the signal, or the signal and its value. The line brakes smoothly, so the robot stands a little
        beyond the place that it has found.

        Example:
            >>> motion = robot.search(robot.tcp @ virtualrobot.pose(z=0.1), "touch", velocity=0.02)
            >>> if motion.search.found:
            ...     surface = motion.search.world_t_tcp
        """
        line = self.linear(
            reference_t_tcp,
            reference=reference,
            velocity=velocity,
            acceleration=acceleration,
            speed_factor=speed_factor,
            until=until,
        )
        return self.start(line, **options)

    def move_circular(
        self,
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
        lock: Lock = (),
        prefer: Prefer = "",
        **options: Any,  # noqa: ANN401
    ) -> motion.Motion:
        """Move the tool centre point along an arc; see `circular`.

        Example:
            >>> robot.move_circular(via=[0.5, 0.1, 0.4], goal=robot.tcp @ virtualrobot.pose(x=0.2))
            >>> robot.move_circular(center=[0.5, 0.0, 0.4], axis=[0, 0, 1], angle=2 * math.pi)     # a whole turn
        """
        return self.start(
            self.circular(
                via,
                goal,
                center=center,
                axis=axis,
                angle=angle,
                turn_with_arc=turn_with_arc,
                reference=reference,
                velocity=velocity,
                acceleration=acceleration,
                speed_factor=speed_factor,
                time_law=time_law,
                lock=lock,
                prefer=prefer,
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

    # Before moving; nothing moves.

    def plan(self, move: motion_pb2.Move, *, sample_seconds: float = 0.0) -> plans.MotionPlan:
        """Return what a move would do, in samples `sample_seconds` apart; see `Client.plan`.

        Example:
            >>> plan = robot.plan(robot.linear(goal))
            >>> np.abs(plan.robots[robot.name].efforts).max(axis=0)
            array([...])
        """
        return plans.plan(self._services, [move], sample_seconds=sample_seconds)

    def check(self, move: motion_pb2.Move, *, min_singular_value: float = 0.0) -> plans.MotionCheck:
        """Return whether a move keeps all limits, and else the first one that it violates; see `Client.check`.

        Example:
            >>> robot.check(robot.ptp("home")).ok
            True
        """
        return plans.check(self._services, [move], min_singular_value=min_singular_value)

    def stop(self) -> list[motion.Motion]:
        """Cancel every motion of this robot; return them."""
        response = self._services.motion.Stop(motion_pb2.StopRequest(robots=[self.name]))
        return [motion.Motion(self._services, message) for message in response.motions]

    def _wished(
        self, move: motion_pb2.Move, lock: Lock, prefer: Prefer, arm_angle: float | None = None
    ) -> motion_pb2.Move:
        """Return a move with what is wished of joints that its goal does not need."""
        wish = redundancy(lock, arm_angle, prefer, joints_now=self._joints_now)
        if wish is not None:
            move.redundancy.CopyFrom(wish)
        return move

    def _joints_now(self) -> dict[str, float]:
        """Return where the joints with one coordinate are, by name."""
        request = robot_pb2.GetRobotStatesRequest(names=[self.name])
        now = list(self._services.robot.GetRobotStates(request).robots[0].positions)
        here: dict[str, float] = {}
        for joint in self.description.joints:
            values, now = now[: joint.coordinate_count], now[joint.coordinate_count :]
            if len(values) == 1:
                here[joint.name] = values[0]
        return here

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
