"""Range sensors of a scene, and the distances that they measure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import (
    Wrapped,
    array_message,
    array_of,
    seed_of,
    settings_message,
    value_or_default,
    whole,
)
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import sensing_pb2, sensor_pb2

FRAMES = {
    "sensor": sensor_pb2.READING_FRAME_SENSOR,
    "robot": sensor_pb2.READING_FRAME_ROBOT,
    "world": sensor_pb2.READING_FRAME_WORLD,
}


class ScanPattern(Wrapped[sensing_pb2.ScanPattern]):
    """Beams of a range sensor; `fan`, `spinning`, `raster`, `ring` and `beams` make it."""

    __slots__ = ()
    _called = "a pattern, as virtualrobot.fan, spinning, raster, ring and beams make it"


class RangeSensorSettings(Wrapped[sensing_pb2.RangeSensor]):
    """Settings of a range sensor; `range_sensor` makes them."""

    __slots__ = ()
    _called = "what virtualrobot.range_sensor makes"


@checked
def fan(count: int, start: float, end: float) -> ScanPattern:
    """Return `count` beams in the sensor's plane z = 0, from the angle `start` to `end` (rad, from x towards y)."""
    count = whole(count, "a fan's count of beams")
    return ScanPattern(
        sensing_pb2.ScanPattern(fan=sensing_pb2.Fan(count=count, start_angle_radians=start, end_angle_radians=end))
    )


@checked
def spinning(columns: int, elevations: Iterable[float]) -> ScanPattern:
    """Return the beams of a head that turns once: `columns` directions around, at each of the `elevations` (rad)."""
    head = sensing_pb2.Spinning(
        columns=whole(columns, "a head's count of columns"), elevations_radians=[float(one) for one in elevations]
    )
    return ScanPattern(sensing_pb2.ScanPattern(spinning=head))


@checked
def raster(columns: int, rows: int, horizontal_field: float, vertical_field: float) -> ScanPattern:
    """Return beams as the pixels of a picture whose middle is x, at equal steps over these angles (rad)."""
    pixels = sensing_pb2.Raster(
        columns=whole(columns, "a raster's count of columns"),
        rows=whole(rows, "a raster's count of rows"),
        horizontal_field_radians=horizontal_field,
        vertical_field_radians=vertical_field,
    )
    return ScanPattern(sensing_pb2.ScanPattern(raster=pixels))


@checked
def ring(count: int, radius: float, start: float, end: float) -> ScanPattern:
    """Return transducers on a circle of `radius` (m) that look outwards, from the angle `start` to `end` (rad)."""
    count = whole(count, "a ring's count of transducers")
    circle = sensing_pb2.Ring(count=count, radius_meters=radius, start_angle_radians=start, end_angle_radians=end)
    return ScanPattern(sensing_pb2.ScanPattern(ring=circle))


@checked
def beams(directions: ArrayLike, origins: ArrayLike | None = None) -> ScanPattern:
    """Return any beams: `directions` (n, 3) of any length but 0, `origins` (n, 3) in meters (none: all at 0, 0, 0)."""
    free = sensing_pb2.FreeBeams(directions=array_message(directions))
    if origins is not None:
        free.origins.CopyFrom(array_message(origins))
    return ScanPattern(sensing_pb2.ScanPattern(free=free))


