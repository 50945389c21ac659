"""Gazebo's lasers and sonars as range sensors."""

from __future__ import annotations

import base64
import math

import numpy as np

from virtualrobot_sdk.gazebo.tags import (
    BadTagError,
    Element,
    Noise,
    Values,
    Warn,
    child,
    count,
    noise,
    not_negative,
    number,
    said,
)

_FARTHEST = 1e6
"""Range that stands for an infinite one (m)."""


def lidar(sensor: Element, warn: Warn) -> Values:
    """Return the range sensor of a <ray> or <lidar>: its scan, its range, its noise as the model `laser`."""
    ray = next((found for name in ("lidar", "ray") if (found := child(sensor, name)) is not None), None)
    if ray is None:
        raise BadTagError(sensor, "it has neither <ray> nor <lidar>")
    found = child(ray, "noise")
    return _range_sensor(
        _pattern(ray), child(ray, "range"), ("min", "max", "resolution"), noise(found, warn), found, warn
    )


def old_lidar(sensor: Element, warn: Warn) -> Values:
    """Return the range sensor of a <sensor:ray> of Gazebo before 1.0."""
    beams = count(sensor, "rayCount", default=1)
    start, end = (old_angle(sensor, name) for name in ("minAngle", "maxAngle"))
    spread = Noise(deviation=not_negative(sensor, "gaussianNoise"))
    return _range_sensor(_fan(beams, start, end), sensor, ("minRange", "maxRange", "resRange"), spread, sensor, warn)


def sonar(sensor: Element, warn: Warn) -> Values:
    """Return the range sensor of a <sonar>: one cone, by the model `ultrasonic`."""
    tag = child(sensor, "sonar")
    if tag is None:
        raise BadTagError(sensor, "it has no <sonar>")
    least, most = not_negative(tag, "min"), not_negative(tag, "max")
    radius = not_negative(tag, "radius")
    values = said(pattern={"beam": {}}, min_range_meters=least, max_range_meters=most, sensor_model="ultrasonic")
    settings: Values = {"detection_range_meters": most} if most else {}
    if radius and most:
        settings["half_angle_radians"] = min(math.atan(radius / most), 1.2)
    return {**values, "sensor_model_settings": settings}


def old_angle(sensor: Element, name: str) -> float:
    """Return an angle of a tag before 1.0 in radians.

    Gazebo took degrees there and others took radians; what is more than a turn of radians is degrees.
    """
    angle = number(sensor, name)
    if not math.isfinite(angle):
        raise BadTagError(child(sensor, name), f"<{name}> is {angle:g}, which is no angle")
    return math.radians(angle) if abs(angle) > 2.0 * math.pi else angle


def _range_sensor(
    pattern: Values,
    reach: Element | None,
    names: tuple[str, str, str],
    spread: Noise,
    named_by: Element,
    warn: Warn,
) -> Values:
    least, most, resolution = (number(reach, name) for name in names)
    if not (0.0 <= least < math.inf and 0.0 <= most and 0.0 <= resolution < math.inf):
        raise BadTagError(reach, f"the range {least:g} to {most:g} m in steps of {resolution:g} m is none")
    values = said(pattern=pattern, min_range_meters=least, max_range_meters=min(most, _FARTHEST))
    if spread.bias_mean or spread.bias_deviation or spread.bias_walk:
        warn(named_by, "the bias of the noise is left out; a mean is taken")
    if spread.deviation or spread.mean or resolution:
        values["sensor_model"] = "laser"
        # Gazebo's noise is the same at each distance and angle.
        values["sensor_model_settings"] = {
            "deviation_meters": spread.deviation,
            "noise_limit": "none",
            "resolution_meters": max(resolution, spread.precision),
            **said(bias_meters=spread.mean),
        }
    return values


def _pattern(ray: Element) -> Values:
    """Return the beams of a <scan>: first and last angle are both cast, as in Gazebo."""
    scan = child(ray, "scan")
    columns, start, end = _steps(child(scan, "horizontal"))
    rows, low, high = _steps(child(scan, "vertical"))
    if rows == 1 and low == 0.0:
        return _fan(columns, start, end)
    step = (end - start) / max(columns - 1, 1)
    elevations = np.linspace(low, high, rows) if rows > 1 else np.array([low])
    around = 2.0 * math.pi / step if step else 0.0
    if abs(start + math.pi) < 1e-3 and columns - 1.001 < around < columns + 0.001:
        # The last beam of a full turn is its first again.
        return {"spinning": {"columns": round(around), "elevations_radians": elevations.tolist()}}
    if rows * columns > 2_000_000:
        raise BadTagError(scan, f"it has {rows * columns:,} beams; at most 2,000,000 are cast")
    up, turned = np.meshgrid(elevations, np.linspace(start, end, columns), indexing="ij")
    directions = np.stack([np.cos(up) * np.cos(turned), np.cos(up) * np.sin(turned), np.sin(up)], axis=-1)
    data = np.ascontiguousarray(directions.reshape(-1, 3), "<f4").tobytes()
    array = {
        "type": "NUMERIC_TYPE_FLOAT32",
        "shape": [rows * columns, 3],
        "data": base64.b64encode(data).decode("ascii"),
    }
    return {"free": {"directions": array}}


def _steps(axis: Element | None) -> tuple[int, float, float]:
    """Return how many beams an axis has and the angles of the first and the last."""
    beams = count(axis, "samples") * not_negative(axis, "resolution", default=1.0)
    start, end = number(axis, "min_angle"), number(axis, "max_angle")
    if not (math.isfinite(start) and math.isfinite(end) and start <= end):
        raise BadTagError(axis, f"the angles go from {start:g} to {end:g}")
    return max(round(beams), 1), start, end


def _fan(beams: int, start: float, end: float) -> Values:
    if beams == 1:
        start = end = 0.5 * (start + end)
        if start == 0.0:
            return {"beam": {}}
    end = min(end, start + 2.0 * math.pi)
    return {"fan": {"count": beams, "start_angle_radians": start, "end_angle_radians": end}}
