"""Actions of robots: trajectories at given times, and grippers by their width; all in simulation time."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.state import MotionState, Phase
from virtualrobot.robots.robot import Robot

from virtualrobot_apps.bridges.ros.hub import ABORTED, CANCELED, SUCCEEDED, Feedback, HubError, Refused
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, header, nanoseconds_of, time_of
from virtualrobot_apps.bridges.ros.mapping.trajectories import (
    INVALID_GOAL,
    BadGoalError,
    Rows,
    error_code,
    rows_of,
    tolerances_of,
    words_of,
)
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.messages.values import default

FOLLOW = "control_msgs/action/FollowJointTrajectory"
GRIP, GRIP_PARALLEL = "control_msgs/action/GripperCommand", "control_msgs/action/ParallelGripperCommand"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"

LOOK_SECONDS = 0.05
"""Time (s of the wall clock) after which a goal's motion is looked at again, and told of."""

_REACHED_METERS = 1e-3


def _started(robot: Robot, rows: Rows, **tolerances: Any) -> Motion:  # noqa: ANN401 options of move_trajectory
    """Start a trajectory, which takes over from one that runs; each segment is as ros2_control's controller has it."""
    return robot.move_trajectory(
        rows.times,
        rows.positions,
        rows.velocities,
        joints=rows.joints,
        accelerations=rows.accelerations,
        interpolation="segments",
        start_time=rows.start,
        replace=True,
        wait=False,
        **tolerances,
    )


def _now(client: Client) -> int:
    stamp = client.clock.read().stamp
    return round(stamp.simulation_time * 1e9)


async def follow_trajectory(
    client: Client, name: str, goal: RosValue, feedback: Feedback, cancel: asyncio.Event
) -> tuple[int, RosValue]:
    """Run a goal of FollowJointTrajectory; another goal takes over from it without stopping."""
    robot = await asyncio.to_thread(client.robot, name)

    def start() -> Motion:
        rows = rows_of(goal.trajectory, robot.joint_names, _now(client))
        if goal.multi_dof_trajectory.joint_names or goal.multi_dof_trajectory.points:
            raise BadGoalError(INVALID_GOAL, "joints of several degrees of freedom are not followed")
        return _started(
            robot,
            rows,
            path_tolerances=tolerances_of(goal.path_tolerance, rows.joints) or None,
            goal_tolerances=tolerances_of(goal.goal_tolerance, rows.joints) or None,
            goal_time_tolerance=nanoseconds_of(goal.goal_time_tolerance) / 1e9 or None,
        )

    def refused(code: int, words: str) -> tuple[int, RosValue]:
        return ABORTED, make(f"{FOLLOW}_Result", error_code=code, error_string=words)

    try:
        motion = await asyncio.to_thread(start)
    except BadGoalError as error:
        return refused(error.code, str(error))
    except VirtualRobotError as error:
        return refused(INVALID_GOAL, str(error))
    joints = list(goal.trajectory.joint_names)

    def told(state: MotionState) -> RosValue:
        return _follow_feedback(robot, joints, state.start_time)

    state = await _ended(motion, told, feedback, cancel)
    status = _status(state, cancel)
    return status, make(f"{FOLLOW}_Result", error_code=error_code(state), error_string=words_of(state))


def _follow_feedback(robot: Robot, joints: list[str], start: float) -> RosValue:
    """Return where joints shall be and are, and by how much these differ."""
    state, names = robot.state, robot.joint_names
    places = [names.index(one) for one in joints]
    time = round(state.stamp.simulation_time * 1e9)

    def point(positions: np.ndarray, velocities: np.ndarray) -> RosValue:
        since = make("builtin_interfaces/msg/Duration", **vars_of(time_of(max(0, time - round(start * 1e9)))))
        return make(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            positions=positions[places],
            velocities=velocities[places],
            accelerations=np.empty(0),
            effort=np.empty(0),
            time_from_start=since,
        )

    many = default("trajectory_msgs/msg/MultiDOFJointTrajectoryPoint")
    return make(
        f"{FOLLOW}_Feedback",
        header=header(time, ""),
        joint_names=joints,
        desired=point(state.commanded_positions, state.commanded_velocities),
        actual=point(state.positions, state.velocities),
        error=point(
            state.commanded_positions - state.positions,
            state.commanded_velocities - state.velocities,
        ),
        multi_dof_joint_names=[],
        multi_dof_desired=many,
        multi_dof_actual=many,
        multi_dof_error=many,
    )


def vars_of(time: RosValue) -> dict[str, int]:
    """Return the seconds and nanoseconds of a time by name."""
    return {"sec": time.sec, "nanosec": time.nanosec}


