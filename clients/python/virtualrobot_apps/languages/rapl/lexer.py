"""Words of a line of RAPL-II: numbers, names, texts, strings (`&1`), parameters (`%0`) and signs."""

from __future__ import annotations

import re
from dataclasses import dataclass

_WORD = re.compile(
    r"""[ \t]*(?:
    (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
  | (?P<name>[#]?[A-Za-z_][A-Za-z0-9_$.]*)
  | (?P<text>'[^']*')
  | (?P<string>&\d+)
  | (?P<parameter>%[0-7])
  | (?P<sign>==|<>|!=|<=|>=|\+\+|--|[-+*/()=<>,!;])
  )""",
    re.VERBOSE,
)


@dataclass(frozen=True, slots=True)
class Word:
    """One word: its kind, its text (names in capitals, texts without quotes), and the place where it begins."""

    kind: str
    text: str
    at: int


class WordError(Exception):
    """Something at a place of a line that is no word there."""

    def __init__(self, at: int, message: str) -> None:
        """Keep the place and what to say."""
        super().__init__(message)
        self.at = at


def words_of(text: str, at: int = 0) -> list[Word]:
    """Return the words of a text, which begins at a place of its source; raises WordError."""
    words, begin = [], 0
    while text[begin:].strip(" \t"):
        found = _WORD.match(text, begin)
        if found is None:
            place = begin + len(text[begin:]) - len(text[begin:].lstrip(" \t"))
            said = "this text has no closing quote" if text[place] == "'" else f"{text[place]!r} can't stand here"
            raise WordError(at + place, said)
        kind = str(found.lastgroup)
        said = found[kind]
        shown = said.upper() if kind == "name" else said[1:-1] if kind == "text" else said
        words.append(Word(kind, shown, at + found.start(kind)))
        begin = found.end()
    return words
