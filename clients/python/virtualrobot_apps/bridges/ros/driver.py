"""The driver `ros_trajectory`: a robot that is known by ROS alone, over rosbridge.

Its joints are read from a topic of `sensor_msgs/JointState`, and it goes to points by goals of
`control_msgs/FollowJointTrajectory`, as ros2_control's joint_trajectory_controller and most arms' drivers take them.
Nothing of ROS is needed here: rosbridge_server runs beside the robot, or `virtualrobot ros` stands in for both.

Source of the protocol: ROSBRIDGE_PROTOCOL.md of rosbridge_suite (branch ros2), 3.4 and 3.6.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Mode, Pace, Reading
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats

api_version = "1.0"

JOINT_STATE = "sensor_msgs/msg/JointState"
FOLLOW = "control_msgs/action/FollowJointTrajectory"
SUCCEEDED, CANCELED = 4, 5
"""States of a goal that is over; source: action_msgs/GoalStatus."""

ERRORS = {
    -1: "INVALID_GOAL",
    -2: "INVALID_JOINTS",
    -3: "OLD_HEADER_TIMESTAMP",
    -4: "PATH_TOLERANCE_VIOLATED",
    -5: "GOAL_TOLERANCE_VIOLATED",
}
"""Errors of a goal; source: control_msgs/FollowJointTrajectory."""

PEAK = 1.875
"""Greatest speed of a quintic between two rests, as a multiple of its mean: 15/8."""

_OPEN_SECONDS, _FIRST_SECONDS = 4.0, 4.0
_LEAST_SECONDS = 0.05
_CANCEL_SECONDS = 0.1
"""Time (s) after which a goal that has not ended is canceled again: one that was just sent may not be known yet."""

_MOST_BYTES = 1 << 20
_NANO = 1_000_000_000

Name = Annotated[str, Meta(pattern=r"^/[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*$", max_length=255)]


@dataclass(frozen=True, slots=True)
class RosTrajectorySettings:
    """Settings of a robot that ROS moves."""

    url: Annotated[str, Meta(pattern=r"^wss?://.+", description="Address of rosbridge_server: ws://HOST:9090.")] = (
        "ws://127.0.0.1:9090"
    )
    joint_states: Annotated[Name, Meta(description="Topic that tells the joints (sensor_msgs/JointState).")] = (
        "/joint_states"
    )
    action: Annotated[Name, Meta(description="Action that moves them (control_msgs/FollowJointTrajectory).")] = (
        "/joint_trajectory_controller/follow_joint_trajectory"
    )
    joints: Annotated[
        tuple[str, ...],
        Meta(description="Names of the joints in ROS, in the order in which they count; none: as the topic has them."),
    ] = ()
    speed: Annotated[
        float, Meta(gt=0, le=100, description="Speed (rad/s, m/s) of a joint where it is told to go as fast as it can.")
    ] = 1.0
    rate: Annotated[float, Meta(ge=1, le=500, description="Readings a second.")] = 50.0
    silence: Annotated[
        float, Meta(ge=0.1, le=60, description="Time (s) without joints after which the connection is lost.")
    ] = 1.0
    token: Annotated[str, Meta(description="Token that the server asks for, as a bearer's; empty: none.")] = ""


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Offer the driver; the bridge to ROS has it, so that no plugin needs to know of ROS."""
    register("ros_trajectory", RosTrajectory, RosTrajectorySettings)


