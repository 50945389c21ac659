"""Debugger of a program whose code looks around before each statement: breakpoints, steps, and where it stands.

A program that stands holds its thread, in which it computes what others ask for meanwhile.
"""

from __future__ import annotations

import queue
import threading
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from concurrent.futures import TimeoutError as TooLate
from dataclasses import dataclass
from types import CodeType, FrameType
from typing import Any, Protocol, TypeVar

LONGEST_SECONDS = 1.0
"""Time (s of the wall clock) that an expression may take."""
_MOST_FRAMES = 1000
"""Number of entries of the call stack that are shown of an endless recursion."""
RUNS = "the program runs; it stands after a breakpoint or a pause"
"""Words for what can be done only where a program stands."""

Result = TypeVar("Result")


class WrongExpression(Exception):
    """An expression that can't be computed where the program stands; its message says why."""


@dataclass(frozen=True, slots=True)
class Breakpoint:
    """A line before which a program stops, if its condition is true; `line` is the one that is left of what was asked.

    `fault` says why there is none; it never stops a program then.
    """

    line: int
    condition: CodeType | None = None
    fault: str = ""


@dataclass(frozen=True, slots=True)
class Place:
    """An entry of the call stack: what is being done, and file and line; no frame where only the robot is."""

    name: str
    file: str
    line: int
    frame: FrameType | None


class Datum(Protocol):
    """A datum where a program stands."""

    @property
    def name(self) -> str:
        """The name."""
        ...

    @property
    def kind(self) -> str:
        """The type, in the language's words."""
        ...

    @property
    def text(self) -> str:
        """The value, as a program would write it."""
        ...

    @property
    def parts(self) -> list[Any]:
        """Elements or components, each a datum; none of a single value."""
        ...


@dataclass(frozen=True, slots=True)
class Scope:
    """Data that belong together; `local`: they are those of a call. `aside`: an editor opens it on demand alone."""

    name: str
    data: Callable[[], list[Any]]
    local: bool = False
    aside: bool = False


