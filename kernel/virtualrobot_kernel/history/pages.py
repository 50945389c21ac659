"""Rows of a SQLite database that SQLite itself can't read any more, page by page.

By https://www.sqlite.org/fileformat2.html. Nothing above the pages with rows is needed, neither the header nor the
trees. What a page says is believed by nobody: rows have checksums, which whoever takes them compares.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

PAGE_BYTES = 4096
HEAD = b"SQLite format 3\0"
"""First bytes of a database."""

FRAME_BYTES = PAGE_BYTES + 24
"""Length of a page with what stands before it in a write-ahead log."""

_TABLE, _INDEX = 0x0D, 0x0A
"""Types of pages: rows of a table, and of one without numbers."""

_LARGEST = {_TABLE: PAGE_BYTES - 35, _INDEX: (PAGE_BYTES - 12) * 64 // 255 - 23}
"""Number of bytes of a row from which some are on other pages."""

_SMALLEST = (PAGE_BYTES - 12) * 32 // 255 - 23
_INTEGERS = {1: 1, 2: 2, 3: 3, 4: 4, 5: 6, 6: 8}
_DAMAGE = (IndexError, ValueError, struct.error, KeyError)

Row = tuple[Any, ...]
"""Columns of a row."""


class Frame(NamedTuple):
    """Page in a write-ahead log: its number, the place of its bytes, and whether it ends a transaction."""

    number: int
    place: int
    is_end: bool


def wal_frames(wal: Path) -> tuple[list[Frame], list[Frame]]:
    """Return the pages of a write-ahead log's present run, and those of earlier ones that are still behind them.

    These have other salts than the log's head and the first page, of which one may be damaged
    (https://www.sqlite.org/fileformat2.html#walformat). Where salts differ by a few bits these are damaged.
    """
    present: list[Frame] = []
    earlier: list[Frame] = []
    try:
        file = open(wal, "rb")
    except FileNotFoundError:
        return present, earlier
    with file:
        known = [int.from_bytes(file.read(32)[16:24], "big")]
        while len(head := file.read(24)) == 24:
            number, size = struct.unpack_from(">II", head)
            salts = int.from_bytes(head[8:16], "big")
            if not present and not earlier:
                known.append(salts)
            is_present = any((salts ^ one).bit_count() <= 2 for one in known if one)
            (present if is_present else earlier).append(Frame(number, file.tell(), size != 0))
            file.seek(PAGE_BYTES, 1)
    return present, earlier


def rows(database: Path, wal: Path) -> Iterator[Row]:
    """Yield the rows that pages of a database and of its write-ahead log seem to have, newer ones after older ones.

    Some were deleted, or never were.
    """
    present, earlier = wal_frames(wal)
    if not present:  # nobody knows any more which these are
        present, earlier = earlier, []
    with open(database, "rb") as file, open(wal if wal.exists() else database, "rb") as log:
        newest = {frame.number: frame.place for frame in present}

        def page(number: int) -> bytes:
            """Return a page as it was written last."""
            place = newest.get(number)
            return _read(file, (number - 1) * PAGE_BYTES) if place is None else _read(log, place)

        for frame in earlier:
            yield from _rows_of(_read(log, frame.place), page)
        place = PAGE_BYTES  # the first page says how the tables are made
        while data := _read(file, place):
            yield from _rows_of(data, page)
            place += PAGE_BYTES
        for frame in present:
            yield from _rows_of(_read(log, frame.place), page)


def _read(file: BinaryIO, place: int) -> bytes:
    file.seek(place)
    return file.read(PAGE_BYTES)


def _rows_of(data: bytes, page: Callable[[int], bytes]) -> Iterator[Row]:
    """Yield the rows of a page; one whose type has a wrong bit may be one with rows."""
    kind = next((kind for kind in (_TABLE, _INDEX) if (data[:1] or b"\0")[0] ^ kind in (0, *_BITS)), None)
    if kind is None or len(data) < 8:
        return
    (count,) = struct.unpack_from(">H", data, 3)
    for cell in range(min(count, PAGE_BYTES // 4)):
        try:
            (at,) = struct.unpack_from(">H", data, 8 + 2 * cell)
            yield _row(data, at, kind, page)
        except _DAMAGE:
            continue


_BITS = tuple(1 << bit for bit in range(8))


def _row(data: bytes, at: int, kind: int, page: Callable[[int], bytes]) -> Row:
    size, at = _varint(data, at)
    number: int | None = None
    if kind == _TABLE:
        number, at = _varint(data, at)
    here = size
    if size > _LARGEST[kind]:
        here = _SMALLEST + (size - _SMALLEST) % (PAGE_BYTES - 4)
        here = here if here <= _LARGEST[kind] else _SMALLEST
    payload = bytearray(data[at : at + here])
    (following,) = struct.unpack_from(">I", data, at + here) if here < size else (0,)
    while len(payload) < size:
        if following < 2 or len(more := page(following)) < PAGE_BYTES:
            raise ValueError("it goes on nowhere")
        payload += more[4 : 4 + size - len(payload)]
        (following,) = struct.unpack_from(">I", more)
    columns = tuple(_columns(bytes(payload)))
    return (number, *columns[1:]) if columns[:1] == (None,) else columns  # the column that is the row's number is empty


def _columns(record: bytes) -> Iterator[Any]:
    end, at = _varint(record, 0)
    place = end
    while at < end:
        kind, at = _varint(record, at)
        size = _INTEGERS.get(kind, 0) if kind < 12 else (kind - 12) // 2
        size = 8 if kind == 7 else size
        if kind in (10, 11) or place + size > len(record):
            raise ValueError("no column has this type")
        data = record[place : place + size]
        place += size
        if kind in _INTEGERS:
            yield int.from_bytes(data, "big", signed=True)
        elif kind == 7:
            yield struct.unpack(">d", data)[0]
        elif kind >= 12:
            yield data if kind % 2 == 0 else data.decode("utf-8", "surrogateescape")
        else:
            yield (None, 0, 1)[max(0, kind - 7)]


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """Return a number and the place after it."""
    value = 0
    for place in range(at, at + 8):
        value = value << 7 | data[place] & 0x7F
        if data[place] < 0x80:
            return value, place + 1
    return value << 8 | data[at + 8], at + 9
