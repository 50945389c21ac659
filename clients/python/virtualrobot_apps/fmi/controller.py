"""A controller that is an FMU for co-simulation (FMI 2.0, 3.0), in the process that `wire` starts; FMPy loads it."""

from __future__ import annotations

import json
import math
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import fmpy
from fmpy.simulation import instantiate_fmu
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, VirtualRobotError, WrongStateError

from virtualrobot_apps.fmi.names import Value, command_of, flattened, is_command, values_for

VERSIONS = ("2.0", "3.0")
_STORED = {"Enumeration": {"2.0": "Integer", "3.0": "Int64"}}


class FmuController:
    """A controller that is loaded into this process: its inputs are set, it makes a step, its outputs are the command.

    Each input has the name of a value of the state, such as `robot.heading`, and each output that counts that of a part
    of a command, such as `twist.vx`; see `names`.
    """

    def __init__(self, file: Path, folder: Path, period: float) -> None:
        """Unpack it into a folder, and load it; it is asked once a period (s).

        Raises:
            MalformedFileError: when it is no FMU for co-simulation, or has no output that is part of a command.
            WrongStateError: when it can't begin.
        """
        self._folder, self._period, self._steps = str(folder), period, 0
        self._fmu: Any = None
        self._load(file)

    def _load(self, file: Path) -> None:
        try:
            description = fmpy.read_model_description(str(file))
            fmpy.extract(str(file), self._folder)
        except Exception as error:  # FMPy and lxml raise what they like
            raise MalformedFileError(f"{file.name} is no FMU: {_short(error)}") from error
        self._version = str(description.fmiVersion)
        if self._version not in VERSIONS or description.coSimulation is None:
            raise MalformedFileError(
                f"{file.name} is FMI {self._version}{'' if description.coSimulation else ', not for co-simulation'}; "
                f"a controller is an FMU for co-simulation of FMI {' or '.join(VERSIONS)}"
            )
        variables = description.modelVariables
        self._inputs = [one for one in variables if one.causality == "input"]
        self._outputs = [one for one in variables if one.causality == "output" and is_command(one.name)]
        if not self._outputs:
            names = ", ".join(one.name for one in variables if one.causality == "output")[:200] or "none"
            raise MalformedFileError(
                f"{file.name} has no output that is part of a command, such as twist.vx or positions.JOINT; "
                f"it has {names}"
            )
        try:
            self._fmu = instantiate_fmu(self._folder, description, "CoSimulation")
            if self._version == "2.0":
                self._fmu.setupExperiment(startTime=0.0)
                self._fmu.enterInitializationMode()
            else:
                self._fmu.enterInitializationMode(startTime=0.0)
        except Exception as error:
            raise WrongStateError(f"the controller {file.name} cannot begin: {_short(error)}") from error

    def step(self, state: dict[str, Any]) -> dict[str, Any] | None:
        """Return the command after a step at a state; None once it wants to end.

        Raises:
            InvalidArgumentError: for an input that the state has no value for.
            WrongStateError: when it has failed.
        """
        self._set(flattened(state))
        told = self._call("doStep", self._steps * self._period, self._period)
        self._steps += 1
        if isinstance(told, tuple) and told[1]:  # terminateSimulation
            return None
        outputs: dict[str, list[Value]] = {}
        for one in self._outputs:
            kind, count = self._kind(one), _count(one)
            more = (count,) if self._version == "3.0" else ()
            values = self._call(f"get{kind}", [one.valueReference], *more)
            if one.type == "Boolean":
                values = [bool(value) for value in values]
            if not all(math.isfinite(value) for value in values if isinstance(value, float)):
                raise WrongStateError(f"the controller's output {one.name!r} is {values[0]}")
            outputs[one.name] = list(values)
        return command_of(outputs)

    def terminate(self) -> None:
        """Let it end as it likes, such as close files."""
        with suppress(Exception):  # it has failed before
            self._fmu.terminate()

    def _set(self, state: dict[str, list[Value]]) -> None:
        for one in self._inputs:
            values = values_for(one.name, _count(one), state)
            kind = self._kind(one)
            number = int if "Int" in kind or kind == "Boolean" else str if kind == "String" else float
            try:
                given = [number(value) for value in values]
            except (ValueError, OverflowError) as error:
                raise InvalidArgumentError(f"the FMU's input {one.name!r} is {one.type}, not {values[0]!r}") from error
            self._call(f"set{kind}", [one.valueReference], given)
        if not self._steps:
            self._call("exitInitializationMode")

    def _kind(self, variable: Any) -> str:  # noqa: ANN401 FMPy's ModelVariable
        kind = str(variable.type)
        return _STORED.get(kind, {}).get(self._version, kind)

    def _call(self, name: str, *arguments: object) -> Any:  # noqa: ANN401
        try:
            return getattr(self._fmu, name)(*arguments)
        except Exception as error:
            raise WrongStateError(f"the controller has failed in {name}: {_short(error)}") from error


def _count(variable: Any) -> int:  # noqa: ANN401
    return math.prod(int(one.start) for one in variable.dimensions or ()) if variable.dimensions else 1


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__


def play(file: Path, folder: Path, period: float) -> None:
    """Answer each state on the input by a command on the output, a line of JSON each, once `{}` has told the begin.

    What ends it is told as the name of an exception of `virtualrobot.errors`, and its words. What the FMU itself prints
    goes to the standard error.
    """
    with os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8", buffering=1) as out:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        try:
            fmu = FmuController(file, folder, period)
            print("{}", file=out)
            for line in sys.stdin:
                if (command := fmu.step(json.loads(line))) is None:
                    break
                print(json.dumps(command), file=out)
            fmu.terminate()
        except VirtualRobotError as error:
            print(json.dumps({"error": type(error).__name__, "message": str(error)}), file=out)


if __name__ == "__main__":
    play(Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3]))
    os._exit(0)  # libraries that run Python, as PythonFMU's, leave objects behind whose code has gone
