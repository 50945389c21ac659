"""Codec: values of frozen classes to bytes and back, bit for bit, by their annotations alone.

A document is MessagePack: [format, classes, shared, root]. `classes` names each class that is in it, and its version:
[tag, version, tag, version, ...]; whatever is not known is so refused before anything is read. A value of a class is
[its place among them, field, field, ...]. `shared` holds the values of classes that compare by identity: each is
written once, after those that are in it, and is one object again. Where an annotation leaves open what a value is (a
union, `object`, `Any`), a container says so by a negative number in that place.
"""

from __future__ import annotations

import dataclasses
import functools
import struct
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping
from enum import Enum
from hashlib import blake2b
from operator import attrgetter
from typing import Any

import numpy as np
from msgspec.msgpack import Ext

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.converters import PLAIN, Converters, pairs
from virtualrobot_kernel.history.documents import (
    Form,
    InParts,
    Parts,
    PartWriter,
    Reader,
    UnknownVersionError,
    UnreadableError,
    Writer,
)
from virtualrobot_kernel.history.extensions import (
    DECODER,
    ENCODER,
    PART,
    SHARED,
    Reference,
    encode_array,
    encode_scalar,
    full_name,
    unwritable,
)

FORMAT = 1
"""Number of the format of documents; one with another number is refused."""

TUPLE, LIST, MAP, MEMBER, SET, ELLIPSIS = -1, -2, -3, -4, -5, -6
"""Numbers that say what a container is where nothing else says so."""

hints_of = functools.cache(typing.get_type_hints)
"""Function that returns the types of a class's fields; to find them twice would take 20 ms of a start."""

Migration = Callable[[list[Any]], list[Any]]
"""Function from the written fields of one version of a class to those of the next one."""


