"""Codec: values of frozen classes to bytes and back, bit for bit, by their annotations alone.

A document is MessagePack: [format, classes, shared, root]. `classes` names each class that is in it, and its version:
[tag, version, tag, version, ...]; whatever is not known is so refused before anything is read. A value of a class is
[its place among them, field, field, ...]. `shared` holds the values of classes that compare by identity: each is
written once, after those that are in it, and is one object again. Where an annotation leaves open what a value is (a
union, `object`, `Any`), a container says so by a negative number in that place.
"""

from __future__ import annotations

import dataclasses
import inspect
import struct
import sys
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from hashlib import blake2b
from operator import attrgetter
from typing import Any

import msgspec
import numpy as np
from msgspec.msgpack import Ext
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason

FORMAT = 1
"""Number of the format of documents; one with another number is refused."""

# Codes of MessagePack's extensions.
ARRAY, SCALAR, SHARED, PART = 1, 2, 3, 4
# What a container is where nothing else says so.
TUPLE, LIST, MAP, MEMBER, SET, ELLIPSIS = -1, -2, -3, -4, -5, -6

DTYPES = tuple(map(np.dtype, ("<f8", "<f4", "<i8", "<i4", "<i2", "|i1", "<u8", "<u4", "<u2", "|u1", "|b1")))
PLAIN = (type(None), bool, int, float, str, bytes)

Migration = Callable[[list[Any]], list[Any]]
"""Function from the written fields of one version of a class to those of the next one."""

Encode = Callable[[Any, "_Writer"], Any]
Decode = Callable[[Any, "_Reader"], Any]


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
class _Writer:
    """Document that is being written: its classes, its shared values and their places, and the digests of its parts."""

    parts: _PartWriter | None
    classes: dict[str, int] = dataclasses.field(default_factory=dict)
    shared: list[Any] = dataclasses.field(default_factory=list)
    places: dict[int, Ext] = dataclasses.field(default_factory=dict)
    digests: set[bytes] = dataclasses.field(default_factory=set)


@dataclass(slots=True, eq=False)
class _PartWriter:
    """Parts of a document and of its parts: those of before, those used, and those written anew."""

    known: Mapping[int, tuple[object, Ext, frozenset[bytes]]]
    used: dict[int, tuple[object, Ext, frozenset[bytes]]] = dataclasses.field(default_factory=dict)
    fresh: dict[bytes, bytes] = dataclasses.field(default_factory=dict)


@dataclass(slots=True, eq=False)
class _Reader:
    """Document that is being read: its classes with their versions, what gives its parts, and its shared values."""

    classes: list[tuple[_Form, int]]
    part: Callable[[bytes], Any]
    shared: list[Any] = dataclasses.field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class _Reference:
    """Extension as it was read: the place of a shared value, or the digest of a part."""

    code: int
    data: bytes


