"""Messages and plain values in CBOR (RFC 8949), arrays of numbers as typed ones (RFC 8746).

What is large is copied once; cbor2's own writer takes several times as long for the bytes of a picture.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from virtualrobot_apps.bridges.ros.messages import types
from virtualrobot_apps.bridges.ros.messages.types import NO_FIELD

_UNSIGNED, _NEGATIVE, _BYTES, _TEXT, _LIST, _MAP, _TAG = range(7)
"""Major types; source: RFC 8949, section 3.1."""

_FALSE, _TRUE, _NULL = b"\xf4", b"\xf5", b"\xf6"
_DOUBLE = struct.Struct(">Bd")
_DOUBLE_HEAD = 0xFB
_SHORT = 24
"""Counts below this stand in the head itself."""

_TAGS = {
    **{"uint16": 69, "uint32": 70, "uint64": 71, "int8": 72, "int16": 77, "int32": 78, "int64": 79},
    **{"float32": 85, "float64": 86},
}
"""Tags of typed arrays in little-endian order; source: RFC 8746, table 1. Of bytes there is a form without a tag."""

_Add = Callable[[Any], None]


def to_cbor(value: object) -> bytes:
    """Return a message, or plain values with arrays of numbers and messages among them, in CBOR.

    Raises:
        TypeError: for what has no form there, an integer of more than 64 bits among it.
    """
    return b"".join(cbor_parts(value))


def cbor_parts(value: object) -> list[Any]:
    """Return bytes and arrays that are a value in CBOR one behind the other; raises as `to_cbor` does."""
    parts: list[Any] = []
    _put(value, parts.append)
    return parts


@cache
def _short_head(major: int, count: int) -> bytes:
    return bytes((major << 5 | count,))


def _head(major: int, count: int) -> bytes:
    if count < _SHORT:
        return _short_head(major, count)
    for power in range(4):
        if not count >> (8 << power):
            return bytes((major << 5 | _SHORT + power,)) + count.to_bytes(1 << power, "big")
    raise TypeError("an integer of more than 64 bits has no form in CBOR here")


@cache
def _text(value: str) -> bytes:
    return _head(_TEXT, len(data := value.encode())) + data


@cache
def _fields(name: str) -> tuple[bytes, list[tuple[bytes, str]]]:
    """Return the head of a message's map, and its keys in CBOR with their names."""
    names = [one for one in types.fields(name) if one != NO_FIELD]
    return _head(_MAP, len(names)), [(_text(one), one) for one in names]


def _put(value: Any, add: _Add) -> None:  # noqa: ANN401 a message or any of its parts
    _WRITERS[type(value)](value, add)


def _put_float(value: float, add: _Add) -> None:
    add(_DOUBLE.pack(_DOUBLE_HEAD, value))


def _put_int(value: int, add: _Add) -> None:
    add(_head(_UNSIGNED, value) if value >= 0 else _head(_NEGATIVE, -1 - value))


def _put_text(value: str, add: _Add) -> None:
    data = value.encode()
    add(_head(_TEXT, len(data)) + data)


def _put_bytes(value: bytes, add: _Add) -> None:
    add(_head(_BYTES, len(value)))
    add(value)


def _put_list(value: list[Any] | tuple[Any, ...], add: _Add) -> None:
    add(_head(_LIST, len(value)))
    for one in value:
        _WRITERS[type(one)](one, add)


def _put_map(value: dict[Any, Any], add: _Add) -> None:
    add(_head(_MAP, len(value)))
    for key, one in value.items():
        _put(key, add)
        _put(one, add)


def _put_message(value: Any, add: _Add) -> None:  # noqa: ANN401 each type is a class of its own
    head, names = _fields(value.__msgtype__)
    add(head)
    for key, attribute in names:
        add(key)
        found = getattr(value, attribute)
        _WRITERS[type(found)](found, add)


def _put_array(value: np.ndarray, add: _Add) -> None:
    if value.dtype == np.bool_:
        return _put(value.tolist(), add)
    tag, is_plain = _form(value.dtype)
    add(tag + _head(_BYTES, value.nbytes))
    # Arrays are their own bytes; they are copied where all parts are joined.
    is_plain = is_plain and value.flags.c_contiguous
    add(value if is_plain else np.ascontiguousarray(value, value.dtype.newbyteorder("<")))


@cache
def _form(kind: np.dtype) -> tuple[bytes, bool]:
    """Return the tag of arrays of a kind of number, and whether their bytes are in the order that it tells."""
    return b"" if kind == np.uint8 else _head(_TAG, _TAGS[kind.name]), kind == kind.newbyteorder("<")


class _Writers(dict[type, Callable[[Any, _Add], None]]):
    """Writers of values by their class; those of messages come when the first one does."""

    def __missing__(self, kind: type) -> Callable[[Any, _Add], None]:
        """Return the writer of a class that has none yet; raises TypeError for what has no form."""
        if issubclass(kind, np.generic):
            found: Callable[[Any, _Add], None] = lambda value, add: _put(value.item(), add)  # noqa: E731
        elif hasattr(kind, "__msgtype__"):
            found = _put_message
        else:
            raise TypeError(f"{kind.__name__} has no form in CBOR")
        self[kind] = found
        return found


_WRITERS = _Writers(
    {
        **{float: _put_float, int: _put_int, str: _put_text, bytes: _put_bytes, np.ndarray: _put_array},
        **{list: _put_list, tuple: _put_list, dict: _put_map},
        bool: lambda value, add: add(_TRUE if value else _FALSE),
        type(None): lambda value, add: add(_NULL),
    }
)