class Codec:
    """Codec of some classes: dataclasses, named tuples and enums; of arrays, and of what JSON has.

    Bit for bit: -0.0, infinities and what is in a NaN, dtype, shape and order of an array and whether it may be
    written to, the type of a NumPy scalar. A mapping becomes a dict, in its order.
    """

    def __init__(
        self,
        classes: Iterable[type],
        *,
        tags: Mapping[type, str] | None = None,
        versions: Mapping[type, int] | None = None,
        migrations: Mapping[tuple[str, int], Migration] | None = None,
        parts: Iterable[type] = (),
    ) -> None:
        """Prepare the classes; raise TypeError for an annotation that can't be written, or a tag of two classes.

        Args:
            classes: all that a value may consist of.
            tags: the name of a class in documents, where that isn't its own.
            versions: of classes whose fields have changed since they were first written (1).
            migrations: by (tag, version), what makes its fields those of the next version.
            parts: classes whose values `encode_in_parts` writes by themselves; they compare by identity.
        """
        self._migrations = dict(migrations or {})
        self._forms: dict[type, Form] = {}
        self._by_tag: dict[str, Form] = {}
        for cls in classes:
            form = Form(cls, (tags or {}).get(cls, cls.__name__), (versions or {}).get(cls, 1))
            if (other := self._by_tag.get(form.tag)) is not None:
                raise TypeError(
                    f"two classes would be written as {form.tag!r}: {full_name(cls)}, {full_name(other.cls)}"
                )
            self._forms[cls] = self._by_tag[form.tag] = form
        for form in self._forms.values():
            if not issubclass(form.cls, Enum):
                self._prepare(form)
        for cls in parts:
            if not self._forms[cls].shared:
                raise TypeError(f"{full_name(cls)} compares by value, so that it can't be a part")
            self._forms[cls].part = True

    def encode(self, value: object) -> bytes:
        """Return the document of a value; raise KernelError (INTERNAL) when something in it has no form here."""
        return self._document(value, None)[0]

    def decode(self, data: bytes, part: Callable[[bytes], bytes] | None = None) -> Any:  # noqa: ANN401
        """Return the value of a document; `part` gives the bytes of one of its parts by digest.

        Raises UnknownVersionError for what a newer program has written, else UnreadableError.
        """
        values: dict[bytes, Any] = {}

        def made(digest: bytes) -> object:
            if digest not in values:
                if part is None:
                    raise UnreadableError(f"the part {digest.hex()} is missing")
                values[digest] = self._read(part(digest), made)
            return values[digest]

        return self._read(data, made)

    def encode_in_parts(self, value: object, parts: Parts) -> InParts:
        """Return the document of a value whose parts are documents by themselves, named by their digests.

        What `parts` remembers isn't written again; it remembers afterwards what this value consists of.
        """
        writer = PartWriter(parts.written)
        body, digests = self._document(value, writer)
        parts.written = writer.used
        return InParts(body, digests, writer.fresh)

    def schema(self) -> dict[str, tuple[int, list[str]]]:
        """Return version and fields ("name: annotation") of each class by tag, or the names of an enum's members."""
        return {
            tag: (form.version, [*form.cls.__members__] if issubclass(form.cls, Enum) else [*_annotations(form)])
            for tag, form in sorted(self._by_tag.items())
        }

    def _document(
        self, value: object, parts: PartWriter | None, *, is_part: bool = False
    ) -> tuple[bytes, frozenset[bytes]]:
        writer = Writer(parts)
        try:
            root = self._encode_fields(value, writer) if is_part else self._encode_any(value, writer)
            classes = [item for tag in writer.classes for item in (tag, self._by_tag[tag].version)]
            data = ENCODER.encode([FORMAT, classes, writer.shared, root])
        except (TypeError, OverflowError, RecursionError) as error:
            raise KernelError(f"a value can't be written: {error}", reason=Reason.INTERNAL) from error
        return data, frozenset(writer.digests)

    def _read(self, data: bytes, part: Callable[[bytes], Any]) -> Any:  # noqa: ANN401
        try:
            format, *rest = DECODER.decode(data)
            if format != FORMAT:
                raise UnknownVersionError(f"the format is number {format!r}; this program knows {FORMAT}")
            classes, shared, root = rest
            reader = Reader([self._known(tag, version) for tag, version in pairs(classes)], part)
            for raw in shared:
                reader.shared.append(self._decode_any(raw, reader))
            return self._decode_any(root, reader)
        except UnreadableError:
            raise
        except Exception as error:  # whatever a damaged byte may lead to, in the classes' own checks, too
            raise UnreadableError(f"it is damaged: {error or type(error).__name__}") from error

    def _known(self, tag: str, version: int) -> tuple[Form, int]:
        form = self._by_tag.get(tag)
        if form is None:
            raise UnknownVersionError(
                f"it has a {tag!r} of version {version}, which this program doesn't know", tag=tag, version=version
            )
        known = {form.version}
        while (tag, min(known) - 1) in self._migrations:
            known.add(min(known) - 1)
        if version not in known:
            raise UnknownVersionError(
                f"it has a {tag!r} of version {version}; this program knows {_numbers(known)}",
                tag=tag,
                version=version,
                known=_numbers(known),
            )
        return form, version

    def _prepare(self, form: Form) -> None:
        cls = form.cls
        hints = hints_of(cls)
        form.names = names = _field_names(cls)
        if len(names) > 1:
            form.fields = attrgetter(*names)
        else:
            form.fields = lambda value: tuple(getattr(value, name) for name in names)
        converters = Converters(self._forms, self._encode_record, self._encode_any, self._decode_any)
        both = [converters.of(hints[name], f"{full_name(cls)}.{name}") for name in names]
        encoders = tuple(encode for encode, _ in both)
        form.encoders = encoders if any(encoders) else ()
        form.decoders = tuple(decode for _, decode in both)
        form.make = cls
        if dataclasses.is_dataclass(cls):
            form.shared = cls.__eq__ is object.__eq__
            if any(field.kw_only for field in dataclasses.fields(cls)):
                form.make = lambda *values: cls(**dict(zip(names, values, strict=True)))

    def _encode_fields(self, value: object, writer: Writer) -> list[Any]:
        form = self._forms[type(value)]
        place = writer.classes.setdefault(form.tag, len(writer.classes))
        fields = form.fields(value)
        if not form.encoders:
            return [place, *fields]
        return [
            place,
            *[encode(one, writer) if encode else one for encode, one in zip(form.encoders, fields, strict=True)],
        ]

    def _encode_record(self, value: object, writer: Writer) -> object:
        parts = writer.parts
        if parts is not None and (known := parts.known.get(id(value))) is not None:  # most of a world that was written
            parts.used[id(value)] = known
            writer.digests.update(known[2])
            return known[1]
        form = self._forms.get(type(value))
        if form is None:
            raise unwritable(type(value))
        if not form.shared:
            return self._encode_fields(value, writer)
        if (reference := writer.places.get(id(value))) is not None:
            return reference
        if form.part and parts is not None:
            reference = self._part(value, writer, parts)
        else:
            written = self._encode_fields(value, writer)
            number = len(writer.shared)
            reference = Ext(SHARED, number.to_bytes((number.bit_length() + 7) // 8 or 1, "little"))
            writer.shared.append(written)
        writer.places[id(value)] = reference
        return reference

    def _part(self, value: object, writer: Writer, parts: PartWriter) -> Ext:
        """Return the reference to a part, which is written if it wasn't yet."""
        known = parts.used.get(id(value))
        if known is None:
            data, inner = self._document(value, parts, is_part=True)
            digest = blake2b(data, digest_size=16).digest()
            parts.fresh[digest] = data
            known = (value, Ext(PART, digest), inner | {digest})
            parts.used[id(value)] = known
        writer.digests.update(known[2])
        return known[1]

    def _encode_any(self, value: object, writer: Writer) -> object:
        cls = type(value)
        if cls in PLAIN:
            return value
        if isinstance(value, Enum):
            tag = self._forms[cls].tag if cls in self._forms else None
            if tag is None:
                raise unwritable(cls)
            return [MEMBER, writer.classes.setdefault(tag, len(writer.classes)), value.name]
        if cls in self._forms:
            return self._encode_record(value, writer)
        if isinstance(value, np.ndarray):
            return encode_array(value)
        if cls in (tuple, list) and isinstance(value, (tuple, list)):
            return [TUPLE if cls is tuple else LIST, *[self._encode_any(one, writer) for one in value]]
        if isinstance(value, Mapping):
            items = (one for pair in value.items() for one in pair)
            return [MAP, *[self._encode_any(one, writer) for one in items]]
        if isinstance(value, frozenset):
            return [SET, *[self._encode_any(one, writer) for one in sorted(value)]]
        if value is ...:
            return [ELLIPSIS]
        if isinstance(value, np.generic):
            return encode_scalar(value)
        raise unwritable(cls)

    def _decode_any(self, raw: Any, reader: Reader) -> Any:  # noqa: ANN401
        if type(raw) is Reference:
            if raw.code == SHARED:
                return reader.shared[int.from_bytes(raw.data, "little")]
            return reader.part(raw.data)
        if type(raw) is not list:
            return raw
        kind, *rest = raw
        if type(kind) is not int:
            raise ValueError(f"{kind!r:.80} stands where a class belongs")
        if kind >= 0:
            return self._decode_record(*reader.classes[kind], rest, reader)
        if kind == MEMBER:
            form, _ = reader.classes[rest[0]]
            return form.cls[rest[1]]  # pyright: ignore[reportIndexIssue]
        if kind == ELLIPSIS:
            return ...
        values = [self._decode_any(one, reader) for one in rest]
        if kind == MAP:
            return dict(pairs(values))
        return {TUPLE: tuple, LIST: list, SET: frozenset}[kind](values)

    def _decode_record(self, form: Form, version: int, fields: list[Any], reader: Reader) -> object:
        while version != form.version:
            fields = self._migrations[form.tag, version](fields)
            version += 1
        if len(fields) != len(form.decoders):
            raise ValueError(f"a {form.tag!r} has {len(form.decoders)} fields, not {len(fields)}")
        return form.make(*[decode(one, reader) for decode, one in zip(form.decoders, fields, strict=True)])


def same(one: object, other: object, path: str = "") -> str:
    """Return where two values differ first in type or bits (`.joints[2]`), or an empty text; NaN equals itself."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        if [*one] != [*other]:
            return f"{path}: {[*one]} and {[*other]}"
        inner = [(f"{path}[{key!r}]", one[key], other[key]) for key in one]
    elif type(one) is not type(other):
        return f"{path}: {type(one).__name__} and {type(other).__name__}"
    elif isinstance(one, np.ndarray):
        assert isinstance(other, np.ndarray)
        alike = one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
        return "" if alike else f"{path}: {one!r} and {other!r}"
    elif isinstance(one, float):
        return "" if struct.pack("d", one) == struct.pack("d", other) else f"{path}: {one!r} and {other!r}"
    elif dataclasses.is_dataclass(one):
        names = [field.name for field in dataclasses.fields(one)]
        inner = [(f"{path}.{name}", getattr(one, name), getattr(other, name)) for name in names]
    elif isinstance(one, (tuple, list)):
        assert isinstance(other, (tuple, list))
        if len(one) != len(other):
            return f"{path}: {len(one)} and {len(other)} items"
        inner = [(f"{path}[{at}]", *pair) for at, pair in enumerate(zip(one, other, strict=True))]
    else:
        return "" if one == other else f"{path}: {one!r} and {other!r}"
    return next((found for where, a, b in inner if (found := same(a, b, where))), "")


def _field_names(cls: type) -> tuple[str, ...]:
    """Return the names of what an instance is made of, in order."""
    if dataclasses.is_dataclass(cls):
        return tuple(field.name for field in dataclasses.fields(cls) if field.init)
    return cls._fields  # pyright: ignore[reportAttributeAccessIssue]


def _annotations(form: Form) -> Iterator[str]:
    for name in form.names:
        annotation = next(vars(cls)["__annotations__"][name] for cls in form.cls.__mro__ if name in _own(cls))
        yield f"{name}: {getattr(annotation, '__forward_arg__', annotation)}"


def _own(cls: type) -> Mapping[str, Any]:
    return vars(cls).get("__annotations__", {})


def _numbers(numbers: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(numbers)))
