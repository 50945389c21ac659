"""Words of RAPID as its parser takes them."""

from __future__ import annotations

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Failed, WordReader
from virtualrobot_apps.languages.rapid.lexer import KEYWORDS, words_of


class RapidReader(WordReader):
    """Words of one source and the number of the next one."""

    def __init__(self, source: Source, diagnostics: Diagnostics) -> None:
        """Begin at the first word."""
        super().__init__(source, diagnostics, words_of(source, diagnostics))

    def name(self, what: str = "a name") -> str:
        """Take a name; a reserved word in its place is told to be one."""
        if self.kind in KEYWORDS:
            said = f"{self.values[self.next]!r} is a reserved word, and no name: {what} is expected here"
            self.diagnostics.add(self.source, self.at, said)
            raise Failed
        return super().name(what)

    def semicolon(self) -> None:
        """Take the semicolon of a statement; one that misses at the end of a line is told, and thought there."""
        if self.take(";"):
            return
        before = self.ends[self.next - 1]
        if self.source.line(before) == self.source.line(self.at) and self.kind != "end":
            self.fail("';'")
        self.diagnostics.add(self.source, before, "';' is missing here")
