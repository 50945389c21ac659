"""Parser of RAPID's expressions.

Priorities are those of ABB's *Basic Characteristics RAPID* 7.7: `* / DIV MOD`, `+ -`, comparisons, `AND`, and weakest
`XOR OR NOT`.
"""

from __future__ import annotations

from math import isinf

from virtualrobot_apps.languages.core.words import Failed
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.lexer import number_value, text_value
from virtualrobot_apps.languages.rapid.words import RapidReader

PRIORITIES = {
    **dict.fromkeys(("or", "xor"), 1),
    "and": 2,
    **dict.fromkeys(("=", "<>", "<", ">", "<=", ">="), 3),
    **dict.fromkeys(("+", "-"), 4),
    **dict.fromkeys(("*", "/", "div", "mod"), 5),
}
"""Strength with which each operator binds."""
LONGEST = 200
"""Number of operators in a row beyond which an expression is refused."""


class ExpressionParser(RapidReader):
    """Parser of expressions and of arguments."""

    def expression(self, least: int = 0) -> tree.Expression:
        """Parse an expression whose operators bind more strongly than `least`."""
        kind, at = self.kinds[self.next], self.starts[self.next]
        if kind == "not":
            self.next += 1
            self.deepen()
            left: tree.Expression = tree.Unary(at, "not", self.expression(1))
            self.depth -= 1
        elif kind in ("+", "-"):
            self.next += 1
            self.deepen()
            left = tree.Unary(at, kind, self.expression(4))
            self.depth -= 1
        else:
            left = self.primary()
        count = 0
        while (priority := PRIORITIES.get(operator := self.kinds[self.next], 0)) > least:
            at, count = self.starts[self.next], count + 1
            if count > LONGEST:
                self.diagnostics.add(self.source, at, f"more than {LONGEST} operators are in a row here")
                raise Failed
            self.next += 1
            left = tree.Binary(at, operator, left, self.expression(priority))
        return left

    def expressions(self, end: str) -> list[tree.Expression]:
        """Parse expressions with commas between them, and the sign that ends them."""
        found = [self.expression()]
        while self.take(","):
            found.append(self.expression())
        self.eat(end, f"',' or {end!r}")
        return found

    def primary(self) -> tree.Expression:
        """Parse a value, with the components and elements that are taken of it."""
        kind, at, value = self.kinds[self.next], self.starts[self.next], self.values[self.next]
        if kind == "name":
            self.next += 1
            if self.take("("):
                self.deepen()
                call = tree.Call(at, value, self.arguments(")"))
                self.depth -= 1
                self.eat(")", "',' or ')'")
                return self.parts(call)
            return self.parts(tree.Name(at, value))
        if kind == "number":
            self.next += 1
            number = number_value(value)
            if isinf(number):
                self.diagnostics.add(self.source, at, f"the number {value} is too great")
            return tree.Number(at, number, value)
        if kind == "text":
            self.next += 1
            return tree.Text(at, text_value(value))
        if kind in ("true", "false"):
            self.next += 1
            return tree.Truth(at, kind == "true")
        if kind == "[":
            self.next += 1
            self.deepen()
            items = self.expressions("]")
            self.depth -= 1
            return tree.Aggregate(at, items)
        if kind == "(":
            self.next += 1
            self.deepen()
            inner = self.expression()
            self.depth -= 1
            self.eat(")")
            return inner
        self.fail("a value")

    def parts(self, of: tree.Expression) -> tree.Expression:
        """Parse the components and elements that are taken of what was parsed."""
        depth = self.depth
        while (kind := self.kinds[self.next]) in (".", "{"):
            at = self.starts[self.next]
            self.deepen()
            self.next += 1
            if kind == ".":
                of = tree.Component(at, of, self.name("the name of a component"))
            else:
                of = tree.Element(at, of, self.expressions("}"))
        self.depth = depth
        return of

    def arguments(self, end: str) -> list[tree.Argument]:
        """Parse the arguments of a call up to the sign that ends them, which is left.

        The comma before the backslash of an optional argument may miss.
        """
        found: list[tree.Argument] = []
        kinds = self.kinds
        while (kind := kinds[self.next]) != end:
            if found and kind == ",":
                self.next += 1
            elif found and kind != "\\":
                if self.kind == "end" or self.source.line(self.ends[self.next - 1]) != self.source.line(self.at):
                    return found  # whoever called tells what is missing
                self.fail(f"',' or {end!r}")
            at = self.starts[self.next]
            if kinds[self.next] == "\\":
                self.next += 1
                name = self.name("the name of an optional argument")
                if self.take("?"):
                    where = self.at
                    condition = tree.Name(where, self.name("the name of an optional parameter"))
                    found.append(tree.Argument(at, name, condition, condition))
                else:
                    found.append(tree.Argument(at, name, self.expression() if self.take(":=") else None))
                continue
            value = self.expression()
            if isinstance(value, tree.Name) and self.take(":="):
                found.append(tree.Argument(at, value.name, self.expression()))
            else:
                found.append(tree.Argument(at, None, value))
        return found
