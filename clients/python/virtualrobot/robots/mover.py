"""Moves and motions of a robot: what it can be told to do, and what is done at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import joint_map, value_or_default
from virtualrobot._wire.options import check_options
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import checked_pose
from virtualrobot.motions import motion, moves, plans
from virtualrobot.motions.motion import Motion, StartOptions
from virtualrobot.motions.moves import (
    CartesianOptions,
    CircularOptions,
    JogOptions,
    LinearOptions,
    Move,
    MoveOptions,
    PointToPointOptions,
    TrajectoryOptions,
)
from virtualrobot.motions.setpoints import TOOL_MODES, SetpointStream, by_name
from virtualrobot.robots import trajectory_file
from virtualrobot.robots.description import coordinate_names
from virtualrobot.robots.mechanism import JointPositions, Mechanism
from virtualrobot.robots.named_goals import check_target, is_target
from virtualrobot.robots.redundancy import redundancy
from virtualrobot.v1 import motion_pb2


class _MoveStart(MoveOptions, StartOptions, total=False): ...


class _PointToPointStart(PointToPointOptions, StartOptions, total=False): ...


class _CartesianStart(CartesianOptions, StartOptions, total=False): ...


class _LinearStart(LinearOptions, StartOptions, total=False): ...


class _CircularStart(CircularOptions, StartOptions, total=False): ...


class _TrajectoryStart(TrajectoryOptions, StartOptions, total=False): ...


class _JogStart(JogOptions, StartOptions, total=False): ...


@checked
class Mover(Mechanism):
    """Motions of a robot; positions are radians or meters, poses 4x4 arrays.

    `ptp`, `linear`, `circular`, `spline`, `trajectory` and the like make moves, for `Client.move_together`, programs,
    `plan` and `check`. `move_linear` and its like start them too: they take the move's options and those of a start
    (`motions.motion.StartOptions`), block until the motion has ended unless `wait=False`, and return a `Motion` that
    can be waited for, paused and cancelled. The options of the moves are told in `virtualrobot.motions.moves`.
    """

    # Moves, which start nothing.

    def ptp(self, goal: JointPositions | str, **options: Unpack[PointToPointOptions]) -> Move:
        """Return a point-to-point move: all joints start and end together, straight in joint space.

        `goal` is joint values by name, joint values in order (all joints, or those of the chain), the name of a
        posture or of a target, or a 4x4 pose of the tool centre point. Of a pose the posture nearest to the present one
        is taken; of a target that was taught with this robot the one nearest to that in which it was.
        """
        if isinstance(goal, str) and is_target(self._services, self.name, goal):
            path = motion_pb2.PointToPoint(pose=moves.target_goal(goal, options), **moves.tcp_rates(options))
            return self._move(options, PointToPointOptions, point_to_point=path)
        if isinstance(goal, Mapping) or (not isinstance(goal, str) and np.shape(goal) != (4, 4)):
            goal = self._named(goal)
        return self._move(options, PointToPointOptions, point_to_point=moves.point_to_point(goal, options))

    def actuated(self, positions: Mapping[str, float], **options: Unpack[MoveOptions]) -> Move:
        """Return a point-to-point move to where actuators, by name and in their own units, have the joints."""
        goal = motion_pb2.ActuatorGoal(actuator_positions=joint_map(positions))
        return self._move(options, MoveOptions, point_to_point=motion_pb2.PointToPoint(actuators=goal))

    def linear(
        self, reference_t_tcp: PoseLike | str, *, until: moves.Until | None = None, **options: Unpack[LinearOptions]
    ) -> Move:
        """Return a straight move of the tool centre point to a 4x4 pose or a target; with `until` a `search`."""
        if isinstance(reference_t_tcp, str):
            check_target(self._services, self.name, reference_t_tcp)
        return self._move(options, LinearOptions, linear=moves.linear(reference_t_tcp, until, options))

    def circular(
        self,
        via: ArrayLike | None = None,
        goal: ArrayLike | None = None,
        *,
        until: moves.Until | None = None,
        **options: Unpack[CircularOptions],
    ) -> Move:
        """Return a move of the tool centre point along an arc to the 4x4 pose `goal`; with `until` a search.

        The arc passes the point `via`, (3,) in m, or turns about the option `center`. `until` is that of `search`, and
        `Motion.search` tells where the signal was on.
        """
        return self._move(options, CircularOptions, circular=moves.circular(via, goal, until, options))

    def spline(
        self,
        goals: Iterable[ArrayLike | str],
        *,
        references: Sequence[str] | None = None,
        **options: Unpack[CartesianOptions],
    ) -> Move:
        """Return a move of the tool centre point along a smooth curve through 4x4 poses or targets, up to 1,000.

        `references` names the node in whose frame each pose is given; without them it is the option `reference`.
        """
        goals = list(goals)
        for name in (goal for goal in goals if isinstance(goal, str)):
            check_target(self._services, self.name, name)
        return self._move(options, CartesianOptions, spline=moves.spline(goals, references, options))

    def trajectory(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        *,
        joints: Sequence[str] | None = None,
        **options: Unpack[TrajectoryOptions],
    ) -> Move:
        """Return a move through `positions` (n, k) at `times` (n,) in seconds from 0; the first row is where it is now.

        `velocities` (n, k) are 0 at both ends; without them the curve is smooth. `joints` names the columns, those
        of a planar or floating joint together; without it they are all joints, or those of the chain. With the option
        `interpolation="segments"` it goes by the given values alone, as a joint_trajectory_controller does.
        """
        columns = np.asarray(positions, dtype=float)
        if columns.ndim != 2:
            raise InvalidArgumentError(f"positions have the shape (times, joints), not {columns.shape}")
        every = self._joints_for(columns.shape[1]) if joints is None else joints
        path = moves.trajectory(coordinate_names(self._description, every), times, columns, velocities, options)
        return self._move(options, TrajectoryOptions, joint_trajectory=path)

    def read_trajectory(self, file: str | Path, text: str | None = None, *, speed_factor: float | None = None) -> Move:
        """Return the `trajectory` that a CSV or JSON file describes; with `text`, its content, `file` only names it.

        Raises MissingFileError, or MalformedFileError with line and column.

        Example:
            >>> sweep = robot.read_trajectory("sweep.csv")
            >>> robot.plan(sweep).duration
        """
        text = trajectory_file.text_of(Path(file)) if text is None else text
        joints = trajectory_file.Joints(self.name, list(self.coordinates), self._joints_for)
        read = trajectory_file.read(text, str(file), joints)
        more: TrajectoryOptions = {"accelerations": read.accelerations, "interpolation": read.interpolation}
        path = moves.trajectory(read.joint_names, read.times, read.positions, read.velocities, more)
        return self._move({"speed_factor": speed_factor}, MoveOptions, joint_trajectory=path)

    def joint_jog(self, joint: str, velocity: float, distance: float | None = None) -> Move:
        """Return a jog of one joint; see `jog_joint`."""
        jog = motion_pb2.JointJog(joint=joint, velocity=velocity, distance=distance)
        return self._move({}, MoveOptions, joint_jog=jog)

    def cartesian_jog(self, translation: ArrayLike | None = None, **options: Unpack[JogOptions]) -> Move:
        """Return a jog of the tool centre point; see `jog`."""
        return self._move(options, JogOptions, cartesian_jog=moves.cartesian_jog(translation, options))

    # Motions.

    def start(self, move: Move, **options: Unpack[StartOptions]) -> Motion:
        """Start one move."""
        return motion.start(self._services, [move], **options)

    def move_joints(self, goal: JointPositions, **options: Unpack[_MoveStart]) -> Motion:
        """Move joints to values by name, or in order (all joints, or those of the chain).

        Example:
            >>> robot.move_joints({"lbr_iiwa_joint_4": -1.57}, speed_factor=0.5)
            >>> agv.move_joints({"base": [2.0, 1.0, math.pi / 2]})                 # x, y and angle of a planar joint
        """
        return self._started(self.ptp, self._named(goal), options=options, kind=_MoveStart)

    def move_pose(self, reference_t_tcp: PoseLike, **options: Unpack[_PointToPointStart]) -> Motion:
        """Move the tool centre point to a 4x4 pose, point to point, with the posture nearest to the present one.

        Example:
            >>> panda.move_pose(goal, lock={"panda_joint7": 0.5})
            >>> iiwa.move_pose(goal, arm_angle=0.3)
        """
        return self._started(self.ptp, checked_pose(reference_t_tcp), options=options, kind=_PointToPointStart)

    def move_to(self, name: str, **options: Unpack[_PointToPointStart]) -> Motion:
        """Move, point to point, to a posture with a name, such as `home`, or to a target.

        Raises:
            UnknownNameError: when neither has this name; it lists both.
            InvalidArgumentError: when both have it, or for an option that a posture has no use for.

        Example:
            >>> arm.move_to("home")
            >>> arm.move_to("pick 1", above=0.1)
        """
        return self._started(self.ptp, name, options=options, kind=_PointToPointStart)

    def move_actuators(self, positions: Mapping[str, float], **options: Unpack[_MoveStart]) -> Motion:
        """Move to where actuators, by name and in their own units, have the joints; see `Robot.actuators`.

        Example:
            >>> palletizer.move_actuators({"motor_2": 30.0, "motor_3": 75.0})
        """
        return self._started(self.actuated, positions, options=options, kind=_MoveStart)

    def move_linear(self, reference_t_tcp: PoseLike | str, **options: Unpack[_LinearStart]) -> Motion:
        """Move the tool centre point straight to a 4x4 pose or a target.

        Example:
            >>> robot.move_linear(robot.tcp @ virtualrobot.pose(z=0.1), velocity=0.1)     # 10 cm along the tool
            >>> robot.move_linear("pick 1")
        """
        return self._started(self.linear, reference_t_tcp, options=options, kind=_LinearStart)

    def search(self, reference_t_tcp: PoseLike | str, until: moves.Until, **options: Unpack[_LinearStart]) -> Motion:
        """Move straight to a 4x4 pose or a target, or until a signal is on; `Motion.search` tells where that was.

        `until` is the signal, signal and value, or signal, comparison and value. The line brakes smoothly, so the robot
        stands a little beyond the place that it has found.

        Example:
            >>> motion = robot.search(robot.tcp @ virtualrobot.pose(z=0.1), "touch", velocity=0.02)
            >>> if motion.search.found:
            ...     surface = motion.search.world_t_tcp
        """
        line = partial(self.linear, reference_t_tcp, until=until)
        return self._started(line, options=options, kind=_LinearStart)

    def move_circular(
        self, via: ArrayLike | None = None, goal: ArrayLike | None = None, **options: Unpack[_CircularStart]
    ) -> Motion:
        """Move the tool centre point along an arc; see `circular`.

        Example:
            >>> robot.move_circular(via=[0.5, 0.1, 0.4], goal=robot.tcp @ virtualrobot.pose(x=0.2))
            >>> robot.move_circular(center=[0.5, 0.0, 0.4], axis=[0, 0, 1], angle=2 * math.pi)     # a whole turn
        """
        return self._started(self.circular, via, goal, options=options, kind=_CircularStart)

    def move_spline(self, goals: Iterable[ArrayLike | str], **options: Unpack[_CartesianStart]) -> Motion:
        """Move the tool centre point along a smooth curve through 4x4 poses or targets; see `spline`.

        Example:
            >>> here = robot.tcp
            >>> robot.move_spline([here @ virtualrobot.pose(x=0.05 * k, y=0.02 * (-1) ** k) for k in range(1, 6)])
        """
        return self._started(self.spline, goals, options=options, kind=_CartesianStart)

    def move_trajectory(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        *,
        joints: Sequence[str] | None = None,
        **options: Unpack[_TrajectoryStart],
    ) -> Motion:
        """Pass joint positions at given times; see `trajectory`.

        Example:
            >>> robot.move_trajectory([1.0, 2.0], [first, second], [through, at_rest], interpolation="segments")
            >>> robot.move_trajectory([0.5], [other], interpolation="segments", replace=True)     # while it moves
        """
        move = partial(self.trajectory, times, positions, velocities, joints=joints)
        return self._started(move, options=options, kind=_TrajectoryStart)

    def jog_joint(
        self, joint: str, velocity: float, distance: float | None = None, **options: Unpack[StartOptions]
    ) -> Motion:
        """Move one joint at a velocity in rad/s or m/s, whose sign says which way, and return at once.

        It goes `distance` radians or meters; without one until the joint's limit, or a whole turn where it has none.

        Example:
            >>> motion = robot.jog_joint("lbr_iiwa_joint_1", -0.2)       # a key is pressed
            >>> motion.cancel()                                          # and released
        """
        return self.start(self.joint_jog(joint, velocity, distance), **{"wait": False, **options})

    def jog(self, translation: ArrayLike | None = None, **options: Unpack[_JogStart]) -> Motion:
        """Move the tool centre point along `translation`, or turn it about the axis `rotation`, and return at once.

        It goes on until its distance or until the robot can go no farther; cancel it when the key is released.

        Example:
            >>> motion = robot.jog([0, 0, 1], frame="tool", velocity=0.05)
            >>> motion.cancel()
            >>> robot.jog(rotation=[0, 0, 1], node="table", distance=0.5, wait=True)
        """
        return self._started(self.cartesian_jog, translation, options={"wait": False, **options}, kind=_JogStart)

    def stream_tool(
        self,
        mode: str = "twist",
        *,
        frame: str | None = None,
        node: str | None = None,
        max_velocity: float | None = None,
        max_rotation_velocity: float | None = None,
        timeout: float = 0.2,
        preempt: bool = False,
    ) -> SetpointStream:
        """Open a stream of twists or poses of the tool centre point, which it follows as this program sends them.

        A twist is (vx, vy, vz, wx, wy, wz), m/s and rad/s; a pose 4x4, or (x, y, z, qx, qy, qz, qw). The tool goes
        straight, and slower where a joint would be too fast, comes to its limit, or a singularity is near.

        Args:
            mode: the quantity of the setpoints, `twist` or `pose`.
            frame: the frame that they are in: `base` (the robot's, the default), `tool` (of twists alone) or `world`.
            node: a node in whose frame they are instead.
            max_velocity: greatest speed in m/s; None: 0.25.
            max_rotation_velocity: greatest angular velocity in rad/s; None: 1.
            timeout: after how many seconds of simulation time without a setpoint the robot stops.
            preempt: cancel motions in the way instead of being refused.

        Raises:
            WrongStateError: when no joint moves the flange.
            UnknownNameError: when there is no such node.
            RobotBusyError: when one of the joints moves already.
            LeasedError: when somebody else has leased the robot.

        Example:
            >>> with robot.stream_tool("twist", frame="tool") as stream:
            ...     stream.send([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
        """
        if mode not in TOOL_MODES:
            raise InvalidArgumentError(f"mode is 'twist' or 'pose', not {mode!r}")
        target = motion_pb2.SetpointTarget(
            robot=self.name,
            mode=TOOL_MODES[mode],
            timeout_seconds=timeout,
            busy_policy=motion_pb2.BUSY_POLICY_PREEMPT if preempt else motion_pb2.BUSY_POLICY_REJECT,
            frame=moves.jog_frame(frame, node),
            node=node,
            group=self._group,
            max_velocity_meters_per_second=value_or_default(max_velocity, "max_velocity"),
            max_rotation_velocity_radians_per_second=value_or_default(max_rotation_velocity, "max_rotation_velocity"),
        )
        return SetpointStream(self._services, target, by_name)

    def stop(self) -> list[Motion]:
        """Cancel every motion of this robot; return them."""
        return motion.stop(self._services, [self.name])

    # Before moving; nothing moves.

    def plan(self, move: Move, **options: Unpack[plans.PlanOptions]) -> plans.MotionPlan:
        """Return what a move would do, in samples; see `Client.plan`.

        Example:
            >>> plan = robot.plan(robot.linear(goal))
            >>> np.abs(plan.robots[robot.name].efforts).max(axis=0)
            array([...])
        """
        return plans.plan(self._services, plans.motion_of([move]), **options)

    def check(self, move: Move, **options: Unpack[plans.CheckOptions]) -> plans.MotionCheck:
        """Return whether a move keeps all limits and touches nothing, and else what it violates; see `Client.check`.

        Example:
            >>> robot.check(robot.ptp("home")).ok
            True
        """
        return plans.check(self._services, plans.motion_of([move]), **options)

    def _started(self, make: Callable[..., Move], *goal: object, options: Mapping[str, Any], kind: type) -> Motion:
        """Start what `make` makes of a goal and those options that are not of the start."""
        check_options(options, kind, "this motion")
        going = {name: value for name, value in options.items() if name in StartOptions.__optional_keys__}
        return self.start(make(*goal, **{name: options[name] for name in options.keys() - going}), **going)

    def _move(self, options: Mapping[str, Any], kind: type, **how: Any) -> Move:  # noqa: ANN401 the kind of the move
        """Return a move of this robot or group, with the options that all kinds of moves have."""
        check_options(options, kind, "this move")
        lock, prefer = options.get("lock") or (), options.get("prefer")
        message = motion_pb2.Move(
            robot=self.name,
            group=self._group,
            speed_factor=value_or_default(options.get("speed_factor"), "speed_factor"),
            time_law=moves.time_law_number(options.get("time_law")),
            acceleration_factor=value_or_default(options.get("acceleration_factor"), "acceleration_factor"),
            jerk_factor=value_or_default(options.get("jerk_factor"), "jerk_factor"),
            fixed_tool=options.get("fixed_tool"),
            redundancy=redundancy(lock, options.get("arm_angle"), prefer, joints_now=self._joints_now),
            **how,
        )
        return Move(message)
