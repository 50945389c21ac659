"""Damage of files that leaves most of them readable: numbers, words, elements and lines, rather than bytes."""

from __future__ import annotations

import random
import re

NUMBERS = (
    b"0", b"-0.0", b"-1", b"1", b"2", b"3", b"0.5", b"1e308", b"-1e308", b"1e-320", b"nan", b"inf", b"-inf", b"",
    b"1e400", b"1e", b".", b"null",
    b"2147483648", b"-2147483649", b"4294967296", b"9223372036854775808", b"99999999999999999999", b"0x10", b"1_0",
    b"true", b"1 2 3", b"\xd9\xa3", b"[]", b"{}", b'""', b"[1]",
)  # fmt: skip
"""What may stand where a number stood."""

WORDS = (
    b"",
    b" ",
    b"world",
    b"/",
    b"..",
    b"\xc3\xa9",
    b"\\u0000",
    b"a" * 300,
    b"a.b",
    b"-",
    b"1",
    b"null",
    b"&#0;",
    b"%00",
)
"""What may stand where a word stood."""

NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][\w.-]*")
QUOTED = re.compile(rb'"[^"<>\n]{0,200}"')
ELEMENT = re.compile(rb"<(\w+)\b[^<>]*(?:/>|>.*?</\1\s*>)|\{[^{}]*\}|\[[^][]*\]", re.DOTALL)
LINE = re.compile(rb"[^\n]*\n")
PIECES = (NUMBER, NUMBER, WORD, QUOTED, ELEMENT, ELEMENT, LINE)


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Return a copy with one to four pieces changed, gone, doubled, exchanged or put elsewhere."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        data = _changed(data, rng)
    return data


def _changed(data: bytes, rng: random.Random) -> bytes:
    pattern = rng.choice(PIECES)
    found = list(pattern.finditer(data))
    if not found or rng.random() < 0.1:
        return _byte_changed(data, rng)
    piece = rng.choice(found)
    start, end = piece.span()
    other = rng.choice(found)
    kind = rng.random()
    if pattern is NUMBER and kind < 0.5:
        return data[:start] + rng.choice(NUMBERS) + data[end:]
    if pattern in (WORD, QUOTED) and kind < 0.3:
        word = rng.choice(WORDS)
        return data[:start] + (b'"%s"' % word if pattern is QUOTED else word) + data[end:]
    if kind < 0.65:
        return data[:start] + other[0] + data[end:]
    if kind < 0.8:
        return data[:start] + data[end:]
    if kind < 0.9:
        return data[:end] + piece[0] * rng.choice((1, 1, 2, 50)) + data[end:]
    return data[: other.start()] + piece[0] + data[other.start() :]


def _byte_changed(data: bytes, rng: random.Random) -> bytes:
    if not data or rng.random() < 0.2:
        return data + bytes(rng.choices(range(256), k=rng.choice((1, 4))))
    place = rng.randrange(len(data))
    if rng.random() < 0.3:
        return data[:place]
    return data[:place] + bytes([rng.choice((0, 1, 127, 128, 255, rng.randrange(256)))]) + data[place + 1 :]
