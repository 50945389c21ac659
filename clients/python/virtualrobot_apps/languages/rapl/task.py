"""Tasks of RAPL-II: one run of programs that are loaded, a line after the other."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NoReturn

from virtualrobot.errors import VirtualRobotError, WrongStateError

from virtualrobot_apps.languages.core.diagnostics import did_you_mean
from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.rapl.expressions import Evaluate
from virtualrobot_apps.languages.rapl.faults import RaplFault, RaplStopped
from virtualrobot_apps.languages.rapl.forms import Argument
from virtualrobot_apps.languages.rapl.lexer import Word
from virtualrobot_apps.languages.rapl.locations import Location
from virtualrobot_apps.languages.rapl.program import Loaded, Program, Statement
from virtualrobot_apps.languages.rapl.world import GRIPPER, World

POLL_SECONDS = 0.01
"""Time (s) from one look at the world to the next while a program waits."""
DEEPEST = 100
"""Number of programs that may have called each other."""
MOST_CALLERS = 20
"""Greatest number of programs, each called by the next, that a fault names."""
ANALOG = "analog_{}"
"""Signal of an analog output, by its number."""


@dataclass(slots=True)
class Frame:
    """A program at work: the place of its next statement, and its parameters %0 to %7."""

    program: Program
    at: int
    parameters: list[Word]


class RaplTask(Task):
    """One run of programs: variables, strings, locations, and what their commands work on.

    Attributes:
        write: gets each line that is shown.
        question: shows a question, and returns the answer.
        variables: values by name.
        strings: texts by number.
        locations: locations by name.
        paths: what CTPATH has kept, by number: locations and speed.
        traces: each line is shown.
        halt_on: the input, and whether it is on, that stops moves.
    """

    def __init__(
        self,
        program: Loaded,
        world: World | None = None,
        write: Callable[[str], None] = print,
        ask: Callable[[str], str] = input,
        signals: tuple[str, str] = ("input_{}", "output_{}"),
    ) -> None:
        """Set up a run; `signals` are the names of inputs and outputs by number.

        Raises WrongStateError for signals that the world has not, and for a gripper that the arm has not.
        """
        super().__init__()
        self.program, self.write, self.question = program, write, ask
        self._inputs, self._outputs = signals
        self._world = world
        self.variables: dict[str, float] = {}
        self.strings: defaultdict[int, str] = defaultdict(str)
        self.locations: dict[str, Location] = dict(program.locations)
        self.paths: dict[int, tuple[list[Location], float]] = {}
        self.traces = False
        self.halt_on: tuple[int, bool] | None = None
        self._frames: list[Frame] = []
        self._now: Statement | None = None
        self._source = program.programs[program.first].source
        if world is not None:
            self._check_world(world)
            world.begin(self)

    def _check_world(self, world: World) -> None:
        there = set(world.client.signals)
        lacking = [name for name in signals_of(self.program, self._inputs, self._outputs) if name not in there]
        if lacking:
            raise WrongStateError(
                f"the world has no signal {', '.join(lacking)}; create it by 'virtualrobot signal NAME --create', or "
                "all by --create-signals"
            )
        if (place := self.program.first_use("OPEN", "CLOSE")) and not world.has_gripper():
            file, _, line = place.rpartition(":")
            raise WrongStateError(
                f"{place}: the arm has no gripper to open and close: mount one, or create the signal {GRIPPER!r}, "
                "which is on where it is closed; --create-signals does so, too",
                metadata={"file": file, "line": line},
            )

    @property
    def world(self) -> World:
        """The robot; raises a fault where there is none."""
        if self._world is None:
            raise RaplFault("this program was started without a robot, and can't do that")
        return self._world

    def place(self) -> str:
        """Return file and line of the statement that is being done."""
        return "" if self._now is None else f"{self._source.file}:{self._source.line(self._now.at)}"

    def program_pointer(self) -> str:
        """Return file and line of the statement that is being done."""
        return self.place()

    def motion_pointer(self) -> str:
        """Return file and line of the move that the arm makes."""
        return "" if self._world is None else self._world.queue.doing()

    # One line after the other.

    def run(self, name: str = "") -> None:
        """Run a program, by default the first, to its end, and wait until the arm stands.

        Raises:
            RaplStopped: for a fault, with file, line and number.
            TaskStopped: when somebody stopped it; the robot brakes on its path.
            WrongStateError: when there is no such program.
        """
        with self.at_work():
            self._run(name)

    def _run(self, name: str) -> None:
        known = self.program.programs
        wanted = name.upper() or self.program.first
        if wanted not in known:
            raise WrongStateError(
                f"there is no program {name!r}{did_you_mean(name, known)}; there are: {', '.join(known)}"
            )
        self._frames = [Frame(known[wanted], 0, [])]
        try:
            while self._frames:
                self._step(self._frames[-1])
            self._now = None
            if self._world is not None:
                self._world.close()
        except BaseException as error:
            if self._world is not None:
                self._world.cancel("the program ended early")
            if isinstance(error, (RaplFault, VirtualRobotError)):
                self._tell(error)
            raise

    def _step(self, frame: Frame) -> None:
        if self.flags:
            self.poll()
        if frame.at >= len(frame.program.statements):
            self._frames.pop()
            return
        statement = self._now = frame.program.statements[frame.at]
        self._source = frame.program.source
        frame.at += 1
        if self.traces:
            self.write(f"{frame.program.name}#{statement.number:05d} {statement.text}")
        statement.command.run(self, *(self._value(one, frame) for one in statement.arguments))
        if self.halt_on is not None and statement.command.room == "motion":
            self._watch_input()

    def _tell(self, error: RaplFault | VirtualRobotError) -> NoReturn:
        """Raise an error as one of the program's, with its place."""
        message = str(error)
        if self._now is None:
            raise RaplStopped(message) from error
        file, line = self._source.file, self._source.line(self._now.at)
        callers = [one.program.name for one in reversed(self._frames[:-1])]
        called = f"\ncalled from {' from '.join(callers)}" if 0 < len(callers) <= MOST_CALLERS else ""
        metadata = {"file": file, "line": str(line)}
        raise RaplStopped(f"{file}:{line}: line {self._now.number}: {message}{called}", metadata=metadata) from error

    # Values of arguments.

    def _value(self, argument: Argument, frame: Frame) -> Any:  # noqa: ANN401 each kind has its own
        kind, value = argument.kind, argument.value
        if isinstance(value, list):
            return [self._value(replace(argument, value=one), frame) for one in value]
        if value is None or kind in ("word", "message", "relation"):
            return value
        if kind == "number":
            return self._computed(value, frame)
        if kind == "line":
            return int(float(value.text))
        if kind == "signal":
            return round(self._computed(value[0], frame)), value[1]
        if kind == "assignment":
            target, given = value
            if target.kind == "string":
                return int(target.text[1:]), self._text(given)
            return target.text, self._computed(given, frame)
        if kind == "said":
            return self._text(value)
        if kind == "string":
            return int(value.text[1:])
        word = self._given(value, frame)
        return word if kind == "parameter" else word.text

    def _text(self, word: Word) -> str:
        return word.text if word.kind == "text" else self.strings[int(word.text[1:])]

    def _given(self, word: Word, frame: Frame) -> Word:
        """Return a word, or what the program was given in its place."""
        if word.kind != "parameter":
            return word
        number = int(word.text[1:])
        if number >= len(frame.parameters):
            raise RaplFault(f"{frame.program.name} was given {len(frame.parameters)} parameters, and not {word.text}")
        return frame.parameters[number]

    def _computed(self, evaluate: Evaluate, frame: Frame) -> float:
        def value_of(word: Word) -> float:
            given = self._given(word, frame)
            return float(given.text) if given.kind == "number" else self.variable(given.text)

        return evaluate(value_of)

    # What commands ask for.

    def variable(self, name: str) -> float:
        """Return the value of a variable; raises a fault where it has none."""
        try:
            return self.variables[name]
        except KeyError:
            raise RaplFault(f"the variable {name!r} has no value yet") from None

    def location(self, name: str) -> Location:
        """Return a location; raises a fault where it is not there."""
        try:
            return self.locations[name]
        except KeyError:
            raise RaplFault(f"the location {name!r} is not there{did_you_mean(name, self.locations)}") from None

    def go_to(self, line: int) -> None:
        """Go on at a line of the program that is at work."""
        frame = self._frames[-1]
        frame.at = frame.program.places[line]

    def call(self, name: str, parameters: list[Word]) -> None:
        """Go to another program, and come back after it."""
        if len(self._frames) >= DEEPEST:
            raise RaplFault("programs call each other without an end")
        if len(parameters) > 8:
            raise RaplFault(f"GOSUB gives up to 8 parameters, and not {len(parameters)}")
        self._frames.append(Frame(self.program.programs[name], 0, parameters))

    def leave(self, skipped: int) -> None:
        """Go back to the calling program, and leave out lines there."""
        self._frames.pop()
        if self._frames:
            self._frames[-1].at += skipped

    def end(self) -> None:
        """End all programs."""
        self._frames.clear()

    def time(self) -> float:
        """Return the time (s): that of the simulation, or of the wall where there is no robot."""
        return time.monotonic() if self._world is None else self._world.client.clock.simulation_time

    def delay(self, seconds: float) -> None:
        """Wait for some seconds of the simulation."""
        end = self.time() + seconds
        self.wait_until(lambda: self.time() >= end - 1e-9)

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition is so."""
        while not condition():
            self.pause(POLL_SECONDS)

    def inputs_are(self, signals: list[tuple[int, bool]]) -> bool:
        """Return whether inputs are on or off, as told."""
        names = [self._inputs.format(number) for number, _ in signals]
        values = {one.name: bool(one.value) for one in self.world.client.signals.read(names)}
        self.pause(0.0 if self.passing is None else POLL_SECONDS)
        return all(values[name] == on for name, (_, on) in zip(names, signals, strict=True))

    def set_outputs(self, signals: list[tuple[int, bool]]) -> None:
        """Set outputs on or off, all at one instant."""
        self.world.client.signals.set({self._outputs.format(number): on for number, on in signals})

    def set_analog(self, output: float, value: float) -> None:
        """Set an analog output to -5 to 5."""
        if not -5.0 <= value <= 5.0:
            raise RaplFault(f"an analog output is -5 to 5, not {value:g}")
        self.world.client.signals[ANALOG.format(int(output))] = float(value)

    def _watch_input(self) -> None:
        """Wait for a move, and stop it when the input of HALT ON is there."""
        assert self.halt_on is not None
        while not self.world.queue.rests:
            if self.inputs_are([self.halt_on]):
                self.world.halt()
                return
            self.pause(POLL_SECONDS)


def signals_of(program: Loaded, inputs: str, outputs: str) -> list[str]:
    """Return the names of the signals that programs name by number."""
    named = [inputs.format(number) for number in program.signals("input")]
    return named + [outputs.format(number) for number in program.signals("output")]
