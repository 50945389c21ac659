"""Interface of vehicle dynamics: the motion of a body with six velocities by its drives, in water or another medium."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from virtualrobot_sdk.kinematics import Floats


class DriveQuantity(Enum):
    """Quantity of a drive that follows its command."""

    SPEED = "speed"
    """Speed of a turning joint (rad/s), as of a propeller."""
    POSITION = "position"
    """Angle of a turning joint (rad), as of a fin."""


@dataclass(frozen=True, slots=True)
class VehicleDrive:
    """Drive of a vehicle, such as a thruster or a fin; its values are in rad/s or rad, by `quantity`."""

    name: str
    """Name among the drives of the vehicle, that of its joint."""
    quantity: DriveQuantity
    """Quantity that its command and its state are of."""
    lowest: float
    """Least command."""
    highest: float
    """Greatest command, above the least."""


@dataclass(frozen=True, slots=True, eq=False)
class Carried:
    """Bodies that move with a vehicle beside what it is itself, such as an arm, at the start and the end of a step.

    Both are about the origin of the base and along its axes; in between they change evenly.
    """

    inertia: Floats
    """(2, 6, 6) mass matrices of the bodies as if they were rigid with the base: kg, kg m, kg m^2."""
    momentum: Floats
    """(2, 6) linear (kg m/s) and angular momentum (kg m^2/s) by their movement against the base alone."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Medium about a vehicle, the same within one step everywhere, and what it carries; axes are the world's, z up."""

    current: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Velocity of the water (m/s)."""
    density: float = 1000.0
    """Density of the water (kg/m^3), above 0."""
    surface: float = 0.0
    """Height of the water's surface (m); above it nothing floats."""
    gravity: float = 9.80665
    """Acceleration of gravity (m/s^2), downwards, 0 or more."""
    carried: Carried | None = None
    """Bodies that it carries; None: none. Their momentum with that of the vehicle changes by outer forces alone.
    Dynamics that know of no such thing leave them out."""


class VehicleDynamics(Protocol):
    """The dynamics of one vehicle with m drives; poses are 4x4 in the world, z up.

    The frame of the base has x forward, y to the left and z up. A twist (6,) is the velocity of the base against the
    world along the base's own axes: linear (m/s), then angular (rad/s). Calls depend on nothing but their arguments.
    """

    @property
    def drives(self) -> tuple[VehicleDrive, ...]:
        """Return the m drives, one at least, in the order of all arrays."""
        ...

    def step(
        self,
        world_t_base: Floats,
        twist: Floats,
        drive_states: Floats,
        commands: Floats,
        seconds: float,
        surroundings: Surroundings,
        /,
    ) -> tuple[Floats, Floats, Floats]:
        """Return pose (4, 4), twist (6,) and drives (m,) after `seconds`, the drives told `commands` (m,) all the time.

        States of drives go towards their commands and never past them. Two steps of half the time come to the same as
        one, but for the error of integration that the component documents. A vehicle that is shifted, or turned about
        the vertical, moves alike when current and surface are too; in water that flows evenly it moves as in still
        water that is carried along. Raises ArgumentError for other shapes, for values that are not finite, for commands
        beyond a drive's range, for a pose that is not rigid, for a time or density that is not above 0 and for a
        gravity below 0.
        """
        ...
