"""Touches of the twin, as the kernel's collision monitor tells them."""

from __future__ import annotations

import threading
import time
from collections import deque
from contextlib import suppress
from itertools import takewhile

from virtualrobot import Client, VirtualRobotError
from virtualrobot.collisions.values import Collision
from virtualrobot.robots.robot import Robot

from virtualrobot_apps.emulators.body import Twin

_CYCLES = 900
"""Cycles that are counted at most; the controller remembers so many positions."""
_ASKED_SECONDS = 1.0
"""Time (s) for which the mode of the robot is taken to be as it was."""


class Touches:
    """Touches of a robot, its tools and what it holds with anything else.

    Those that there were when watching began don't count: a robot touches what it stands on.
    """

    def __init__(self, client: Client, robot: Robot, body: Twin) -> None:
        """Watch from the first question on."""
        self._client, self._robot, self._body = client, robot.name, body
        self._since: float | None = None
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

    def cycles(self) -> int:
        """Return the number of cycles since the robot has begun to touch something; 0 where it doesn't."""
        since = self._since
        if since is None:
            return 0
        return max(1, sum(1 for _ in takewhile(lambda one: one >= since, reversed(self._times))))

    def _watch(self) -> None:
        with suppress(VirtualRobotError):
            for report in self._client.collisions.watch():
                parents = {node.name: node.parent for node in self._client.scene.nodes()} if report.touching else {}
                begun = [
                    one.simulation_time
                    for one in report.touching
                    if not one.tolerated and self._is_own(one.collision, parents)
                ]
                self._since = min(begun, default=None)
        self._since, self._watches = None, False

    def _is_own(self, collision: Collision, parents: dict[str, str]) -> bool:
        return self._carries(collision.first, parents) != self._carries(collision.second, parents)

    def _carries(self, node: str, parents: dict[str, str]) -> bool:
        while node in parents and node.partition(".")[0] != self._robot:
            node = parents[node]
        return node.partition(".")[0] == self._robot
