"""Words of URScript. The end of a line is a word, except within brackets."""

from __future__ import annotations

import re

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Words

KEYWORDS = frozenset(
    """and break continue def elif else end enter_critical exit_critical False global halt if join kill local not or
    pass return run sec thread True while xor""".split()
)
"""Reserved words; case counts."""

_WORD = re.compile(
    r"""
     (?P<name>[^\W\d]\w*)
    |(?P<sign>==|!=|<=|>=|[-+*/%<>=,:()\[\]]|\.(?!\d))
    |(?P<newline>\n)|(?P<comment>\#[^\n]*)
    |(?P<number>0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
    |(?P<text>"[^"\n]*")|(?P<unclosed>"[^\n]*)
    |(?P<label>\$[^\n]*)
    |(?P<bad>[^ \t\f\xa0])""",
    re.VERBOSE,
)
_SKIPPED = {"comment", "label"}
_BEGINS = frozenset("def end thread sec while if elif else return break continue halt local global".split())
"""Reserved words that never stand in brackets: a bracket before one of them on an earlier line is not closed."""


def words_of(source: Source, diagnostics: Diagnostics) -> Words:
    """Return the words of a source; what is none is told and left out.

    Of several newlines in a row there is one, and none at the begin. Labels of programs (`$ 1 "name"`) are left out.
    """
    words = Words([], [], [], [])
    kinds = words.kinds
    depth = 0
    ended: tuple[int, int] | None = None
    """Begin and end of the newline that was passed over last within brackets."""

    def put(kind: str, value: str, begin: int, end: int) -> None:
        kinds.append(kind)
        words.values.append(value)
        words.starts.append(begin)
        words.ends.append(end)

    for match in _WORD.finditer(source.text):
        kind, value = match.lastgroup or "", match[0]
        begin, end = match.span()
        if kind in _SKIPPED:
            continue
        if kind == "newline":
            ended = (begin, end)
            if not depth and kinds and kinds[-1] != "newline":
                put("newline", "the end of the line", begin, end)
            continue
        if kind == "name" and value in KEYWORDS:
            kind = value
            if depth and ended is not None and value in _BEGINS:
                depth = 0
                put("newline", "the end of the line", *ended)
        elif kind == "sign":
            kind = value
            if value in "()[]":
                depth = max(0, depth + (1 if value in "([" else -1))
        elif kind == "bad":
            diagnostics.add(source, begin, f"the character {value!r} can't stand here")
            continue
        elif kind == "unclosed":
            diagnostics.add(source, begin, "this text has no closing quote on its line")
            kind, value = "text", f'{value}"'
        ended = None
        put(kind, value, begin, end)
    end = len(source.text.rstrip())
    if kinds and kinds[-1] != "newline":
        put("newline", "the end of the line", end, end)
    put("end of file", "the end of the file", end, end)
    return words


def number_value(word: str) -> int | float:
    """Return the value of a number: whole unless it has a point or an exponent."""
    if word[:2] in ("0x", "0X"):
        return int(word, 16)
    return int(word) if word.isdigit() and len(word) < 300 else float(word)