@dataclass(slots=True, eq=False)
class _Form:
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
        self._forms: dict[type, _Form] = {}
        self._by_tag: dict[str, _Form] = {}
        for cls in classes:
            form = _Form(cls, (tags or {}).get(cls, cls.__name__), (versions or {}).get(cls, 1))
            if (other := self._by_tag.get(form.tag)) is not None:
                raise TypeError(f"two classes would be written as {form.tag!r}: {_path(cls)}, {_path(other.cls)}")
            self._forms[cls] = self._by_tag[form.tag] = form
        for form in self._forms.values():
            if not issubclass(form.cls, Enum):
                self._prepare(form)
        for cls in parts:
            if not self._forms[cls].shared:
                raise TypeError(f"{_path(cls)} compares by value, so that it can't be a part")
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
        writer = _PartWriter(parts.written)
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
        self, value: object, parts: _PartWriter | None, *, is_part: bool = False
    ) -> tuple[bytes, frozenset[bytes]]:
        writer = _Writer(parts)
        try:
            root = self._encode_fields(value, writer) if is_part else self._encode_any(value, writer)
            classes = [item for tag in writer.classes for item in (tag, self._by_tag[tag].version)]
            data = _ENCODER.encode([FORMAT, classes, writer.shared, root])
        except (TypeError, OverflowError, RecursionError) as error:
            raise KernelError(f"a value can't be written: {error}", reason=Reason.INTERNAL) from error
        return data, frozenset(writer.digests)

    def _read(self, data: bytes, part: Callable[[bytes], Any]) -> Any:  # noqa: ANN401
        try:
            format, *rest = _DECODER.decode(data)
            if format != FORMAT:
                raise UnknownVersionError(f"the format is number {format!r}; this program knows {FORMAT}")
            classes, shared, root = rest
            reader = _Reader([self._known(tag, version) for tag, version in _pairs(classes)], part)
            for raw in shared:
                reader.shared.append(self._decode_any(raw, reader))
            return self._decode_any(root, reader)
        except UnreadableError:
            raise
        except Exception as error:  # whatever a damaged byte may lead to, in the classes' own checks, too
            raise UnreadableError(f"it is damaged: {error or type(error).__name__}") from error

    def _known(self, tag: str, version: int) -> tuple[_Form, int]:
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

    def _prepare(self, form: _Form) -> None:
        cls = form.cls
        hints = typing.get_type_hints(cls, vars(sys.modules[cls.__module__]))
        form.names = names = _field_names(cls)
        if len(names) > 1:
            form.fields = attrgetter(*names)
        else:
            form.fields = lambda value: tuple(getattr(value, name) for name in names)
        pairs = [self._converters(hints[name], f"{_path(cls)}.{name}") for name in names]
        encoders = tuple(encode for encode, _ in pairs)
        form.encoders = encoders if any(encoders) else ()
        form.decoders = tuple(decode for _, decode in pairs)
        form.make = cls
        if dataclasses.is_dataclass(cls):
            form.shared = cls.__eq__ is object.__eq__
            if any(field.kw_only for field in dataclasses.fields(cls)):
                form.make = lambda *values: cls(**dict(zip(names, values, strict=True)))

    def _converters(self, hint: Any, where: str) -> tuple[Encode | None, Decode]:  # noqa: ANN401
        """Return how values with an annotation are written (None: as they are) and read."""
        origin, args = typing.get_origin(hint), typing.get_args(hint)
        if hint in PLAIN or hint is None:
            return None, _plain(hint or type(None))
        if origin is np.ndarray:
            return _encode_array, _checked(np.ndarray)
        if origin in (types.UnionType, typing.Union):
            return self._union(args, where)
        if origin is tuple and args[1:] == (...,):
            return self._items(args[0], tuple, where)
        if origin is tuple:
            return self._tuple([self._converters(one, where) for one in args])
        if origin is list:
            return self._items(args[0], list, where)
        if origin is frozenset:
            encode, decode = self._items(args[0], frozenset, where)
            return lambda value, writer: encode(sorted(value), writer) if encode else sorted(value), decode
        if origin is not None and issubclass(origin, Mapping) and args[1] is not Any:
            return self._mapping(*(self._converters(one, where) for one in args))
        if inspect.isclass(hint) and issubclass(hint, Enum):
            return _encode_member, _decode_member(hint)
        if hint in self._forms:
            return self._encode_record, self._decode_checked(hint)
        open_to_all = hint in (Any, object, types.EllipsisType) or getattr(hint, "_is_protocol", False)
        if open_to_all or (origin is not None and issubclass(origin, Mapping)):
            return self._encode_any, self._decode_any
        raise TypeError(f"{where} is annotated with {hint}, which can't be written")

    def _union(self, options: Sequence[Any], where: str) -> tuple[Encode | None, Decode]:
        some = [one for one in options if one is not type(None)]
        if len(some) == 1:
            encode, decode = self._converters(some[0], where)
            return (
                encode and (lambda value, writer: None if value is None else encode(value, writer)),
                lambda raw, reader: None if raw is None else decode(raw, reader),
            )
        for one in some:
            self._converters(one, where)  # each can be written
        if all(one in PLAIN for one in options):
            return None, _plain(*options)
        return self._encode_any, self._decode_checked(*(typing.get_origin(one) or one for one in options))

    def _items(self, item: object, make: type, where: str) -> tuple[Encode | None, Decode]:
        encode, decode = self._converters(item, where)
        allowed = _plain_types(item)

        def read(raw: object, reader: _Reader) -> object:
            if allowed.issuperset(map(type, _listed(raw))):  # the same, quicker
                return make(typing.cast("list[Any]", raw))
            return make([decode(one, reader) for one in _listed(raw)])

        if encode is None:
            return None if make is not frozenset else lambda value, writer: value, read
        return lambda value, writer: [encode(one, writer) for one in value], read

    def _tuple(self, pairs: Sequence[tuple[Encode | None, Decode]]) -> tuple[Encode, Decode]:
        encoders, decoders = zip(*pairs, strict=True)
        return (
            lambda value, writer: [e(x, writer) if e else x for e, x in zip(encoders, value, strict=True)],
            lambda raw, reader: tuple([d(x, reader) for d, x in zip(decoders, _listed(raw), strict=True)]),
        )

    def _mapping(
        self, keys: tuple[Encode | None, Decode], values: tuple[Encode | None, Decode]
    ) -> tuple[Encode, Decode]:
        (encode_key, decode_key), (encode, decode) = keys, values

        def write(value: Mapping[Any, Any], writer: _Writer) -> list[Any]:
            written = []
            for key, one in value.items():
                written.append(encode_key(key, writer) if encode_key else key)
                written.append(encode(one, writer) if encode else one)
            return written

        def read(raw: object, reader: _Reader) -> dict[Any, Any]:
            return {decode_key(key, reader): decode(one, reader) for key, one in _pairs(_listed(raw))}

        return write, read

    def _encode_fields(self, value: object, writer: _Writer) -> list[Any]:
        form = self._forms[type(value)]
        place = writer.classes.setdefault(form.tag, len(writer.classes))
        fields = form.fields(value)
        if not form.encoders:
            return [place, *fields]
        return [
            place,
            *[encode(one, writer) if encode else one for encode, one in zip(form.encoders, fields, strict=True)],
        ]

    def _encode_record(self, value: object, writer: _Writer) -> object:
        parts = writer.parts
        if parts is not None and (known := parts.known.get(id(value))) is not None:  # most of a world that was written
            parts.used[id(value)] = known
            writer.digests.update(known[2])
            return known[1]
        form = self._forms.get(type(value))
        if form is None:
            raise TypeError(f"nothing says how {_path(type(value))} is written")
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

    def _part(self, value: object, writer: _Writer, parts: _PartWriter) -> Ext:
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

    def _encode_any(self, value: object, writer: _Writer) -> object:
        cls = type(value)
        if cls in PLAIN:
            return value
        if isinstance(value, Enum):
            tag = self._forms[cls].tag if cls in self._forms else None
            if tag is None:
                raise TypeError(f"nothing says how {_path(cls)} is written")
            return [MEMBER, writer.classes.setdefault(tag, len(writer.classes)), value.name]
        if cls in self._forms:
            return self._encode_record(value, writer)
        if isinstance(value, np.ndarray):
            return _encode_array(value, writer)
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
            return _scalar(value)
        raise TypeError(f"nothing says how {_path(cls)} is written")

    def _decode_checked(self, *classes: type) -> Decode:
        def read(raw: object, reader: _Reader) -> object:
            value = self._decode_any(raw, reader)
            if not isinstance(value, classes):
                raise ValueError(f"{value!r:.80} stands where {_named(classes)} belongs")
            return value

        return read

    def _decode_any(self, raw: Any, reader: _Reader) -> Any:  # noqa: ANN401
        if type(raw) is _Reference:
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
            return dict(_pairs(values))
        return {TUPLE: tuple, LIST: list, SET: frozenset}[kind](values)

    def _decode_record(self, form: _Form, version: int, fields: list[Any], reader: _Reader) -> object:
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
        pairs = [(f"{path}[{key!r}]", one[key], other[key]) for key in one]
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
        pairs = [(f"{path}.{name}", getattr(one, name), getattr(other, name)) for name in names]
    elif isinstance(one, (tuple, list)):
        assert isinstance(other, (tuple, list))
        if len(one) != len(other):
            return f"{path}: {len(one)} and {len(other)} items"
        pairs = [(f"{path}[{at}]", *pair) for at, pair in enumerate(zip(one, other, strict=True))]
    else:
        return "" if one == other else f"{path}: {one!r} and {other!r}"
    return next((found for where, a, b in pairs if (found := same(a, b, where))), "")


