"""Mappings of devices from files: what drives a craft, moves a joint, a tool or a page's view, and what is held.

schema_version: 1
hold: right_shoulder
drive: {forward: -left_y, turn: -right_x, left: [dpad_left, dpad_right]}
jog: {1: left_x, 2: -left_y}
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from virtualrobot.cli import space_mouse
from virtualrobot.cli.felt_force import ForceMapping
from virtualrobot.cli.gamepad import AXES, BUTTONS, PadState
from virtualrobot.errors import MalformedFileError, MissingFileError

DIRECTIONS = ("forward", "left", "turn")
"""Parts of a craft's twist, in its order."""
TOOL = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Parts of a tool's twist, in its order."""
FRAMES = ("base", "tool", "world")
"""Frames in which a tool's twist may be, beside those of nodes."""
CAMERA = ("right", "up", "nearer", "turn", "tilt")
"""Ways in which a page's view moves: along the picture, to what is looked at, around it to the right, and over it."""
USUAL = Path(__file__).with_name("gamepad.yaml")
"""Mapping that is taken where none is named."""
USUAL_SPACE_MOUSE = Path(__file__).with_name("space_mouse.yaml")
"""The same of a space mouse."""


USUAL_KEYBOARD = Path(__file__).with_name("keyboard.yaml")
"""The same of a page's keyboard."""


class Device(NamedTuple):
    """Names that a mapping may use of a device: those of its axes and its buttons."""

    axes: tuple[str, ...]
    buttons: tuple[str, ...]


GAMEPAD = Device(AXES, BUTTONS)
SPACE_MOUSE = Device(space_mouse.AXES, space_mouse.BUTTONS)
KEYBOARD = Device(
    (), (*"1234567890", *"qwertyuiopasdfghjklzxcvbnm", "shift", "arrow_up", "arrow_down", "arrow_left", "arrow_right")
)
"""Keys by what stands on them in the layout of the United States, wherever other layouts have it."""


@dataclass(frozen=True)
class Control:
    """Axis with its sign, or two buttons, that give a value from -1 to 1."""

    axis: str = ""
    sign: float = 1.0
    buttons: tuple[str, str] = ("", "")
    """That for 1, and that for -1."""

    def value(self, state: PadState, dead_zone: float) -> float:
        """Return its value: 0 within the dead zone, from there on growing to 1."""
        if not self.axis:
            plus, minus = (float(one in state.buttons) for one in self.buttons)
            return plus - minus
        moved = state.axes.get(self.axis, 0.0)
        beyond = max(0.0, min(1.0, (abs(moved) - dead_zone) / (1.0 - dead_zone)))
        return self.sign * math.copysign(beyond, moved) if beyond else 0.0


@dataclass(frozen=True)
class GamepadMapping:
    """Meaning of a device's axes and buttons.

    hold: the dead man's button. dead_zone: part of a stick's way that is none. drive: by part of a twist. jog: by a
    joint's name, or its number from 1 on. tool: by part of a tool's twist, in the axes of `frame`, one of FRAMES or a
    node's name. force: what is felt meanwhile, None for nothing. camera: what moves the view of a page while nothing is
    held. slower, faster: buttons that change the speed by a
    tenth.
    """

    hold: str
    dead_zone: float
    drive: Mapping[str, Control]
    jog: Mapping[str, Control]
    tool: Mapping[str, Control] = field(default_factory=dict)
    frame: str = "base"
    force: ForceMapping | None = None
    slower: str = ""
    faster: str = ""
    camera: Mapping[str, Control] = field(default_factory=dict)


def read_mapping(file: Path = USUAL, device: Device = GAMEPAD) -> GamepadMapping:
    """Return the mapping of a file for a device.

    Raises MissingFileError, or MalformedFileError with the field that is wrong.
    """
    try:
        text = file.read_text("utf-8")
    except OSError as error:
        raise MissingFileError(f"there is no mapping {file}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise MalformedFileError(f"{file} is not YAML: {error}", metadata={"file": str(file)}) from error
    return mapping_of(text, str(file), device)


def mapping_of(text: str, name: str, device: Device) -> GamepadMapping:
    """Return the mapping of a text that is called `name`; raises MalformedFileError with the field that is wrong."""
    try:
        # What is named again and again may be endless when it is told.
        if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, yaml.SafeLoader)):
            raise ValueError("aliases (*name) are not read: write it out")
        return _mapping(yaml.safe_load(text), device)
    except (yaml.YAMLError, RecursionError) as error:
        raise MalformedFileError(f"{name} is not YAML: {error}", metadata={"file": name}) from error
    except ValueError as error:
        raise MalformedFileError(f"{name}: {error}", metadata={"file": name}) from error


