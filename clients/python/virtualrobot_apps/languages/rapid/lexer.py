"""Words of RAPID: a text as parallel lists of kinds, values and places, which a parser goes through by number."""

from __future__ import annotations

import re
from collections.abc import Iterator

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Words

KEYWORDS = frozenset(
    """alias and backward case connect const default div do else elseif endfor endfunc endif endmodule endproc
    endrecord endtest endtrap endwhile error exit false for from func goto if inout local mod module not or pers
    proc raise record retry return step task test then to trap true trynext undo var while with xor""".split()
)
"""Reserved words in small letters; attributes of modules, such as SYSMODULE, are none."""

_SPACES = r" \t\n\f\xa0\u3000"
_FORMS = rf"""
     (?P<name>[^\W\d]\w*)
    |(?P<number>0[xX][0-9a-fA-F]+|0[bB][01]+|0[oO][0-7]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
    |(?P<comment>![^\n]*)|(?P<head>%%%[^%]*%%%)
    |(?P<text>"(?:[^"\n]|"")*")
    |(?P<unclosed>"[^\n]*)
    |(?P<place><(?:TDN|DDN|RDN|PAR|ALT|DIM|SMT|VAR|EIT|CSE|EXP|ARG|ID)>)
    |(?P<sign>:=|<>|<=|>=|[-+*/=<>.,:;\\?%|{{}}()\[\]])
    |(?P<preset>\#[^\n]*)|(?P<bad>[\0-\x08\x0e-\x1f\x7f]+|[^{_SPACES}])"""
_WORD = re.compile(_FORMS, re.VERBOSE)
_PIECE = re.compile(rf"(?P<space>[{_SPACES}]+)|{_FORMS}", re.VERBOSE)
_SKIPPED = {"comment", "head", "preset"}


def pieces_of(source: Source, begin: int = 0) -> Iterator[tuple[str, str, int]]:
    """Yield all of a source from a place on: kind (a reserved word or sign itself, or what it is), text and place."""
    for match in _PIECE.finditer(source.text, begin):
        kind, value = match.lastgroup or "", match.group()
        if kind == "name":
            lower = value.lower()
            kind = lower if lower in KEYWORDS else kind
        elif kind == "sign":
            kind = value
        yield kind, value, match.start()


def words_of(source: Source, diagnostics: Diagnostics) -> Words:
    """Return the words of a source; what is none is told and left out."""
    kinds: list[str] = []
    values: list[str] = []
    starts: list[int] = []
    ends: list[int] = []
    for match in _WORD.finditer(source.text):
        kind, value = match.lastgroup or "", match[0]
        at, end = match.span()
        if kind == "text" and "\0" in value:
            diagnostics.add(source, at + value.index("\0"), "the character '\\x00' can't stand in a text")
        if kind == "name":
            lower = value.lower()
            if lower in KEYWORDS:
                kind = lower
        elif kind == "sign":
            kind = value
        elif kind in _SKIPPED:
            continue
        elif kind == "bad":
            before = f"the character {value[0]!r} can't stand here"
            many = f", nor can the {len(value) - 1} after it" if len(value) > 1 else ""
            diagnostics.add(source, at, before + many)
            continue
        elif kind == "unclosed":
            diagnostics.add(source, at, "this text has no closing quote on its line")
            kind, value = "text", f'{value}"'
        elif kind == "place":
            diagnostics.add(source, at, f"{value} is a place that nobody has filled")
            kind, value = "name", value.strip("<>")
        kinds.append(kind)
        values.append(value)
        starts.append(at)
        ends.append(end)
    end = len(source.text.rstrip())
    return Words([*kinds, "end"], [*values, "the end of the file"], [*starts, end], [*ends, end])


_ESCAPE = re.compile(r"\\(\\|[0-9a-fA-F]{2})")


def text_value(word: str) -> str:
    r"""Return what a text in quotes says: `""` is a quote, `\\` a backslash, `\07` the character of that code."""
    inner = word[1:-1].replace('""', '"')
    return _ESCAPE.sub(lambda found: "\\" if found[1] == "\\" else chr(int(found[1], 16)), inner)


def number_value(word: str) -> float:
    """Return the value of a number, which may be hexadecimal, octal or binary."""
    based = len(word) > 1 and word[1] in "xXbBoO"
    return float(int(word, 0)) if based else float(word)
