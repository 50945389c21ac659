"""Files of connections: read, and checked against the signals of a world, each fault with file and line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from virtualrobot_apps.cell_io.yaml_file import Item, nearest, read_file
from virtualrobot_apps.connections.expressions import (
    GREATEST_INTEGER,
    KIND_NAMES,
    LEAST_INTEGER,
    Connection,
    Expression,
    Value,
)
from virtualrobot_apps.connections.logic import in_order
from virtualrobot_apps.connections.operators import MANY, OPERATORS, TWO, kind_of

LONGEST_SECONDS = 86400.0

FIRST_VALUES: dict[str, Value] = {"boolean": False, "integer": 0, "number": 0.0, "text": ""}
"""First values of signals that a file makes, by type; groups have none, since their length is theirs."""

FILE_FIELDS = ("schema_version", "signals", "connections", "tools", "belts")
SIGNAL_FIELDS = ("name", "type", "value", "unit", "description")
TOOL_FIELDS = ("robot", "tool", "signal", "on", "off", "done")
BELT_FIELDS = ("robot", "joint", "signal", "velocity", "moving")


@dataclass(frozen=True, eq=False)
class NewSignal:
    """A signal that is made where the world has none of its name."""

    name: str
    value: Value
    unit: str
    description: str
    item: Item


@dataclass(frozen=True, eq=False)
class ToolDevice:
    """A tool whose state a boolean chooses.

    Attributes:
        robot: name of the robot that has it.
        tool: its name; empty means the robot's only or chosen one.
        signal: the boolean.
        on: the state while that is on.
        off: the state while that is off.
        done: a boolean that says that the state `on` is reached; empty means none.
        item: where it stands.
    """

    robot: str
    tool: str
    signal: str
    on: str
    off: str
    done: str
    item: Item


@dataclass(frozen=True, eq=False)
class BeltDevice:
    """A joint that runs while a boolean is on.

    Attributes:
        robot: name of the robot.
        joint: name of its joint.
        signal: the boolean.
        velocity: how fast (m/s or rad/s), or the name of the number that says it.
        moving: a boolean that says that it moves; empty means none.
        item: where it stands.
    """

    robot: str
    joint: str
    signal: str
    velocity: float | str
    moving: str
    item: Item


@dataclass(frozen=True, eq=False)
class ConnectionFile:
    """Content of a file of connections."""

    connections: tuple[Connection, ...]
    signals: tuple[NewSignal, ...]
    tools: tuple[ToolDevice, ...]
    belts: tuple[BeltDevice, ...]
    root: Item

    def driven(self) -> dict[str, Item]:
        """Return the signals that it drives, and where."""
        found = {one.target: one.item for one in self.connections}
        feedback = [(one.done, one.item) for one in self.tools] + [(one.moving, one.item) for one in self.belts]
        for name, item in feedback:
            if name in found:
                raise item.error(f"the signal {name!r} is driven in line {found[name].line} already")
            if name:
                found[name] = item
        return found

    def check_signals(self, world: Mapping[str, Value]) -> None:
        """Check names and types of signals where the world has these; those that the file makes are known too.

        Raises:
            MalformedFileError: for the first fault, with its line.
        """
        values = {one.name: one.value for one in self.signals} | dict(world)
        kinds = {name: type(value) for name, value in values.items()}
        for one in self.signals:
            if kinds[one.name] is not type(one.value):
                said = f"the world has it as {KIND_NAMES[kinds[one.name]]}, not {KIND_NAMES[type(one.value)]}"
                raise one.item.error(f"{one.name!r}: {said}")
        for connection in self.connections:
            wanted = _kind(kinds, connection.target, connection.item)
            _check_names(kinds, connection.source)
            kind = kind_of(connection.source, kinds)
            if kind is not wanted and (kind, wanted) != (int, float):
                said = f"{connection.target!r} is {KIND_NAMES[wanted]}, and this gives {KIND_NAMES[kind]}"
                raise connection.source.item.error(said)
        for device in (*self.tools, *self.belts):
            feedback = device.done if isinstance(device, ToolDevice) else device.moving
            for name in filter(None, (device.signal, feedback)):
                if _kind(kinds, name, device.item) is not bool:
                    raise device.item.error(f"the signal {name!r} is {KIND_NAMES[kinds[name]]}, and boolean is wanted")
        for belt in self.belts:
            speed = belt.velocity
            if isinstance(speed, str) and _kind(kinds, speed, belt.item) not in (int, float):
                raise belt.item.error(f"the signal {speed!r} is {KIND_NAMES[kinds[speed]]}, and a number is wanted")


def read_connections(path: str | Path) -> ConnectionFile:
    """Return what a file of connections says; loops and signals that are driven twice are refused.

    Raises:
        MissingFileError: when the file can't be read.
        MalformedFileError: for the first fault, with file and line.
    """
    return connections_of(read_file(path))


def connections_of(root: Item) -> ConnectionFile:
    """Return what the root of a file of connections says, as `read_connections` does."""
    fields = root.fields(FILE_FIELDS)
    pairs = fields["connections"].mapping("signals") if "connections" in fields else {}
    lists = {name: fields[name].items() if name in fields else [] for name in ("signals", "tools", "belts")}
    file = ConnectionFile(
        tuple(Connection(name, _expression(item), item) for name, item in pairs.items()),
        tuple(map(_signal, lists["signals"])),
        tuple(map(_tool, lists["tools"])),
        tuple(map(_belt, lists["belts"])),
        root,
    )
    in_order(file.connections)
    file.driven()
    seen: dict[str, int] = {}
    for one in file.signals:
        if one.name in seen:
            raise one.item.error(f"the signal {one.name!r} is made in line {seen[one.name]} already")
        seen[one.name] = one.item.line
    return file


def _signal(item: Item) -> NewSignal:
    fields = item.fields(SIGNAL_FIELDS, ["name"])
    kind = fields["type"].one_of(FIRST_VALUES) if "type" in fields else "boolean"
    value = FIRST_VALUES[kind]
    if "value" in fields:
        given = fields["value"]
        readers = {"boolean": given.boolean, "number": given.number, "text": given.text}
        value = readers[kind]() if kind in readers else given.whole(LEAST_INTEGER, GREATEST_INTEGER)
    unit, description = (fields[name].text() if name in fields else "" for name in ("unit", "description"))
    return NewSignal(fields["name"].text(), value, unit, description, item)


def _tool(item: Item) -> ToolDevice:
    fields = item.fields(TOOL_FIELDS, ["robot", "signal", "on", "off"])
    texts = {name: fields[name].text() if name in fields else "" for name in TOOL_FIELDS}
    return ToolDevice(**texts, item=item)


def _belt(item: Item) -> BeltDevice:
    fields = item.fields(BELT_FIELDS, ["robot", "joint", "signal", "velocity"])
    texts = {name: fields[name].text() for name in ("robot", "joint", "signal")}
    speed = fields["velocity"]
    velocity = speed.text() if isinstance(speed.scalar(), str) else speed.number()
    return BeltDevice(
        **texts, velocity=velocity, moving=fields["moving"].text() if "moving" in fields else "", item=item
    )


def _expression(item: Item) -> Expression:
    if item.is_list:
        raise item.error(f"a list needs an operator before it: one of {', '.join(_of_lists())}")
    if not item.is_mapping:
        value = item.scalar()
        if not isinstance(value, str):
            if not isinstance(value, bool):
                item.number(LEAST_INTEGER, GREATEST_INTEGER)
            return Expression("constant", item, constant=value)
        return Expression("signal", item, signal=item.text())
    fields = item.mapping("operators")
    if len(fields) != 1:
        raise item.error(f"one operator belongs here, not {len(fields)}: {', '.join(fields)}")
    ((name, about),) = fields.items()
    if name == "text":
        return Expression("constant", about, constant=str(about.node.value) if about.scalar() is not None else "")
    if name not in OPERATORS:
        known = [*OPERATORS, "text"]
        raise about.error(f"there is no operator {name!r}{nearest(name, known)} known: {', '.join(known)}")
    made = OPERATORS[name]
    if made.inputs in (MANY, TWO):
        inputs = about.items()
        if len(inputs) < 2 or (made.inputs == TWO and len(inputs) != 2):
            raise about.error(f"{name!r} takes {'two' if made.inputs == TWO else 'two or more'}, not {len(inputs)}")
        return Expression(name, about, tuple(map(_expression, inputs)))
    if made.inputs == ("input",) and not made.settings:
        return Expression(name, about, (_expression(about),))
    needed = [one for one in (*made.inputs, *made.settings) if one not in made.optional]
    found = about.fields((*made.inputs, *made.settings), needed)
    if name == "count" and not ("up" in found or "down" in found):
        raise about.error("'count' needs 'up', 'down' or both")
    off = Expression("constant", about)
    return Expression(
        name,
        about,
        tuple(_expression(found[one]) if one in found else off for one in made.inputs),
        seconds=found["seconds"].number(0.0, LONGEST_SECONDS) if "seconds" in found else 0.0,
        index=found["index"].whole(0, 1023) if "index" in found else 0,
    )


def _of_lists() -> list[str]:
    return [name for name, made in OPERATORS.items() if made.inputs in (MANY, TWO)]


def _check_names(kinds: Mapping[str, type], expression: Expression) -> None:
    if expression.operator == "signal":
        _kind(kinds, expression.signal, expression.item)
    for one in expression.inputs:
        _check_names(kinds, one)


def _kind(kinds: Mapping[str, type], name: str, item: Item) -> type:
    if name not in kinds:
        raise item.error(f"there is no signal {name!r}{nearest(name, kinds)} 'signals' in the file may make it")
    return kinds[name]
