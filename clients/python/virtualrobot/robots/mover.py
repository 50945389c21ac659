"""Motions of a robot: moves that are started."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Unpack

from numpy.typing import ArrayLike

from virtualrobot.motions import motion, moves, plans
from virtualrobot.robots.move_maker import JointPositions, MoveMaker
from virtualrobot.robots.redundancy import Lock, Prefer
from virtualrobot.v1 import motion_pb2


class Mover(MoveMaker):
    """The motions of a robot; positions are radians or meters, poses 4x4 arrays.

    Motions block until they have ended unless `wait=False`, and return a `Motion` that can be waited for, paused and
    cancelled. Their common options:

    - `speed_factor`: the part of the joints' greatest speed that is used, above 0, up to 1.
    - `time_law`: `jerk_limited`, the default, or `time_optimal`, which keeps speeds and accelerations and no jerk.
    - `wait`: whether to return only at the end.
    - `preempt`: cancel motions in the way instead of being refused with `RobotBusyError`.
    - `on_disconnect`: what the kernel does when this program vanishes, `stop` or `continue`.
    - `tracking`: what it goes along with, a `virtualrobot.Tracking`.
    - `expected_revision`: refuse to start when the scene's structure has another one (`StaleRevisionError`).

    Moves to poses take wishes for joints that the pose does not need, as `solve_inverse` does:

    - `lock`: joints that stand still, radians or meters by name, or a list of names: where they are now.
    - `prefer`: what free joints are used for: `limits`, `manipulability`, `distance` (to things), or a posture to be
      near, by joint name.
    """

    def start(self, move: motion_pb2.Move, **options: Unpack[motion.StartOptions]) -> motion.Motion:
        """Start one move; see the options of the class."""
        return motion.start(self._services, [self._of_group(move)], **options)

    def move_joints(
        self,
        goal: JointPositions,
        *,
        speed_factor: float = 0.0,
        time_law: str = "",
        **options: Unpack[motion.StartOptions],
    ) -> motion.Motion:
        """Move joints to values by name, or in order (all joints, or those of the chain).

        Example:
            >>> robot.move_joints({"lbr_iiwa_joint_4": -1.57}, speed_factor=0.5)
            >>> agv.move_joints({"base": [2.0, 1.0, math.pi / 2]})                 # x, y and angle of a planar joint
        """
        return self.start(self.ptp(self._named(goal), speed_factor=speed_factor, time_law=time_law), **options)

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
        **options: Unpack[motion.StartOptions],
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
        **options: Unpack[motion.StartOptions],
    ) -> motion.Motion:
        """Move to a posture with a name, such as `home`."""
        return self.start(self.ptp(posture, speed_factor=speed_factor, time_law=time_law), **options)

    def move_actuators(
        self,
        positions: Mapping[str, float],
        *,
        speed_factor: float = 0.0,
        time_law: str = "",
        **options: Unpack[motion.StartOptions],
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
        **options: Unpack[motion.StartOptions],
    ) -> motion.Motion:
        """Move the tool centre point straight to a 4x4 pose.

        `velocity` in m/s and `acceleration` in m/s^2; 0 means 0.25 and 1.

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
        time_law: str = "",
        lock: Lock = (),
        prefer: Prefer = "",
        **options: Unpack[motion.StartOptions],
    ) -> motion.Motion:
        """Move straight to a 4x4 pose, or until a signal is on; `Motion.search` tells where that was.

        `until` is the signal, or the signal and its value; all else is as for `move_linear`. The line brakes smoothly,
        so the robot stands a little beyond the place that it has found.

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
            time_law=time_law,
            lock=lock,
            prefer=prefer,
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
        **options: Unpack[motion.StartOptions],
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
        **options: Unpack[motion.StartOptions],
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
        return plans.plan(self._services, plans.motion_of([move]), sample_seconds=sample_seconds)

    def check(
        self, move: motion_pb2.Move, *, min_singular_value: float = 0.0, collisions: bool = True
    ) -> plans.MotionCheck:
        """Return whether a move keeps all limits and touches nothing, and else what it violates; see `Client.check`.

        Example:
            >>> robot.check(robot.ptp("home")).ok
            True
        """
        wanted = plans.motion_of([move])
        return plans.check(self._services, wanted, min_singular_value=min_singular_value, collisions=collisions)

    def stop(self) -> list[motion.Motion]:
        """Cancel every motion of this robot; return them."""
        response = self._services.motion.Stop(motion_pb2.StopRequest(robots=[self.name]))
        return [motion.Motion(self._services, message) for message in response.motions]
