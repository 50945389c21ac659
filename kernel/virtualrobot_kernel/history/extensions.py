"""Extensions of MessagePack in documents: arrays and NumPy scalars bit for bit, and references to what is elsewhere."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from msgspec.msgpack import Ext
from numpy.typing import NDArray

ARRAY, SCALAR, SHARED, PART = 1, 2, 3, 4
"""Codes of the extensions."""

DTYPES = tuple(map(np.dtype, ("<f8", "<f4", "<i8", "<i4", "<i2", "|i1", "<u8", "<u4", "<u2", "|u1", "|b1")))
"""Types of the elements of arrays, each written as its place here."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Extension as it was read: the place of a shared value, or the digest of a part."""

    code: int
    data: bytes


def encode_array(array: NDArray[Any], _: object = None) -> Ext:
    """Return an array of any shape as it is written; raise TypeError for one whose elements have no form here."""
    c_order = array.flags.c_contiguous or not array.flags.f_contiguous
    head = struct.pack(
        f"<BBB{array.ndim}I",
        _dtype_number(array.dtype),
        (not c_order) + 2 * array.flags.writeable,
        array.ndim,
        *array.shape,
    )
    return Ext(ARRAY, head + array.tobytes("C" if c_order else "F"))


def _decode_array(data: bytes) -> NDArray[Any]:
    number, flags, dimensions = data[:3]
    shape = struct.unpack_from(f"<{dimensions}I", data, 3)
    # A copy, since what lies anywhere in a message isn't aligned.
    array = np.frombuffer(data, DTYPES[number], offset=3 + 4 * dimensions).copy()
    array = array.reshape(shape, order="F" if flags & 1 else "C")
    array.setflags(write=bool(flags & 2))
    return array


def encode_scalar(value: object) -> Ext:
    """Return a NumPy scalar as it is written; raise TypeError for anything else."""
    if not isinstance(value, np.generic):
        raise unwritable(type(value))
    return Ext(SCALAR, bytes([_dtype_number(value.dtype)]) + value.tobytes())


def _dtype_number(dtype: np.dtype[Any]) -> int:
    try:
        return DTYPES.index(dtype.newbyteorder("<"))
    except ValueError:
        raise TypeError(f"nothing says how an array of {dtype} is written") from None


def _extension(code: int, data: memoryview) -> object:
    content = bytes(data)
    if code == ARRAY:
        return _decode_array(content)
    if code == SCALAR:
        return np.frombuffer(content, DTYPES[content[0]], offset=1)[0]
    if code in (SHARED, PART):
        return Reference(code, content)
    raise ValueError(f"there is no extension {code}")


def full_name(cls: type) -> str:
    """Return the name of a class with that of its module."""
    return f"{cls.__module__}.{cls.__qualname__}"


def unwritable(cls: type) -> TypeError:
    """Return the error of a value whose class has no form."""
    return TypeError(f"nothing says how {full_name(cls)} is written")


ENCODER = msgspec.msgpack.Encoder(enc_hook=encode_scalar)
DECODER = msgspec.msgpack.Decoder(list[Any], ext_hook=_extension)
