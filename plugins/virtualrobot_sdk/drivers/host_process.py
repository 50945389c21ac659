"""Host of a driver as a worker process has it."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from virtualrobot_sdk.drivers.driver import Driver
from virtualrobot_sdk.drivers.host import ORPHAN_SECONDS, Host
from virtualrobot_sdk.drivers.robot_side import RobotSide
from virtualrobot_sdk.drivers.shared import CellBlock, TickRing
from virtualrobot_sdk.errors import PluginError
from virtualrobot_sdk.registration import ComponentKind


def make_host(
    entry_point: tuple[str, str, str],
    component: str,
    settings: Mapping[str, Any],
    side: RobotSide,
    ring: Path,
    cell: Path,
) -> Host:
    """Make the host of a plugin's driver, in the process of a worker; connected to nothing yet.

    Raises ArgumentError for settings that the driver refuses, and PluginError where the plugin has no such driver.
    """
    from virtualrobot_sdk.loading import load
    from virtualrobot_sdk.worker import child
    from virtualrobot_sdk.worker.host import factory_of

    child.ORPHAN_SECONDS = ORPHAN_SECONDS
    _, registrations, _ = load(EntryPoint(*entry_point))
    driver = factory_of(registrations, entry_point[0], ComponentKind.ROBOT_DRIVER, component, settings)()
    if not isinstance(driver, Driver):
        name = type(driver).__name__
        raise PluginError(f"{component!r} made a {name}; a driver is a virtualrobot_sdk.drivers.Driver")
    host = Host(driver, side, TickRing.attach(ring, len(side.joints)), CellBlock.attach(cell))
    host.start()
    return host
