"""Locations: those of the arm, copies, shifts, the tool, and what is shown of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from virtualrobot_apps.languages.rapl.faults import RaplFault
from virtualrobot_apps.languages.rapl.locations import Location, pose_of, values_of
from virtualrobot_apps.languages.rapl.table import command

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapl.task import RaplTask


@command("HERE", "new_location")
def _here(task: RaplTask, name: str) -> None:
    """Keeps where the arm has been sent as a location; with # as a precision point."""
    task.locations[name] = task.world.located(name, task.world.joints())


@command("ACTUAL", "new_location")
def _actual(task: RaplTask, name: str) -> None:
    """Keeps where the arm is, at this moment, as a location."""
    task.locations[name] = task.world.located(name, task.world.actual())


@command("SET", "new_location [=] location")
def _set(task: RaplTask, name: str, equals: str, other: str) -> None:
    """Gives a location the value of another one of its kind."""
    value = task.location(other)
    if value.is_precision != name.startswith("#"):
        raise RaplFault(f"{name} and {other} must both be cartesian, or both precision points")
    task.locations[name] = Location(name, value.values)


@command("SHIFT", "location number number number")
def _shift(task: RaplTask, name: str, x: float, y: float, z: float) -> None:
    """Shifts a cartesian location by so far (mm) along x, y and z of the base."""
    _shifted(task, name, (x, y, z, 0.0, 0.0, 0.0))


@command("SHIFTA", "location number number number number number number")
def _shift_all(task: RaplTask, name: str, x: float, y: float, z: float, yaw: float, pitch: float, roll: float) -> None:
    """Adds to all components of a cartesian location: mm, and degrees of yaw, pitch and roll."""
    _shifted(task, name, (x, y, z, yaw, pitch, roll))


def _shifted(task: RaplTask, name: str, by: tuple[float, ...]) -> None:
    location = task.location(name)
    if location.is_precision:
        raise RaplFault(f"{name} is a precision point, and only cartesian locations are shifted")
    task.locations[name] = Location(name, tuple(a + b for a, b in zip(location.values, by, strict=True)))


@command("TOOL", "location")
def _tool(task: RaplTask, name: str) -> None:
    """Takes a cartesian location as the place of the tool's tip on the flange from now on; the arm stands meanwhile."""
    location = task.location(name)
    if location.is_precision:
        raise RaplFault(f"{name} is a precision point, and a tool is a cartesian location")
    task.world.use_tool(pose_of(location.values))


@command("DLOCN", "location...")
def _forget(task: RaplTask, names: list[str]) -> None:
    """Forgets locations."""
    for name in names:
        task.locations.pop(name, None)


@command("LISTL", "[location]")
def _list(task: RaplTask, name: str | None) -> None:
    """Shows a location, or all."""
    for location in [task.location(name)] if name else task.locations.values():
        task.write(str(location))


@command("W0")
def _commanded(task: RaplTask) -> None:
    """Shows where the arm has been sent: pulses, degrees, and the tool's place."""
    _show(task, task.world.joints())


@command("W2")
def _position(task: RaplTask) -> None:
    """Shows where the arm is at this moment, as W0 does."""
    _show(task, task.world.actual())


def _show(task: RaplTask, joints: np.ndarray) -> None:
    world = values_of(task.world.place_at(joints))
    task.write("PULSES " + " ".join(f"{value:+.0f}" for value in task.world.pulses * np.degrees(joints)))
    task.write("JOINTS " + " ".join(f"{value:+.4f}" for value in np.degrees(joints)))
    task.write("WORLD " + " ".join(f"{value:+.4f}" for value in world))
