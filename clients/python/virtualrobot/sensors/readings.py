"""Readings and states of sensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from virtualrobot._wire.messages import Stamp, pose_of, stamp_of
from virtualrobot._wire.showing import shown
from virtualrobot.geometry import Matrix
from virtualrobot.sensors.cameras import CameraReading, camera_reading_of
from virtualrobot.sensors.contact_sensors import contacts_of
from virtualrobot.sensors.motion_sensors import encoder_reading_of, imu_reading_of, pose_reading_of, wrench_reading_of
from virtualrobot.sensors.range_sensors import RangeReading, RangeSensorSettings, range_reading_of
from virtualrobot.v1 import sensor_pb2

VALUES: dict[str, Callable[[Any], Any]] = {
    "range": range_reading_of,
    "camera": camera_reading_of,
    "contact": contacts_of,
    "imu": imu_reading_of,
    "encoders": encoder_reading_of,
    "pose": pose_reading_of,
    "wrench": wrench_reading_of,
}
"""Makes the value of a reading from its message, by the field of the contract."""


@dataclass(frozen=True, slots=True)
class SensorStatus:
    """Status of a sensor.

    Attributes:
        name: its node.
        kind: of node, such as `range_sensor`.
        state: stopped, running or fault.
        fault: the reason for which it cannot read; empty while it is well.
        rate: readings per second of simulation time, while it runs.
        readings: number of readings since it was started.
        missed: number of readings since then that it was late for and left out.
        mean_reading_time: the mean time that a reading takes.
    """

    name: str
    kind: str
    state: str
    fault: str
    rate: float
    readings: int
    missed: int
    mean_reading_time: float


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """Reading of a sensor.

    Attributes:
        stamp: the instant of the world that the sensor saw.
        sensor: its node.
        state: stopped, running or fault.
        fault: the reason for which there is no value; empty where there is one.
        number: counts the readings since the sensor was started, from 1; of single ones, those asked for.
        missed: number of readings so far that the sensor was late for and left out.
        world_t_sensor: (4, 4) pose of the sensor in the world's frame (m).
        value: a RangeReading, CameraReading, ImuReading, EncoderReading, PoseReading or WrenchReading; of a contact
            sensor a tuple of Contact; None where there is none.
    """

    stamp: Stamp
    sensor: str
    state: str
    fault: str
    number: int
    missed: int
    world_t_sensor: Matrix
    value: Any

    def _repr_png_(self) -> bytes | None:
        """Return what a camera saw, for notebooks."""
        return self.value._repr_png_() if isinstance(self.value, CameraReading) else None

    @property
    def range(self) -> RangeReading:
        """The reading of a range sensor; raises TypeError for that of another one."""
        if not isinstance(self.value, RangeReading):
            said = self.fault or f"it holds {type(self.value).__name__}"
            raise TypeError(f"the reading of {self.sensor!r} has no distances: {said}")
        return self.value

    @property
    def camera(self) -> CameraReading:
        """The reading of a camera; raises TypeError for that of another sensor."""
        if not isinstance(self.value, CameraReading):
            said = self.fault or f"it holds {type(self.value).__name__}"
            raise TypeError(f"the reading of {self.sensor!r} has no pictures: {said}")
        return self.value


@dataclass(frozen=True, slots=True)
class ComponentTrial:
    """Trial of a range sensor's components: the times (s) of one reading, and its number of rays."""

    cast_time: float
    model_time: float
    rays: int


@shown
@dataclass(frozen=True, slots=True, eq=False)
class SensorPreset:
    """A device that a range sensor may be set as: what it is, where its numbers come from, how it is set."""

    name: str
    description: str
    source: str
    settings: RangeSensorSettings


def reading_of(message: sensor_pb2.SensorReading) -> Reading:
    """Return what a sensor said from a message."""
    field = message.WhichOneof("reading")
    return Reading(
        stamp=stamp_of(message.stamp),
        sensor=message.sensor,
        state=_state(message.state),
        fault=message.fault,
        number=message.number,
        missed=message.missed,
        world_t_sensor=pose_of(message.world_t_sensor),
        value=VALUES[field](getattr(message, field)) if field else None,
    )


def status_of(message: sensor_pb2.SensorStatus) -> SensorStatus:
    """Return how a sensor is from a message."""
    return SensorStatus(
        message.name,
        f"{sensor_pb2.SensorKind.Name(message.kind).removeprefix('SENSOR_KIND_').lower()}_sensor",
        _state(message.state),
        message.fault,
        message.rate_hertz,
        message.readings,
        message.missed,
        message.mean_reading_seconds,
    )


def _state(number: int) -> str:
    return sensor_pb2.SensorState.Name(number).removeprefix("SENSOR_STATE_").lower()  # pyright: ignore[reportArgumentType] a number of the enum