async def grip(
    client: Client, robot: str, tool: str, goal: RosValue, feedback: Feedback, cancel: asyncio.Event
) -> tuple[int, RosValue]:
    """Run a goal of GripperCommand: `position` is how wide the tool shall be open (m); forces are not told."""

    def result(part: str, width: float, reached: bool) -> RosValue:
        return make(f"{GRIP}_{part}", position=width, effort=0.0, stalled=False, reached_goal=reached)

    return await _gripped(client, robot, tool, goal.command.position, result, feedback, cancel)


async def grip_parallel(
    client: Client, robot: str, tool: str, goal: RosValue, feedback: Feedback, cancel: asyncio.Event
) -> tuple[int, RosValue]:
    """Run a goal of ParallelGripperCommand: the one position is how wide the tool shall be open (m)."""

    def result(part: str, width: float, reached: bool) -> RosValue:
        state = make(
            "sensor_msgs/msg/JointState",
            **{"header": header(_now(client), ""), "name": [tool], "position": np.array([width])},
            **{"velocity": np.empty(0), "effort": np.empty(0)},
        )
        ended = {"stalled": False, "reached_goal": reached} if part == "Result" else {}
        return make(f"{GRIP_PARALLEL}_{part}", state=state, **ended)

    if len(goal.command.position) != 1:
        raise HubError("'command' has one position: how wide the gripper shall be open, in meters")
    return await _gripped(client, robot, tool, float(goal.command.position[0]), result, feedback, cancel)


async def _gripped(
    client: Client,
    robot: str,
    tool: str,
    width: float,
    result: Callable[[str, float, bool], RosValue],
    feedback: Feedback,
    cancel: asyncio.Event,
) -> tuple[int, RosValue]:
    """Open a tool to a width (m); `result` makes Feedback and Result of the width that it has, and whether it is it."""
    found = await asyncio.to_thread(lambda: client.robot(robot).tool(tool))
    if not np.isfinite(width):
        raise HubError("'position' is how wide the gripper shall be open, in meters")

    def told(part: str, state: MotionState) -> RosValue:
        is_width = found.width
        return result(part, is_width, state.phase is Phase.SUCCEEDED and abs(is_width - width) < _REACHED_METERS)

    motion = await asyncio.to_thread(lambda: found.move_to_width(width, wait=False))
    state = await _ended(motion, partial(told, "Feedback"), feedback, cancel)
    return _status(state, cancel), await asyncio.to_thread(told, "Result", state)


async def _ended(
    motion: Motion, told: Callable[[MotionState], RosValue], feedback: Feedback, cancel: asyncio.Event
) -> MotionState:
    """Wait for the end of a motion, which `cancel` brings about; `told` makes feedback meanwhile, in a thread."""
    asked = False
    while True:
        state = await asyncio.to_thread(lambda: motion.state)
        if state.phase.ended:
            return state
        if cancel.is_set() and not asked:
            asked = True
            await asyncio.to_thread(motion.cancel, "the client has cancelled the goal")
        feedback(await asyncio.to_thread(told, state))
        await asyncio.sleep(LOOK_SECONDS)


def _status(state: MotionState, cancel: asyncio.Event) -> int:
    if state.phase is Phase.SUCCEEDED:
        return SUCCEEDED
    return CANCELED if cancel.is_set() and state.phase is Phase.CANCELLED else ABORTED


class TrajectoryTopic:
    """Trajectories that a robot hears on a topic: each takes over from the one before; the newest counts."""

    def __init__(self, client: Client, robot: str, say: Callable[[str], None]) -> None:
        """Hear of none yet."""
        self._client, self._robot, self._say = client, robot, say
        self._changed = threading.Condition()
        self._newest: tuple[RosValue, Refused] | None = None
        self._thread: threading.Thread | None = None

    def take(self, value: RosValue, refused: Refused) -> None:
        """Take a `trajectory_msgs/JointTrajectory`; returns at once. What can't be run is said, also to `refused`."""
        with self._changed:
            self._newest = value, refused
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name=f"trajectories of {self._robot}", daemon=True)
                self._thread.start()

    def _run(self) -> None:
        while True:
            with self._changed:
                newest, self._newest = self._newest, None
                if newest is None:
                    self._thread = None
                    return
            value, refused = newest
            try:
                robot = self._client.robot(self._robot)
                _started(robot, rows_of(value, robot.joint_names, _now(self._client)))
            except (BadGoalError, VirtualRobotError) as error:
                self._say(f"a trajectory for {self._robot} is not taken: {error}")
                refused(str(error))
