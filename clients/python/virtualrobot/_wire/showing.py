"""Lines that objects show of themselves at a prompt, one to five, and pictures in notebooks."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from datetime import datetime
from enum import Enum
from html import escape
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from virtualrobot.errors import VirtualRobotError

MOST_NAMED = 8
"""Largest number of names in a line."""

_MOST_LINES = 5
_WIDTH = 110
_MOST_LETTERS = 60
_MOST_NUMBERS = 8
_MOST_ENTRIES = 4

Shown = TypeVar("Shown", bound=type)


def told(title: str, say: Callable[[], str]) -> str:
    """Return a line of what is said; where the kernel cannot be asked, why: a prompt or debugger must get a line."""
    try:
        words = say()
    except VirtualRobotError as error:
        words = str(error)
    return f"<{title}: {words}>"


def listed(words: Iterable[str], none: str = "none") -> str:
    """Return the first words with commas between them, and how many there are besides; `none` where there is none."""
    every = list(words)
    more = f" and {len(every) - MOST_NAMED} more" if len(every) > MOST_NAMED else ""
    return (", ".join(every[:MOST_NAMED]) + more) if every else none


def shown(one: Shown) -> Shown:
    """Return a dataclass that shows its fields in one to five lines: arrays and long lists by what they hold."""
    one.__repr__ = _summary  # pyright: ignore[reportAttributeAccessIssue]
    return one


def _summary(self: Any) -> str:  # noqa: ANN401 any dataclass
    """Return the fields in a few lines."""
    name = type(self).__name__
    told = ((one.name, getattr(self, one.name)) for one in fields(self) if one.repr)
    # What is not there says nothing.
    parts = [f"{field}={brief(value)}" for field, value in told if not (value is None or _empty(value))]
    if not parts:
        return f"{name}()"
    lines, indent = [f"{name}("], " " * (len(name) + 1)
    for number, part in enumerate(parts):
        part += ")" if number == len(parts) - 1 else ", "
        if len(lines[-1]) + len(part) > _WIDTH and lines[-1].strip() != f"{name}(":
            if len(lines) == _MOST_LINES:
                lines[-1] = f"{lines[-1].rstrip()} and {len(parts) - number} more)"
                break
            lines.append(indent)
        lines[-1] += part
    return "\n".join(line.rstrip() for line in lines)


def _empty(value: Any) -> bool:  # noqa: ANN401
    return isinstance(value, str | tuple | list | Mapping) and not value


def brief(value: Any) -> str:  # noqa: ANN401 anything that a field holds
    """Return a value in a few words: of many numbers their shape and range, of many entries how many there are."""
    if isinstance(value, np.ndarray):
        return _brief_array(value)
    if own := getattr(value, "_brief", ""):
        return own
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, bytes):
        return f"{len(value):,} bytes"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, datetime):
        return value.isoformat(sep=" ", timespec="milliseconds")
    if isinstance(value, Mapping):
        return f"{{{_entries([f'{name!r}: {brief(one)}' for name, one in value.items()])}}}"
    if isinstance(value, tuple | list):
        return f"({_entries([brief(one) for one in value])})"
    words = " ".join(repr(value).split())
    return words if len(words) <= _MOST_LETTERS else _cut(words, is_dataclass(value))


def _cut(words: str, closed: bool) -> str:
    return f"{words[: _MOST_LETTERS - 4]}...{')' if closed else ''}"


def _entries(words: Sequence[str]) -> str:
    few = ", ".join(words[:_MOST_ENTRIES])
    return few if len(words) <= _MOST_ENTRIES else f"{few}, ... {len(words)} in all"


def _brief_array(values: NDArray[Any]) -> str:
    if values.shape == (4, 4):
        x, y, z = values[:3, 3]
        return f"pose at ({x:z.4g}, {y:z.4g}, {z:z.4g})"
    if values.size <= _MOST_NUMBERS:
        return np.array2string(values, precision=4, separator=", ", suppress_small=True, max_line_width=10_000).replace(
            "\n", ""
        )
    kind = f"{values.dtype} {values.shape}"
    if values.dtype.kind == "b":
        return f"{kind}: {int(values.sum())} true"
    finite = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    return f"{kind}: {finite.min():.4g} to {finite.max():.4g}" if finite.size else f"{kind}: none finite"


def table_html(title: str, rows: Sequence[Sequence[str]]) -> str:
    """Return rows, the first of which is headings, as an HTML table below a title."""
    lines = [
        "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row) + "</tr>"
        for tag, row in zip(("th", *("td",) * len(rows)), rows, strict=False)
    ]
    return f"<b>{escape(title)}</b><table>{''.join(lines)}</table>"


def png(pixels: NDArray[np.uint8] | NDArray[np.bool_], dots_per_meter: int | None = None) -> bytes:
    """Return a picture as the bytes of a PNG file (W3C, Portable Network Graphics, 2003).

    Args:
        pixels: (h, w, 3) red, green and blue, or (h, w) of booleans, True for white.
        dots_per_meter: by which it is printed; nothing is said of it by default.
    """
    height, width = pixels.shape[:2]
    # The kind: a bit of grey each, or 8 bits each of red, green and blue.
    bits, color, values = (
        (1, 0, np.packbits(pixels, axis=1)) if pixels.ndim == 2 else (8, 2, np.asarray(pixels, np.uint8))
    )
    rows = values.reshape(height, -1)
    rows = np.concatenate([np.zeros((height, 1), np.uint8), rows], axis=1)  # each begins with its filter: none

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    size = b"" if dots_per_meter is None else chunk(b"pHYs", struct.pack(">IIB", dots_per_meter, dots_per_meter, 1))
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0))
        + size
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + chunk(b"IEND", b"")
    )
