"""Debugger of a script in URScript on an emulated controller, whose time stands while the script stands."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import CodeType, FrameType
from typing import Any

from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.languages.core.debugger import Debugger, Place, Scope, WrongExpression
from virtualrobot_apps.languages.core.diagnostics import Diagnostics, did_you_mean
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Failed
from virtualrobot_apps.languages.urscript import tree
from virtualrobot_apps.languages.urscript.check import statements_of
from virtualrobot_apps.languages.urscript.expressions import ExpressionParser
from virtualrobot_apps.languages.urscript.faults import ScriptFault, ScriptHalted
from virtualrobot_apps.languages.urscript.generate import MAIN, Generator
from virtualrobot_apps.languages.urscript.robot import RobotTask
from virtualrobot_apps.languages.urscript.table import BUILTINS
from virtualrobot_apps.languages.urscript.task import Loaded, Own, Thread, told
from virtualrobot_apps.languages.urscript.values import Struct, copied, kind_of, text


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable, element or component: what holds it, and where there."""

    name: str
    holder: Any
    index: Any

    @property
    def kind(self) -> str:
        """The kind of value, in words."""
        return kind_of(self.holder[self.index])

    @property
    def text(self) -> str:
        """The value as the controller writes it; a string in quotes."""
        value = self.holder[self.index]
        return f'"{value}"' if isinstance(value, str) else text(value)

    @property
    def parts(self) -> list[Variable]:
        """The elements of a list or pose, or the components of a struct."""
        value = self.holder[self.index]
        if isinstance(value, list):
            return [Variable(f"[{number}]", value, number) for number in range(len(value))]
        return [Variable(name, value, name) for name in value] if type(value) is Struct else []


