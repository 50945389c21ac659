"""The Boe-Bot as a program drives it in stepped time: it tells twists, lets time go on, and reads sensors."""

from __future__ import annotations

import math
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.robots.values import RobotState
from virtualrobot.sensors.cameras import CameraReading
from virtualrobot.sensors.motion_sensors import EncoderReading
from virtualrobot.sensors.range_sensors import RangeReading

from virtualrobot_apps.pace import Pace
from virtualrobot_apps.vehicles.boebot.worlds import ROBOT

TRACK, RADIUS = 0.116, 0.0325
"""Distance of the wheels and their radius (m), as a program knows them."""


class Cockpit:
    """Owns the stream of twists. A context manager; the clock is stepped, and stands afterwards."""

    def __init__(self, client: Client, pace: float = 0.0) -> None:
        """Take a client, and simulated seconds for each second of the wall clock; 0: as fast as it can be."""
        self._client = client
        client.clock.set_stepped()
        self.tick_length = client.clock.read().tick_length
        self._stream = client.robot(ROBOT).stream_twist(timeout=10.0)
        self._pace = Pace(pace)
        self.state: RobotState = client.clock.step(1).robots[ROBOT]
        """Robot's true state after the last step, which is for those who judge, not for the program."""
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

    def ticks_of(self, seconds: float) -> int:
        """Return how many ticks are nearest to a time (s), one at least."""
        return max(1, round(seconds / self.tick_length))

    def drive(self, speed: float, turning: float, ticks: int) -> None:
        """Tell speed (m/s) and turning rate (rad/s), and let time go on by some ticks."""
        self._stream.send((speed, 0.0, turning), wait=True)
        self.state = self._client.clock.step(ticks).robots[ROBOT]
        self._pace.keep(self.now)

    def encoders(self) -> EncoderReading:
        """Return what the encoders count."""
        reading: EncoderReading = self._client.sensors[f"{ROBOT}.encoders"].read().value
        return reading

    def wheels(self) -> NDArray[np.float64]:
        """Return the angles (2,) of the left and the right wheel as encoders count them (rad)."""
        return np.array(self.encoders().positions)

    def distance(self, sensor: str) -> float:
        """Return the least distance (m) that a range sensor measures; inf where it measures none."""
        reading: RangeReading = self._client.sensors[f"{ROBOT}.{sensor}"].read().value
        return float(reading.distances[reading.valid].min(initial=math.inf))

    def picture(self) -> CameraReading:
        """Return what the camera sees."""
        return self._client.sensors[f"{ROBOT}.camera"].read().value

    def __enter__(self) -> Cockpit:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the robot at once."""
        self._stream.cancel()
