"""Exchange with an outside controller: it gets the state, its command comes, time goes on by a period, and again."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.clock import Observation
from virtualrobot.errors import InvalidArgumentError, VirtualRobotError
from virtualrobot.robots.values import RobotState
from virtualrobot.sensors.range_sensors import RangeReading
from virtualrobot.sensors.readings import Reading

from virtualrobot_apps.lockstep.wire import Wire

KINDS = ("twist", "positions", "velocities")
"""Parts of a command that move the robot."""

_KNOWN = (*KINDS, "signals", "done")
_REST_SECONDS = 5.0
"""Longest simulation time (s) in which the robot comes to rest at the end."""


@dataclass(frozen=True, slots=True)
class Run:
    """Result of an exchange: steps that were made, simulation time (s), and why it ended, in words."""

    steps: int
    seconds: float
    end: str


class Lockstep:
    """Lockstep of a kernel and a controller of one robot; the clock is stepped meanwhile, and as before afterwards."""

    def __init__(self, client: Client, robot: str, period: float, sensors: Sequence[str] = ()) -> None:
        """Prepare to control a robot once a period (s of simulation time).

        Raises:
            UnknownNameError: when robot or sensor is not there.
            InvalidArgumentError: when the period is shorter than a tick.
        """
        self._client, self._sensors = client, list(sensors)
        self._robot = client.robots[robot]
        for name in sensors:
            client.sensors.status(name)
        self._tick = client.clock.read().tick_length
        if not self._tick <= period < math.inf:
            raise InvalidArgumentError(f"a period is a tick ({self._tick:g} s) at least, not {period:g} s")
        self._period = period

    def run(
        self, wire: Wire, timeout: float, seconds: float | None = None, told: Callable[[float], object] = lambda _: None
    ) -> Run:
        """Exchange states and commands until the controller is done or has ended, or the time is over.

        Args:
            wire: the way to the controller.
            timeout: how long to wait for each command (s of the wall clock).
            seconds: the simulation time; None: until the controller ends it.
            told: is told the simulation time after each step (s since the begin).

        Raises:
            CallTimeoutError: when no command came in time; the robot comes to rest.
            WrongStateError: when the controller has failed; the robot comes to rest.
            InvalidArgumentError: for what is no command; the robot comes to rest.
            VirtualRobotError: for a command that the kernel refuses.
        """
        with self._client.clock.hold_stepped():
            return self._run(wire, timeout, seconds, told)

    def _run(self, wire: Wire, timeout: float, seconds: float | None, told: Callable[[float], object]) -> Run:
        clock = self._client.clock
        kinds: set[str] = set()
        try:
            seen = clock.step(1, sensors=self._sensors)
            start, steps = seen.stamp.tick, 0
            while True:
                now = (seen.stamp.tick - start) * self._tick
                if seconds is not None and now >= seconds:
                    return Run(steps, now, "the time is over")
                wire.send(json.dumps(self._state(seen, now), allow_nan=False))
                try:
                    line = wire.receive(timeout)
                except VirtualRobotError as error:
                    words = f"{error}; it was given the state of {now:.3f} s, and {self._robot.name} comes to rest"
                    raise type(error)(words) from None
                if line is None:
                    return Run(steps, now, "the controller has ended")
                command = self._command(line)
                if command.pop("done", False):
                    return Run(steps, now, "the controller is done")
                steps += 1
                due = start + round(steps * self._period / self._tick)
                given: dict[str, Any] = {
                    _option(kind): {self._robot.name: command[kind]} for kind in KINDS if kind in command
                }
                kinds |= given.keys()
                signals = command.get("signals")
                seen = clock.step(due - seen.stamp.tick, signals=signals, sensors=self._sensors, **given)
                told(now + self._period)
        finally:
            self._rest(kinds)

    def _rest(self, kinds: set[str]) -> None:
        """Let the robot come to rest in simulation time."""
        clock, name = self._client.clock, self._robot.name
        for kind in kinds:  # each by itself: one that was refused, or stopped by others, leaves the rest to be ended
            ends: dict[str, Any] = {kind: {name: None}}
            with suppress(VirtualRobotError):
                clock.step(1, **ends)
        if kinds:
            with suppress(VirtualRobotError):  # the kernel has gone
                for _ in range(round(_REST_SECONDS / self._tick / 25.0)):
                    if not np.any(np.abs(clock.step(25).robots[name].velocities) > 1e-6):
                        break

    def _command(self, line: str) -> dict[str, Any]:
        """Return the command of a line; raise InvalidArgumentError for what is none, with what would be right."""
        try:
            command = json.loads(line)
        except ValueError as error:
            raise InvalidArgumentError(f"the controller wrote no JSON: {line[:80]!r} ({error})") from error
        if not isinstance(command, dict) or set(command) - set(_KNOWN):
            wrong = sorted(set(command) - set(_KNOWN)) if isinstance(command, dict) else line[:80]
            raise InvalidArgumentError(f"a command is an object with {', '.join(_KNOWN)}, not {wrong!r}")
        for kind in KINDS:
            if kind in command and not _are_numbers(command[kind]):
                raise InvalidArgumentError(
                    f"{kind!r} is a list of finite numbers, or numbers by name, not {command[kind]!r}"
                )
        if not isinstance(command.get("signals", {}), dict):
            raise InvalidArgumentError(f"'signals' are values by name, not {command['signals']!r}")
        return command

    def _state(self, seen: Observation, now: float) -> dict[str, Any]:
        state = seen.robots[self._robot.name]
        told: dict[str, Any] = {"time": now, "tick": seen.stamp.tick, "robot": self._of_robot(state)}
        if self._sensors:
            told["sensors"] = {name: _of_reading(seen.readings[name]) for name in self._sensors}
        if seen.signals:
            told["signals"] = dict(seen.signals)
        return told

    def _of_robot(self, state: RobotState) -> dict[str, Any]:
        names = list(self._robot.coordinates)
        place = state.world_t_tcp
        return {
            "name": state.name,
            "positions": dict(zip(names, state.positions.tolist(), strict=True)),
            "velocities": state.velocities.tolist(),
            "position": place[:3, 3].tolist(),
            "heading": math.atan2(place[1, 0], place[0, 0]),
            "world_t_tcp": place.tolist(),
        }


def _option(kind: str) -> str:
    return "twists" if kind == "twist" else kind


def _are_numbers(value: object) -> bool:
    values = value.values() if isinstance(value, dict) else value if isinstance(value, list) else [None]
    return all(isinstance(one, int | float) and not isinstance(one, bool) and math.isfinite(one) for one in values)


def _of_reading(reading: Reading) -> dict[str, Any]:
    """Return a reading as JSON has it: what is not valid or not finite is null."""
    value = reading.value
    told: dict[str, Any] = {"time": reading.stamp.simulation_time, "number": reading.number}
    if isinstance(value, RangeReading):
        distances = np.where(value.valid, value.distances, np.nan)
        told["distances"] = _plain(distances.ravel() if distances.ndim == 2 and 1 in distances.shape else distances)
        return told
    for name in getattr(value, "__dataclass_fields__", {}):
        told[name] = _plain(getattr(value, name))
    return told


def _plain(value: Any) -> Any:  # noqa: ANN401 anything that a reading has
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, str | int | bool | type(None)) else str(value)
