"""Control of a vehicle's velocity over ground and of its heading by the masses of its file."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from virtualrobot_apps.vehicles.guidance import Floats, Wanted
from virtualrobot_apps.vehicles.vehicle_file import VehicleFile


@dataclass(frozen=True)
class Gains:
    """Rates (1/s) at which errors go: of the velocity, of its integral, and of the heading."""

    velocity: float = 4.0
    integral: float = 1.0
    heading: float = 1.2
    """Both rates of a second-order system, critically damped."""
    tilt: float = 3.5
    """The same of roll and pitch: a hull that is broader than long to the water turns across it where nothing holds it
    (Munk's moment), by more than its weight rights it."""


class Autopilot:
    """Owns the integral of the velocity's error, which comes to be what currents and buoyancy ask for."""

    def __init__(self, vehicle: VehicleFile, gains: Gains | None = None) -> None:
        """Take a vehicle's masses and thrusters."""
        self._vehicle = vehicle
        self._gains = gains or Gains()
        self._integral = np.zeros(3)

    def speeds(self, wanted: Wanted, rotation: Floats, twist: Floats, seconds: float) -> Floats:
        """Return the speeds of the thrusters (m,) (rad/s).

        `rotation` (3, 3) is that of the base in the world, `twist` (6,) its velocity over ground along its own axes
        (m/s, rad/s); `seconds` have gone since the call before.
        """
        gains, masses = self._gains, self._vehicle.masses
        # The integral is kept along the world's axes, where a current is; it stops at what the thrusters can give.
        error = wanted.velocity - rotation @ twist[:3]
        self._integral = np.clip(self._integral + gains.integral * seconds * error, -1.0, 1.0)
        force = masses[:3] * (rotation.T @ (gains.velocity * (error + self._integral)))
        heading = math.atan2(rotation[1, 0], rotation[0, 0])
        off = math.remainder(wanted.heading - heading, 2.0 * math.pi)
        yaw = masses[5] * gains.heading * (gains.heading * off - 2.0 * twist[5])
        # The way from the vehicle's own upward axis to the vertical, about its x and y.
        lean = np.array([rotation[2, 1], -rotation[2, 0]])
        tilt = -masses[3:5] * gains.tilt * (gains.tilt * lean + 2.0 * twist[3:5])
        return self._vehicle.thrusters.speeds(np.array([*force, *tilt, yaw]))
