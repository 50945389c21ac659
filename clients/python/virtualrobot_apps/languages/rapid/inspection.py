"""Inspection of a program that stands: the data that its routines have, and expressions of RAPID in them."""

from __future__ import annotations

from dataclasses import dataclass
from types import CodeType, FrameType
from typing import Any

from virtualrobot_apps.languages.core.debugger import WrongExpression
from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Failed
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.check import Checked
from virtualrobot_apps.languages.rapid.expressions import ExpressionParser
from virtualrobot_apps.languages.rapid.generate_values import Values
from virtualrobot_apps.languages.rapid.meaning import Meaning
from virtualrobot_apps.languages.rapid.support import copied
from virtualrobot_apps.languages.rapid.symbols import ModuleScope, RoutineSymbol
from virtualrobot_apps.languages.rapid.types import ANY, SIGNALS, Type, Types
from virtualrobot_apps.languages.rapid.values import Clock, value_text


@dataclass(frozen=True, slots=True)
class Slot:
    """A datum of a program that stands: the list that holds it, and the index there.

    Attributes:
        name: its name, of a component or element that within the datum.
        type: its type.
        types: those of the program.
        holder: the list.
        index: the index.
        constant: it can't be changed.
    """

    name: str
    type: Type
    types: Types
    holder: list[Any]
    index: int
    constant: bool = False

    @property
    def kind(self) -> str:
        """The type's name."""
        return str(self.type)

    @property
    def text(self) -> str:
        """The value, as a program would write it."""
        value = self.holder[self.index]
        if self.type.name in SIGNALS:
            return str(value)
        return value_text(value.read()) if isinstance(value, Clock) else value_text(value)

    @property
    def parts(self) -> list[Slot]:
        """The elements of an array, or the components of a record."""
        value = self.holder[self.index]
        if not isinstance(value, list):
            return []
        if self.type.dimensions:
            inner = Type(self.type.name, self.type.dimensions - 1)
            return [
                Slot(f"{{{number + 1}}}", inner, self.types, value, number, self.constant)
                for number in range(len(value))
            ]
        return [
            Slot(name, Type(self.types.resolved(kind) or "any"), self.types, value, number, self.constant)
            for number, (kind, name) in enumerate(self.types.components(self.type.name))
        ]

    def set(self, value: Any) -> None:  # noqa: ANN401 any value of RAPID
        """Give it a value of its type; a record or array stays the same list."""
        if isinstance(value, list):
            self.holder[self.index][:] = copied(value)
        else:
            self.holder[self.index] = value


class Inspection:
    """Data and expressions of one program, of which routines are told by the names of their functions in Python."""

    def __init__(self, checked: Checked, names: dict[str, Any]) -> None:
        """Look at a program; `names` are those that its code was run with."""
        self._checked, self._names = checked, names
        self.routines = {one.python: one for scope in checked.modules for one in scope.routines}

    def routine(self, frame: FrameType) -> RoutineSymbol:
        """Return the routine of a frame, of which its error handler and its UNDO part are functions within."""
        return self.routines[frame.f_code.co_qualname.partition(".")[0]]

    # Data.

    def slot(self, name: str, kind: Type, holder: list[Any], index: int, constant: bool) -> Slot:
        """Return a datum of the program."""
        return Slot(name, kind, self._checked.types, holder, index, constant)

    def of_routine(self, frame: FrameType) -> list[Slot]:
        """Return parameters and variables that a frame's routine has by now."""
        routine, found, local = self.routine(frame), [], self.local(frame)
        for datum in routine.data:
            constant = datum.storage == "const" or datum.type.name in SIGNALS
            if datum.storage in ("inout", "pers"):
                holder, index = local.get(f"c_{datum.python}"), local.get(f"i_{datum.python}", 0)
            else:
                value = local.get(datum.python)
                holder, index = (value if datum.boxable or value is None else [value]), 0
            if isinstance(holder, list) and holder[index] is not None:
                found.append(self.slot(datum.name, datum.type, holder, index, constant))
        line = frame.f_lineno
        for loop in _loops(routine, line):
            if loop.symbol.python in local:
                found.append(self.slot(loop.name, loop.symbol.type, [local[loop.symbol.python]], 0, True))
        return found

    def of_module(self, scope: ModuleScope) -> list[Slot]:
        """Return the data that a module declares."""
        data = [one.symbol for one in scope.module.declarations if isinstance(one, tree.Data)]
        return [self.slot(one.name, one.type, self._names[one.python], 0, one.storage == "const") for one in data]

    def local(self, frame: FrameType) -> dict[str, Any]:
        """Return the locals of a frame's routine, by their names in Python."""
        qualified, around = frame.f_code.co_qualname.partition("."), frame.f_back
        found = dict(frame.f_locals)
        while qualified[1] and around is not None:
            if around.f_code.co_qualname == qualified[0] and around.f_code.co_filename == frame.f_code.co_filename:
                return {**around.f_locals, **found}
            around = around.f_back
        return found

    # Expressions.

    def compiled(
        self, text: str, routine: RoutineSymbol, line: int, wanted: Type | None = None
    ) -> tuple[CodeType, Type]:
        """Return code and type of an expression in a line of a routine; raises WrongExpression for one that is none.

        `wanted` is the type that it must have.
        """
        diagnostics = Diagnostics()
        parser = ExpressionParser(Source(text, "expression"), diagnostics)
        try:
            node = parser.expression()
            if parser.kind != "end":
                parser.fail("the end of the expression")
        except Failed:
            node = tree.Truth(0, False)
        except RecursionError:
            raise WrongExpression("brackets are too deep within each other") from None
        meaning = Meaning(diagnostics)
        meaning.source = parser.source
        meaning.types, meaning.globals, meaning.uses = (
            self._checked.types,
            self._checked.globals,
            {**self._checked.uses},
        )
        loops = {one.name.lower(): one.symbol for one in _loops(routine, line)}
        meaning.scopes = [routine.module.names, {one.name.lower(): one for one in routine.data}, loops]
        referenced = [one for one in routine.data if one.referenced]
        kind = wanted or ANY
        if not len(diagnostics):
            if wanted is not None:
                meaning.expect(node, wanted, "the value")
            else:
                kind = meaning.type_of(node)
            meaning.resolve_signals()
        for one in routine.data:
            one.referenced = one in referenced
        if len(diagnostics):
            raise WrongExpression(diagnostics.sorted()[0].message)
        values = Values(self._checked.types)
        values.boxed = {id(one) for one in routine.data if one.boxable}
        return compile(values.value(node), "expression", "eval"), kind

    def computed(self, code: CodeType, frame: FrameType) -> Any:  # noqa: ANN401 any value of RAPID
        """Return the value of an expression where a frame stands; raises what its computing does."""
        try:
            return eval(code, self._names, self.local(frame))
        except NameError as error:
            raise WrongExpression("a variable in it has no value yet") from error


def _loops(routine: RoutineSymbol, line: int) -> list[tree.For]:
    """Return the loops of a routine that a line is in."""
    at = routine.module.module.source.line
    found = []
    for one in tree.statements_within(routine.node):
        if isinstance(one, tree.For) and one.symbol is not None:
            last = max((at(inner.at) for inner in tree.statements_within(one)), default=at(one.at))
            if at(one.at) <= line <= last:
                found.append(one)
    return found
