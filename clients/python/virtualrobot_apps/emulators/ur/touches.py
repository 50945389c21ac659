"""Touches of the twin, as the kernel's collision monitor tells them."""

from __future__ import annotations

import threading
import time
from collections import deque
from contextlib import suppress
from itertools import takewhile

import numpy as np
from virtualrobot import Client, VirtualRobotError
from virtualrobot.collisions.values import Collision
from virtualrobot.robots.robot import Robot

from virtualrobot_apps.emulators.body import Twin
from virtualrobot_apps.emulators.ur.kinematics import Floats

_CYCLES = 900
"""Cycles that are counted at most; the controller remembers so many positions."""
_ASKED_SECONDS = 1.0
"""Time (s) for which the mode of the robot is taken to be as it was."""
_AGAINST = np.cos(np.radians(80.0))
"""Cosine of the largest angle between a direction and the way into what is touched that is against it."""


class Touches:
    """Touches of a robot, its tools and what it holds with anything else.

    Those that there were when watching began don't count: a robot touches what it stands on.
    """

    def __init__(self, client: Client, robot: Robot, body: Twin) -> None:
        """Watch from the first question on."""
        self._client, self._robot, self._body = client, robot.name, body
        self._own: list[tuple[float, Floats]] = []
        self._times: deque[float] = deque(maxlen=_CYCLES)
        self._asked, self._on, self._watches = float("-inf"), False, False

    def watched(self) -> bool:
        """Return whether the kernel tells of the robot's touches: unless its mode is off."""
        if time.monotonic() - self._asked > _ASKED_SECONDS:
            self._asked = time.monotonic()
            settings = self._client.collisions.settings
            self._on = settings.robots.get(self._robot, settings.mode) != "off"
        if self._on and not self._watches:
            self._watches = True
            threading.Thread(target=self._watch, name=f"touches of {self._robot}", daemon=True).start()
        return self._on

    def cycle(self) -> None:
        """Note the time of a cycle of the controller, which may be slower than the kernel's time."""
        self._times.append(self._body.time)

    def cycles(self, direction: Floats) -> int:
        """Return the number of cycles since the robot has begun to touch something; 0 where it doesn't.

        Touches against a direction (3,), along the base's axes, count, and where it is 0 all of them.
        """
        length = float(np.linalg.norm(direction))
        against = direction / length if length else direction
        since = min(
            (
                began
                for began, into in self._own
                if not length or not len(into) or float((into @ against).max()) > _AGAINST
            ),
            default=None,
        )
        if since is None:
            return 0
        return max(1, sum(1 for _ in takewhile(lambda one: one >= since, reversed(self._times))))

    def _watch(self) -> None:
        places: dict[tuple[str, str], Collision] = {}
        with suppress(VirtualRobotError):
            for report in self._client.collisions.watch():
                for begun in (*report.touching, *(event.begun for event in report.events)):
                    # Only the first report and events tell where two touch.
                    if begun is not None and len(begun.collision.points):
                        places[begun.collision.first, begun.collision.second] = begun.collision
                nodes = {node.name: node for node in self._client.scene.nodes()} if report.touching else {}
                parents = {name: node.parent for name, node in nodes.items()}
                turn = self._client.scene.pose(self._robot)[:3, :3] if report.touching else np.eye(3)
                own = []
                for one in report.touching:
                    first, second = one.collision.first, one.collision.second
                    mine = self._carries(first, parents)
                    if one.tolerated or mine == self._carries(second, parents):
                        continue
                    normals = places.get((first, second), one.collision).normals
                    own.append((one.simulation_time, (normals if mine else -normals) @ turn))
                self._own = own
        self._own, self._watches = [], False

    def _carries(self, node: str, parents: dict[str, str]) -> bool:
        while node in parents and node.partition(".")[0] != self._robot:
            node = parents[node]
        return node.partition(".")[0] == self._robot
