"""Scans of a range sensor of two or three dimensions, as surveillance compares them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.sensors.range_sensors import RangeReading

from virtualrobot_apps.seeing.given import finite

Floats = NDArray[np.float64]

FEWEST = 200
"""Fewest echoes of a scan that can be compared."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Scan: points (n, 3) in the frame of its sensor (m), and world_t_sensor (4, 4) as the robot has it."""

    points: Floats
    world_t_sensor: Floats

    def __post_init__(self) -> None:
        """Raise InvalidArgumentError for too few echoes, and for numbers that are not finite."""
        finite(self.points, 3, "points of the scan")
        if np.shape(self.world_t_sensor) != (4, 4) or not np.isfinite(self.world_t_sensor).all():
            raise InvalidArgumentError("world_t_sensor is a pose (4, 4) of finite numbers")
        if len(self.points) < FEWEST:
            raise InvalidArgumentError(f"the scan has {len(self.points)} echoes, and {FEWEST} at least are needed")


def scan_of(reading: RangeReading, world_t_sensor: Floats) -> Scan:
    """Return the scan of a reading that was asked for with its points in the frame of the sensor."""
    if reading.points is None or reading.frame != "sensor":
        raise InvalidArgumentError("the reading has no points in its sensor's frame: read(points=True, frame='sensor')")
    points = np.asarray(reading.points, np.float64)[reading.valid]
    return Scan(points[np.isfinite(points).all(axis=1)], np.asarray(world_t_sensor, np.float64))
