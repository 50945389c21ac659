"""Converters of values by their annotations: how what is annotated so is written, and read again."""

from __future__ import annotations

import inspect
import types
import typing
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from virtualrobot_kernel.history.documents import Decode, Encode, Reader, Writer
from virtualrobot_kernel.history.extensions import encode_array

PLAIN = (type(None), bool, int, float, str, bytes)
"""Classes of values that MessagePack has itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Converters:
    """Converters by annotations, of values that a codec writes.

    Attributes:
        known: the classes that have a form.
        encode_record: writes a value of one of these.
        encode_any: writes a value of which its annotation leaves open what it is,
        decode_any: and reads it.
    """

    known: Container[type]
    encode_record: Encode
    encode_any: Encode
    decode_any: Decode

    def of(self, hint: Any, where: str) -> tuple[Encode | None, Decode]:  # noqa: ANN401
        """Return how values with an annotation are written (None: as they are) and read.

        Raises TypeError, with `where` it is, for one that can't be written.
        """
        origin, args = typing.get_origin(hint), typing.get_args(hint)
        if hint in PLAIN or hint is None:
            return None, _plain(hint or type(None))
        if origin is np.ndarray:
            return encode_array, _as_it_is(np.ndarray)
        if origin in (types.UnionType, typing.Union):
            return self._union(args, where)
        if origin is tuple and args[1:] == (...,):
            return self._items(args[0], tuple, where)
        if origin is tuple:
            return self._tuple([self.of(one, where) for one in args])
        if origin is list:
            return self._items(args[0], list, where)
        if origin is frozenset:
            encode, decode = self._items(args[0], frozenset, where)
            return lambda value, writer: encode(sorted(value), writer) if encode else sorted(value), decode
        if origin is not None and issubclass(origin, Mapping) and args[1] is not Any:
            return self._mapping(*(self.of(one, where) for one in args))
        if inspect.isclass(hint) and issubclass(hint, Enum):
            return _encode_member, _decode_member(hint)
        if hint in self.known:
            return self.encode_record, self._checked(hint)
        open_to_all = hint in (Any, object, types.EllipsisType) or getattr(hint, "_is_protocol", False)
        if open_to_all or (origin is not None and issubclass(origin, Mapping)):
            return self.encode_any, self.decode_any
        raise TypeError(f"{where} is annotated with {hint}, which can't be written")

    def _union(self, options: Sequence[Any], where: str) -> tuple[Encode | None, Decode]:
        some = [one for one in options if one is not type(None)]
        if len(some) == 1:
            encode, decode = self.of(some[0], where)
            return (
                encode and (lambda value, writer: None if value is None else encode(value, writer)),
                lambda raw, reader: None if raw is None else decode(raw, reader),
            )
        for one in some:
            self.of(one, where)  # each can be written
        if all(one in PLAIN for one in options):
            return None, _plain(*options)
        return self.encode_any, self._checked(*(typing.get_origin(one) or one for one in options))

    def _items(self, item: object, make: type, where: str) -> tuple[Encode | None, Decode]:
        encode, decode = self.of(item, where)
        allowed = _plain_types(item)

        def read(raw: object, reader: Reader) -> object:
            if allowed.issuperset(map(type, listed(raw))):  # the same, quicker
                return make(typing.cast("list[Any]", raw))
            return make([decode(one, reader) for one in listed(raw)])

        if encode is None:
            return None if make is not frozenset else lambda value, writer: value, read
        return lambda value, writer: [encode(one, writer) for one in value], read

    def _tuple(self, converters: Sequence[tuple[Encode | None, Decode]]) -> tuple[Encode, Decode]:
        encoders, decoders = zip(*converters, strict=True)
        return (
            lambda value, writer: [e(x, writer) if e else x for e, x in zip(encoders, value, strict=True)],
            lambda raw, reader: tuple([d(x, reader) for d, x in zip(decoders, listed(raw), strict=True)]),
        )

    def _mapping(
        self, keys: tuple[Encode | None, Decode], values: tuple[Encode | None, Decode]
    ) -> tuple[Encode, Decode]:
        (encode_key, decode_key), (encode, decode) = keys, values

        def write(value: Mapping[Any, Any], writer: Writer) -> list[Any]:
            written = []
            for key, one in value.items():
                written.append(encode_key(key, writer) if encode_key else key)
                written.append(encode(one, writer) if encode else one)
            return written

        def read(raw: object, reader: Reader) -> dict[Any, Any]:
            return {decode_key(key, reader): decode(one, reader) for key, one in pairs(listed(raw))}

        return write, read

    def _checked(self, *classes: type) -> Decode:
        def read(raw: object, reader: Reader) -> object:
            value = self.decode_any(raw, reader)
            if not isinstance(value, classes):
                raise _misplaced(value, classes)
            return value

        return read


def _encode_member(value: Enum, _: Writer) -> str:
    return value.name


def _decode_member(cls: type[Enum]) -> Decode:
    return lambda raw, reader: cls[raw]


def _plain(*classes: type) -> Decode:
    """Return what reads values that are written as they are: an int may stand for a float, a NumPy scalar for both."""
    wider = {bool: (np.bool_,), int: (bool, np.integer), float: (int, np.floating, np.integer)}
    return _as_it_is(*classes, *(one for cls in classes for one in wider.get(cls, ())))


def _plain_types(hint: object) -> frozenset[type]:
    """Return types of values with an annotation that are read as they are."""
    return frozenset({float: {float, int}, int: {int}, str: {str}, bool: {bool}}.get(typing.cast("type", hint), ()))


def _as_it_is(*classes: type) -> Decode:
    def read(raw: object, _: Reader) -> object:
        if not isinstance(raw, classes):
            raise _misplaced(raw, classes)
        return raw

    return read


def _misplaced(value: object, classes: tuple[type, ...]) -> ValueError:
    names = " or ".join(cls.__name__ for cls in classes)
    return ValueError(f"{value!r:.80} stands where {names} belongs")


def listed(raw: object) -> list[Any]:
    """Return what was read as a list; raise ValueError when it is none."""
    if type(raw) is not list:
        raise ValueError(f"{raw!r:.80} stands where a list belongs")
    return raw


def pairs(values: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
    """Return values two by two; raise ValueError for an odd number of them."""
    return zip(values[::2], values[1::2], strict=True)