class Debugger(ABC):
    """Program that a debugger looks at; a language's task inherits it besides.

    Attributes:
        name: that of the task.
        files: the files of its program.
        stopped: is called, by the task's thread, where it stands: with `entry`, `breakpoint`, `step`, `pause` or
            `exception`, and words about it.
        stops_first: it stops before its first statement.
        stops_at_errors: it stops where an error was that nothing has handled, and ends then.
    """

    name: str
    files: frozenset[str]

    def __init__(self, *args: Any, **named: Any) -> None:  # noqa: ANN401 as the task has them
        """Set up; nothing runs yet. Arguments are those of the task."""
        super().__init__(*args, **named)
        self.stopped: Callable[[str, str], None] = lambda reason, told: None
        self.stops_first = self.stops_at_errors = False
        self._breakpoints: Mapping[str, Mapping[int, Breakpoint]] = {}
        self._step, self._depth = "", 0
        self._stepping: object = None
        self._pausing = self._let_go = self._given_up = False
        self._last: tuple[FrameType, int] | None = None
        self._standing: list[tuple[FrameType, int]] = []
        self._jobs: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()

    # What a language knows.

    @abstractmethod
    def stack(self) -> list[Place]:
        """Return the call stack where it stands, the innermost first."""

    @abstractmethod
    def scopes(self, frame: FrameType) -> list[Scope]:
        """Return the data that are known in a frame."""

    @abstractmethod
    def value(self, text: str, frame: FrameType) -> Datum:
        """Return the value of an expression in a frame; raises WrongExpression."""

    @abstractmethod
    def assign(self, datum: Any, text: str, frame: FrameType) -> None:  # noqa: ANN401 of the language's own class
        """Give a datum the value of an expression in a frame; raises WrongExpression."""

    @abstractmethod
    def stop(self, why: str = "stopped") -> None:
        """End the program, also where it stands; any thread may call it."""

    @abstractmethod
    def _is_own(self, frame: FrameType) -> bool:
        """Return whether a frame is that of a routine of the program."""

    @abstractmethod
    def _deep(self, frames: Iterable[tuple[FrameType, int]]) -> int:
        """Return how many routines are at work in frames."""

    @abstractmethod
    def _lines(self, file: str) -> Mapping[int, Any]:
        """Return the lines of a file before which it can stop, with the routine that each is in."""

    @abstractmethod
    def _condition(self, text: str, routine: Any, line: int) -> CodeType:  # noqa: ANN401 of the language's own class
        """Return the code of a condition in a line of a routine; raises WrongExpression."""

    @abstractmethod
    def _compute(self, code: CodeType, frame: FrameType) -> Any:  # noqa: ANN401 any value of the language
        """Return the value of an expression's code in a frame; raises WrongExpression."""

    # Before each statement.

    def _look(self, frame: FrameType) -> None:
        """Stop where that was asked for. A line that is come to twice with nothing between is one place."""
        line = frame.f_lineno
        again = self._last is not None and self._last[0] is frame and self._last[1] == line
        self._last = (frame, line)
        reason, told = "", ""
        if self._pausing:
            reason = "pause"
        elif again:
            return
        elif self.stops_first:
            reason = "entry"
        elif self._step and self._strand() is self._stepping and self._has_come(frame):
            reason = "step"
        at = None if again else self._breakpoints.get(frame.f_code.co_filename, {}).get(line)
        if at is not None and not reason:
            reached, told = self._is_so(at, frame)
            reason = "breakpoint" if reached else ""
        if reason:
            self.stops_first = self._pausing = False
            self._step = ""
            self._stand(self._frames(frame), reason, told)

    def _has_come(self, frame: FrameType) -> bool:
        """Return whether a step is over in a frame."""
        return self._step == "in" or self._deep(self._frames(frame)) <= self._depth

    def _strand(self) -> object:
        """Return which of the strands of a program that has several is at work; a step stays in its own."""
        return None

    def _frames(self, frame: FrameType | None) -> list[tuple[FrameType, int]]:
        """Return the frames of the program's routines with their lines, the innermost first."""
        found = []
        while frame is not None:
            if self._is_own(frame):
                found.append((frame, frame.f_lineno))
            frame = frame.f_back
        return found

    def _stand_at(self, errors: Iterable[BaseException | None], told: str) -> None:
        """Stand where errors were, one the cause of the other, if any was in the program's routines."""
        frames = [
            (one, number)
            for each in errors
            for one, number in traceback.walk_tb(None if each is None else each.__traceback__)
            if self._is_own(one)
        ]
        if frames:
            self._stand(frames[: -_MOST_FRAMES - 1 : -1], "exception", told)

    def _is_so(self, at: Breakpoint, frame: FrameType) -> tuple[bool, str]:
        """Return whether a breakpoint's condition is true, or why it can't be told, which stops the task, too."""
        if at.condition is None:
            return True, ""
        try:
            return bool(self._compute(at.condition, frame)), ""
        except WrongExpression as error:
            return True, f"the condition can't be computed: {error}"

    def _stand(self, frames: list[tuple[FrameType, int]], reason: str, told: str) -> None:
        """Stand until somebody has the task go on, and compute meanwhile what is asked for."""
        with self._lock:
            self._standing = frames
        self.stopped(reason, told)
        while self._standing and not self._let_go:
            job = self._jobs.get()
            if job is not None:
                job()
        with self._lock:
            self._standing = []
        while not self._jobs.empty():  # nobody waits in vain
            job = self._jobs.get()
            if job is not None:
                job()

    # What others ask for; any thread may.

    @property
    def stands(self) -> bool:
        """True where the task stands before a statement."""
        return bool(self._standing)

    @property
    def at(self) -> tuple[str, int] | None:
        """File and line of the statement that it does, or stands before; None before the first one."""
        last = self._last
        return None if last is None else (last[0].f_code.co_filename, last[1])

    @property
    def moves_at(self) -> str:
        """Place of the move that the robot makes, as `file:line`; nothing where it stands, or a language tells none."""
        return ""

    def go_on(self, step: str = "") -> None:
        """Have a task that stands go on: to the next statement (`in`), that of the same routine (`over`), or its end.

        `out` goes on to the next statement of whoever called the routine; without a step it goes on for good.
        """
        with self._lock:
            if not self._standing:
                raise WrongExpression(RUNS)
            self._step, self._stepping = step, self._strand()
            self._depth = self._deep(self._standing) - (step == "out")
            self._standing = []
        self._jobs.put(None)

    def halt(self) -> None:
        """Have the task stand before its next statement."""
        self._pausing = True

    def let_go(self) -> None:
        """Look at nothing from here on, and go on where it stands."""
        self._breakpoints, self._step, self._pausing, self.stops_first = {}, "", False, False
        self._let_go = True
        self._jobs.put(None)

    def set_breakpoints(self, file: str, asked: Mapping[int, str]) -> list[Breakpoint]:
        """Take breakpoints of a file in place of all that it had, by line with conditions, and return what they became.

        One on a line without a statement goes to the next line that has one.
        """
        lines = self._lines(file)
        found = [self._breakpoint(lines, line, condition) for line, condition in asked.items()]
        good = {one.line: one for one in found if not one.fault}
        self._breakpoints = {**self._breakpoints, file: good}
        return found

    def _breakpoint(self, lines: Mapping[int, Any], line: int, condition: str) -> Breakpoint:
        later = [one for one in lines if one >= line]
        if not later:
            return Breakpoint(line, fault="there is no statement in this line or after it")
        line = min(later)
        if not condition.strip():
            return Breakpoint(line)
        try:
            return Breakpoint(line, self._condition(condition, lines[line], line))
        except WrongExpression as error:
            return Breakpoint(line, fault=f"the condition can't be used: {error}")

    def _asked(self, work: Callable[[], Result]) -> Result:
        """Return what the task's own thread finds where it stands; raises WrongExpression where it doesn't."""
        future: Future[Result] = Future()

        def job() -> None:
            try:
                future.set_result(work())
            except WrongExpression as error:
                future.set_exception(error)
            except BaseException as error:  # whoever asks waits for an answer
                future.set_exception(WrongExpression(f"{type(error).__name__}: {error}"))

        with self._lock:
            if not self._standing:
                raise WrongExpression(RUNS)
            self._jobs.put(job)
        try:
            return future.result(LONGEST_SECONDS)
        except TooLate:
            self._given_up = True
            return future.result()
