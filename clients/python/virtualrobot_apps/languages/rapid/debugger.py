"""Debugger of a task of RAPID: breakpoints, steps, and the stack and the data where it stands.

Generated code looks at `flags` before each statement. A debugged task has code that sees flags each time, and so comes
to the debugger; other tasks know nothing of one.
"""

from __future__ import annotations

import queue
import sys
import threading
import traceback
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from concurrent.futures import TimeoutError as TooLate
from dataclasses import dataclass
from types import CodeType, FrameType
from typing import Any, TypeVar

from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.faults import (
    CAUGHT,
    ProgramEnded,
    RapidFault,
    RapidStopped,
    as_fault,
)
from virtualrobot_apps.languages.rapid.inspection import Inspection, Slot, WrongExpression
from virtualrobot_apps.languages.rapid.symbols import ModuleScope, RoutineSymbol
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.types import BOOL

LONGEST_SECONDS = 1.0
"""Time (s of the wall clock) that an expression may take."""

_MOST_FRAMES = 1000
"""Number of entries of the call stack that are shown of an endless recursion."""

RUNS = "the program runs; it stands after a breakpoint or a pause"
"""Words for what can be done only where a task stands."""

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Breakpoint:
    """A line before which a task stops, if its condition is true; `line` is the one that is left of what was asked for.

    `fault` says why there is none; it never stops a task then.
    """

    line: int
    condition: CodeType | None = None
    fault: str = ""


@dataclass(frozen=True, slots=True)
class Place:
    """An entry of the call stack: what is being done, and file and line."""

    name: str
    file: str
    line: int
    frame: FrameType | None


