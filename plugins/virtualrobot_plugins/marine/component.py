"""The component `fossen`: dynamics of vehicles under water after Fossen."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.arguments import rigid_target
from virtualrobot_sdk.compiled.cache import make_ready
from virtualrobot_sdk.compiled.rigid import orthonormalise
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.vehicles import Surroundings, VehicleDrive

from virtualrobot_plugins.marine.equations import EULER, LIE, RK4, advance
from virtualrobot_plugins.marine.parameters import parameters
from virtualrobot_plugins.marine.vehicle import Vehicle, read_bundled

SLACK = 1e-9
"""Part of a limit of a drive by which a command may be beyond it."""
METHODS = {"euler": EULER, "rk4": RK4, "lie": LIE}


@dataclass(frozen=True, slots=True)
class FossenSettings:
    """Settings of a vehicle under water."""

    vehicle: Annotated[
        str | Vehicle,
        Meta(description="A bundled vehicle by its name, or all parameters, as a vehicle's file holds them."),
    ] = "bluerov2_heavy"
    integrator: Annotated[
        Literal["euler", "rk4", "lie"],
        Meta(description="Euler's method, Runge and Kutta's of order 4, or a midpoint step that keeps momentum."),
    ] = "rk4"
    longest_step_seconds: Annotated[
        float, Meta(gt=0, le=1, description="Longer steps are made in equal parts, none longer than this (s).")
    ] = 0.005


class FossenDynamics:
    """A vehicle under water after Fossen: added mass, damping, buoyancy, thrusters and fins by tables."""

    def __init__(self, settings: FossenSettings) -> None:
        """Read and check the vehicle; raises ArgumentError that names what is wrong."""
        vehicle = settings.vehicle
        self._parameters = parameters(read_bundled(vehicle) if isinstance(vehicle, str) else vehicle)
        self._method = METHODS[settings.integrator]
        self._longest = settings.longest_step_seconds
        p = self._parameters
        self._fixed = p.mass_matrix, p.inverse_mass, p.damping, p.hull, p.is_fin, p.drive, p.table_start, p.tables
        # A command that was reckoned from another unit may be off by rounding.
        self._lowest = np.array([drive.lowest - SLACK * abs(drive.lowest) for drive in p.drives])
        self._highest = np.array([drive.highest + SLACK * abs(drive.highest) for drive in p.drives])
        make_ready()

    @property
    def drives(self) -> tuple[VehicleDrive, ...]:
        """Return the thrusters, then the fins."""
        return self._parameters.drives

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
        """Return pose, twist and states of drives after `seconds`; the error of integration is the integrator's."""
        pose = rigid_target(world_t_base, orthonormalise)
        velocity = _vector(twist, 6, "twist")
        state = _vector(drive_states, len(self.drives), "drive_states")
        told = _vector(commands, len(self.drives), "commands")
        if (told < self._lowest).any() or (told > self._highest).any():
            raise self._beyond(told)
        if not 0.0 < seconds < math.inf:
            raise ArgumentError(f"seconds is {seconds}; it must be a finite number above 0", seconds=seconds)
        water = _water(surroundings)
        steps = max(1, math.ceil(seconds / self._longest - 1e-9))
        advance(self._method, pose, velocity, state, told, seconds, steps, water, *self._fixed)
        return pose, velocity, state

    def _beyond(self, told: Floats) -> ArgumentError:
        i = int(np.flatnonzero((told < self._lowest) | (told > self._highest))[0])
        drive = self.drives[i]
        unit = "rad/s" if drive.quantity.value == "speed" else "rad"
        return ArgumentError(
            f"drive {drive.name} is told {told[i]:g}; it takes {drive.lowest:g} to {drive.highest:g} {unit}",
            drive=drive.name,
            value=told[i],
        )


def _vector(value: Floats, count: int, what: str) -> Floats:
    """Return a copy of an argument, (count,)."""
    vector = np.array(value, dtype=np.float64)
    if vector.shape != (count,):
        raise ArgumentError(f"{what} has shape {vector.shape}; it must be ({count},)", shape=vector.shape)
    if not np.isfinite(vector).all():
        raise ArgumentError(f"{what} is {vector.tolist()}; all must be finite")
    return vector


def _water(surroundings: Surroundings) -> Floats:
    """Return current, density, surface and gravity (6,)."""
    s = surroundings
    water = np.array([*s.current, s.density, s.surface, s.gravity], dtype=np.float64)
    if water.shape != (6,) or not np.isfinite(water).all() or s.density <= 0.0 or s.gravity < 0.0:
        raise ArgumentError(
            f"the surroundings are {s}; all must be finite, the density above 0 and gravity 0 or more",
        )
    return water