def _encode_array(array: NDArray[Any], _: _Writer) -> Ext:
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


def _scalar(value: object) -> Ext:
    if not isinstance(value, np.generic):
        raise TypeError(f"nothing says how {_path(type(value))} is written")
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
        return _Reference(code, content)
    raise ValueError(f"there is no extension {code}")


_ENCODER = msgspec.msgpack.Encoder(enc_hook=_scalar)
_DECODER = msgspec.msgpack.Decoder(list[Any], ext_hook=_extension)


def _encode_member(value: Enum, _: _Writer) -> str:
    return value.name


def _decode_member(cls: type[Enum]) -> Decode:
    return lambda raw, reader: cls[raw]


def _plain(*classes: type) -> Decode:
    """Return what reads values that are written as they are: an int may stand for a float, a NumPy scalar for both."""
    wider = {bool: (np.bool_,), int: (bool, np.integer), float: (int, np.floating, np.integer)}
    return _checked(*classes, *(one for cls in classes for one in wider.get(cls, ())))


def _plain_types(hint: object) -> frozenset[type]:
    """Return types of values with an annotation that are read as they are."""
    return frozenset({float: {float, int}, int: {int}, str: {str}, bool: {bool}}.get(typing.cast("type", hint), ()))


def _checked(*classes: type) -> Decode:
    def read(raw: object, _: _Reader) -> object:
        if not isinstance(raw, classes):
            raise ValueError(f"{raw!r:.80} stands where {_named(classes)} belongs")
        return raw

    return read


def _listed(raw: object) -> list[Any]:
    if type(raw) is not list:
        raise ValueError(f"{raw!r:.80} stands where a list belongs")
    return raw


def _pairs(values: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
    return zip(values[::2], values[1::2], strict=True)


def _field_names(cls: type) -> tuple[str, ...]:
    """Return the names of what an instance is made of, in order."""
    if dataclasses.is_dataclass(cls):
        return tuple(field.name for field in dataclasses.fields(cls) if field.init)
    return cls._fields  # pyright: ignore[reportAttributeAccessIssue]


def _annotations(form: _Form) -> Iterator[str]:
    for name in form.names:
        annotation = next(vars(cls)["__annotations__"][name] for cls in form.cls.__mro__ if name in _own(cls))
        yield f"{name}: {getattr(annotation, '__forward_arg__', annotation)}"


def _own(cls: type) -> Mapping[str, Any]:
    return vars(cls).get("__annotations__", {})


def _path(cls: type) -> str:
    return f"{cls.__module__}.{cls.__qualname__}"


def _named(classes: Iterable[type]) -> str:
    return " or ".join(cls.__name__ for cls in classes)


def _numbers(numbers: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(numbers)))
