"""Words of a source as a parser takes them, one after the other; faults are told and end what is being parsed."""

from __future__ import annotations

from typing import NoReturn

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.lexer import words_of


class Failed(Exception):
    """End of what is being parsed; the fault is told already."""


class WordReader:
    """Words of one source and the number of the next one."""

    def __init__(self, source: Source, diagnostics: Diagnostics) -> None:
        """Begin at the first word."""
        self.source, self.diagnostics = source, diagnostics
        words = words_of(source, diagnostics)
        self.kinds, self.values, self.starts, self.ends = words.kinds, words.values, words.starts, words.ends
        self.next = 0

    @property
    def kind(self) -> str:
        """Kind of the next word."""
        return self.kinds[self.next]

    @property
    def at(self) -> int:
        """Place of the next word."""
        return self.starts[self.next]

    def fail(self, what: str) -> NoReturn:
        """Tell that something else is expected at the next word, and give up what is being parsed."""
        value = self.values[self.next]
        found = value if self.kind == "end" else repr(value)
        self.diagnostics.add(self.source, self.at, f"{what} is expected here, not {found}")
        raise Failed

    def eat(self, kind: str, what: str = "") -> str:
        """Take a word of this kind and return it as written."""
        if self.kinds[self.next] != kind:
            self.fail(what or repr(kind))
        self.next += 1
        return self.values[self.next - 1]

    def take(self, kind: str) -> bool:
        """Take a word of this kind, if it is the next one."""
        if self.kinds[self.next] == kind:
            self.next += 1
            return True
        return False

    def name(self, what: str = "a name") -> str:
        """Take a name."""
        return self.eat("name", what)

    def semicolon(self) -> None:
        """Take the semicolon of a statement; one that misses at the end of a line is told, and thought there."""
        if self.take(";"):
            return
        before = self.ends[self.next - 1]
        if self.source.line(before) == self.source.line(self.at) and self.kind != "end":
            self.fail("';'")
        self.diagnostics.add(self.source, before, "';' is missing here")