def _mapping(document: Any, device: Device) -> GamepadMapping:  # noqa: ANN401  whatever a file may hold
    fields = _table(document, "a mapping")
    known = (
        "schema_version",
        "hold",
        "dead_zone",
        "drive",
        "jog",
        "tool",
        "frame",
        "force",
        "camera",
        "slower",
        "faster",
    )
    if unknown := [name for name in fields if name not in known]:
        raise ValueError(f"there is no {unknown[0]!r}; a mapping has {', '.join(known)}")
    if fields.get("schema_version") != 1:
        raise ValueError(f"schema_version is {fields.get('schema_version')!r}; it must be 1")
    dead_zone = fields.get("dead_zone", 0.15)
    if isinstance(dead_zone, bool) or not isinstance(dead_zone, int | float) or not 0.0 <= dead_zone <= 0.9:
        raise ValueError(f"dead_zone is {dead_zone!r}; it must be a number from 0 to 0.9")
    drive, jog, tool, camera = (
        {name: _control(said, f"{part}.{name}", device) for name, said in _table(fields.get(part, {}), part).items()}
        for part in ("drive", "jog", "tool", "camera")
    )
    for part, controls, names in (("drive", drive, DIRECTIONS), ("tool", tool, TOOL), ("camera", camera, CAMERA)):
        if unknown := [name for name in controls if name not in names]:
            raise ValueError(f"there is no {part}.{unknown[0]}; it has {', '.join(names)}")
    if jog and tool:
        raise ValueError("there are both jog and tool; an arm is moved by its joints or by its tool: leave one out")
    return GamepadMapping(
        hold=_button(fields.get("hold"), "hold", device),
        dead_zone=float(dead_zone),
        drive=drive,
        jog=jog,
        tool=tool,
        frame=str(fields.get("frame", "base")),
        camera=camera,
        force=_force(_table(fields["force"], "force")) if "force" in fields else None,
        **{name: _button(fields[name], name, device) for name in ("slower", "faster") if name in fields},
    )


def _force(fields: dict[str, Any]) -> ForceMapping:
    if unknown := [name for name in fields if name not in ("sensor", "full")]:
        raise ValueError(f"there is no force.{unknown[0]}; it has sensor, full")
    sensor, full = fields.get("sensor"), fields.get("full")
    if not isinstance(sensor, str) or not sensor:
        raise ValueError(f"force.sensor is {sensor!r}; it must be the name of a force and torque sensor")
    if isinstance(full, bool) or not isinstance(full, int | float) or not 0.0 < full < math.inf:
        raise ValueError(f"force.full is {full!r}; it must be a number of newtons above 0")
    return ForceMapping(sensor, float(full))


def _table(said: Any, place: str) -> dict[str, Any]:  # noqa: ANN401  as above
    if not isinstance(said, dict):
        raise ValueError(f"{place} is {said!r}; it must be fields with values")
    return {str(name): value for name, value in said.items()}


def _control(said: Any, place: str, device: Device) -> Control:  # noqa: ANN401  as above
    if isinstance(said, list) and len(said) == 2:
        return Control(buttons=(_button(said[0], place, device), _button(said[1], place, device)))
    name = str(said)
    axis = name.removeprefix("-")
    if axis not in device.axes and not device.axes:
        raise ValueError(f"{place} is {said!r}; it must be two keys, such as [1, q]")
    if axis not in device.axes:
        raise ValueError(
            f"{place} is {said!r}; it must be an axis, such as -{device.axes[1]}, or two buttons; axes are "
            f"{', '.join(device.axes)}"
        )
    return Control(axis, -1.0 if name.startswith("-") else 1.0)


def _button(said: Any, place: str, device: Device) -> str:  # noqa: ANN401  as above
    name = str(said) if type(said) is int else said  # a key with a digit
    if name not in device.buttons:
        raise ValueError(f"{place} is {said!r}; it must be a button: {', '.join(device.buttons)}")
    return str(name)
