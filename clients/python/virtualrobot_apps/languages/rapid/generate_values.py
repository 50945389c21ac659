"""Generator of Python expressions: values, variables and calls of a checked program."""

from __future__ import annotations

from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.symbols import Datum, RoutineSymbol
from virtualrobot_apps.languages.rapid.table import Builtin
from virtualrobot_apps.languages.rapid.types import SIGNALS, Type, Types

_OPERATORS = {"=": "==", "<>": "!=", "and": "and", "or": "or", "xor": "!="}
_FUNCTIONS = {
    ("div", "num", "num"): "divided",
    ("div", "dnum", "dnum"): "divided",
    ("mod", "num", "num"): "remainder",
    ("mod", "dnum", "dnum"): "remainder",
    ("+", "string", "string"): "joined",
    ("+", "pos", "pos"): "vector_sum",
    ("-", "pos", "pos"): "vector_difference",
    ("*", "pos", "num"): "scaled",
    ("*", "pos", "pos"): "vector_product",
    ("*", "orient", "orient"): "linked",
}
"""The functions of operators on types for which Python has no operator of the same meaning."""

_DEFAULTS = {
    **{"num": "0.0", "dnum": "0.0", "bool": "False", "string": "''"},
    **{"clock": "task.clock()", "socketdev": "task.socket()", "iodev": "task.file()", "dir": "task.folder()"},
    **{"rawbytes": "b''", "syncident": "''", "shapedata": "None"},
}
"""First values of atomic types."""

_OF_MOVES = ("tooldata", "wobjdata", "loaddata", "speeddata", "zonedata", "robtarget", "jointtarget")
"""Types of data that moves take, for which the program waits in no case."""