@checked
def range_sensor(
    preset: str | None = None,
    *,
    pattern: ScanPattern | None = None,
    rate: float | None = None,
    min_range: float | None = None,
    max_range: float | None = None,
    ray_caster: str | None = None,
    ray_caster_settings: Mapping[str, object] | None = None,
    sensor_model: str | None = None,
    sensor_model_settings: Mapping[str, object] | None = None,
    seed: int = 0,
    motion_distortion: bool = False,
    running: bool = False,
) -> RangeSensorSettings:
    """Return the settings of a range sensor for `scene.add_range_sensor`; what is not said is the preset's.

    Args:
        preset: a device, such as `LDS-01`; `client.sensors.presets()` has them all.
        pattern: beam directions: `fan`, `spinning`, `raster`, `ring` or `beams` make it; by default one beam ahead.
        rate: readings a second of simulation time while it runs, 10 by default.
        min_range: the least distance that it measures, in meters, 0 by default.
        max_range: the greatest one, 10 by default.
        ray_caster: the component that finds what rays hit, `embree` by default.
        ray_caster_settings: those of that component.
        sensor_model: the component that makes readings of true hits, `ideal` by default.
        sensor_model_settings: those of that component.
        seed: the seed of its noise.
        motion_distortion: whether columns are measured one after the other, as a turning head does.
        running: whether it reads from the start.

    Example:
        >>> scene.add_range_sensor("lidar", virtualrobot.range_sensor("LDS-01"), pose=virtualrobot.pose(z=0.2))
        >>> fan = virtualrobot.fan(181, -np.pi / 2, np.pi / 2)
        >>> scene.add_range_sensor("scanner", virtualrobot.range_sensor(pattern=fan, sensor_model="laser"))
    """
    settings = sensing_pb2.RangeSensor(
        preset=preset,
        pattern=None if pattern is None else pattern._message,
        rate_hertz=value_or_default(rate, "rate"),
        min_range_meters=min_range,
        max_range_meters=max_range,
        ray_caster=ray_caster,
        sensor_model=sensor_model,
        seed=seed_of(seed),
        motion_distortion=motion_distortion,
        running=running,
    )
    if ray_caster_settings is not None:
        settings.ray_caster_settings.CopyFrom(settings_message(ray_caster_settings))
    if sensor_model_settings is not None:
        settings.sensor_model_settings.CopyFrom(settings_message(sensor_model_settings))
    return RangeSensorSettings(settings)


def frame_of(name: str) -> sensor_pb2.ReadingFrame:
    """Return a frame of points by its name; raises InvalidArgumentError for another name."""
    if name not in FRAMES:
        raise InvalidArgumentError(f"{name!r} is no frame of points: use {', '.join(FRAMES)}")
    return FRAMES[name]


@shown
@checked
@dataclass(frozen=True, slots=True, eq=False)
class RangeReading:
    """Reading of a range sensor; (r, c) is its pattern's shape; arrays are read-only.

    Attributes:
        distances: (r, c) float32 meters; where `valid` is False, what this sensor says then (inf, 0 or its range).
        valid: (r, c) bool: true where the sensor trusts the distance.
        intensities: (r, c) float32, 0 to 1; None unless asked for.
        elements: (r, c) int32 places in `element_names`, -1 where nothing was hit; None unless asked for.
        element_names: the nodes that `elements` tells of.
        points: (r, c, 3) float32 meters in `frame`, NaN where not valid; None unless asked for.
        frame: sensor, robot or world.
        ages: (c,) float32: time from the measurement of each column to the reading (s); None: all at its instant.
    """

    distances: NDArray[np.float32]
    valid: NDArray[np.bool_]
    intensities: NDArray[np.float32] | None
    elements: NDArray[np.int32] | None
    element_names: tuple[str, ...]
    points: NDArray[np.float32] | None
    frame: str
    ages: NDArray[np.float32] | None

    def mask(self, name: str) -> NDArray[np.bool_]:
        """Return (r, c) where the node `name` was hit; raises InvalidArgumentError unless elements were asked for."""
        if self.elements is None:
            raise InvalidArgumentError("this reading has no elements: ask for it with elements=True")
        if name not in self.element_names:
            return np.zeros(self.elements.shape, np.bool_)
        return self.elements == self.element_names.index(name)


def range_reading_of(message: sensor_pb2.RangeReading) -> RangeReading:
    """Return what a range sensor measured from a message."""

    def given(field: str) -> NDArray | None:
        return array_of(getattr(message, field)) if message.HasField(field) else None  # pyright: ignore[reportArgumentType]

    return RangeReading(
        distances=array_of(message.distances),
        valid=array_of(message.valid).view(np.bool_),
        intensities=given("intensities"),
        elements=given("elements"),
        element_names=tuple(message.element_names),
        points=given("points"),
        frame=next((name for name, number in FRAMES.items() if number == message.frame), "sensor"),
        ages=given("ages"),
    )
