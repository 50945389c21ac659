"""Texts as editors speak of them: lines from 0, and columns in units of UTF-16."""

from __future__ import annotations

import re
from typing import Any

from virtualrobot_apps.languages.core.source import Source

_WORD = re.compile(r"\w+|[^\w\s]+")


class Positions:
    """Positions in one source, and places, which are counts of characters."""

    def __init__(self, source: Source) -> None:
        """Keep the lines of a source."""
        self._source = source
        self._lines = source.text.split("\n")

    def place(self, position: Any) -> int:  # noqa: ANN401 JSON
        """Return the place of a position; one beyond the end of its line is that end."""
        line, column = int(position["line"]), int(position["character"])
        if not 0 <= line < len(self._lines) or column < 0:
            return len(self._source.text) if line > 0 else 0
        text = self._lines[line]
        before = text.encode("utf-16-le", "replace")[: 2 * column].decode("utf-16-le", "ignore")
        return self._source.at(line + 1) + len(before)

    def position(self, at: int) -> dict[str, int]:
        """Return the position of a place."""
        line = self._source.line(at)
        before = self._lines[line - 1][: self._source.column(at) - 1]
        return {"line": line - 1, "character": len(before.encode("utf-16-le", "replace")) // 2}

    def range(self, begin: int, end: int) -> dict[str, dict[str, int]]:
        """Return the positions of begin and end."""
        return {"start": self.position(begin), "end": self.position(end)}

    def whole(self) -> dict[str, dict[str, int]]:
        """Return the range of all of the text."""
        return self.range(0, len(self._source.text))

    def word(self, line: int, column: int) -> dict[str, dict[str, int]]:
        """Return the range of the word at a line and column from 1; at the end of a line that of its last letter."""
        at = self._source.at(line) + column - 1
        found = _WORD.match(self._source.text, at)
        if found is not None:
            return self.range(at, found.end())
        return self.range(max(self._source.at(line), at - 1), at)


def comment_above(source: Source, line: int, sign: str) -> str:
    """Return the comment on the lines that stand directly above a line, without its signs."""
    lines = source.text.split("\n")
    found: list[str] = []
    while line > 1 and lines[line - 2].lstrip().startswith(sign):
        line -= 1
        found.append(lines[line - 1].strip().lstrip(sign).strip())
    return "\n".join(reversed(found))


def code(language: str, text: str, *told: str) -> str:
    """Return a text of a program, and words about it, in Markdown."""
    return "\n\n".join([f"```{language}\n{text}\n```", *(one for one in told if one)])
