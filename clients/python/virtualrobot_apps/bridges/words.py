"""Values as the other side holds them: types with their ranges, registers of 16 bits, scales."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from virtualrobot_apps.bridges.mapping import Entry

Raw = bool | int | float | str
"""Value as the other side has it."""


@dataclass(frozen=True)
class Range:
    """Type of a number: its code for `struct`, its registers, and its least and greatest value."""

    code: str
    words: int
    least: float
    greatest: float


_FLOAT32 = struct.unpack(">f", b"\x7f\x7f\xff\xff")[0]
RANGES = {
    "int16": Range("h", 1, -(2**15), 2**15 - 1),
    "uint16": Range("H", 1, 0, 2**16 - 1),
    "int32": Range("i", 2, -(2**31), 2**31 - 1),
    "uint32": Range("I", 2, 0, 2**32 - 1),
    "int64": Range("q", 4, -(2**63), 2**63 - 1),
    "float32": Range("f", 2, -_FLOAT32, _FLOAT32),
    "float64": Range("d", 4, -math.inf, math.inf),
}
TYPES = ("boolean", *RANGES, "text")


class BadValueError(ValueError):
    """A value that can't go over: not finite, out of range, or of another type."""


def to_raw(entry: Entry, value: bool | int | float | str) -> Raw:
    """Return the value of a signal as the other side holds it.

    Raises:
        BadValueError: when it is out of range there.
    """
    if entry.type in ("boolean", "text"):
        return value
    number: int | float = value if isinstance(value, int) else float(value)
    if (entry.scale, entry.offset) != (1.0, 0.0):
        number = (number - entry.offset) / entry.scale
    known = RANGES[entry.type]
    if not isinstance(number, int) and not entry.type.startswith("float"):
        number = round(number) if math.isfinite(number) else number
    if not known.least <= number <= known.greatest:
        raise BadValueError(f"{value!r} is {number:g} there, and {entry.type} goes from {_bounds(known)}")
    return float(number) if entry.type.startswith("float") else int(number)


def to_signal(entry: Entry, raw: object, kind: type) -> bool | int | float | str:
    """Return the value of a signal of a type for what the other side has.

    Raises:
        BadValueError: for what is not finite, out of range or of another type.
    """
    if entry.type == "boolean":
        if isinstance(raw, bool):
            return raw
        raise BadValueError(f"{raw!r:.60} is no boolean")
    if entry.type == "text":
        if isinstance(raw, str) and len(raw) <= 4096:
            return raw
        raise BadValueError(f"{raw!r:.60} is no text of at most 4096 characters")
    if isinstance(raw, bool) or not isinstance(raw, int | float) or not math.isfinite(raw):
        raise BadValueError(f"{raw!r:.60} is no finite number")
    known = RANGES[entry.type]
    whole = not entry.type.startswith("float")
    if not known.least <= raw <= known.greatest or (whole and raw != int(raw)):
        raise BadValueError(f"{raw!r} is no {entry.type}, which goes from {_bounds(known)}")
    value = raw if (entry.scale, entry.offset) == (1.0, 0.0) else raw * entry.scale + entry.offset
    if kind is bool:
        return bool(value)
    if not math.isfinite(value) or (kind is int and not -(2**63) <= value < 2**63):
        raise BadValueError(f"{raw!r} with its scale is no value of a signal")
    return round(value) if kind is int else float(value)


def to_registers(entry: Entry, raw: Raw) -> list[int]:
    """Return the registers, each of 16 bits, of a number."""
    known = RANGES[entry.type]
    words = list(struct.unpack(f">{known.words}H", struct.pack(f">{known.code}", raw)))
    return words[::-1] if entry.low_word_first else words


def from_registers(entry: Entry, registers: Sequence[int]) -> Raw:
    """Return the number that registers hold."""
    known = RANGES[entry.type]
    words = registers[::-1] if entry.low_word_first else registers
    return struct.unpack(f">{known.code}", struct.pack(f">{known.words}H", *words))[0]


def _bounds(known: Range) -> str:
    return f"{known.least:g} to {known.greatest:g}"
