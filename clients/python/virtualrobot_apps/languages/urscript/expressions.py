"""Parser of URScript's expressions.

Operators bind as in Python: weakest `or` and `xor`, then `and`, `not`, comparisons, `+ -`, `* / %`, and a sign.
"""

from __future__ import annotations

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Failed, WordReader, Words
from virtualrobot_apps.languages.urscript import tree
from virtualrobot_apps.languages.urscript.lexer import number_value, words_of

PRIORITIES = {
    **dict.fromkeys(("or", "xor"), 1),
    "and": 2,
    **dict.fromkeys(("==", "!=", "<", ">", "<=", ">="), 4),
    **dict.fromkeys(("+", "-"), 5),
    **dict.fromkeys(("*", "/", "%"), 6),
}
"""Strength with which each operator binds; that of `not` is 3."""
LARGEST = 1e300
"""Size of the numbers that a script may have."""


class ExpressionParser(WordReader):
    """Parser of expressions and of arguments."""

    def __init__(self, source: Source, diagnostics: Diagnostics, words: Words | None = None) -> None:
        """Begin at the first word; `words` are those of the source, if somebody has found them already."""
        super().__init__(source, diagnostics, words or words_of(source, diagnostics))

    def expression(self, least: int = 0) -> tree.Expression:
        """Parse an expression whose operators bind more strongly than `least`."""
        before = self.depth
        self.deepen()
        found = self._expression(least)
        self.depth = before
        return found

    def _expression(self, least: int) -> tree.Expression:
        kind, at = self.kind, self.at
        if kind == "not":
            self.next += 1
            left: tree.Expression = tree.Unary(at, "not", self.expression(2))
        elif kind in ("+", "-"):
            self.next += 1
            left = tree.Unary(at, kind, self.expression(6))
        else:
            left = self.primary()
        while (priority := PRIORITIES.get(operator := self.kind, 0)) > least:
            at = self.at
            self.deepen()
            self.next += 1
            left = tree.Binary(at, operator, left, self.expression(priority))
        return left

    def expressions(self, end: str) -> list[tree.Expression]:
        """Parse expressions with commas between them, maybe none, and the sign that ends them."""
        found: list[tree.Expression] = []
        if self.take(end):
            return found
        while True:
            found.append(self.expression())
            if not self.take(","):
                self.eat(end, f"',' or {end!r}")
                return found

    def primary(self) -> tree.Expression:
        """Parse a value, with the elements and components that are taken of it."""
        kind, at, value = self.kind, self.at, self.values[self.next]
        if kind == "name":
            self.next += 1
            if self.take("("):
                return self.parts(tree.Call(at, value, self.arguments()))
            if value == "p" and self.kind == "[" and self.at == self.ends[self.next - 1]:
                self.next += 1
                return self.parts(self._pose_or_element(at))
            return self.parts(tree.Name(at, value))
        if kind == "number":
            self.next += 1
            number = number_value(value)
            if not abs(number) < LARGEST:
                self.diagnostics.add(self.source, at, f"the number {value} is too large")
                number = 0
            return tree.Number(at, number)
        if kind == "text":
            self.next += 1
            return tree.Text(at, value[1:-1])
        if kind in ("True", "False"):
            self.next += 1
            return tree.Truth(at, kind == "True")
        if kind == "[":
            self.next += 1
            return self.parts(tree.Items(at, self.expressions("]")))
        if kind == "(":
            self.next += 1
            inner = self.expression()
            self.eat(")")
            return self.parts(inner)
        if kind == "run":
            self.next += 1
            where, name = self.at, self.name("the name of a thread")
            self.eat("(", "'(' and the arguments")
            return tree.Run(at, tree.Call(where, name, self.arguments()))
        self.fail("a value")

    def _pose_or_element(self, at: int) -> tree.Expression:
        """Parse what follows `p[`: a pose of six numbers, or one or two numbers of an element of the variable p."""
        items = self.expressions("]")
        if len(items) == 6:
            return tree.Items(at, items, pose=True)
        if 1 <= len(items) <= 2:
            return tree.Element(at, tree.Name(at, "p"), items)
        self.diagnostics.add(self.source, at, f"a pose has 6 numbers (x, y, z, rx, ry, rz), not {len(items)}")
        raise Failed

    def parts(self, of: tree.Expression) -> tree.Expression:
        """Parse the elements and components that are taken of what was parsed."""
        while True:
            at = self.at
            if self.kind in ("[", "."):
                self.deepen()
            if self.take("["):
                indices = self.expressions("]")
                if not 1 <= len(indices) <= 2:
                    self.diagnostics.add(self.source, at, f"an element has 1 or 2 indices, not {len(indices)}")
                    raise Failed
                of = tree.Element(at, of, indices)
            elif self.take("."):
                of = tree.Component(at, of, self.name("the name of a component"))
                if self.kind == "(":
                    said = f"'.{of.name}()' can't be used here yet: methods of lists and structs don't work"
                    self.diagnostics.add(self.source, at, said)
                    raise Failed
            else:
                return of

    def arguments(self) -> list[tree.Argument]:
        """Parse the arguments of a call, and the parenthesis that ends them."""
        found: list[tree.Argument] = []
        if self.take(")"):
            return found
        while True:
            at, name = self.at, ""
            if self.kind == "name" and self.kinds[self.next + 1] == "=":
                name = self.values[self.next]
                self.next += 2
            found.append(tree.Argument(at, name, self.expression()))
            if not self.take(","):
                self.eat(")", "',' or ')'")
                return found
