"""Check of what range sensors name: devices and components must be there, with settings that these take."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.settings import make_settings

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.sensing.readers import SensingRoom
from virtualrobot_kernel.sensing.settings import range_settings
from virtualrobot_kernel.world.commands import Command, CreateNodes, UpdateNode
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.structure import NodeSpec


def check_choices(commands: Iterable[Command], room: SensingRoom) -> None:
    """Raise KernelError when a range sensor that a command creates or changes names what there isn't.

    Settings are checked where the component's code is loaded; others find out when they are made.
    """
    for command in commands:
        changed = command.specs if isinstance(command, CreateNodes) else [command]
        for one in changed:
            if isinstance(one, NodeSpec | UpdateNode) and isinstance(one.data, RangeSensor):
                settings = range_settings(one.data, room.presets)
                _check(room.catalog, ComponentKind.RAY_CASTER, settings.ray_caster, settings.ray_caster_settings)
                _check(room.catalog, ComponentKind.SENSOR_MODEL, settings.sensor_model, settings.sensor_model_settings)


def _check(catalog: Catalog, kind: ComponentKind, name: str, settings: Mapping[str, Any]) -> None:
    offer = catalog.find(kind, name)
    if offer.register is None:
        return
    try:
        make_settings(offer.register().config_type, settings)
    except ArgumentError as error:
        raise KernelError(f"{kind.value} component {name!r}: {error}") from error
