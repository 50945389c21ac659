"""Geometry of scans: what the distances of a range sensor are measured along, and how far."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot._wire.services import Services
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.recording import topics
from virtualrobot.streams.table import settings_of
from virtualrobot.v1 import scene_pb2

_MOST_METERS, _RATE_HERTZ = 10.0, 10.0
"""Range and rate of sensors whose settings don't say them; the contract says these."""


@dataclass(frozen=True, slots=True)
class ScanGeometry:
    """Geometry of a range sensor's readings.

    Attributes:
        angles: those of the first and the last beam about z, from x towards y, where all beams are in the plane z = 0
            and begin in one point; None where readings are clouds.
        single: True for one beam along x.
        least: least distance that it measures (m).
        most: greatest distance (m).
        rate: readings a second of simulation time, while it reads.
        model: component that makes readings of true hits, such as `laser` or `ultrasonic`.
    """

    angles: tuple[float, float] | None
    single: bool
    least: float
    most: float
    rate: float
    model: str


def scan_geometry(services: Services, sensor: str) -> ScanGeometry:
    """Return the geometry of a range sensor, by itself or by its device; raises InvalidArgumentError for others."""
    node = services.scene.GetScene(scene_pb2.GetSceneRequest(names=[sensor])).nodes[0]
    if not node.HasField("range_sensor"):
        raise InvalidArgumentError(f"{sensor} is no range sensor")
    own, device = settings_of(services, node.range_sensor)
    pattern = own.pattern if own.HasField("pattern") else device.pattern
    least = own.min_range_meters if own.HasField("min_range_meters") else device.min_range_meters
    most = next((one.max_range_meters for one in (own, device) if one.HasField("max_range_meters")), _MOST_METERS)
    return ScanGeometry(
        topics.scan_angles(pattern),
        pattern.WhichOneof("pattern") in (None, "beam"),
        least,
        most,
        own.rate_hertz or device.rate_hertz or _RATE_HERTZ,
        own.sensor_model or device.sensor_model or "ideal",
    )
