"""Values of signals, and conditions that compare them. Pure."""

from __future__ import annotations

import operator
from enum import Enum
from typing import NamedTuple

SignalValue = bool | int | float | str | tuple[bool, ...]
"""Value of a signal: on or off, a whole number, a number, words, or a group of booleans."""


class Comparison(Enum):
    """Comparison of a signal with a value; the names equal those of `Comparison` in the contract."""

    EQUAL = "=="
    NOT_EQUAL = "!="
    LESS = "<"
    AT_MOST = "<="
    GREATER = ">"
    AT_LEAST = ">="


OPERATORS = {
    Comparison.EQUAL: operator.eq,
    Comparison.NOT_EQUAL: operator.ne,
    Comparison.LESS: operator.lt,
    Comparison.AT_MOST: operator.le,
    Comparison.GREATER: operator.gt,
    Comparison.AT_LEAST: operator.ge,
}

ORDERED = frozenset({Comparison.LESS, Comparison.AT_MOST, Comparison.GREATER, Comparison.AT_LEAST})
"""Comparisons that only integers and numbers can be asked by."""


class Condition(NamedTuple):
    """Condition that a signal meets when it compares with a value of its own type."""

    signal: str
    value: SignalValue = True
    comparison: Comparison = Comparison.EQUAL

    def holds(self, value: SignalValue | None) -> bool:
        """Return whether the signal's value meets it; None, of a signal that is gone, never does."""
        return value is not None and bool(OPERATORS[self.comparison](value, self.value))

    def __str__(self) -> str:
        """Return the condition in words."""
        if isinstance(self.value, bool) and self.comparison is Comparison.EQUAL:
            return "on" if self.value else "off"
        return f"{self.comparison.value} {self.value!r}"
