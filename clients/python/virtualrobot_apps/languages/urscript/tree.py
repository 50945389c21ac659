"""Syntax tree of URScript. `at` is the place in the source."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias


@dataclass(slots=True)
class Number:
    """A number, whole or not."""

    at: int
    value: int | float


@dataclass(slots=True)
class Text:
    """A string."""

    at: int
    value: str


@dataclass(slots=True)
class Truth:
    """True or False."""

    at: int
    value: bool


@dataclass(slots=True)
class Name:
    """A variable by its name."""

    at: int
    name: str


@dataclass(slots=True)
class Items:
    """Values in brackets: a list, or a pose p[x, y, z, rx, ry, rz]."""

    at: int
    items: list[Expression]
    pose: bool = False


@dataclass(slots=True)
class Element:
    """An element of a list or a pose, or of a matrix by two numbers."""

    at: int
    of: Expression
    indices: list[Expression]


@dataclass(slots=True)
class Component:
    """A component of a struct."""

    at: int
    of: Expression
    name: str


@dataclass(slots=True)
class Argument:
    """An argument of a call, with the name of its parameter where that is said."""

    at: int
    name: str
    value: Expression


@dataclass(slots=True)
class Call:
    """A call of a function."""

    at: int
    name: str
    arguments: list[Argument]


@dataclass(slots=True)
class Run:
    """The start of a thread, whose value is its handle."""

    at: int
    call: Call


@dataclass(slots=True)
class Unary:
    """`-`, `+` or `not` of a value."""

    at: int
    operator: str
    operand: Expression


@dataclass(slots=True)
class Binary:
    """Two values and an operator."""

    at: int
    operator: str
    left: Expression
    right: Expression


Expression: TypeAlias = Number | Text | Truth | Name | Items | Element | Component | Call | Run | Unary | Binary


@dataclass(slots=True)
class Assign:
    """An assignment; `scope` is `local`, `global` or empty."""

    at: int
    scope: str
    target: Name | Element | Component
    value: Expression


@dataclass(slots=True)
class Do:
    """An expression as a statement."""

    at: int
    value: Expression


@dataclass(slots=True)
class If:
    """IF with its arms, each with its condition."""

    at: int
    arms: list[tuple[Expression, list[Statement]]]
    otherwise: list[Statement] | None


@dataclass(slots=True)
class While:
    """A loop."""

    at: int
    condition: Expression
    body: list[Statement]


@dataclass(slots=True)
class Return:
    """The end of a function, with its value where there is one."""

    at: int
    value: Expression | None


@dataclass(slots=True)
class Word:
    """A statement of one word: break, continue, pass, halt, enter_critical, exit_critical."""

    at: int
    word: str


@dataclass(slots=True)
class OfThread:
    """`join` or `kill` of a thread by its handle."""

    at: int
    word: str
    handle: Expression


@dataclass(slots=True)
class Parameter:
    """A parameter of a function, with the value that it has where it isn't given."""

    at: int
    name: str
    value: Expression | None


@dataclass(slots=True)
class Function:
    """A function, a thread or a program: `kind` is def, thread or sec."""

    at: int
    kind: str
    name: str
    parameters: list[Parameter] = field(default_factory=list)
    body: list[Statement] = field(default_factory=list)


Statement: TypeAlias = Assign | Do | If | While | Return | Word | OfThread | Function
