"""Sensors at work: start, stop, read once, watch; and which components a range sensor has."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from virtualrobot.cameras import CameraReading, camera_reading_of, image_kinds
from virtualrobot.contact_sensors import contacts_of
from virtualrobot.errors import UnknownNameError
from virtualrobot.geometry import Matrix
from virtualrobot.motion_sensors import encoder_reading_of, imu_reading_of, pose_reading_of, wrench_reading_of
from virtualrobot.newest import newest
from virtualrobot.range_sensors import RangeReading, frame_of, range_reading_of
from virtualrobot.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot.v1 import sensing_pb2, sensor_pb2
from virtualrobot.wire import Stamp, pose_of, settings_message, stamp_of

MOST_NAMES = 8
"""How many names an error tells."""

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
    """How a sensor is.

    Attributes:
        name: its node.
        kind: of node, such as `range_sensor`.
        state: stopped, running or fault.
        fault: why it cannot read; empty while it is well.
        rate_hertz: readings a second of simulation time, while it runs.
        readings: how many it has given since it was started.
        missed: how many it was late for and left out since then.
        mean_reading_seconds: the mean time that a reading takes.
    """

    name: str
    kind: str
    state: str
    fault: str
    rate_hertz: float
    readings: int
    missed: int
    mean_reading_seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """What a sensor said.

    Attributes:
        stamp: when the world was as the sensor saw it.
        sensor: its node.
        state: stopped, running or fault.
        fault: why there is no value; empty where there is one.
        number: counts the readings since the sensor was started, from 1; of single ones, those asked for.
        missed: how many the sensor was late for and left out so far.
        world_t_sensor: (4, 4) where the sensor was.
        value: what it said: a RangeReading, CameraReading, ImuReading, EncoderReading, PoseReading or WrenchReading; of
            a contact sensor a tuple of Contact; None where nothing.
    """

    stamp: Stamp
    sensor: str
    state: str
    fault: str
    number: int
    missed: int
    world_t_sensor: Matrix
    value: Any

    @property
    def range(self) -> RangeReading:
        """What a range sensor measured; raises TypeError for a reading that is none."""
        if not isinstance(self.value, RangeReading):
            said = self.fault or f"it holds {type(self.value).__name__}"
            raise TypeError(f"the reading of {self.sensor!r} has no distances: {said}")
        return self.value

    @property
    def camera(self) -> CameraReading:
        """What a camera saw; raises TypeError for a reading that is none."""
        if not isinstance(self.value, CameraReading):
            said = self.fault or f"it holds {type(self.value).__name__}"
            raise TypeError(f"the reading of {self.sensor!r} has no pictures: {said}")
        return self.value


@dataclass(frozen=True, slots=True)
class ComponentTrial:
    """What trying a range sensor's components has shown: the time of one reading, and how many rays it casts."""

    cast_seconds: float
    model_seconds: float
    rays: int


@dataclass(frozen=True, slots=True, eq=False)
class SensorPreset:
    """A device that a range sensor may be set as: what it is, where its numbers come from, how it is set."""

    name: str
    description: str
    source: str
    settings: sensing_pb2.RangeSensor


class Sensor:
    """One sensor by its name; `client.sensors["lidar"]` makes it."""

    def __init__(self, services: Services, name: str) -> None:
        """Handle the sensor `name`."""
        self._services = services
        self.name = name

    @property
    def status(self) -> SensorStatus:
        """How it is now."""
        return Sensors(self._services).status(self.name)

    def start(self) -> None:
        """Let it read at its rate; one with a fault is tried anew."""
        self._services.sensor.StartSensor(sensor_pb2.StartSensorRequest(sensors=[self.name]))

    def stop(self) -> None:
        """Let it read no more."""
        self._services.sensor.StopSensor(sensor_pb2.StopSensorRequest(sensors=[self.name]))

    def read(
        self,
        *,
        points: bool = False,
        frame: str = "sensor",
        intensities: bool = False,
        elements: bool = False,
        images: Iterable[str] = (),
    ) -> Reading:
        """Return one reading of the world as it is now, whether the sensor runs or not.

        Args:
            points: of range sensors: where the echoes come from too.
            frame: of points: sensor, robot or world.
            intensities: of range sensors: how strong the echoes are too.
            elements: of range sensors: which nodes were hit too.
            images: of cameras: color, depth, segmentation, normals; none means those that the camera is set to.

        Raises:
            PluginFailedError: when a component of the sensor raised, hung, died or returned nonsense.
        """
        request = sensor_pb2.ReadSensorRequest(
            sensor=self.name, options=_options(points, frame, intensities, elements, images)
        )
        return reading_of(self._services.sensor.ReadSensor(request, timeout=LONG_TIMEOUT_SECONDS).reading)

    def watch(
        self,
        *,
        points: bool = False,
        frame: str = "sensor",
        intensities: bool = False,
        elements: bool = False,
        images: Iterable[str] = (),
        max_rate: float = 0.0,
    ) -> Iterator[Reading]:
        """Yield the latest reading and then each new one; who is slow gets the latest.

        The options are those of `read`; `max_rate` is the most readings a second of the wall clock, 0: all that the
        reader keeps up with. A stop, a fault or the sensor's removal is told by a reading without a value.
        """
        options = _options(points, frame, intensities, elements, images)
        return _watched(self._services, [self.name], options, max_rate)

    def set_ray_caster(self, name: str, settings: Mapping[str, object] | None = None) -> ComponentTrial:
        """Give a range sensor another ray caster, while it runs or not; it is tried first."""
        return self._set(ray_caster=name, ray_caster_settings=settings_message(settings or {}))

    def set_model(self, name: str, settings: Mapping[str, object] | None = None) -> ComponentTrial:
        """Give a range sensor another sensor model, while it runs or not; it is tried first."""
        return self._set(sensor_model=name, sensor_model_settings=settings_message(settings or {}))

    def _set(self, **fields: Any) -> ComponentTrial:  # noqa: ANN401 fields of the request
        request = sensor_pb2.SetRangeComponentsRequest(sensor=self.name, **fields)
        response = self._services.sensor.SetRangeComponents(request, timeout=LONG_TIMEOUT_SECONDS)
        return ComponentTrial(response.cast_seconds, response.model_seconds, response.rays)

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Sensor {self.name!r} ({self.status.state})>"


