"""A cell as others step it: variables by name, and a kernel whose time goes on by their steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.clock import Observation
from virtualrobot.errors import InvalidArgumentError, VirtualRobotError
from virtualrobot.sensors.range_sensors import RangeReading

from virtualrobot_apps.fmi.names import TWIST, Value, part

COMMANDS = ("positions", "velocities")
INPUT, OUTPUT = "input", "output"
UNITS = {"m": {"m": 1}, "rad": {"rad": 1}, "m/s": {"m": 1, "s": -1}, "rad/s": {"rad": 1, "s": -1}}
"""Units that variables have, by powers of base units; those of joints and of others' signals are not told."""


@dataclass(frozen=True)
class Variable:
    """A variable of the cell.

    Attributes:
        name: its structured name.
        type: `Float64`, `Boolean`, `Int64` or `String`.
        causality: `input` or `output`.
        start: the value at the beginning.
        unit: of UNITS; empty where it is not told.
        description: in words.
    """

    name: str
    type: str
    causality: str
    start: Value
    unit: str = ""
    description: str = ""


@dataclass(frozen=True)
class Plan:
    """Plan of a cell, which is JSON in the FMU.

    Attributes:
        model: name of the model, an identifier of C.
        address: of the kernel; empty means that of the environment variable VIRTUALROBOT_ADDRESS.
        robots: coordinates of each robot.
        commands: kind of the command of each robot: `twists`, `positions` or `velocities`.
        sensors: range sensors that are read after each step.
        signals: names of signals.
        variables: all variables.
    """

    model: str
    address: str
    robots: dict[str, list[str]]
    commands: dict[str, str]
    sensors: list[str] = field(default_factory=list)
    signals: list[str] = field(default_factory=list)
    variables: list[Variable] = field(default_factory=list)

    def to_plain(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return asdict(self)

    @staticmethod
    def from_plain(plain: Mapping[str, Any]) -> Plan:
        """Return the plan of what `to_plain` gave."""
        return Plan(**{**plain, "variables": [Variable(**one) for one in plain["variables"]]})


def plan_cell(
    client: Client,
    robots: Sequence[str] = (),
    *,
    model: str = "cell",
    command: str = "positions",
    sensors: Sequence[str] = (),
    address: str = "",
) -> Plan:
    """Return the variables of a world as it is now.

    Args:
        client: of its kernel.
        robots: those that stand in it; none means all.
        model: name of the model.
        command: of joints: `positions` or `velocities`; crafts are commanded by twists.
        sensors: range sensors that it tells.
        address: of the kernel that the FMU connects to; empty means the default when it runs.

    Raises:
        UnknownNameError: when a robot or a sensor is not there.
        InvalidArgumentError: for a model that is no identifier, and sensors that are no range sensors.
    """
    if not model.isidentifier() or not model.isascii():
        raise InvalidArgumentError(f"the model's name is an identifier (letters, digits, _), not {model[:80]!r}")
    found: list[Variable] = []
    crafts = {one.about for one in client.streams.table() if one.content == "twist"}
    coordinates: dict[str, list[str]] = {}
    commands: dict[str, str] = {}
    for name in robots or list(client.robots):
        robot = client.robots[name]
        coordinates[name] = list(robot.coordinates)
        commands[name] = "twists" if name in crafts else command
        found += _of_robot(name, coordinates[name], commands[name], robot.state)
    for name in sensors:
        value = client.sensors[name].read().value
        if not isinstance(value, RangeReading):
            raise InvalidArgumentError(f"{name!r} is no range sensor; an FMU of the cell tells readings of these alone")
        found += [
            Variable(f"{part(name)}.distances[{number + 1}]", "Float64", OUTPUT, distance, "m")
            for number, distance in enumerate(_distances(value))
        ]
    signals: list[str] = []
    for one in client.signals.read():
        if isinstance(one.value, tuple):  # a group
            continue
        signals.append(one.name)
        kind = {bool: "Boolean", int: "Int64", float: "Float64", str: "String"}[type(one.value)]
        name = f"signals.{part(one.name)}"
        causality = INPUT if one.direction == "input" else OUTPUT
        found.append(Variable(name, kind, causality, one.value, description=one.description))
    return Plan(model, address, coordinates, commands, list(sensors), signals, found)


def _of_robot(name: str, coordinates: Sequence[str], command: str, state: Any) -> list[Variable]:  # noqa: ANN401
    own = part(name)
    told = _of_state(name, coordinates, state)
    units = {f"{own}.heading": "rad", **{f"{own}.position[{axis + 1}]": "m" for axis in range(3)}}
    found = [Variable(key, "Float64", OUTPUT, value, units.get(key, "")) for key, value in told.items()]
    if command == "twists":
        speeds = zip(TWIST, ("m/s", "m/s", "rad/s"), strict=True)
        return found + [Variable(f"{own}.twist.{one}", "Float64", INPUT, 0.0, unit) for one, unit in speeds]
    starts = dict(zip(coordinates, state.positions.tolist(), strict=True))
    return found + [
        Variable(f"{own}.command.{part(one)}", "Float64", INPUT, starts[one] if command == "positions" else 0.0)
        for one in _commanded(coordinates)
    ]


def _commanded(coordinates: Sequence[str]) -> list[str]:
    """Return the coordinates that commands are for: those of a base that moves freely are not among them."""
    return [one for one in coordinates if "/" not in one]


def _of_state(name: str, coordinates: Sequence[str], state: Any) -> dict[str, float]:  # noqa: ANN401 a RobotState
    own, place = part(name), state.world_t_tcp
    told = {
        f"{own}.positions.{part(one)}": value for one, value in zip(coordinates, state.positions.tolist(), strict=True)
    }
    velocities = state.velocities.tolist()  # of a floating base there are fewer than coordinates
    names = (
        [f".{part(one)}" for one in coordinates]
        if len(velocities) == len(coordinates)
        else [f"[{number + 1}]" for number in range(len(velocities))]
    )
    told |= {f"{own}.velocities{name}": value for name, value in zip(names, velocities, strict=True)}
    told |= {f"{own}.position[{axis + 1}]": float(place[axis, 3]) for axis in range(3)}
    return told | {f"{own}.heading": math.atan2(place[1, 0], place[0, 0])}


def _distances(value: RangeReading) -> list[float]:
    """Return distances (m), infinity where there is no echo."""
    return np.where(value.valid, value.distances, np.inf).ravel().tolist()


class SteppedCell:
    """A kernel whose time goes on by steps of others; nobody else steps it meanwhile."""

    def __init__(self, client: Client, plan: Plan) -> None:
        """Take the clock, and make the first tick.

        Raises:
            WrongStateError: while another program holds the clock.
            UnknownNameError: when a robot or a sensor of the plan is not there.
        """
        self._client, self._plan = client, plan
        self._tick_seconds = client.clock.read().tick_length
        self._hold = client.clock.hold_stepped()
        try:
            self._seen = client.clock.step(1, sensors=plan.sensors)
        except BaseException:
            self._hold.close()
            raise
        self._start = self._seen.stamp.tick
        self._commanded = False

    def values(self) -> dict[str, Value]:
        """Return the outputs as they are now."""
        seen, plan = self._seen, self._plan
        found: dict[str, Value] = {}
        for name, coordinates in plan.robots.items():
            found |= _of_state(name, coordinates, seen.robots[name])
        for name in plan.sensors:
            for number, distance in enumerate(_distances(seen.readings[name].range)):
                found[f"{part(name)}.distances[{number + 1}]"] = distance
        for name in plan.signals:
            if not isinstance(value := seen.signals[name], tuple):
                found[f"signals.{part(name)}"] = value
        return found

    def step(self, until: float, inputs: Mapping[str, Value]) -> Observation:
        """Let time go on until so many seconds after the begin, with these inputs; less than a tick is made up later.

        Raises:
            VirtualRobotError: for a command that the kernel refuses; no time has gone by then.
        """
        ticks = self._start + round(until / self._tick_seconds) - self._seen.stamp.tick
        if ticks > 0:
            given = self._commands(inputs)
            signals = {name: inputs[key] for name in self._plan.signals if (key := f"signals.{part(name)}") in inputs}
            self._seen = self._client.clock.step(ticks, signals=signals, sensors=self._plan.sensors, **given)
            self._commanded = True
        return self._seen

    def close(self) -> None:
        """Let robots come to rest, and time go on as before; raises nothing."""
        if self._commanded:
            for name, kind in self._plan.commands.items():
                ends: dict[str, Any] = {kind: {name: None}}
                with suppress(VirtualRobotError):  # it has been stopped already
                    self._client.clock.step(1, **ends)
        with suppress(VirtualRobotError):
            self._hold.close()

    def _commands(self, inputs: Mapping[str, Value]) -> dict[str, Any]:
        given: dict[str, dict[str, Any]] = {}
        for name, kind in self._plan.commands.items():
            own = part(name)
            if kind == "twists":
                given.setdefault(kind, {})[name] = [inputs[f"{own}.twist.{one}"] for one in TWIST]
            elif joints := _commanded(self._plan.robots[name]):
                given.setdefault(kind, {})[name] = {one: inputs[f"{own}.command.{part(one)}"] for one in joints}
        return given
