"""Programs in what has come over a connection: each is whole with its last `end`, lines are with their newline."""

from __future__ import annotations

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.urscript.lexer import words_of

_OPENS = frozenset(("def", "sec", "thread", "if", "while"))


def pieces(text: str) -> tuple[list[str], str]:
    """Return the programs of a text that are whole, and the begin of one that isn't.

    What comes after a program without being one itself, such as a call of it, belongs to it.
    """
    source = Source(text)
    words = words_of(source, Diagnostics())
    found: list[str] = []
    begin = depth = 0
    filled = False
    for kind, at in zip(words.kinds, words.starts, strict=True):
        if not depth and kind in ("def", "sec") and filled:
            found.append(source.text[begin:at])
            begin = at
        filled = filled or kind != "newline"
        depth = max(0, depth + (kind in _OPENS) - (kind == "end"))
    rest = source.text[begin:]
    if depth or not source.text.endswith("\n"):
        return found, rest
    return [*found, *([rest] if rest.strip() else [])], ""
