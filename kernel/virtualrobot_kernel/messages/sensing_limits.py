"""Limits of the settings of sensors and lights: each check says what is wrong and what would be right."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.values import GREATEST
from virtualrobot_kernel.world import sensing
from virtualrobot_kernel.world.sensing import ImageKind, Projection

MOST_BEAMS = 2_000_000
"""The most beams of a range sensor."""
MOST_PIXELS = 16_000_000
"""The most pixels of a camera."""
BRIGHTEST = 1e9
"""The greatest intensity of a light."""
MURKIEST = 1000.0
"""The greatest attenuation of light (1/m)."""
FASTEST = 10_000.0
"""The greatest rate in hertz; nothing reads more than once a tick."""
SLOWEST = 1e-6
"""The least rate in hertz: a reading in 12 days."""
FINEST = 1e-30
"""The least step of numbers, in any unit: numbers divided by it stay numbers."""


def _refuse(what: str, text: str, **metadata: float) -> None:
    raise KernelError(f"{what} {text}", reason=Reason.INVALID_ARGUMENT, field=what, **metadata)


def _count(value: int, what: str) -> None:
    if not 1 <= value <= MOST_BEAMS:
        _refuse(what, f"must be 1 to {MOST_BEAMS:,}, not {value:,}", value=value)


def _rate(data: Any, what: str) -> None:  # noqa: ANN401 any sensor
    rate = data.rate_hertz
    if rate and not SLOWEST <= rate <= FASTEST:
        _refuse(f"{what}.rate_hertz", f"must be {SLOWEST:g} to {FASTEST:g}, or 0, not {rate:g}", value=rate)


def _fan(data: sensing.Fan | sensing.Ring, what: str) -> None:
    _count(data.count, f"{what}.count")
    turn = data.end_angle_radians - data.start_angle_radians
    if abs(turn) > 2.0 * math.pi + 1e-9:
        _refuse(what, f"goes over {math.degrees(turn):.6g} degrees; a full turn is the most")


def _spinning(data: sensing.Spinning, what: str) -> None:
    _count(data.columns, f"{what}.columns")
    _count(data.columns * len(data.elevations_radians), f"{what}: columns times elevations")
    if steep := [one for one in data.elevations_radians if abs(one) >= math.pi / 2]:
        _refuse(f"{what}.elevations_radians", f"must be between -pi/2 and pi/2, not {steep[0]:g}", value=steep[0])


def _raster(data: sensing.Raster, what: str) -> None:
    _count(data.columns * data.rows, f"{what}: columns times rows")
    wide, high = data.horizontal_field_radians, data.vertical_field_radians
    if wide > 2.0 * math.pi or high >= math.pi:
        _refuse(what, f"may be a full turn wide and less than half a turn high, not {wide:g} x {high:g} rad")


def _free(data: sensing.FreeBeams, what: str) -> None:
    _count(len(data.directions), f"{what}: the number of directions")
    short = np.flatnonzero(~(np.abs(data.directions).max(axis=1) > 1e-9))
    if len(short):
        _refuse(f"{what}.directions", f"row {short[0]} is zero; a direction has a length", row=int(short[0]))
    if data.origins is None:
        return
    if len(data.origins) != len(data.directions):
        _refuse(f"{what}.origins", f"has {len(data.origins)} rows for {len(data.directions)} directions; give as many")
    if (far := np.flatnonzero(np.abs(data.origins).max(axis=1) > GREATEST)).size:
        _refuse(f"{what}.origins", f"must be within {GREATEST:g} m; row {far[0]} is not", row=int(far[0]))


def _range(data: sensing.RangeSensor, what: str) -> None:
    _rate(data, what)
    if data.max_range_meters is not None and not (data.min_range_meters or 0.0) < data.max_range_meters:
        least = data.min_range_meters or 0.0
        _refuse(f"{what}.max_range_meters", f"must be above the least range {least:g}, not {data.max_range_meters:g}")


def _camera(data: sensing.CameraSensor, what: str) -> None:
    _rate(data, what)
    if (data.width or 640) * (data.height or 480) > MOST_PIXELS:
        _refuse(what, f"has {data.width} x {data.height} pixels; at most {MOST_PIXELS:,} are taken")
    if data.intrinsics and data.horizontal_field_radians:
        _refuse(what, "says its intrinsics and its field of view; give one")
    eye = data.intrinsics
    if eye and not (eye.fx > 0.0 and eye.fy > 0.0):
        _refuse(f"{what}.intrinsics", f"needs focal lengths above 0, not {eye.fx:g}, {eye.fy:g}")
    widest = math.pi if data.projection is Projection.PINHOLE else 2.0 * math.pi + 1e-9
    if data.horizontal_field_radians >= widest:
        _refuse(
            f"{what}.horizontal_field_radians", f"must be below {widest:.6g}, not {data.horizontal_field_radians:g}"
        )
    counts = {Projection.PINHOLE: (0, 4, 5, 8), Projection.FISHEYE: (0, 4), Projection.SPHERICAL: (0,)}
    if len(data.distortion) not in counts[data.projection]:
        valid = " or ".join(map(str, counts[data.projection]))
        _refuse(f"{what}.distortion", f"has {len(data.distortion)} coefficients; {valid} are known for this projection")
    near, far = data.near_meters or 0.01, data.far_meters or 100.0
    if not near < far:
        _refuse(f"{what}.far_meters", f"must be above near_meters ({near:g}), not {far:g}")
    if len(set(data.images)) != len(data.images):
        names = ", ".join(kind.name for kind in ImageKind)
        _refuse(f"{what}.images", f"names a kind twice; give each of {names} once")
    taken = data.water_attenuation_per_meter
    if taken is not None and not 0.0 <= min(taken) <= max(taken) <= MURKIEST:
        _refuse(f"{what}.water_attenuation_per_meter", f"must be 0 to {MURKIEST:g} in each colour, not {list(taken)}")
    if data.water_color is not None and taken is None:
        _refuse(f"{what}.water_color", "is of no water; give water_attenuation_per_meter, too")


def _contact(data: sensing.ContactSensor, what: str) -> None:
    _rate(data, what)
    if data.region_size is not None and min(data.region_size) <= 0.0:
        _refuse(f"{what}.region_size", f"must have edges above 0, not {list(data.region_size)}")


def _noise(data: sensing.NoiseModel, what: str) -> None:
    if 0.0 < data.resolution < FINEST:
        _refuse(f"{what}.resolution", f"must be at least {FINEST:g}, or 0, not {data.resolution:g}")


def _light(data: sensing.Light, what: str) -> None:
    if data.cone_angle_radians > math.pi / 2:
        _refuse(f"{what}.cone_angle_radians", f"must be at most pi/2, not {data.cone_angle_radians:g}")
    if data.intensity > BRIGHTEST:
        _refuse(f"{what}.intensity", f"must be at most {BRIGHTEST:g}, not {data.intensity:g}", value=data.intensity)


CHECKS: dict[type, Callable[[Any, str], None]] = {
    sensing.Fan: _fan,
    sensing.Ring: _fan,
    sensing.Spinning: _spinning,
    sensing.Raster: _raster,
    sensing.FreeBeams: _free,
    sensing.RangeSensor: _range,
    sensing.CameraSensor: _camera,
    sensing.ContactSensor: _contact,
    sensing.MotionSensor: _rate,
    sensing.NoiseModel: _noise,
    sensing.Light: _light,
}
"""The check of each class that has one; `what` names it in errors."""
