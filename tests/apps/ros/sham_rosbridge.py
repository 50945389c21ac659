"""A robot of ROS behind rosbridge that a test plays: it tells joints, and takes goals of FollowJointTrajectory."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve

FEW_SECONDS = 0.02


class ShamRobot:
    """A robot with two joints and a gripper, which tells them 50 times a second.

    It is at each goal at once, or goes there by a quintic in the time of the goal.

    Attributes:
        positions: where the joints are, by name.
        goals, canceled: what it was told.
        answers: state, code and words by which goals end; None: they don't end.
        talks: whether it tells its joints.
        says: what it sends before its next message.
        is_deaf: whether it passes over the next cancel.
        is_plugged: whether it serves those who connect.
    """

    def __init__(self, *, at_once: bool = True) -> None:
        """Stand at the begin."""
        self._at_once = at_once
        self._stopped = threading.Event()
        self.is_plugged = True
        self.positions = {"gripper": 0.04, "elbow": 0.5, "shoulder": -0.25}
        self.goals: list[dict[str, Any]] = []
        self.canceled: list[str] = []
        self.answers: tuple[int, int, str] | None = (4, 0, "")
        self.talks = True
        self.says = ""
        self.is_deaf = False
        self.headers: list[str | None] = []
        self._ticks = 0
        self._open: list[ServerConnection] = []

    def handle(self, connection: ServerConnection) -> None:
        """Serve a client until it goes."""
        if not self.is_plugged:
            return
        assert connection.request is not None
        self.headers.append(connection.request.headers.get("Authorization"))
        self._open.append(connection)
        ended = threading.Event()
        teller = threading.Thread(target=self._tell, args=(connection, ended), daemon=True)
        try:
            for text in connection:
                op = json.loads(text)
                if op["op"] == "subscribe":
                    teller.start()
                elif op["op"] == "send_action_goal":
                    self.goals.append(op)
                    self._reach(connection, op)
                elif op["op"] == "cancel_action_goal":
                    self.canceled.append(op["id"])
                    if self.is_deaf:  # as a server that has not sent the goal on yet
                        self.is_deaf = False
                    elif self._at_once:
                        self._end(connection, op, 5, 0, "")
                    else:
                        self._stopped.set()
        except ConnectionClosed:
            pass
        finally:
            ended.set()

    def unplug(self) -> None:
        """Close all connections."""
        for one in self._open:
            one.close()

    def _reach(self, connection: ServerConnection, op: dict[str, Any]) -> None:
        if self.answers is None:
            return
        if not self._at_once:
            self._stopped.clear()
            threading.Thread(target=self._go, args=(connection, op), daemon=True).start()
            return
        status, code, words = self.answers
        if status == 4:
            trajectory = op["args"]["trajectory"]
            last = trajectory["points"][-1]["positions"]
            self.positions |= dict(zip(trajectory["joint_names"], last, strict=True))
        self._end(connection, op, status, code, words)

    def _go(self, connection: ServerConnection, op: dict[str, Any]) -> None:
        """Go to a goal by a quintic, as ros2_control has a segment with velocities and accelerations of zero."""
        trajectory = op["args"]["trajectory"]
        names, point = trajectory["joint_names"], trajectory["points"][-1]
        starts, due = [self.positions[name] for name in names], point["time_from_start"]
        began, seconds = time.monotonic(), due["sec"] + 1e-9 * due["nanosec"]
        share = 0.0
        while share < 1.0 and not self._stopped.wait(0.005):
            share = min((time.monotonic() - began) / seconds, 1.0)
            gone = 10.0 * share**3 - 15.0 * share**4 + 6.0 * share**5
            for name, start, end in zip(names, starts, point["positions"], strict=True):
                self.positions[name] = end if share == 1.0 else start + gone * (end - start)
        with suppress(ConnectionClosed):
            self._end(connection, op, 4 if share == 1.0 else 5, 0, "")

    def _end(self, connection: ServerConnection, op: dict[str, Any], status: int, code: int, words: str) -> None:
        result = {"error_code": code, "error_string": words}
        head = {"op": "action_result", "id": op["id"], "action": op["action"], "result": True}
        connection.send(json.dumps(head | {"status": status, "values": result}))

    def _tell(self, connection: ServerConnection, ended: threading.Event) -> None:
        try:
            while not ended.wait(FEW_SECONDS):
                self._ticks += 1
                if self.says:
                    connection.send(self.says)
                    self.says = ""
                if self.talks:
                    connection.send(json.dumps({"op": "publish", "topic": "/joint_states", "msg": self._message()}))
        except (ConnectionClosed, OSError):
            pass

    def _message(self) -> dict[str, Any]:
        seconds, nanos = divmod(self._ticks * 20_000_000, 1_000_000_000)
        return {
            "header": {"stamp": {"sec": seconds, "nanosec": nanos}, "frame_id": ""},
            "name": list(self.positions),
            "position": list(self.positions.values()),
            "velocity": [0.0] * len(self.positions),
            "effort": [],
        }


@contextmanager
def sham_robot() -> Iterator[tuple[str, ShamRobot]]:
    """Give the address of a robot that a test plays, and the robot."""
    robot = ShamRobot()
    with serve(robot.handle, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}", robot
        finally:
            robot.unplug()
            server.shutdown()
            thread.join(60.0)