class DebuggedTask(RapidTask):
    """A task that a debugger looks at; its program was loaded as `debugged`.

    Attributes:
        stopped: is called, by the task's thread, where it stands: with `entry`, `breakpoint`, `step`, `pause` or
            `exception`, and words about it.
        stops_first: it stops before its first statement.
        stops_at_errors: it stops where an error was that nothing has handled, and ends then.
    """

    def __init__(self, *args: Any, **named: Any) -> None:  # noqa: ANN401 as RapidTask has them
        """Set up the data; nothing runs yet. Arguments are those of a task."""
        super().__init__(*args, **named)
        self.stopped: Callable[[str, str], None] = lambda reason, told: None
        self.stops_first = self.stops_at_errors = False
        self._breakpoints: Mapping[str, Mapping[int, Breakpoint]] = {}
        self._step, self._depth = "", 0
        self._pausing = self._computing = self._given_up = False
        self._last: tuple[FrameType, int] | None = None
        self._standing: list[tuple[FrameType, int]] = []
        self._jobs: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._files = frozenset(self.program.files)
        self.inspection = Inspection(self.program.checked, self._names)
        self._names |= {"flags": (True,), "poll": self._at_statement}

    # Before each statement.

    def _at_statement(self) -> None:
        frame = sys._getframe(1)
        if self._computing:
            if self._given_up:
                raise RapidFault("ERR_ARGVALERR", f"this takes longer than {LONGEST_SECONDS:g} s")
        else:
            self._look(frame)
        if self.flags:
            self.poll()

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
        elif self._step == "in" or (self._step and self._deep(self._frames(frame)) <= self._depth):
            reason = "step"
        at = None if again else self._breakpoints.get(frame.f_code.co_filename, {}).get(line)
        if at is not None and not reason:
            reached, told = self._is_so(at, frame)
            reason = "breakpoint" if reached else ""
        if reason:
            self.stops_first = self._pausing = False
            self._step = ""
            self._stand(self._frames(frame), reason, told)

    def _deep(self, frames: Iterable[tuple[FrameType, int]]) -> int:
        """Return how many routines are at work; an error handler is in its routine."""
        return sum(one.f_code.co_name in self.inspection.routines for one, _ in frames)

    def _frames(self, frame: FrameType | None) -> list[tuple[FrameType, int]]:
        """Return the frames of the program's routines with their lines, the innermost first."""
        found = []
        while frame is not None:
            if self._is_own(frame):
                found.append((frame, frame.f_lineno))
            frame = frame.f_back
        return found

    def _is_own(self, frame: FrameType) -> bool:
        return frame.f_code.co_filename in self._files and frame.f_code.co_name != "<module>"

    def _undo(self) -> None:
        """Stand where an error was, if that was asked for, and do the UNDO parts."""
        error = sys.exc_info()[1]
        if self.stops_at_errors and isinstance(error, (*CAUGHT, VirtualRobotError, RecursionError)):
            cause = error.__cause__ if isinstance(error, RapidStopped) else None
            told = str(as_fault(error)) if isinstance(error, CAUGHT) else str(error)
            frames = [
                (one, number)
                for each in (error, cause)
                for one, number in traceback.walk_tb(None if each is None else each.__traceback__)
                if self._is_own(one)
            ]
            if frames:
                self._stand(frames[: -_MOST_FRAMES - 1 : -1], "exception", told)
        super()._undo()

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
        while self._standing and not self._why:
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

    def go_on(self, step: str = "") -> None:
        """Have a task that stands go on: to the next statement (`in`), that of the same routine (`over`), or its end.

        `out` goes on to the next statement of whoever called the routine; without a step it goes on for good.
        """
        with self._lock:
            if not self._standing:
                raise WrongExpression(RUNS)
            self._step = step
            self._depth = self._deep(self._standing) - (step == "out")
            self._standing = []
        self._jobs.put(None)

    def halt(self) -> None:
        """Have the task stand before its next statement."""
        self._pausing = True

    def stop(self, why: str = "stopped") -> None:
        """End the program, also where it stands; its UNDO parts are done without a stop."""
        self._breakpoints, self._step, self._pausing, self.stops_first = {}, "", False, False
        super().stop(why)
        self._jobs.put(None)

    def set_breakpoints(self, file: str, asked: Mapping[int, str]) -> list[Breakpoint]:
        """Take breakpoints of a file in place of all that it had, by line with conditions, and return what they became.

        One on a line without a statement goes to the next line that has one.
        """
        found = [self._breakpoint(file, line, condition) for line, condition in asked.items()]
        good = {one.line: one for one in found if not one.fault}
        self._breakpoints = {**self._breakpoints, file: good}
        return found

    def _breakpoint(self, file: str, line: int, condition: str) -> Breakpoint:
        lines = {
            scope.module.source.line(one.at): routine
            for scope in self.program.checked.modules
            if scope.module.source.file == file
            for routine in scope.routines
            for one in _stops(routine)
        }
        later = [one for one in lines if one >= line]
        if not later:
            return Breakpoint(line, fault="there is no statement in this line or after it")
        line = min(later)
        if not condition.strip():
            return Breakpoint(line)
        try:
            return Breakpoint(line, self.inspection.compiled(condition, lines[line], line, BOOL)[0])
        except WrongExpression as error:
            return Breakpoint(line, fault=f"the condition can't be used: {error}")

    # What is asked where it stands.

    def stack(self) -> list[Place]:
        """Return the call stack from the program pointer on, and last, where the robot is elsewhere, its place."""
        found = [Place(self._title(one), one.f_code.co_filename, number, one) for one, number in self._standing]
        file, _, line = self.motion_pointer().rpartition(":")
        if file:
            found.append(Place("motion pointer", file, int(line), None))
        return found

    def motion_pointer(self) -> str:
        """Return the place of the move that the robot makes, as `file:line`; nothing where it stands or is none."""
        try:
            return self.world.queue.doing() if self.has_robot else ""
        except VirtualRobotError:
            return ""

    def _title(self, frame: FrameType) -> str:
        name = self.inspection.routine(frame).node.name
        return name + {"handler": " ERROR", "undo": " UNDO"}.get(frame.f_code.co_name, "")

    def scopes(self, frame: FrameType) -> tuple[list[Slot], ModuleScope, list[ModuleScope]]:
        """Return the data of a frame's routine, its module, and the other modules of the program."""
        routine = self.inspection.routine(frame)
        others = [one for one in self.program.checked.modules if one is not routine.module]
        return self.inspection.of_routine(frame), routine.module, others

    def value(self, text: str, frame: FrameType) -> Slot:
        """Return the value of an expression in a frame; raises WrongExpression."""
        code, kind = self.inspection.compiled(text, self.inspection.routine(frame), frame.f_lineno)
        return Slot(text, kind, [self._asked(lambda: self._compute(code, frame))], 0, True)

    def assign(self, slot: Slot, text: str, frame: FrameType) -> None:
        """Give a datum the value of an expression in a frame; raises WrongExpression."""
        if slot.constant:
            raise WrongExpression(f"{slot.name!r} can't be changed")
        routine = self.inspection.routine(frame)
        code, _ = self.inspection.compiled(text, routine, frame.f_lineno, slot.type)
        self._asked(lambda: slot.set(self._compute(code, frame)))

    def _asked(self, work: Callable[[], Result]) -> Result:
        """Return what the task's own thread finds where it stands; raises WrongExpression where it doesn't."""
        future: Future[Result] = Future()

        def job() -> None:
            try:
                future.set_result(work())
            except WrongExpression as error:
                future.set_exception(error)
            except (Exception, TaskStopped) as error:  # whoever asks waits for an answer
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

    def _compute(self, code: CodeType, frame: FrameType) -> Any:  # noqa: ANN401 any value of RAPID
        self._computing, self._given_up = True, False
        try:
            return self.inspection.computed(code, frame)
        except CAUGHT as error:
            raise WrongExpression(str(as_fault(error))) from error
        except (VirtualRobotError, RecursionError) as error:
            raise WrongExpression(str(error)) from error
        except ProgramEnded as error:
            raise WrongExpression("this would end the program") from error
        finally:
            self._computing = False


def _stops(routine: RoutineSymbol) -> list[tree.Statement]:
    """Return the statements of a routine before which a task can stop."""
    node = routine.node
    parts = [*node.body, *(node.handler or ()), *(node.undo or ())]
    found = [inner for one in parts for inner in (one, *tree.statements_within(one))]
    return [one for one in found if not isinstance(one, tree.Data | tree.Label)]
