"""Sensors at work: start, stop, read once, watch; and which components a range sensor has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from difflib import get_close_matches
from typing import Any, TypedDict, Unpack

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import settings_message, value_or_default
from virtualrobot._wire.newest import newest
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import listed, table_html, told
from virtualrobot.errors import UnknownNameError
from virtualrobot.scene.editor import Direct
from virtualrobot.sensors.cameras import image_kinds
from virtualrobot.sensors.range_sensors import RangeSensorSettings, frame_of
from virtualrobot.sensors.readings import ComponentTrial, Reading, SensorPreset, SensorStatus, reading_of, status_of
from virtualrobot.v1 import sensor_pb2

MOST_NAMES = 8
"""Largest number of names in an error."""


class ReadingOptions(TypedDict, total=False):
    """Options of readings.

    Attributes:
        points: of range sensors: where the echoes come from too.
        frame: of points: `sensor` (the default), `robot` or `world`.
        intensities: of range sensors: how strong the echoes are too.
        elements: of range sensors: which nodes were hit too.
        images: of cameras: color, depth, segmentation, normals; by default those that the camera is set to.
    """

    points: bool | None
    frame: str | None
    intensities: bool | None
    elements: bool | None
    images: str | Iterable[str] | None


@checked
class Sensor:
    """One sensor by its name; `client.sensors["lidar"]` makes it."""

    def __init__(self, services: Services, name: str) -> None:
        """Handle the sensor `name`."""
        self._services = services
        self.name = name

    @property
    def status(self) -> SensorStatus:
        """Status of the sensor now."""
        return Sensors(self._services).status(self.name)

    def start(self) -> None:
        """Let it read at its rate; one with a fault is tried anew."""
        Direct(self._services).start_sensors(self.name)

    def stop(self) -> None:
        """Stop reading."""
        Direct(self._services).stop_sensors(self.name)

    def read(self, **options: Unpack[ReadingOptions]) -> Reading:
        """Return one reading of the world as it is now, whether the sensor runs or not.

        Raises:
            PluginFailedError: when a component of the sensor raised, hung, died or returned nonsense.
        """
        request = sensor_pb2.ReadSensorRequest(sensor=self.name, options=reading_options(options))
        return reading_of(self._services.sensor.ReadSensor(request, timeout=LONG_TIMEOUT_SECONDS).reading)

    def watch(self, *, max_rate: float | None = None, **options: Unpack[ReadingOptions]) -> Iterator[Reading]:
        """Yield the latest reading and then each new one; who is slow gets the latest.

        `max_rate` is the most readings a second of the wall clock; without it all that the reader keeps up with. A
        stop, a fault or the sensor's removal is told by a reading without a value.
        """
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
        return told(f"Sensor {self.name!r}", lambda: self.status.state)


@checked
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
        return list(map(status_of, response.sensors))

    def status(self, name: str) -> SensorStatus:
        """Return how a sensor is; raises UnknownNameError, a KeyError, when there is none of this name."""
        known = {one.name: one for one in self.statuses()}
        if name not in known:
            raise UnknownNameError(f"there is no sensor named {name!r}; {_there(name, known)}")
        return known[name]

    def start(self, *names: str) -> None:
        """Let sensors read at their rates (none named: all)."""
        Direct(self._services).start_sensors(*names)

    def stop(self, *names: str) -> None:
        """Let sensors read no more (none named: all)."""
        Direct(self._services).stop_sensors(*names)

    def watch(self, *names: str, max_rate: float | None = None, **options: Unpack[ReadingOptions]) -> Iterator[Reading]:
        """Yield the readings of several sensors (none named: all, later ones too); see `Sensor.watch`."""
        return _watched(self._services, names, options, max_rate)

    def presets(self) -> dict[str, SensorPreset]:
        """Return the devices that a range sensor may be set as, by name."""
        response = self._services.sensor.ListSensorPresets(sensor_pb2.ListSensorPresetsRequest())
        return {
            one.name: SensorPreset(one.name, one.description, one.source, RangeSensorSettings(one.sensor))
            for one in response.presets
        }

    def __getitem__(self, name: str) -> Sensor:
        """Return a sensor; raises UnknownNameError, a KeyError, when there is none of this name."""
        return Sensor(self._services, self.status(name).name)

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter([one.name for one in self.statuses()])

    def __len__(self) -> int:
        """Return the count of sensors."""
        return len(self.statuses())

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that IPython completes."""
        return list(self)

    def _repr_html_(self) -> str:
        """Return a table for notebooks."""
        rows = [[one.name, one.kind, one.state, f"{one.rate:g} Hz", str(one.readings)] for one in self.statuses()]
        return table_html("Sensors", [["sensor", "kind", "state", "rate", "readings"], *rows])

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            return listed((f"{one.name!r} ({one.kind}, {one.state})" for one in self.statuses()), "none yet")

        return told("Sensors", say)


def _there(name: str, known: Iterable[str]) -> str:
    """Return which sensors there are, those first whose names are like `name`."""
    names = sorted(known)
    if close := get_close_matches(name, names):
        return f"did you mean {', '.join(map(repr, close))}?"
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return f"there are {', '.join(map(repr, names[:MOST_NAMES]))}{more}" if names else "there is none yet"


def _watched(
    services: Services, names: Iterable[str], options: ReadingOptions, max_rate: float | None
) -> Iterator[Reading]:
    rate = value_or_default(max_rate, "max_rate")
    request = sensor_pb2.WatchReadingsRequest(sensors=names, options=reading_options(options), max_rate_hertz=rate)
    stream = services.sensor.WatchReadings(request)
    with closing(newest(stream, lambda response: ((one.sensor, one) for one in response.readings))) as readings:
        yield from map(reading_of, readings)


def reading_options(options: ReadingOptions) -> sensor_pb2.ReadingOptions:
    """Return options of readings as a message; raise InvalidArgumentError for those that there aren't."""
    check_options(options, ReadingOptions, "a reading")
    return sensor_pb2.ReadingOptions(
        points=options.get("points") or False,
        frame=frame_of(options.get("frame") or "sensor"),
        intensities=options.get("intensities") or False,
        elements=options.get("elements") or False,
        images=image_kinds(options.get("images") or ()),
    )
