"""Settings of sensors in full: what a node does not say is the preset's, or else the contract's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.world.sensing import MotionSensor, Pattern, RangeSensor, Sensor, SingleBeam

DEFAULT_RATE_HERTZ = 10.0
DEFAULT_MOTION_RATE_HERTZ = 100.0
"""Of what tells how it moves."""
DEFAULT_MAX_RANGE_METERS = 10.0
DEFAULT_RAY_CASTER = "embree"
DEFAULT_SENSOR_MODEL = "ideal"
SLOWEST_TURN_HERTZ = 1.0
"""The least rate of a sensor with motion distortion: the past is kept no longer than a second."""


@dataclass(frozen=True, slots=True, eq=False)
class Preset:
    """A range sensor that can be bought: its name, a line about it, where its numbers come from, how it is set."""

    name: str
    description: str
    source: str
    sensor: RangeSensor


Presets = Mapping[str, Preset]


@dataclass(frozen=True, slots=True, eq=False)
class RangeSettings:
    """A range sensor with nothing left unsaid; fields as in `RangeSensor`."""

    pattern: Pattern
    rate_hertz: float
    min_range_meters: float
    max_range_meters: float
    ray_caster: str
    ray_caster_settings: Mapping[str, Any]
    sensor_model: str
    sensor_model_settings: Mapping[str, Any]
    seed: int
    motion_distortion: bool


def range_settings(data: RangeSensor, presets: Presets) -> RangeSettings:
    """Return a range sensor's settings in full.

    Raises UnknownNameError for a preset that there isn't; KernelError for ranges that do not fit together and for a
    rate below 1 Hz with motion distortion.
    """
    base = _preset(data, presets)
    least = _first(data.min_range_meters, base.min_range_meters, 0.0)
    most = _first(data.max_range_meters, base.max_range_meters, DEFAULT_MAX_RANGE_METERS)
    if not least < most:
        raise KernelError(
            f"the sensor measures from {least:g} m to {most:g} m; max_range_meters must be above min_range_meters",
            min_range_meters=least,
            max_range_meters=most,
        )
    rate = data.rate_hertz or base.rate_hertz or DEFAULT_RATE_HERTZ
    distorted = data.motion_distortion or base.motion_distortion
    if distorted and rate < SLOWEST_TURN_HERTZ:
        raise KernelError(
            f"rate_hertz is {rate:g}; with motion_distortion it must be {SLOWEST_TURN_HERTZ:g} or more", rate_hertz=rate
        )
    model_of_base = base.sensor_model or DEFAULT_SENSOR_MODEL
    model = data.sensor_model or model_of_base
    model_settings = data.sensor_model_settings
    if model_settings is None and model == model_of_base:
        model_settings = base.sensor_model_settings
    return RangeSettings(
        pattern=data.pattern or base.pattern or SingleBeam(),
        rate_hertz=rate,
        min_range_meters=least,
        max_range_meters=most,
        ray_caster=data.ray_caster or base.ray_caster or DEFAULT_RAY_CASTER,
        ray_caster_settings=data.ray_caster_settings or {},
        sensor_model=model,
        sensor_model_settings=model_settings or {},
        seed=data.seed,
        motion_distortion=distorted,
    )


def rate_hertz(data: Sensor, presets: Presets) -> float:
    """Return how many readings a second a sensor gives while it runs; raises UnknownNameError for an unknown preset."""
    if isinstance(data, RangeSensor):
        return data.rate_hertz or _preset(data, presets).rate_hertz or DEFAULT_RATE_HERTZ
    return data.rate_hertz or (DEFAULT_MOTION_RATE_HERTZ if isinstance(data, MotionSensor) else DEFAULT_RATE_HERTZ)


def _preset(data: RangeSensor, presets: Presets) -> RangeSensor:
    if not data.preset:
        return RangeSensor()
    if data.preset not in presets:
        raise UnknownNameError("sensor preset", data.preset, presets)
    return presets[data.preset].sensor


def _first(*values: float | None) -> float:
    return next(value for value in values if value is not None)
