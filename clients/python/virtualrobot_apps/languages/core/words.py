"""Words of a source as a parser takes them, one after the other; faults are told and end what is being parsed."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import NoReturn

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source


@dataclass(frozen=True, slots=True)
class Words:
    """Words of a text: kind (a reserved word or sign itself, or name, number, text, newline), value, begin and end.

    The last one is the end of the file, and its value is words for that; so is the value of a newline.
    """

    kinds: list[str]
    values: list[str]
    starts: list[int]
    ends: list[int]

    def name_at(self, at: int) -> int | None:
        """Return the number of the name at a place, or that ends there."""
        for number in (bisect_right(self.starts, at) - 1, bisect_right(self.starts, at) - 2):
            if number >= 0 and self.starts[number] <= at <= self.ends[number] and self.kinds[number] == "name":
                return number
        return None


class Failed(Exception):
    """End of what is being parsed; the fault is told already."""


DEEPEST = 90
"""Number of statements, brackets and signs within each other beyond which a program is refused."""


class WordReader:
    """Words of one source, the number of the next one, and how deep within others what is being parsed is."""

    def __init__(self, source: Source, diagnostics: Diagnostics, words: Words) -> None:
        """Begin at the first word."""
        self.source, self.diagnostics = source, diagnostics
        self.kinds, self.values, self.starts, self.ends = words.kinds, words.values, words.starts, words.ends
        self.next = self.depth = 0

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
        found = value if self.kind == "newline" or self.next == len(self.kinds) - 1 else repr(value)
        self.diagnostics.add(self.source, self.at, f"{what} is expected here, not {found}")
        raise Failed

    def deepen(self) -> None:
        """Go into something, which takes 1 from `depth` at its end; tell where that is too deep."""
        self.depth += 1
        if self.depth > DEEPEST:
            self.diagnostics.add(self.source, self.at, f"this is nested deeper than {DEEPEST} levels")
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
