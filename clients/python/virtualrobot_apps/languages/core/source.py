"""Sources of programs: their text, and the line and column of each place in it."""

from __future__ import annotations

import codecs
import re
from bisect import bisect_right
from contextlib import suppress
from itertools import accumulate
from pathlib import Path

from virtualrobot.errors import MissingFileError


class Source:
    """Text of one file; places are counts of characters from its begin."""

    def __init__(self, text: str, file: str = "program") -> None:
        """Keep the text, without a byte order mark, and the name by which it is told of."""
        self.text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
        self.file = file
        *begun, _ = accumulate((len(line) + 1 for line in self.text.split("\n")), initial=0)
        self._starts = begun

    def line(self, at: int) -> int:
        """Return the line of a place, from 1."""
        return bisect_right(self._starts, at)

    def at(self, line: int) -> int:
        """Return the place at which a line begins, from 1."""
        return self._starts[line - 1]

    def column(self, at: int) -> int:
        """Return the column of a place, from 1."""
        return at - self._starts[self.line(at) - 1] + 1


_MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}


_PRIVATE = re.compile("[\ue000-\uf8ff]")
"""Letters that no text has."""


def read_source(file: Path) -> Source:
    """Return the text of a file; raises MissingFileError where it can't be read."""
    try:
        return Source(decoded(file.read_bytes()), str(file))
    except OSError as error:
        raise MissingFileError(f"{file} can't be read: {error.strerror}") from error


def decoded(data: bytes) -> str:
    """Return the text of a file, in the code that its bytes have."""
    mark, code = code_of(data)
    return data[len(mark) :].decode(code, "replace")


def encoded_like(text: str, data: bytes) -> bytes:
    """Return a text with line feeds in the code and with the line ends of a file's bytes."""
    mark, code = code_of(data)
    if "\r\n" in decoded(data):
        text = text.replace("\n", "\r\n")
    return mark + text.encode(code)


def code_of(data: bytes) -> tuple[bytes, str]:
    """Return the byte order mark with which a file begins, and its code: that of the mark, or as its bytes look.

    They are UTF-8 where they can be, else GB 18030 if they can be Chinese, else ISO 8859-1. Controllers write
    ISO 8859-1, in which every byte is a letter. Letters of GB 18030 come in pairs of bytes above 0x80, and a letter of
    a European language stands alone among ASCII, or makes a pair that stands for no letter, as in Grüß.
    """
    for mark, code in _MARKS.items():
        if data.startswith(mark):
            return mark, code
    high = [False, *(byte > 0x7F for byte in data), False]
    alone = any(one and not (high[at] or high[at + 2]) for at, one in enumerate(high[1:-1]))
    for code in ("utf-8",) if alone else ("utf-8", "gb18030"):
        with suppress(UnicodeDecodeError):
            if not _PRIVATE.search(data.decode(code)):
                return b"", code
    return b"", "latin-1"
