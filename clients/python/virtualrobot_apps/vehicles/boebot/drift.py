"""Drift of a Boe-Bot's odometry: the same run reckoned by its own encoders, by others, and with a wheel taken amiss."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from virtualrobot.robots.robot import Robot
from virtualrobot.sensors.motion_sensors import EncoderReading

from virtualrobot_apps.vehicles.boebot.cockpit import RADIUS, TRACK

ENCODED = 64
"""Counts a turn of the encoders that the robot has."""
OTHERS = (8, 64, 360)
"""Counts a turn of encoders that are compared."""
LARGER = 1.005
"""Factor of a wheel that a program takes for larger than it is."""
AS_TOLD = f"{ENCODED} counts a turn, as told"
TRUE = "true angles"
"""Of the odometry by the encoders' readings, and of that by the joints themselves."""


class Drift:
    """Reckons a run in several ways, each by `Robot.odometry`, once it is over."""

    def __init__(self, robot: Robot, encoders: EncoderReading) -> None:
        """Begin where the robot is, its encoders as they were read."""
        amiss = {
            "track_meters": TRACK,
            "wheel_radius_meters": RADIUS,
            "right_wheel_radius_meters": LARGER * RADIUS,
        }
        self._told = robot.odometry(encoders=encoders)
        self._others = {f"{counts} counts a turn": robot.odometry(counts_per_turn=counts) for counts in OTHERS}
        self._others |= {TRUE: robot.odometry(), "right wheel taken 0.5% larger": robot.odometry(settings=amiss)}

    def reckon(self, encoders: Sequence[EncoderReading], true: Sequence[EncoderReading]) -> NDArray[np.float64]:
        """Go on to where the robot is, by what its encoders told (n of them) and where its wheels truly were then.

        Return x, y (m) and heading (rad) (n, 3) by its encoders, in the robot's frame.
        """
        for odometry in self._others.values():
            odometry.reckon(true)
        return self._told.reckon(encoders)

    def off(self) -> dict[str, NDArray[np.float64]]:
        """Return by name how far each is off the true pose by now: x, y (m) and heading (rad), shape (3,)."""
        return {name: odometry.drift() for name, odometry in ({AS_TOLD: self._told} | self._others).items()}


def drift_rows(off: Mapping[str, Sequence[float] | NDArray[np.float64]]) -> list[str]:
    """Return the lines of a table: how far each odometry is off the true pose, and how far turned."""
    rows = [f"{'odometry in the end':32} {'off by':>14} {'turned by':>14}"]
    for name, (x, y, turn) in off.items():
        rows.append(f"{name:32} {1e3 * math.hypot(x, y):>11.1f} mm {math.degrees(turn):>12.2f} °")
    return rows
