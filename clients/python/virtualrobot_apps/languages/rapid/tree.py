"""Syntax tree of RAPID. `at` is the place in the source; names are as written, and compared in small letters.

What the check finds out of a node, it leaves in the node's last fields, for the generator.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from virtualrobot_apps.languages.core.source import Source


@dataclass(slots=True)
class Number:
    """A number; `word` is how it is written."""

    at: int
    value: float
    word: str


@dataclass(slots=True)
class Text:
    """A string."""

    at: int
    value: str


@dataclass(slots=True)
class Truth:
    """TRUE or FALSE."""

    at: int
    value: bool


@dataclass(slots=True)
class Name:
    """A datum, a signal or a parameter by its name."""

    at: int
    name: str
    symbol: Any = None


@dataclass(slots=True)
class Component:
    """A component of a record."""

    at: int
    of: Expression
    name: str
    index: int = -1


@dataclass(slots=True)
class Element:
    """An element of an array."""

    at: int
    of: Expression
    indices: list[Expression]


@dataclass(slots=True)
class Aggregate:
    """Values in brackets, of a record or an array."""

    at: int
    items: list[Expression]


@dataclass(slots=True)
class Argument:
    """An argument of a call.

    `name` of an optional one, or of one that is given by name; `value` is None of a switch; `condition` is the name of
    the optional parameter with which it is there.
    """

    at: int
    name: str | None
    value: Expression | None
    condition: Name | None = None


@dataclass(slots=True)
class Call:
    """A call of a function or, as a statement, of a procedure; `late` is the name of one that is bound late."""

    at: int
    name: str
    arguments: list[Argument]
    late: Expression | None = None
    target: Any = None
    given: list[Any] = field(default_factory=list)


@dataclass(slots=True)
class Unary:
    """`-`, `+` or `not` of a value, with the name of its type."""

    at: int
    operator: str
    operand: Expression
    type: str = ""


@dataclass(slots=True)
class Binary:
    """Two values and an operator, in small letters; `type` is that of the left one."""

    at: int
    operator: str
    left: Expression
    right: Expression
    types: tuple[str, str] = ("", "")


Expression: TypeAlias = Number | Text | Truth | Name | Component | Element | Aggregate | Call | Unary | Binary


@dataclass(slots=True)
class Assign:
    """`target := value;`."""

    at: int
    target: Expression
    value: Expression
    atomic: bool = False


@dataclass(slots=True)
class If:
    """IF with its arms, each a condition and statements; `compact` without THEN."""

    at: int
    arms: list[tuple[Expression, list[Statement]]]
    otherwise: list[Statement] | None
    compact: bool = False


@dataclass(slots=True)
class For:
    """FOR; without `step` it counts by 1 or -1."""

    at: int
    name: str
    first: Expression
    last: Expression
    step: Expression | None
    body: list[Statement]
    symbol: Any = None


@dataclass(slots=True)
class While:
    """WHILE."""

    at: int
    condition: Expression
    body: list[Statement]


@dataclass(slots=True)
class Test:
    """TEST with its cases, each values and statements."""

    at: int
    value: Expression
    cases: list[tuple[list[Expression], list[Statement]]]
    otherwise: list[Statement] | None


@dataclass(slots=True)
class Jump:
    """RETURN, RAISE, EXIT, RETRY or TRYNEXT, in small letters, with the value of the first two."""

    at: int
    word: str
    value: Expression | None


@dataclass(slots=True)
class Goto:
    """GOTO."""

    at: int
    label: str


@dataclass(slots=True)
class Label:
    """A label that GOTO leads to."""

    at: int
    name: str


@dataclass(slots=True)
class Connect:
    """CONNECT of an interrupt with a trap."""

    at: int
    interrupt: Expression
    trap: str
    target: Any = None


@dataclass(slots=True)
class Data:
    """A declaration of data: `storage` is var, pers or const, `scope` local, task or nothing."""

    at: int
    scope: str
    storage: str
    type: str
    name: str
    sizes: list[Expression]
    value: Expression | None
    symbol: Any = None


Statement: TypeAlias = Assign | Call | If | For | While | Test | Jump | Goto | Label | Connect | Data


@dataclass(slots=True)
class Record:
    """A declaration of a record type: components of type and name."""

    at: int
    scope: str
    name: str
    components: list[tuple[str, str]]


@dataclass(slots=True)
class Alias:
    """A declaration of another name of a type."""

    at: int
    scope: str
    name: str
    type: str


@dataclass(slots=True)
class Parameter:
    """A parameter: `mode` is in, inout, var or pers; `choice` is a number that alternatives of one place share."""

    at: int
    mode: str
    type: str
    name: str
    dimensions: int = 0
    optional: bool = False
    choice: int = 0


@dataclass(slots=True)
class Routine:
    """A PROC, FUNC or TRAP: `kind` in small letters; what follows BACKWARD, ERROR or UNDO is None without that."""

    at: int
    scope: str
    kind: str
    name: str
    result: str
    parameters: list[Parameter]
    body: list[Statement]
    handler: list[Statement] | None = None
    handled: list[Expression] = field(default_factory=list)
    undo: list[Statement] | None = None
    backward: list[Statement] | None = None


Declaration: TypeAlias = Data | Record | Alias | Routine


@dataclass(slots=True)
class Module:
    """A module, with the source that it is in."""

    at: int
    name: str
    attributes: list[str]
    declarations: list[Declaration]
    source: Source


BLOCKS = ("declarations", "body", "handler", "undo", "backward", "arms", "cases", "otherwise")
"""Fields that hold declarations and statements."""


def statements_within(node: Module | Declaration | Statement) -> Iterator[Statement]:
    """Yield the statements within a node, those in their blocks too, in the order of the text."""
    for name in BLOCKS:
        for one in getattr(node, name, None) or ():
            for inner in one[-1] if isinstance(one, tuple) else (one,):
                if not isinstance(inner, Record | Alias | Routine):
                    yield inner
                yield from statements_within(inner)
