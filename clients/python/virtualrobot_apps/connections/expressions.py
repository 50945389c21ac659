"""Expressions of connections: values of signals, what gives them, and of which types they are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from virtualrobot_apps.cell_io.yaml_file import Item

Value = bool | int | float | str | tuple[bool, ...]
"""Value of a signal."""

KIND_NAMES: dict[type, str] = {bool: "boolean", int: "integer", float: "number", str: "text", tuple: "group"}

LEAST_INTEGER, GREATEST_INTEGER = -(2**63), 2**63 - 1


@dataclass(frozen=True, eq=False)
class Expression:
    """Source of a value: a signal, a constant, or an operator and what it works on.

    Attributes:
        operator: name of the operator, `signal` or `constant`.
        inputs: what it works on, in the order of its operator's inputs; those left out are false.
        item: where it stands in the file.
        signal: name of the signal.
        constant: the value of a constant.
        seconds: of a delay or pulse (s).
        index: of a bit, from 0.
    """

    operator: str
    item: Item
    inputs: tuple[Expression, ...] = ()
    signal: str = ""
    constant: Value = False
    seconds: float = 0.0
    index: int = 0

    def signals(self) -> Iterable[str]:
        """Yield the names of the signals that it depends on."""
        if self.operator == "signal":
            yield self.signal
        for one in self.inputs:
            yield from one.signals()


@dataclass(frozen=True, eq=False)
class Connection:
    """A signal, and the expression that gives its value."""

    target: str
    source: Expression
    item: Item
