"""Documents of the codec while they are written and read: classes and their forms, what is shared, and parts."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from msgspec.msgpack import Ext

from virtualrobot_kernel.errors import KernelError, Reason

Encode = Callable[[Any, "Writer"], Any]
Decode = Callable[[Any, "Reader"], Any]
"""Function from a value to what MessagePack has, and back."""


class UnreadableError(KernelError):
    """Refusal of bytes that no value comes out of: they are damaged, or another program has written them."""

    reason = Reason.MALFORMED_FILE


class UnknownVersionError(UnreadableError):
    """Refusal of a class, or of a version of it, that this program doesn't know; the message has both numbers."""


@dataclass(frozen=True, slots=True)
class InParts:
    """Document whose parts lie elsewhere: its own bytes, all parts by digest, and the bytes of those written anew."""

    body: bytes
    parts: frozenset[bytes]
    fresh: Mapping[bytes, bytes]


class Parts:
    """Memory of which objects are written already; keep it from one `encode_in_parts` to the next."""

    def __init__(self) -> None:
        """Begin with nothing written."""
        # The objects are kept, since an identity is given anew when its object is gone.
        self.written: dict[int, tuple[object, Ext, frozenset[bytes]]] = {}


@dataclass(slots=True, eq=False)
class Writer:
    """Document that is being written: its classes, its shared values and their places, and the digests of its parts."""

    parts: PartWriter | None
    classes: dict[str, int] = dataclasses.field(default_factory=dict)
    shared: list[Any] = dataclasses.field(default_factory=list)
    places: dict[int, Ext] = dataclasses.field(default_factory=dict)
    digests: set[bytes] = dataclasses.field(default_factory=set)


@dataclass(slots=True, eq=False)
class PartWriter:
    """Parts of a document and of its parts: those of before, those used, and those written anew."""

    known: Mapping[int, tuple[object, Ext, frozenset[bytes]]]
    used: dict[int, tuple[object, Ext, frozenset[bytes]]] = dataclasses.field(default_factory=dict)
    fresh: dict[bytes, bytes] = dataclasses.field(default_factory=dict)


@dataclass(slots=True, eq=False)
class Reader:
    """Document that is being read: its classes with their versions, what gives its parts, and its shared values."""

    classes: list[tuple[Form, int]]
    part: Callable[[bytes], Any]
    shared: list[Any] = dataclasses.field(default_factory=list)


@dataclass(slots=True, eq=False)
class Form:
    """Form in which values of one class are written."""

    cls: type
    tag: str
    version: int
    names: tuple[str, ...] = ()
    fields: Callable[[Any], tuple[Any, ...]] = tuple
    encoders: tuple[Encode | None, ...] = ()  # none where all fields are written as they are
    decoders: tuple[Decode, ...] = ()
    make: Callable[..., Any] = tuple
    shared: bool = False
    part: bool = False