class Values:
    """Values, variables and calls as text of Python."""

    def __init__(self, types: Types) -> None:
        """Begin outside of any routine."""
        self.types = types
        self.boxed: set[int] = set()
        self.in_handler = False

    def value(self, node: tree.Expression) -> str:
        """Return an expression's value."""
        match node:
            case tree.Number() | tree.Text() | tree.Truth():
                return repr(node.value)
            case tree.Name():
                return self.datum(node.symbol)
            case tree.Component():
                return f"{self.value(node.of)}[{node.index}]"
            case tree.Element():
                text = self.value(node.of)
                for index in node.indices:
                    text = f"{text}[place({text}, {self.value(index)})]"
                return text
            case tree.Aggregate():
                return f"[{', '.join(map(self.value, node.items))}]"
            case tree.Call():
                return self.called(node)
            case tree.Unary():
                return self._unary(node)
            case tree.Binary():
                return self._binary(node)

    def datum(self, datum: Datum) -> str:
        """Return the value of what a name stands for."""
        if datum.storage == "signal":
            return f"task.signal_value({datum.name!r})"
        if datum.type.name in SIGNALS:
            return f"task.signal_value({self._raw(datum)})"
        text = self._raw(datum)
        if datum.optional:
            name = datum.name
            if datum.storage in ("inout", "pers") and not datum.shared:
                return f"given(c_{datum.python}, {name!r})[i_{datum.python}]"
            return f"given({text}, {name!r})"
        return text

    def _raw(self, datum: Datum) -> str:
        """Return the value as it is, None of an optional parameter that was left out."""
        if datum.shared:
            return f"{self._holder(datum)}[0]"
        if datum.storage in ("inout", "pers"):
            return (
                f"(c_{datum.python} and c_{datum.python}[i_{datum.python}])"
                if datum.optional
                else f"c_{datum.python}[i_{datum.python}]"
            )
        return f"{datum.python}[0]" if id(datum) in self.boxed else datum.python

    def _holder(self, datum: Datum) -> str:
        """Return the list that holds a datum of a module; one that other tasks see is looked at in time."""
        return f"seen({datum.python})" if datum.common and datum.type.name not in _OF_MOVES else datum.python

    def variable(self, node: tree.Expression) -> tuple[str, str]:
        """Return the list that holds a variable and the index there; of a value a list of its own."""
        match node:
            case tree.Name(symbol=Datum() as datum) if datum.storage not in ("signal",):
                if datum.shared:
                    return self._holder(datum), "0"
                if id(datum) in self.boxed:
                    return datum.python, "0"
                if datum.storage in ("inout", "pers"):
                    return f"c_{datum.python}", f"i_{datum.python}"
                return f"[{datum.python}]", "0"
            case tree.Component():
                return self.value(node.of), str(node.index)
            case tree.Element():
                text = self.value(node.of)
                for index in node.indices[:-1]:
                    text = f"{text}[place({text}, {self.value(index)})]"
                return text, f"place({text}, {self.value(node.indices[-1])})"
            case _:
                return f"[{self.value(node)}]", "0"

    def assigned(self, node: tree.Assign) -> str:
        """Return an assignment; a record or array takes the values of another one, and stays the same list."""
        value = self.value(node.value)
        if node.atomic:
            if isinstance(node.target, tree.Name) and not node.target.symbol.shared:
                datum = node.target.symbol
                if datum.storage not in ("inout", "pers") and id(datum) not in self.boxed:
                    return f"{datum.python} = {value}"
            holder, index = self.variable(node.target)
            return f"{holder}[{index}] = {value}"
        return f"{self.value(node.target)}[:] = copied({value})"

    def called(self, node: tree.Call) -> str:
        """Return a call of a routine or of what comes with the language."""
        if node.late is not None:
            variables = ", ".join(f"({holder}, {index})" for holder, index in map(self._late, node.arguments))
            return f"task.call_late({self.value(node.late)}, [{variables}])"
        target = node.target
        if isinstance(target, Builtin) and target.name == "Present":
            return self._present(node)
        parameters = target.parameters if isinstance(target, Builtin) else [one for one, _ in target.parameters]
        lazy = target.lazy if isinstance(target, Builtin) else frozenset()
        given: list[str] = []
        for parameter, argument in zip(parameters, node.given, strict=True):
            texts = self._argument(parameter, argument)
            given += [f"lambda: {texts[0]}"] if parameter.name.lower() in lazy else texts
        if isinstance(target, RoutineSymbol):
            return f"{target.python}({', '.join(given)})"
        return f"b_{target.name.lower()}({', '.join(['task', *given])})"

    def _late(self, argument: tree.Argument) -> tuple[str, str]:
        assert argument.value is not None
        return self.variable(argument.value)

    def _present(self, node: tree.Call) -> str:
        argument = node.given[0]
        symbol = argument.value.symbol if isinstance(argument.value, tree.Name) else None
        if isinstance(symbol, Datum) and symbol.optional:
            holder = symbol.storage in ("inout", "pers")
            return f"(c_{symbol.python} is not None)" if holder else f"({self._raw(symbol)} is not None)"
        return "True"

    def _argument(self, parameter: tree.Parameter, argument: tree.Argument | None) -> list[str]:
        by_value = parameter.mode == "in"
        if argument is None:
            return ["None"] if by_value else ["None", "0"]
        if argument.condition is not None:
            if by_value:
                return [self._raw(argument.condition.symbol)]
            return list(self.variable(argument.condition))
        if argument.value is None:
            return ["True"]
        if parameter.type.lower() in SIGNALS and isinstance(argument.value, tree.Name):
            symbol = argument.value.symbol
            return [repr(symbol.name) if symbol.storage == "signal" else self._raw(symbol)]
        return [self.value(argument.value)] if by_value else list(self.variable(argument.value))

    def _unary(self, node: tree.Unary) -> str:
        inner = self.value(node.operand)
        if node.operator == "not":
            return f"(not {inner})"
        if node.type == "pos":
            return f"scaled({inner}, {node.operator}1.0)"
        return f"({node.operator}{inner})"

    def _binary(self, node: tree.Binary) -> str:
        left, right = self.value(node.left), self.value(node.right)
        kinds = (node.operator, *node.types)
        if kinds == ("*", "num", "pos"):
            return f"scaled({right}, {left})"
        if kinds == ("/", "pos", "num"):
            return f"scaled({left}, 1 / {right})"
        if kinds in _FUNCTIONS:
            return f"{_FUNCTIONS[kinds]}({left}, {right})"
        return f"({left} {_OPERATORS.get(node.operator, node.operator)} {right})"

    # First values.

    def first_value(self, node: tree.Data, kind: Type) -> str:
        """Return the value that a declaration gives, or else 0, FALSE, the empty string, or these in brackets."""
        if node.value is not None:
            return f"copied({self.value(node.value)})"
        if kind.name == "syncident":
            return f"sync_names({node.name!r}, [{', '.join(map(self.value, node.sizes))}])"
        one = self._default(kind.name)
        return f"array([{', '.join(map(self.value, node.sizes))}], {one})" if node.sizes else one

    def _default(self, name: str) -> str:
        parts = self.types.components(name)
        if parts:
            return f"[{', '.join(self._default(self.types.resolved(part) or '') for part, _ in parts)}]"
        return _DEFAULTS.get(name, "None")
