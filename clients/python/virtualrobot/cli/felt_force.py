"""Force on a sensor as somebody feels it who moves the robot: a strength for the motors of a gamepad."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING

from virtualrobot.errors import VirtualRobotError, WrongStateError

if TYPE_CHECKING:
    from virtualrobot.robots.robot import Robot
    from virtualrobot.sensors.motion_sensors import WrenchReading

RATE_HERTZ = 20.0
"""Rate at which the sensor is read."""


@dataclass(frozen=True)
class ForceMapping:
    """Force that is felt: the name of a force and torque sensor, and the force (N) that is felt with full strength."""

    sensor: str
    full: float


class FeltForce:
    """Strength, 0 to 1, of a sensor's force beyond that at the beginning, such as a tool's weight. A context manager.

    A thread reads the sensor. What goes wrong with that is in `error`, and nothing is felt.
    """

    def __init__(self, robot: Robot, mapping: ForceMapping) -> None:
        """Begin to read; raise UnknownNameError for a sensor that isn't there, WrongStateError for another kind."""
        from virtualrobot.sensors.sensors import Sensors

        self._sensor, self._full = Sensors(robot._services)[mapping.sensor], mapping.full
        self._begin = self._read().force
        self.strength, self.error = 0.0, ""
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="felt force", daemon=True)
        self._thread.start()

    def _read(self) -> WrenchReading:
        from virtualrobot.sensors.motion_sensors import WrenchReading

        value = self._sensor.read().value
        if not isinstance(value, WrenchReading):
            raise WrongStateError(
                f"the mapping's force is of a force and torque sensor, and {self._sensor.name!r} is none"
            )
        return value

    def _run(self) -> None:
        while not self._ended.wait(1.0 / RATE_HERTZ):
            try:
                beyond = self._read().force - self._begin
                self.strength, self.error = min(1.0, float(beyond @ beyond) ** 0.5 / self._full), ""
            except VirtualRobotError as error:
                self.strength, self.error = 0.0, str(error)

    def __enter__(self) -> FeltForce:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Read no more."""
        self._ended.set()
        self._thread.join()
