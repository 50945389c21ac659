"""Random programs in RAPID: what is written is parsed, and laid out it is the same program."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Callable

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.layout import formatted
from virtualrobot_apps.languages.rapid.parser import parse

OPERATORS = ["+", "-", "*", "/", "DIV", "MOD", "=", "<>", "<", ">", "<=", ">=", "AND", "OR", "XOR"]
PLACES = ("at", "source", "symbol", "target", "given")
"""Fields of the tree that tell where a word stands, or that the check fills."""


class Writer:
    """Writer of random programs by the grammar, with as many spaces and line ends between words as are drawn."""

    def __init__(self, rng: random.Random) -> None:
        """Draw from a generator."""
        self.rng = rng

    def spaced(self, *words: str) -> str:
        """Return words with a random space, comment or line end between them."""
        return "".join(word + self.rng.choice([" ", "  ", " \n", " ! said\n "]) for word in words)

    def some(self, make: Callable[[int], str], depth: int, most: int = 3) -> list[str]:
        """Return as many of something as are drawn."""
        return [make(depth) for _ in range(self.rng.randint(0, most))]

    def name(self) -> str:
        """Return a name."""
        return self.rng.choice(["a", "Speed", "p10", "größe", "di_1", "errnum1"])

    def value(self, depth: int) -> str:
        """Return an expression."""
        simple = [
            self.name(),
            "1.5",
            "0xFF",
            '"say ""hi"""',
            "TRUE",
            "9E9",
            f"{self.name()}.x",
            f"{self.name()}{{2,1}}",
        ]
        if depth <= 0:
            return self.rng.choice(simple)
        left, right = self.value(depth - 1), self.value(depth - 1)
        return self.rng.choice(
            [
                *simple,
                self.spaced(left, self.rng.choice(OPERATORS), right),
                f"({left})",
                f"-{right}",
                self.spaced("NOT", f"({left})"),
                f"[{left},{right}]",
                f"{self.name()}({left},{right}\\{self.name()}:={left})",
                f"{self.name()}(\\{self.name()})",
            ]
        )

    def call(self, depth: int) -> str:
        """Return a call of a procedure."""
        return self.rng.choice(
            [
                f"{self.name()} {self.value(depth)},{self.value(depth)}\\{self.name()}:={self.value(depth)};",
                f"{self.name()}\\{self.name()}?{self.name()},{self.value(depth)};",
                f"{self.name()};",
                f'%"job"+{self.name()}% {self.value(depth)};',
            ]
        )

    def block(self, depth: int) -> str:
        """Return statements."""
        return self.spaced(*self.some(self.statement, depth))

    def statement(self, depth: int) -> str:
        """Return a statement."""
        value, inner = self.value(depth), depth - 1
        if depth <= 0 or self.rng.random() < 0.5:
            return self.rng.choice(
                [
                    self.call(depth),
                    f"{self.name()}{{1}}.x:={value};",
                    self.spaced(self.name(), ":=", value, ";"),
                    f"RETURN {self.value(0)};",
                    "EXIT;",
                    "GOTO again;",
                    "again:",
                    f"CONNECT {self.name()} WITH {self.name()};",
                ]
            )
        return self.rng.choice(
            [
                self.spaced("IF", value, self.call(inner)),
                self.spaced("IF", value, "THEN", self.block(inner), "ELSE", self.block(inner), "ENDIF"),
                self.spaced(
                    "IF", value, "THEN", self.block(inner), "ELSEIF", value, "THEN", self.block(inner), "ENDIF"
                ),
                self.spaced("WHILE", value, "DO", self.block(inner), "ENDWHILE"),
                self.spaced(
                    "FOR", self.name(), "FROM", value, "TO", value, "STEP", "2", "DO", self.block(inner), "ENDFOR"
                ),
                self.spaced("TEST", value, "CASE", f"{self.value(0)},2:", self.block(inner), "DEFAULT:", "ENDTEST"),
            ]
        )

    def routine(self, depth: int) -> str:
        """Return a routine or data."""
        name, body = self.name(), self.block(depth)
        handler = self.rng.choice(["", "ERROR", "ERROR(1,ERR_DIVZERO)"])
        ends = self.spaced(handler, "RETRY;" if handler else "", self.rng.choice(["", "UNDO"]))
        parameters = r"(num x,INOUT pos y{*,*}\switch on|string off,PERS tooldata t)"
        return self.rng.choice(
            [
                self.spaced(f"LOCAL PROC {name}{parameters}", body, ends, "ENDPROC"),
                self.spaced(f"FUNC num {name}()", body, ends, "ENDFUNC"),
                self.spaced(f"TRAP {name}", body, "ENDTRAP"),
                self.spaced("LOCAL", "VAR", "num", f"{name}{{2,3}}", ":=", self.value(depth), ";"),
                self.spaced("RECORD", name, "num x;", "pos y;", "ENDRECORD"),
                self.spaced("ALIAS", "num", f"{name};"),
            ]
        )

    def module(self) -> str:
        """Return a module."""
        return self.spaced(f"MODULE {self.name()}(SYSMODULE,NOVIEW)", *self.some(self.routine, 2, 6), "ENDMODULE")


def meaning(node: object) -> object:
    """Return a tree as tuples, without places."""
    if isinstance(node, list | tuple):
        return tuple(map(meaning, node))
    if dataclasses.is_dataclass(node):
        fields = [one.name for one in dataclasses.fields(node) if one.name not in PLACES]
        return type(node).__name__, *(meaning(getattr(node, name)) for name in fields)
    return node


def test_a_program_that_is_laid_out_is_the_same(seed: int, draws: Callable[[int], int]) -> None:
    writer = Writer(random.Random(seed))
    for _ in range(draws(100)):
        text = writer.module()
        trees = []
        once = formatted(Source(text))
        for each in (text, once):
            diagnostics = Diagnostics()
            trees.append(meaning(parse(Source(each), diagnostics)))
            assert diagnostics.sorted() == []
        assert trees[0] == trees[1], text
        assert formatted(Source(once)) == once, text