class RosTrajectory(Driver):
    """The connection to one robot of ROS."""

    def __init__(self, settings: RosTrajectorySettings) -> None:
        """Take the settings; nothing is connected yet."""
        self._settings = settings
        self._socket: Any = None
        self._changed = threading.Condition()
        self._names: tuple[str, ...] = settings.joints
        self._newest: Reading | None = None
        self._came = 0.0
        self._lost = self._said = ""
        self._over: dict[str, tuple[int, dict[str, Any]]] = {}
        self._waiting: deque[tuple[Floats, float]] = deque()
        self._goal = self._canceled = ""
        self._canceled_at = 0.0
        self._target = np.empty(0)
        self._follows = False
        self._done = 0
        self._ids = itertools.count(1)

    def connect(self) -> About:
        """Open the connection, and wait for the joints."""
        from websockets.exceptions import WebSocketException
        from websockets.sync.client import connect

        self.close()
        settings = self._settings
        self._names, self._newest, self._lost, self._said = settings.joints, None, "", ""
        self._forget()
        self._canceled = ""
        headers = {"Authorization": f"Bearer {settings.token}"} if settings.token else None
        try:
            self._socket = connect(
                settings.url,
                additional_headers=headers,
                open_timeout=_OPEN_SECONDS,
                close_timeout=1.0,
                max_size=_MOST_BYTES,
            )
        except (OSError, TimeoutError, WebSocketException, ValueError) as error:
            raise DriverFault(f"nobody speaks rosbridge at {settings.url}: {error}") from error
        threading.Thread(target=self._hear, args=(self._socket,), name="rosbridge", daemon=True).start()
        self._say(
            op="subscribe",
            topic=settings.joint_states,
            type=JOINT_STATE,
            queue_length=1,
            throttle_rate=round(1000.0 / settings.rate),
        )
        with self._changed:
            self._changed.wait_for(lambda: self._newest is not None or self._lost, _FIRST_SECONDS)
            first = self._newest
        if first is None:
            wanted = f" with the joints {', '.join(settings.joints)}" if settings.joints else ""
            raise DriverFault(self._lost or f"nothing comes on {settings.joint_states}{wanted}; {self._words()}")
        return About(joints=len(self._names), rate=settings.rate, pace=Pace.JOBS, silence=settings.silence, model="ROS")

    def read(self) -> Reading:
        """Return the newest joints; when the robot has reached a point, have it go to the next."""
        with self._changed:
            lost, newest, over = self._lost, self._newest, self._over.pop(self._goal, None) if self._goal else None
        if lost or newest is None:
            raise DriverFault(lost or f"{self._settings.url} isn't connected")
        if (quiet := time.monotonic() - self._came) > self._settings.silence:
            raise DriverFault(f"{self._settings.joint_states} has been silent for {quiet:.2g} s")
        self._cancel_again()
        if over is not None:
            self._end_goal(*over)
        if self._follows and not self._goal and self._waiting:
            self._go(*self._waiting.popleft())
        mode = Mode.RUNNING if self._follows else Mode.READY
        return Reading(newest.stamp, newest.positions, newest.velocities, mode=mode, done=self._done)

    def begin(self, held: Floats) -> None:
        """Follow from where it stands."""
        self._forget()
        self._target, self._follows = np.array(held, float), True

    def run(self, points: Sequence[Floats], speeds: Sequence[float], outputs: int) -> None:
        """Keep the points; each is a goal of its own, sent once the one before is reached."""
        if self._follows:
            self._waiting.extend((np.array(point, float), speed) for point, speed in zip(points, speeds, strict=True))

    def stop(self) -> None:
        """Cancel the goal that runs, and forget the points."""
        goal = self._goal
        self._forget()
        if goal and self._socket is not None:
            self._canceled, self._canceled_at = goal, 0.0
            with contextlib.suppress(DriverFault):  # it is told as it is read
                self._cancel_again()

    def close(self) -> None:
        """Close the connection."""
        with self._changed:
            opened, self._socket, self._newest = self._socket, None, None
        if opened is not None:
            opened.close()

    def _forget(self) -> None:
        self._waiting.clear()
        self._goal, self._follows, self._done = "", False, 0
        with self._changed:
            self._over.clear()

    def _cancel_again(self) -> None:
        """Cancel the goal that a stop left, until it has ended."""
        now = time.monotonic()
        with self._changed:
            ended = self._over.pop(self._canceled, None) is not None
        if ended:
            self._canceled = ""
        elif self._canceled and now - self._canceled_at > _CANCEL_SECONDS:
            self._canceled_at = now
            self._say(op="cancel_action_goal", id=self._canceled, action=self._settings.action)

    def _go(self, point: Floats, share: float) -> None:
        """Send a goal: from rest to rest in the time that the longest way of a joint takes at its speed."""
        way = float(np.abs(point - self._target).max(initial=0.0))
        seconds = max(PEAK * way / (self._settings.speed * share), _LEAST_SECONDS)
        whole, nanos = divmod(math.ceil(seconds * _NANO), _NANO)
        rest = [0.0] * len(point)
        reached = {
            "positions": point.tolist(),
            "velocities": rest,
            "accelerations": rest,
            "time_from_start": {"sec": whole, "nanosec": nanos},
        }
        self._goal, self._target = f"virtualrobot-{next(self._ids)}", point
        trajectory = {"joint_names": list(self._names), "points": [reached]}
        self._say(
            op="send_action_goal",
            id=self._goal,
            action=self._settings.action,
            action_type=FOLLOW,
            args={"trajectory": trajectory},
            feedback=False,
        )

    def _end_goal(self, status: int, told: dict[str, Any]) -> None:
        """Take the end of the goal that ran; raise what it ended by, unless it was reached."""
        self._goal = ""
        code = told.get("error_code", 0)
        if status == SUCCEEDED and not code:
            self._done += 1
            return
        self._forget()
        words = str(told.get("error_string") or self._said or ERRORS.get(code, "the goal was not reached"))
        ended = "was canceled by somebody else" if status == CANCELED else f"ended with status {status}"
        raise DriverFault(f"{words} ({self._settings.action} {ended})", str(code) if code else "", clears=True)

    def _say(self, **op: object) -> None:
        from websockets.exceptions import WebSocketException

        try:
            self._socket.send(json.dumps(op))
        except (OSError, WebSocketException) as error:
            raise DriverFault(f"the connection to {self._settings.url} is lost: {error}") from error

    def _words(self) -> str:
        return f"the server says: {self._said}" if self._said else "the server says nothing"

    def _hear(self, opened: Any) -> None:  # noqa: ANN401 a connection of websockets, which is loaded by `connect`
        """Take what the server sends, until the connection ends."""
        from websockets.exceptions import WebSocketException

        words = f"the connection to {self._settings.url} has ended"
        try:
            for text in opened:
                try:
                    self._take(json.loads(text))
                except (ValueError, TypeError, KeyError, AttributeError) as error:
                    words = f"{self._settings.url} sends what is no message of rosbridge: {error!r}"
                    opened.close()
                    break
        except (OSError, WebSocketException) as error:
            words = f"the connection to {self._settings.url} is lost: {error}"
        with self._changed:
            if self._socket is opened:  # neither closed here nor opened anew since
                self._lost = words
                self._changed.notify_all()

    def _take(self, op: dict[str, Any]) -> None:
        with self._changed:
            match op["op"]:
                case "publish" if op["topic"] == self._settings.joint_states:
                    if (reading := self._reading(op["msg"])) is not None:
                        self._newest, self._came = reading, time.monotonic()
                case "action_result":
                    told = op.get("values")
                    values = told if isinstance(told, dict) else {"error_string": str(told or "")}
                    self._over[str(op.get("id"))] = int(op.get("status", 0)), values
                case "status" if op.get("level") in ("error", "warning"):
                    self._said = str(op.get("msg"))[:300]
            self._changed.notify_all()

    def _reading(self, message: dict[str, Any]) -> Reading | None:
        """Return a reading; None for a message that lacks a joint, as of a gripper that tells its own."""
        names = message["name"]
        if not self._names:
            self._names = tuple(map(str, names))
        if any(name not in names for name in self._names):
            return None
        places = [names.index(name) for name in self._names]
        stamp = message["header"]["stamp"]
        told = stamp["sec"] + stamp["nanosec"] / _NANO
        velocities = message.get("velocity") or ()
        return Reading(
            told or time.monotonic(),
            _row(message["position"], places),
            _row(velocities, places) if len(velocities) == len(names) else None,
        )


def _row(values: Sequence[float | None], places: Sequence[int]) -> Floats:
    """Return the values of some joints; JSON has no NaN: null stands for it."""
    return np.array([math.nan if values[place] is None else values[place] for place in places], float)
