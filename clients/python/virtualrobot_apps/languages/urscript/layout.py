"""Layout of scripts in URScript: indentation by two spaces; lines stay lines, and words what they were."""

from __future__ import annotations

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.urscript.lexer import words_of
from virtualrobot_apps.languages.urscript.parser import parse

INDENT = "  "
_OPENING = frozenset("def thread sec if while".split())
_BETWEEN = frozenset(("elif", "else"))
"""Words that stand as far out as what has begun before."""
_BRACKETS = {"(": 1, "[": 1, ")": -1, "]": -1}


def formatted(source: Source) -> str:
    """Return the text of a script, laid out; raises ProgramError with all faults where it can't be parsed."""
    diagnostics = Diagnostics()
    parse(source, diagnostics)
    if len(diagnostics):
        raise ProgramError(diagnostics.sorted())
    words = words_of(source, Diagnostics())
    rows: dict[int, list[str]] = {}
    for kind, at in zip(words.kinds[:-1], words.starts[:-1], strict=True):
        if kind != "newline":
            rows.setdefault(source.line(at), []).append(kind)
    found: list[str] = []
    depth = brackets = 0
    for number, text in enumerate(source.text.split("\n"), 1):
        row = rows.get(number, [])
        ends = next((at for at, kind in enumerate(row) if kind != "end"), len(row))
        level = depth - ends - (ends < len(row) and row[ends] in _BETWEEN)
        if brackets:
            level += brackets - (bool(row) and _BRACKETS.get(row[0]) == -1)
        text = text.strip()
        if text or (found and found[-1]):
            found.append(f"{INDENT * max(0, level)}{text}" if text else "")
        depth += sum((kind in _OPENING) - (kind == "end") for kind in row)
        brackets += sum(_BRACKETS.get(kind, 0) for kind in row)
    return "\n".join(found).rstrip("\n") + "\n"
