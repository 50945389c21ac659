"""Rows of the store's tables: what they say, and their columns, whose last one is a checksum."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

LEAST_PACKED = 500
"""Number of bytes from which they are made smaller."""

PART_HASH_BYTES = 16
"""Length of a part's hash."""

HASH_BYTES = 8
"""Length of the hash of a tick."""

UNSOUND = (TypeError, AttributeError, ValueError, OverflowError, struct.error, zlib.error)
"""Errors that the check of a damaged row may come to, before its checksum is compared."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """Row of the journal: a batch that was applied.

    Attributes:
        seq: its number, from 1, without gaps: the order of truth.
        tick: the number of ticks before it.
        time: of the wall clock, for people: seconds since 1970.
        author: who gave it.
        commands: the encoded commands.
    """

    seq: int
    tick: int
    time: float
    author: str
    commands: bytes


@dataclass(frozen=True, slots=True, eq=False)
class StepRow:
    """Row of a step: what was done, as people see it.

    Attributes:
        number: of its last entry.
        first: number of its first entry.
        tick: the number of ticks before it.
        time: of the wall clock, seconds since 1970.
        author: who did it.
        kind: what it is.
        label: what was done, in words.
        names: names of nodes that it was about, each with its uid.
        undoes: number of the step that it took back; 0 for none.
        difference: the encoded difference that it made.
        touched: the nodes (uids) that it was about.
    """

    number: int
    first: int
    tick: int
    time: float
    author: str
    kind: str
    label: str
    names: tuple[tuple[int, str], ...]
    undoes: int
    difference: bytes
    touched: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class CheckpointRow:
    """World at a moment.

    Attributes:
        id: its number; 0 until it has one.
        seq: number of the last entry that it has in it.
        tick: its tick.
        name: as people know it; "" for those that only replays begin from.
        author: who made it.
        time: when, in seconds since 1970.
        nodes: how many it has.
        body: the encoded world, without its parts.
        parts: their hashes.
    """

    id: int
    seq: int
    tick: int
    name: str
    author: str
    time: float
    nodes: int
    body: bytes = b""
    parts: tuple[bytes, ...] = ()


class Columns:
    """Columns of rows in the order of their tables, and back again where the checksum is right."""

    def __init__(self, seed: int, damaged: Callable[[str], Exception]) -> None:
        """Begin checksums with the number `seed`; `damaged` makes the error that says which row has a wrong one."""
        self._seed = seed
        self._damaged = damaged

    def of_entry(self, row: Row) -> tuple[Any, ...]:
        """Return the columns of an entry."""
        return row.seq, row.tick, row.time, row.author, _packed(row.commands), self._entry_crc(row)

    def entry(self, columns: Sequence[Any]) -> Row:
        """Return the entry with some columns; raise the error of damage."""
        return self._sound(self._entry, columns, "the entry {} has")

    def of_step(self, row: StepRow) -> tuple[Any, ...]:
        """Return the columns of a step."""
        names, touched = _names(row), struct.pack(f"<{len(row.touched)}q", *row.touched)
        said = row.number, row.first, row.tick, row.time, row.author, row.kind, row.label, names, row.undoes
        return *said, _packed(row.difference), touched, self._step_crc(row, touched)

    def step(self, columns: Sequence[Any]) -> StepRow:
        """Return the step with some columns; raise the error of damage."""
        return self._sound(self._step, columns, "the step {} has")

    def of_checkpoint(self, row: CheckpointRow) -> tuple[Any, ...]:
        """Return the columns of a checkpoint."""
        said = row.id, row.seq, row.tick, row.name, row.author, row.time, row.nodes
        return *said, _packed(row.body), b"".join(row.parts), self._checkpoint_crc(row)

    def checkpoint(self, columns: Sequence[Any]) -> CheckpointRow:
        """Return the checkpoint with some columns; raise the error of damage."""
        return self._sound(self._checkpoint, columns, "the checkpoint {} has")

    def of_part(self, key: bytes, body: bytes) -> tuple[Any, ...]:
        """Return the columns of a part."""
        return key, _packed(body), self._crc(len(body), key, body)

    def part(self, columns: Sequence[Any]) -> bytes:
        """Return the part with some columns; raise the error of damage."""
        return self._sound(self._part, columns, "the part {} has")

    def of_hashes(self, first_tick: int, hashes: bytes) -> tuple[Any, ...]:
        """Return the columns of the hashes of ticks from a first one on, `HASH_BYTES` each."""
        last = first_tick + len(hashes) // HASH_BYTES - 1
        return first_tick, last, _packed(hashes), self._crc(first_tick, hashes)

    def hashes(self, columns: Sequence[Any]) -> bytes:
        """Return the hashes with some columns; raise the error of damage."""
        return self._sound(self._hashes, columns, "the hashes from tick {} on have")

    def _sound(self, read: Callable[[Sequence[Any]], tuple[T, int]], columns: Sequence[Any], what: str) -> T:
        """Return what is read of columns, if its checksum is theirs."""
        try:
            row, crc = read(columns)
            if crc == columns[-1]:
                return row
        except UNSOUND:
            pass
        key = columns[0].hex() if isinstance(columns[0], bytes) else columns[0]
        raise self._damaged(f"{what.format(key)} a wrong checksum")

    def _entry(self, columns: Sequence[Any]) -> tuple[Row, int]:
        seq, tick, time, author, commands, _ = columns
        row = Row(seq, tick, time, author, _unpacked(commands))
        return row, self._entry_crc(row)

    def _step(self, columns: Sequence[Any]) -> tuple[StepRow, int]:
        number, first, tick, time, author, kind, label, names, undoes, difference, touched, _ = columns
        named = tuple((int(uid), name) for uid, _, name in (one.partition(" ") for one in names.splitlines()))
        changed = _unpacked(difference)
        row = StepRow(number, first, tick, time, author, kind, label, named, undoes, changed, uids(touched))
        return row, self._step_crc(row, touched)

    def _checkpoint(self, columns: Sequence[Any]) -> tuple[CheckpointRow, int]:
        number, seq, tick, name, author, time, nodes, body, parts, _ = columns
        row = CheckpointRow(number, seq, tick, name, author, time, nodes, _unpacked(body), tuple(part_hashes(parts)))
        return row, self._checkpoint_crc(row)

    def _part(self, columns: Sequence[Any]) -> tuple[bytes, int]:
        key, stored, _ = columns
        body = _unpacked(stored)
        return body, self._crc(len(body), key, body)

    def _hashes(self, columns: Sequence[Any]) -> tuple[bytes, int]:
        first, _, stored, _ = columns
        data = _unpacked(stored)
        return data, self._crc(first, data)

    def _entry_crc(self, row: Row) -> int:
        author = row.author.encode()
        head = struct.pack("<qdI", row.tick, row.time, len(author))
        return self._crc(row.seq, head, author, row.commands)

    def _step_crc(self, row: StepRow, touched: bytes) -> int:
        texts = [text.encode() for text in (row.author, row.kind, row.label, _names(row))]
        head = struct.pack("<qqdqIIIII", row.first, row.tick, row.time, row.undoes, *map(len, texts), len(touched))
        return self._crc(row.number, head, *texts, touched, row.difference)

    def _checkpoint_crc(self, row: CheckpointRow) -> int:
        texts = row.name.encode(), row.author.encode()
        head = struct.pack("<qdqIII", row.tick, row.time, row.nodes, *map(len, texts), len(row.body))
        return self._crc(row.seq, head, *texts, row.body, *row.parts)

    def _crc(self, number: int, *pieces: bytes) -> int:
        """Return the checksum of a number and bytes, which begins with the folder's seed."""
        crc = zlib.crc32(number.to_bytes(8, "little"), self._seed)
        for piece in pieces:
            crc = zlib.crc32(piece, crc)
        return crc


def uids(blob: bytes) -> tuple[int, ...]:
    """Return the uids in a column of them."""
    return struct.unpack(f"<{len(blob) // 8}q", blob)


def part_hashes(parts: bytes) -> Iterator[bytes]:
    """Yield the hashes of parts in a column of them."""
    return (parts[at : at + PART_HASH_BYTES] for at in range(0, len(parts), PART_HASH_BYTES))


def _names(row: StepRow) -> str:
    return "".join(f"{uid} {name}\n" for uid, name in row.names)  # names of nodes have no line breaks


def _packed(data: bytes) -> bytes:
    """Return bytes as they are stored: as they are, or made smaller where that is worth it."""
    if len(data) < LEAST_PACKED:
        return b"\0" + data
    packed = zlib.compress(data, 1)
    return b"\1" + packed if len(packed) < 0.9 * len(data) else b"\0" + data


def _unpacked(stored: bytes) -> bytes:
    """Return what was packed; damaged bytes raise one of `UNSOUND`."""
    how = stored[:1]
    if how not in (b"\0", b"\1"):
        raise ValueError("neither packed nor not")
    return zlib.decompress(stored[1:]) if how == b"\1" else stored[1:]
