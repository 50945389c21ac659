"""Arithmetic of assignments: `+ - * /`, parentheses, functions, variables and parameters, as functions of the task."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from virtualrobot_apps.languages.core.diagnostics import did_you_mean
from virtualrobot_apps.languages.rapl.faults import RaplFault
from virtualrobot_apps.languages.rapl.lexer import Word, WordError

Evaluate: TypeAlias = Callable[[Callable[[Word], float]], float]
"""Function that computes an expression; it is given what the value of a variable or parameter is."""

DEEPEST = 9
"""Number of parentheses within each other that an expression may have, by the manual."""

FUNCTIONS: dict[str, Callable[[float], float]] = {
    "ABS": abs,
    "ACOS": math.acos,
    "ASIN": math.asin,
    "ATAN": math.atan,
    "COS": math.cos,
    "DEG": math.degrees,
    "INT": math.trunc,
    "RAD": math.radians,
    "SIN": math.sin,
    "SQRT": math.sqrt,
    "TAN": math.tan,
}
"""Functions of expressions by name; angles are radians, as those of MA are."""


def number(word: Word) -> Evaluate:
    """Return the value of one word: a number, a variable or a parameter."""
    if word.kind == "number":
        value = float(word.text)
        return lambda _: value
    return lambda value_of: value_of(word)


class Expression:
    """Reader of an expression among words; `used` are the variables that it names."""

    def __init__(self, words: list[Word], at: int, end: int) -> None:
        """Read words from one on; `end` is the place after the last of them."""
        self.words, self.at, self.end = words, at, end
        self.used: list[Word] = []

    def sum(self, depth: int = 0) -> Evaluate:
        """Read a sum."""
        value = self._product(depth)
        while self._sign("+", "-"):
            sign, left, right = self._taken().text, value, self._product(depth)
            value = _added(left, right) if sign == "+" else _less(left, right)
        return value

    def _product(self, depth: int) -> Evaluate:
        value = self._one(depth)
        while self._sign("*", "/"):
            sign, left, right = self._taken().text, value, self._one(depth)
            value = _times(left, right) if sign == "*" else _over(left, right)
        return value

    def _one(self, depth: int) -> Evaluate:
        if self._sign("+", "-"):
            sign, value = self._taken().text, self._one(depth)
            return value if sign == "+" else lambda value_of: -value(value_of)
        if self._sign("("):
            return self._inner(depth)
        if self.at >= len(self.words) or self.words[self.at].kind not in ("number", "name", "parameter"):
            place = self.words[self.at].at if self.at < len(self.words) else self.end
            raise WordError(place, "a value is expected here")
        word = self._taken()
        if word.kind == "name" and self._sign("("):
            function = FUNCTIONS.get(word.text)
            if function is None:
                hint = did_you_mean(word.text, FUNCTIONS)
                raise WordError(word.at, f"there is no function {word.text!r}{hint}; there are {', '.join(FUNCTIONS)}")
            return _applied(word.text, function, self._inner(depth))
        if word.kind == "name":
            self.used.append(word)
        return number(word)

    def _inner(self, depth: int) -> Evaluate:
        opened = self._taken()
        if depth == DEEPEST:
            raise WordError(opened.at, f"parentheses may be {DEEPEST} deep, and not more")
        value = self.sum(depth + 1)
        if not self._sign(")"):
            place = self.words[self.at].at if self.at < len(self.words) else self.end
            raise WordError(place, "')' is missing here")
        self._taken()
        return value

    def _sign(self, *signs: str) -> bool:
        return self.at < len(self.words) and self.words[self.at].kind == "sign" and self.words[self.at].text in signs

    def _taken(self) -> Word:
        self.at += 1
        return self.words[self.at - 1]


def _added(left: Evaluate, right: Evaluate) -> Evaluate:
    return lambda value_of: left(value_of) + right(value_of)


def _less(left: Evaluate, right: Evaluate) -> Evaluate:
    return lambda value_of: left(value_of) - right(value_of)


def _times(left: Evaluate, right: Evaluate) -> Evaluate:
    return lambda value_of: left(value_of) * right(value_of)


def _over(left: Evaluate, right: Evaluate) -> Evaluate:
    def divided(value_of: Callable[[Word], float]) -> float:
        below = right(value_of)
        if below == 0.0:
            raise RaplFault("a division by zero")
        return left(value_of) / below

    return divided


def _applied(name: str, function: Callable[[float], float], inner: Evaluate) -> Evaluate:
    def applied(value_of: Callable[[Word], float]) -> float:
        value = inner(value_of)
        try:
            return float(function(value))
        except (ValueError, OverflowError):
            raise RaplFault(f"{name}({value:g}) has no value") from None

    return applied
