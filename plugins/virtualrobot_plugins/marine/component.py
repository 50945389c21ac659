"""The components `fossen` and `free_body`: dynamics of vehicles under water, and of crafts in air and space."""

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
from virtualrobot_sdk.vehicles import Carried, Surroundings, VehicleDrive

from virtualrobot_plugins.marine.equations import EULER, LIE, RK4, advance
from virtualrobot_plugins.marine.parameters import Parameters, free_parameters, parameters
from virtualrobot_plugins.marine.vehicle import FreeBody, Vehicle, read_bundled, read_bundled_body

SLACK = 1e-9
"""Part of a limit of a drive by which a command may be beyond it."""
Integrator = Annotated[
    Literal["euler", "rk4", "lie"],
    Meta(description="Euler's method, Runge and Kutta's of order 4, or a midpoint step that keeps momentum."),
]
LongestStep = Annotated[
    float, Meta(ge=1e-5, le=1, description="Longer steps are made in equal parts, none longer than this (s).")
]
METHODS = {"euler": EULER, "rk4": RK4, "lie": LIE}


@dataclass(frozen=True, slots=True)
class FossenSettings:
    """Settings of a vehicle under water."""

    vehicle: Annotated[
        str | Vehicle,
        Meta(description="A bundled vehicle by its name, or all parameters, as a vehicle's file holds them."),
    ] = "bluerov2_heavy"
    integrator: Integrator = "rk4"
    longest_step_seconds: LongestStep = 0.005
    carried_density: Annotated[
        float,
        Meta(
            ge=0,
            le=1e5,
            description="Density (kg/m^3) of what it carries, such as an arm; 0: that of the water, so that it floats.",
        ),
    ] = 0.0


@dataclass(frozen=True, slots=True)
class FreeBodySettings:
    """Settings of a craft in air or space."""

    body: Annotated[
        str | FreeBody,
        Meta(description="A bundled craft by its name, or all parameters, as a craft's file holds them."),
    ] = "hummingbird"
    density: Annotated[
        float, Meta(ge=0, le=1e3, description="Density of the air (kg/m^3), by which drag goes; 0: space, without any.")
    ] = 1.225
    gravity: Annotated[float, Meta(ge=0, le=1e3, description="Gravity, downwards (m/s^2); 0: weightless.")] = 9.80665
    integrator: Integrator = "rk4"
    longest_step_seconds: LongestStep = 0.005


class _RigidVehicle:
    """A rigid body that its drives push through what flows about it; the equations are those of `equations`."""

    def __init__(self, made: Parameters, integrator: str, longest: float, carried_density: float) -> None:
        """Prepare steps; a `carried_density` of 0 is that of the fluid, of infinity one that it doesn't bear."""
        self._parameters = p = made
        self._method = METHODS[integrator]
        self._longest = longest
        self._carried_density = carried_density
        self._alone = p.mass_matrix[None], p.inverse_mass[None], np.zeros((1, 10)), np.zeros((6, 7))
        self._fixed = p.damping, p.hull, p.is_fin, p.drive, p.table_start, p.tables
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
        water = self._about(surroundings)
        steps = max(1, math.ceil(seconds / self._longest - 1e-9))
        carried = surroundings.carried
        masses = self._alone if carried is None else self._loaded(carried, seconds, steps, surroundings.density)
        advance(self._method, pose, velocity, state, told, seconds, steps, water, *masses, *self._fixed)
        return pose, velocity, state

    def _about(self, surroundings: Surroundings) -> Floats:
        """Return current, density, surface and gravity (6,)."""
        return _water(surroundings)

    def _loaded(self, carried: Carried, seconds: float, steps: int, density: float) -> tuple[Floats, ...]:
        """Return mass matrices, inverses, `carried` and `change` of `advance` with what it carries."""
        inertia = _finite(carried.inertia, (2, 6, 6), "the inertia of what is carried")
        momentum = _finite(carried.momentum, (2, 6), "the momentum of what is carried")
        shares = np.linspace(0.0, 1.0, 2 * steps + 1)
        own = inertia[0] + shares[:, None, None] * (inertia[1] - inertia[0])
        whole = self._parameters.mass_matrix + own
        moving = momentum[0] + shares[:, None] * (momentum[1] - momentum[0])
        # Mass and first moment stand in the matrix: m and m times the skew matrix of the centre.
        moments = np.stack([own[:, 0, 0], own[:, 5, 1], -own[:, 5, 0], own[:, 4, 0]], axis=1)
        sinking = 1.0 - density / self._carried_density if self._carried_density else 0.0
        change = np.column_stack([inertia[1] - inertia[0], momentum[1] - momentum[0]]) / seconds
        return whole, np.linalg.inv(whole), np.hstack([moving, sinking * moments]), change

    def _beyond(self, told: Floats) -> ArgumentError:
        i = int(np.flatnonzero((told < self._lowest) | (told > self._highest))[0])
        drive = self.drives[i]
        unit = "rad/s" if drive.quantity.value == "speed" else "rad"
        return ArgumentError(
            f"drive {drive.name} is told {told[i]:g}; it takes {drive.lowest:g} to {drive.highest:g} {unit}",
            drive=drive.name,
            value=told[i],
        )


class FossenDynamics(_RigidVehicle):
    """A vehicle under water after Fossen: added mass, damping, buoyancy, thrusters and fins by tables."""

    def __init__(self, settings: FossenSettings) -> None:
        """Read and check the vehicle; raises ArgumentError that names what is wrong."""
        vehicle = settings.vehicle
        made = parameters(read_bundled(vehicle) if isinstance(vehicle, str) else vehicle)
        super().__init__(made, settings.integrator, settings.longest_step_seconds, settings.carried_density)


class FreeBodyDynamics(_RigidVehicle):
    """A craft in air or space by Newton's and Euler's equations: weight, drag, thrusters and flaps by tables.

    Of its surroundings the current counts, as wind; density and gravity are those of its settings.
    """

    def __init__(self, settings: FreeBodySettings) -> None:
        """Read and check the craft; raises ArgumentError that names what is wrong."""
        body = read_bundled_body(settings.body) if isinstance(settings.body, str) else settings.body
        made = free_parameters(body, settings.density)
        super().__init__(made, settings.integrator, settings.longest_step_seconds, math.inf)
        self._density, self._gravity = settings.density, settings.gravity

    def _about(self, surroundings: Surroundings) -> Floats:
        """Return wind, density, surface and gravity (6,)."""
        air = _water(surroundings)
        air[3], air[5] = self._density, self._gravity
        return air


def _vector(value: Floats, count: int, what: str) -> Floats:
    """Return a copy of an argument, (count,)."""
    return _finite(value, (count,), what)


def _finite(value: Floats, shape: tuple[int, ...], what: str) -> Floats:
    """Return a copy of an argument of this shape."""
    array = np.array(value, dtype=np.float64)
    if array.shape != shape:
        raise ArgumentError(f"{what} has shape {array.shape}; it must be {shape}", shape=array.shape)
    if not np.isfinite(array).all():
        raise ArgumentError(f"{what} is {array.tolist()}; all must be finite")
    return array


def _water(surroundings: Surroundings) -> Floats:
    """Return current, density, surface and gravity (6,)."""
    s = surroundings
    water = np.array([*s.current, s.density, s.surface, s.gravity], dtype=np.float64)
    if water.shape != (6,) or not np.isfinite(water).all() or s.density <= 0.0 or s.gravity < 0.0:
        raise ArgumentError(
            f"the surroundings are {s}; all must be finite, the density above 0 and gravity 0 or more",
        )
    return water
