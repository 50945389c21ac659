"""The hooks of a plugin: functions that it may have, each called once to register components of one kind, or models.

    from virtualrobot_sdk.hookspecs import hookimpl

    api_version = "1.0"

    @hookimpl
    def virtualrobot_register_kinematics(register):
        register("my_arm", MyArm, MyArmSettings)

The module stands in the entry points of its package: group `virtualrobot.plugins`, name of the plugin = module.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import pluggy

from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind, Isolation

API_VERSION = "1.0"
"""The version of these hooks and of the interfaces of components; a plugin says the one that it was written for."""
ENTRY_POINT_GROUP = "virtualrobot.plugins"
"""Group of entry points in which plugins are found."""
PROJECT = "virtualrobot"

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)
"""Marks a function of a plugin as one that the kernel calls."""

COMPONENT_DEADLINE_SECONDS = 1.0
IMPORTER_DEADLINE_SECONDS = 60.0
DRIVER_DEADLINE_SECONDS = 10.0
PHYSICS_DEADLINE_SECONDS = 10.0


class Register(Protocol):
    """Function that a hook is given to register a component with."""

    def __call__(
        self,
        name: str,
        factory: Callable[..., Any],
        config_type: type | None = None,
        *,
        isolation: Isolation = Isolation.PROCESS,
        deadline_seconds: float = COMPONENT_DEADLINE_SECONDS,
    ) -> None:
        """Register the component `name`.

        Args:
            name: small letters, digits, `_` and `-`, a letter first; unique among the components of its kind.
            factory: makes the component; the first line of its docstring is what people read about it.
            config_type: a frozen dataclass of its settings; the factory gets one as its last argument.
            isolation: the process that it runs in.
            deadline_seconds: the longest that a call may take where it runs in a process of its own.

        Raises:
            PluginError: one of these is not as it must be.
        """
        ...


class RegisterImporter(Protocol):
    """Function that `virtualrobot_register_importers` is given to register an importer with."""

    def __call__(
        self,
        name: str,
        factory: Callable[..., Any],
        endings: Sequence[str],
        config_type: type | None = None,
        *,
        isolation: Isolation = Isolation.PROCESS,
        deadline_seconds: float = IMPORTER_DEADLINE_SECONDS,
    ) -> None:
        """Register the importer `name` of files with one of these endings: `(".stp", ".step")`; the rest as usual.

        Raises:
            PluginError: one of these is not as it must be.
        """
        ...


class RegisterModel(Protocol):
    """Function that `virtualrobot_register_models` is given to make a model known with."""

    def __call__(self, model: Model) -> None:
        """Make `model://NAME` known; the name is unique among the models of all plugins.

        Raises:
            PluginError: a field of the model is not as it must be.
        """
        ...


@hookspec
def virtualrobot_register_kinematics(register: Register) -> None:
    """Register kinematics: `factory(chain)` or `factory(chain, settings)` returns a `kinematics.Kinematics`.

    `chain` is the `kinematics.SerialChain` of the robot; an ArgumentError refuses a robot that the component is not
    made for.
    """


@hookspec
def virtualrobot_register_mobile_kinematics(register: Register) -> None:
    """Register kinematics of crafts: `factory()` or `factory(settings)` returns a `mobile.MobileKinematics`."""


@hookspec
def virtualrobot_register_physics_engines(register: Register) -> None:
    """Register physics engines: `factory()` or `factory(settings)` returns a `physics.PhysicsEngine`."""


@hookspec
def virtualrobot_register_vehicle_dynamics(register: Register) -> None:
    """Register dynamics of vehicles: `factory()` or `factory(settings)` returns a `vehicles.VehicleDynamics`."""


@hookspec
def virtualrobot_register_ray_casters(register: Register) -> None:
    """Register ray casters: `factory()` or `factory(settings)` returns a `rays.RayCaster`."""


@hookspec
def virtualrobot_register_sensor_models(register: Register) -> None:
    """Register sensor models: `factory()` or `factory(settings)` returns a `rays.SensorModel`."""


@hookspec
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Register robot drivers: `factory()` or `factory(settings)` returns a `drivers.Driver`."""


@hookspec
def virtualrobot_register_importers(register: RegisterImporter) -> None:
    """Register importers of files: `factory()` or `factory(settings)` returns an `importers.Importer`."""


@hookspec
def virtualrobot_register_models(register: RegisterModel) -> None:
    """Register models of robots and grippers, `models.Model`, that are asked for by `model://NAME`."""


MODELS_HOOK = virtualrobot_register_models.__name__
"""The hook for models, which are data and no components."""


@dataclass(frozen=True, slots=True)
class KindOfHook:
    """Registration and making of components of one kind."""

    hook: str
    """The function of the plugin that registers them."""
    deadline_seconds: float
    """Deadline of a call (s) where the plugin says none."""
    arguments: tuple[str, ...] = ()
    """Names of the factory's arguments before the settings."""
    has_endings: bool = False
    """True where endings of files are registered too."""


HOOKS = {
    ComponentKind.KINEMATICS: KindOfHook(
        virtualrobot_register_kinematics.__name__, COMPONENT_DEADLINE_SECONDS, arguments=("chain",)
    ),
    ComponentKind.MOBILE_KINEMATICS: KindOfHook(
        virtualrobot_register_mobile_kinematics.__name__, COMPONENT_DEADLINE_SECONDS
    ),
    ComponentKind.PHYSICS_ENGINE: KindOfHook(virtualrobot_register_physics_engines.__name__, PHYSICS_DEADLINE_SECONDS),
    ComponentKind.VEHICLE_DYNAMICS: KindOfHook(
        virtualrobot_register_vehicle_dynamics.__name__, COMPONENT_DEADLINE_SECONDS
    ),
    ComponentKind.RAY_CASTER: KindOfHook(virtualrobot_register_ray_casters.__name__, COMPONENT_DEADLINE_SECONDS),
    ComponentKind.SENSOR_MODEL: KindOfHook(virtualrobot_register_sensor_models.__name__, COMPONENT_DEADLINE_SECONDS),
    ComponentKind.ROBOT_DRIVER: KindOfHook(virtualrobot_register_robot_drivers.__name__, DRIVER_DEADLINE_SECONDS),
    ComponentKind.IMPORTER: KindOfHook(
        virtualrobot_register_importers.__name__, IMPORTER_DEADLINE_SECONDS, has_endings=True
    ),
}
"""Every kind of component; a hook of a plugin that is neither among them nor that for models is refused."""
