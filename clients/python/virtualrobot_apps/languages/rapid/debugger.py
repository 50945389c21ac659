"""Debugger of a task of RAPID: breakpoints, steps, and the stack and the data where it stands.

Generated code looks at `flags` before each statement. A debugged task has code that sees flags each time, and so comes
to the debugger; other tasks know nothing of one.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from types import CodeType, FrameType
from typing import Any

from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.languages.core.debugger import LONGEST_SECONDS, Debugger, Place, Scope, WrongExpression
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.faults import (
    CAUGHT,
    ProgramEnded,
    RapidFault,
    RapidStopped,
    as_fault,
)
from virtualrobot_apps.languages.rapid.inspection import Inspection, Slot
from virtualrobot_apps.languages.rapid.symbols import RoutineSymbol
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.types import BOOL


class DebuggedTask(Debugger, RapidTask):
    """A task that a debugger looks at; its program was loaded as `debugged`."""

    def __init__(self, *args: Any, **named: Any) -> None:  # noqa: ANN401 as RapidTask has them
        """Set up the data; nothing runs yet. Arguments are those of a task."""
        super().__init__(*args, **named)
        self._computing = False
        self.files = frozenset(self.program.files)
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

    def _deep(self, frames: Iterable[tuple[FrameType, int]]) -> int:
        """Return how many routines are at work; an error handler is in its routine."""
        return sum(one.f_code.co_name in self.inspection.routines for one, _ in frames)

    def _is_own(self, frame: FrameType) -> bool:
        return frame.f_code.co_filename in self.files and frame.f_code.co_name != "<module>"

    def _undo(self) -> None:
        """Stand where an error was, if that was asked for, and do the UNDO parts."""
        error = sys.exc_info()[1]
        if self.stops_at_errors and isinstance(error, (*CAUGHT, VirtualRobotError, RecursionError)):
            cause = error.__cause__ if isinstance(error, RapidStopped) else None
            self._stand_at((error, cause), str(as_fault(error)) if isinstance(error, CAUGHT) else str(error))
        super()._undo()

    # What others ask for; any thread may.

    def stop(self, why: str = "stopped") -> None:
        """End the program, also where it stands; its UNDO parts are done without a stop."""
        RapidTask.stop(self, why)
        self.let_go()

    def _lines(self, file: str) -> Mapping[int, RoutineSymbol]:
        return {
            scope.module.source.line(one.at): routine
            for scope in self.program.checked.modules
            if scope.module.source.file == file
            for routine in scope.routines
            for one in _stops(routine)
        }

    def _condition(self, text: str, routine: RoutineSymbol, line: int) -> CodeType:
        return self.inspection.compiled(text, routine, line, BOOL)[0]

    # What is asked where it stands.

    def stack(self) -> list[Place]:
        """Return the call stack from the program pointer on, and last, where the robot is elsewhere, its place."""
        found = [Place(self._title(one), one.f_code.co_filename, number, one) for one, number in self._standing]
        file, _, line = self.moves_at.rpartition(":")
        if file:
            found.append(Place("motion pointer", file, int(line), None))
        return found

    @property
    def moves_at(self) -> str:
        """Place of the move that the robot makes, as `file:line`; nothing where it stands or is none."""
        try:
            return self.world.queue.doing() if self.has_robot else ""
        except VirtualRobotError:
            return ""

    def _title(self, frame: FrameType) -> str:
        name = self.inspection.routine(frame).node.name
        return name + {"handler": " ERROR", "undo": " UNDO"}.get(frame.f_code.co_name, "")

    def scopes(self, frame: FrameType) -> list[Scope]:
        """Return the data of a frame's routine, its module, and the other modules of the program."""
        routine = self.inspection.routine(frame)
        data = self.inspection.of_routine(frame)
        modules = [routine.module, *(one for one in self.program.checked.modules if one is not routine.module)]
        return [
            Scope("Routine", lambda: data, local=True),
            *(
                Scope(
                    f"Module {one.module.name}",
                    lambda one=one: self.inspection.of_module(one),
                    aside=one is not routine.module,
                )
                for one in modules
            ),
        ]

    def value(self, text: str, frame: FrameType) -> Slot:
        """Return the value of an expression in a frame; raises WrongExpression."""
        code, kind = self.inspection.compiled(text, self.inspection.routine(frame), frame.f_lineno)
        return self.inspection.slot(text, kind, [self._asked(lambda: self._compute(code, frame))], 0, True)

    def assign(self, datum: Slot, text: str, frame: FrameType) -> None:
        """Give a datum the value of an expression in a frame; raises WrongExpression."""
        if datum.constant:
            raise WrongExpression(f"{datum.name!r} can't be changed")
        routine = self.inspection.routine(frame)
        code, _ = self.inspection.compiled(text, routine, frame.f_lineno, datum.type)
        self._asked(lambda: datum.set(self._compute(code, frame)))

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