class Sensors(Mapping[str, Sensor]):
    """The sensors of one kernel by name; they are made and removed as nodes of the scene.

    Example:
        >>> client.scene.add_range_sensor("lidar", virtualrobot.range_sensor("LDS-01"))
        >>> lidar = client.sensors["lidar"]
        >>> lidar.read(points=True, frame="world").range.points
        >>> lidar.start()
        >>> for reading in lidar.watch():
        ...     print(reading.number, np.nanmin(reading.range.distances))
    """

    def __init__(self, services: Services) -> None:
        """Handle the sensors of one kernel."""
        self._services = services

    def statuses(self) -> list[SensorStatus]:
        """Return how all sensors are, in the order of their creation."""
        response = self._services.sensor.ListSensors(sensor_pb2.ListSensorsRequest())
        return [
            SensorStatus(
                one.name,
                one.kind,
                _state(one.state),
                one.fault,
                one.rate_hertz,
                one.readings,
                one.missed,
                one.mean_reading_seconds,
            )
            for one in response.sensors
        ]

    def status(self, name: str) -> SensorStatus:
        """Return how a sensor is; raises UnknownNameError, a KeyError, when there is none of this name."""
        known = {one.name: one for one in self.statuses()}
        if name not in known:
            raise UnknownNameError(f"there is no sensor named {name!r}; {_there(name, known)}")
        return known[name]

    def start(self, *names: str) -> None:
        """Let sensors read at their rates (none named: all)."""
        self._services.sensor.StartSensor(sensor_pb2.StartSensorRequest(sensors=names))

    def stop(self, *names: str) -> None:
        """Let sensors read no more (none named: all)."""
        self._services.sensor.StopSensor(sensor_pb2.StopSensorRequest(sensors=names))

    def watch(
        self,
        *names: str,
        points: bool = False,
        frame: str = "sensor",
        intensities: bool = False,
        elements: bool = False,
        images: Iterable[str] = (),
        max_rate: float = 0.0,
    ) -> Iterator[Reading]:
        """Yield the readings of several sensors (none named: all, later ones too); see `Sensor.watch`."""
        return _watched(self._services, names, _options(points, frame, intensities, elements, images), max_rate)

    def presets(self) -> dict[str, SensorPreset]:
        """Return the devices that a range sensor may be set as, by name."""
        response = self._services.sensor.ListSensorPresets(sensor_pb2.ListSensorPresetsRequest())
        return {one.name: SensorPreset(one.name, one.description, one.source, one.sensor) for one in response.presets}

    def __getitem__(self, name: str) -> Sensor:
        """Return a sensor; raises UnknownNameError, a KeyError, when there is none of this name."""
        return Sensor(self._services, self.status(name).name)

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter([one.name for one in self.statuses()])

    def __len__(self) -> int:
        """Return the count of sensors."""
        return len(self.statuses())


def _there(name: str, known: Iterable[str]) -> str:
    """Return which sensors there are, those first whose names are like `name`."""
    names = sorted(known)
    if close := get_close_matches(name, names):
        return f"did you mean {', '.join(map(repr, close))}?"
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return f"there are {', '.join(map(repr, names[:MOST_NAMES]))}{more}" if names else "there is none yet"


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


def _watched(
    services: Services, names: Iterable[str], options: sensor_pb2.ReadingOptions, max_rate: float
) -> Iterator[Reading]:
    request = sensor_pb2.WatchReadingsRequest(sensors=names, options=options, max_rate_hertz=max_rate)
    stream = services.sensor.WatchReadings(request)
    with closing(newest(stream, lambda response: ((one.sensor, one) for one in response.readings))) as readings:
        yield from map(reading_of, readings)


def _options(
    points: bool, frame: str, intensities: bool, elements: bool, images: Iterable[str]
) -> sensor_pb2.ReadingOptions:
    return sensor_pb2.ReadingOptions(
        points=points,
        frame=frame_of(frame),
        intensities=intensities,
        elements=elements,
        images=image_kinds(images),
    )


def _state(number: int) -> str:
    return sensor_pb2.SensorState.Name(number).removeprefix("SENSOR_STATE_").lower()  # pyright: ignore[reportArgumentType] a number of the enum
