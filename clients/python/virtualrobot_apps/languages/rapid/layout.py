"""Layout of programs in RAPID: indentation by two spaces, spaces between words, reserved words in capital letters.

Lines stay lines, comments stay where they are, and words are what they were.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.lexer import KEYWORDS, pieces_of
from virtualrobot_apps.languages.rapid.parser import parse

INDENT = "  "
_OPENING = frozenset("module proc func trap record then do test".split())
_CLOSING = frozenset("endmodule endproc endfunc endtrap endrecord endif endfor endwhile endtest".split())
_BETWEEN = frozenset("else elseif case default error undo backward".split())
"""Words that stand as far out as what has begun before."""
_BEGINNING = _CLOSING | _BETWEEN | {"module", "local", "task"}
"""Words that begin a line of their own, and are in no statement."""
_BRACKETS = {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}
_OPERANDS = frozenset({"name", "number", "text", "true", "false", ")", "]", "}"})
"""Words after which a sign is an operator between two values."""


@dataclass(slots=True)
class Word:
    """A word, comment or other piece of a line, with its place in the source."""

    kind: str
    text: str
    at: int


def formatted(source: Source) -> str:
    """Return the text of a program, laid out; raises ProgramError with all faults where it can't be parsed."""
    diagnostics = Diagnostics()
    modules = parse(source, diagnostics)
    if len(diagnostics):
        raise ProgramError(diagnostics.sorted())
    layout = _Layout({at for module in modules for at in _starts(module)})
    found: list[str] = []
    blank = True  # a file begins with no empty line
    for words in _lines(source):
        if words or not blank:
            found.append(layout.line(words) if words else "")
        blank = not words
    return "\n".join(found).rstrip("\n") + "\n"


def _starts(node: object) -> Iterator[int]:
    """Yield the places at which declarations and statements begin."""
    if isinstance(node, list):
        for one in node:
            yield from _starts(one)
    elif isinstance(node, tuple):
        yield from _starts(node[-1])
    elif node is not None:
        yield node.at  # pyright: ignore[reportAttributeAccessIssue] a node of the tree
        if not (isinstance(node, tree.If) and node.compact):
            for name in tree.BLOCKS:
                yield from _starts(getattr(node, name, None))


def _lines(source: Source) -> Iterator[list[Word]]:
    """Yield the words of each line; what lies on several lines is one word of the first."""
    words: list[Word] = []
    for kind, text, at in pieces_of(source):
        if kind != "space":
            words.append(Word(kind, text.upper() if kind in KEYWORDS else text.rstrip(), at))
            continue
        for _ in range(text.count("\n")):
            yield words
            words = []
    yield words


class _Layout:
    """Layout of one line after the other."""

    def __init__(self, starts: set[int]) -> None:
        """Begin outside of any module; `starts` are the places where statements begin."""
        self._starts = starts
        self._depth = self._brackets = 0
        self._record = self._late = False
        self._last: Word | None = None

    def line(self, words: list[Word]) -> str:
        """Return a line."""
        first = words[0]
        level = self._depth - (first.kind in _CLOSING or first.kind in _BETWEEN)
        if not (self._record or first.kind in _BEGINNING or first.at in self._starts or first.kind == "comment"):
            level += max(1, self._brackets) - (_BRACKETS.get(first.kind) == -1)
        text = INDENT * max(0, level) if first.kind not in ("head", "preset") else ""
        row = [self._last, *words]
        for number, word in enumerate(words, 1):
            text += (" " if number > 1 and not self._joined(row, number) else "") + word.text
            self._pass(word)
        return text

    def _pass(self, word: Word) -> None:
        """Count what a word opens and closes."""
        self._depth += (word.kind in _OPENING) - (word.kind in _CLOSING or word.kind == "elseif")
        self._brackets += _BRACKETS.get(word.kind, 0)
        if word.kind in ("record", "endrecord"):
            self._record = word.kind == "record"
        if word.kind == "%":
            self._late = not self._late
        if word.kind != "comment":
            self._last = word

    def _joined(self, row: list[Word | None], number: int) -> bool:
        """Return whether a word stands close to the one before; the row begins with the last word of earlier lines."""
        earlier, before, word = row[number - 2], row[number - 1], row[number]
        assert before is not None and word is not None
        if word.kind in (",", ";", ")", "]", "}", ":", ".", "?") or before.kind in ("(", "[", "{", ".", "\\", "?"):
            return True
        if word.kind == "{":
            return before.kind == "name"
        if word.kind == "(":
            return before.kind == "name" and before.at not in self._starts
        if "%" in (word.kind, before.kind):
            return self._late
        if word.kind == ":=":
            return earlier is not None and earlier.kind == "\\"
        if before.kind == ":=":
            name = row[number - 3] if number > 2 else None
            return name is not None and name.kind == "\\"
        if before.kind in ("+", "-"):
            return earlier is not None and (earlier.kind not in _OPERANDS or earlier.at in self._starts)
        return False
