"""The Boe-Bot as a program drives it in stepped time: a call a period tells a twist, lets time go on, reads sensors."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.robots.values import RobotState
from virtualrobot.sensors.cameras import CameraReading
from virtualrobot.sensors.motion_sensors import EncoderReading
from virtualrobot.sensors.range_sensors import RangeReading
from virtualrobot.sensors.readings import Reading

from virtualrobot_apps.pace import Pace
from virtualrobot_apps.vehicles.boebot.worlds import ROBOT

TRACK, RADIUS = 0.116, 0.0325
"""Distance of the wheels and their radius (m), as a program knows them."""
WHEELS = ("left_wheel", "right_wheel")
"""Joints of the wheels: the robot's last ones."""


class Cockpit:
    """Drives by twists, keeps what was read last. A context manager; the clock is stepped, and stands afterwards."""

    def __init__(self, client: Client, pace: float = 0.0, sensors: Iterable[str] = ()) -> None:
        """Take a client, and simulated seconds for each second of the wall clock; 0: as fast as it can be.

        A tick goes by, after which the `sensors` are read.
        """
        self._client = client
        client.clock.set_stepped()
        self.tick_length = client.clock.read().tick_length
        self._pace = Pace(pace)
        self.state: RobotState
        """Robot's true state after the last step, which is for those who judge, not for the program."""
        self._readings: dict[str, Reading] = {}
        self._step(0.0, 0.0, 1, sensors)
        self._start = self.state.stamp

    @property
    def ticks(self) -> int:
        """Return how many ticks have gone since it began."""
        return self.state.stamp.tick - self._start.tick

    @property
    def now(self) -> float:
        """Return the simulation time since it began (s)."""
        return self.ticks * self.tick_length

    @property
    def pose(self) -> tuple[float, float, float]:
        """Return the true place (m) and heading (rad) in the world, which a program does not know."""
        pose = self.state.world_t_tcp
        return float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])

    @property
    def true_wheels(self) -> EncoderReading:
        """Return where the wheels truly are, as encoders without steps would tell it."""
        count = len(WHEELS)
        return EncoderReading(WHEELS, self.state.positions[-count:], self.state.velocities[-count:])

    def ticks_of(self, seconds: float) -> int:
        """Return how many ticks are nearest to a time (s), one at least."""
        return max(1, round(seconds / self.tick_length))

    def drive(self, speed: float, turning: float, ticks: int, sensors: Iterable[str] = ()) -> None:
        """Tell speed (m/s) and turning rate (rad/s), let time go on by some ticks, and read sensors then."""
        self._step(speed, turning, ticks, sensors)
        self._pace.keep(self.now)

    def encoders(self) -> EncoderReading:
        """Return what the encoders counted when they were read last."""
        reading: EncoderReading = self._readings["encoders"].value
        return reading

    def wheels(self) -> NDArray[np.float64]:
        """Return the angles (2,) of the left and the right wheel as encoders counted them (rad)."""
        return np.array(self.encoders().positions)

    def distance(self, sensor: str) -> float:
        """Return the least distance (m) that a range sensor measured; inf where it measured none."""
        reading: RangeReading = self._readings[sensor].value
        return float(reading.distances[reading.valid].min(initial=math.inf))

    def picture(self) -> CameraReading:
        """Return what the camera saw."""
        return self._readings["camera"].value

    def _step(self, speed: float, turning: float, ticks: int, sensors: Iterable[str]) -> None:
        names = {f"{ROBOT}.{sensor}": sensor for sensor in sensors}
        seen = self._client.clock.step(ticks, twists={ROBOT: (speed, 0.0, turning)}, sensors=[*names])
        self.state = seen.robots[ROBOT]
        self._readings |= {names[name]: reading for name, reading in seen.readings.items()}

    def __enter__(self) -> Cockpit:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let the robot come to rest, which begins with one more tick."""
        with suppress(VirtualRobotError):  # what ended it is told already
            self._client.clock.step(1, twists={ROBOT: None})