class DebuggedScript(Debugger, RobotTask):
    """A script that a debugger looks at; it was loaded as `debugged`."""

    def __init__(self, loaded: Loaded, controller: Controller) -> None:
        """Begin before the first statement."""
        super().__init__(loaded, controller)
        self.name = loaded.name
        self.files = frozenset([loaded.source.file])
        self._checked = loaded.checked
        self._functions = {MAIN: loaded.checked.script.main}
        self._functions |= {f"f_{name}": one for name, one in loaded.checked.functions.items()}

    def look(self) -> None:
        """Look around before a statement; generated code calls it."""
        if not self._let_go:
            self._look(sys._getframe(1))
        if self._let_go:
            raise ScriptHalted

    def stop(self, why: str = "stopped") -> None:
        """End the script, also where it stands; any thread may call it."""
        self.let_go()

    @property
    def ended(self) -> bool:
        """True where it was stopped."""
        return self._let_go

    def _turn(self, thread: Thread) -> None:
        try:
            super()._turn(thread)
        except ScriptFault as fault:
            if self.stops_at_errors:
                self._stand_at((fault.__cause__,), str(fault))
            raise

    def _stand(self, frames: list[tuple[FrameType, int]], reason: str, told: str) -> None:
        """Stand, and have the arm rest meanwhile: a robot in a kernel has a time of its own."""
        self.controller.body.halt()
        super()._stand(frames, reason, told)

    def _strand(self) -> Thread:
        return self.thread

    def _is_own(self, frame: FrameType) -> bool:
        return frame.f_code.co_filename in self.files and frame.f_code.co_name in self._functions

    def _deep(self, frames: Iterable[tuple[FrameType, int]]) -> int:
        return sum(1 for _ in frames)

    def _lines(self, file: str) -> Mapping[int, tree.Function]:
        at = self.loaded.source.line
        return {
            at(one.at): function
            for function in self._functions.values()
            for one in statements_of(function.body)
            if not isinstance(one, tree.Function)
        }

    def _function(self, frame: FrameType) -> tree.Function:
        return self._functions[frame.f_code.co_name]

    # What is asked where it stands.

    def stack(self) -> list[Place]:
        """Return the call stack of the thread that stands, the innermost first."""
        return [Place(self._function(one).name, one.f_code.co_filename, line, one) for one, line in self._standing]

    def scopes(self, frame: FrameType) -> list[Scope]:
        """Return the own variables of a frame's function, and those of the script."""
        own: Own = frame.f_locals.get("own", Own())
        every = self.names
        found = [] if frame.f_code.co_name == MAIN else [Scope("Function", lambda: _variables(own, "v_"), local=True)]
        return [*found, Scope("Script", lambda: _variables(every, "g_"), local=not found)]

    def value(self, text: str, frame: FrameType) -> Variable:
        """Return the value of an expression in a frame; raises WrongExpression."""
        code = self._compiled(text, self._function(frame), "{}")
        return Variable(text, [self._asked(lambda: self._compute(code, frame))], 0)

    def assign(self, datum: Variable, text: str, frame: FrameType) -> None:
        """Give a variable the value of an expression in a frame; raises WrongExpression."""
        code = self._compiled(text, self._function(frame), "{}")

        def put() -> None:
            value = copied(self._compute(code, frame))
            if kind_of(value) != kind_of(datum.holder[datum.index]):
                raise WrongExpression(f"the value must be {datum.kind}, as it is, not {kind_of(value)}")
            datum.holder[datum.index] = value

        self._asked(put)

    def _condition(self, text: str, routine: tree.Function, line: int) -> CodeType:
        return self._compiled(text, routine, "truth({})")

    def _compiled(self, given: str, function: tree.Function, form: str) -> CodeType:
        """Return the code of an expression in a function, within a form; raises WrongExpression."""
        diagnostics = Diagnostics()
        try:
            parser = ExpressionParser(Source(given, "expression"), diagnostics)
            node = parser.expression()
            if parser.kind != "newline":
                parser.fail("the end of the expression")
        except Failed:
            node = tree.Truth(0, False)
        if len(diagnostics):
            raise WrongExpression(diagnostics.sorted()[0].message)
        own = self._checked.own.get(function.name, set())
        for one in _within(node):
            if isinstance(one, tree.Run) or (isinstance(one, tree.Call) and one.name in self._checked.functions):
                raise WrongExpression("functions and threads of the script are not begun where it stands")
            if isinstance(one, tree.Call) and one.name != "struct":
                self._check_call(one)
            if isinstance(one, tree.Name) and one.name not in own | self._checked.globals:
                known = did_you_mean(one.name, own | self._checked.globals)
                raise WrongExpression(f"there is no variable {one.name!r} here{known}")
        return compile(
            form.format(Generator(self._checked, debugged=True).within(own).value(node)), "expression", "eval"
        )

    def _check_call(self, call: tree.Call) -> None:
        builtin = BUILTINS.get(call.name)
        if builtin is None:
            raise WrongExpression(f"there is no function {call.name!r}")
        if builtin.waits:
            raise WrongExpression(f"{call.name!r} takes time, which stands while the script does")
        names = [one.name for one in builtin.parameters]
        given = [one.name or name for one, name in zip(call.arguments, names, strict=False)]
        lacking = [one.name for one in builtin.parameters if one.value is None and one.name not in given]
        if len(given) < len(call.arguments) or not {*given} <= {*names} or lacking:
            raise WrongExpression(f"{call.name!r} takes {', '.join(names) or 'nothing'}")

    def _compute(self, code: CodeType, frame: FrameType) -> Any:  # noqa: ANN401 any value of URScript
        try:
            return eval(code, self.names, {"own": frame.f_locals.get("own", Own())})
        except (ScriptFault, ArithmeticError, ValueError, NameError, RecursionError) as error:
            raise WrongExpression(told(error)) from error


def _variables(held: dict[str, Any], prefix: str) -> list[Variable]:
    return [Variable(name.removeprefix(prefix), held, name) for name in held if name.startswith(prefix)]


def _within(node: Any) -> Iterable[Any]:  # noqa: ANN401 any node of an expression
    """Yield a node of an expression and those within it."""
    if isinstance(node, list):
        for one in node:
            yield from _within(one)
    elif hasattr(node, "at"):
        yield node
        for name in node.__slots__:
            yield from _within(getattr(node, name))
