"""Tables of fields: a class of values and its message, each field read and written by the same row."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any, Generic, TypeVar

import numpy as np
from google.protobuf.message import Message

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import BY_NAME, COLOR, FINITE, PLAIN, POSE, SETTINGS, VECTOR, Codec, OrDefault
from virtualrobot_kernel.messages.fields import Field, is_map, is_repeated

V = TypeVar("V")
M = TypeVar("M", bound=Message)

UNITS = (
    *("meters", "radians", "seconds", "kilograms", "hertz", "pixels"),
    *("meters_per_second", "meters_per_second_squared", "radians_per_second"),
)
"""Units that a field's name may have behind that of its attribute."""

USUAL = {"Vector3": VECTOR, "Pose": POSE, "Color": COLOR, "Struct": SETTINGS}
"""Codecs of fields of these messages, where a table says nothing else."""


@dataclass(frozen=True, slots=True)
class _Row:
    attribute: str
    field: str
    read: Callable[[Any, str], Any]
    write: Callable[[Any], Any]
    default: object
    has_presence: bool
    skips_zero: bool
    is_plain: bool


class OneOf:
    """Codec of a oneof: each of its fields has a class, and the message is what holds the oneof."""

    def __init__(self, name: str, **tables: Table[Any, Any]) -> None:
        """Take the name of the oneof, and the table of each of its fields."""
        self.name, self._tables = name, tables
        self._fields = {table.made: field for field, table in tables.items()}

    def read(self, given: Message, what: str) -> Any:  # noqa: ANN401  a value of one of the classes
        """Return the value that is given; raise KernelError where none is."""
        chosen = given.WhichOneof(self.name)
        if chosen is None:
            raise KernelError(f"{what} does not say its {self.name}; give one of {', '.join(self._tables)}", field=what)
        return self._tables[chosen].read(getattr(given, chosen), f"{what}.{chosen}")

    def write(self, value: object) -> dict[str, Any]:
        """Return the field of a value, and its message."""
        field = self._fields[type(value)]
        return {field: self._tables[field].write(value)}


class Table(Generic[V, M]):
    """Rows of a class of values and a message: one for each attribute.

    The field of an attribute has its name, or its name and a unit behind it, or what `names` says. A codec that is not
    said follows from the field's type. What a message leaves out, and an enum's UNSPECIFIED, is the class's default;
    what equals the default is left out of a message, where that can be told from 0.
    """

    def __init__(
        self,
        made: type[V],
        message: type[M],
        /,
        *,
        names: Mapping[str, str] | None = None,
        without: Iterable[str] = (),
        numbers: Codec = FINITE,
        check: Callable[[V, str], object] | None = None,
        **codecs: Codec | OrDefault | OneOf,
    ) -> None:
        """Match the attributes of `made` with the fields of `message`.

        Args:
            made: the class, a dataclass.
            message: the class of the message.
            names: fields by attributes whose names differ.
            without: attributes and fields that the caller converts, or that have no counterpart.
            numbers: the codec of numbers that have none of their own.
            check: raises KernelError for values that don't go together; it takes what was read, and its name.
            codecs: by attribute; a `OneOf` by the name of the oneof.
        """
        self.made, self._message, self._check = made, message, check
        self._rows: list[_Row] = []
        self._oneofs = [(name, one) for name, one in codecs.items() if isinstance(one, OneOf)]
        known = message.DESCRIPTOR.fields_by_name
        for attribute in fields(made):  # pyright: ignore[reportArgumentType] a dataclass
            name = attribute.name
            if name in without or name in message.DESCRIPTOR.oneofs_by_name:
                continue
            tried = ((names or {}).get(name), name, *(f"{name}_{unit}" for unit in UNITS))
            field = next((one for one in tried if one in known), None)
            if field is None:
                raise TypeError(f"{message.DESCRIPTOR.name} has no field for {made.__name__}.{name}")
            codec = codecs.get(name) or _usual(known[field], numbers)
            assert not isinstance(codec, OneOf)
            self._rows.append(_row(name, known[field], codec, _default(attribute)))
        told = {row.field for row in self._rows}.union(without)
        if unsaid := [one.name for one in known.values() if one.name not in told and not _in_oneof(one, self._oneofs)]:
            raise TypeError(f"{made.__name__} has no attribute for {message.DESCRIPTOR.name}.{', '.join(unsaid)}")
        self._needed = [row for row in self._rows if row.default is MISSING and row.has_presence]

    def read(self, given: M, what: str, **more: object) -> V:
        """Return the value of a message; raise KernelError, which names the field, for what is wrong.

        Args:
            given: the message.
            what: its name in errors, before those of its fields.
            more: attributes that the caller has converted.
        """
        values: dict[str, Any] = more
        for row in self._rows:
            if row.has_presence and not given.HasField(row.field):  # pyright: ignore[reportArgumentType] its name
                continue
            value = getattr(given, row.field)
            if row.skips_zero and not value:
                continue
            values[row.attribute] = value if row.is_plain else row.read(value, f"{what}.{row.field}")
        for row in self._needed:
            if row.attribute not in values:
                raise KernelError(f"{what}.{row.field} is missing; give it", field=f"{what}.{row.field}")
        for name, oneof in self._oneofs:
            values[name] = oneof.read(given, what)
        made = self.made(**values)
        if self._check is not None:
            self._check(made, what)
        return made

    def write(self, value: V, **more: Any) -> M:  # noqa: ANN401  each field has its own type
        """Return the message of a value; `more` are fields that the caller has converted."""
        given = more
        for row in self._rows:
            one = getattr(value, row.attribute)
            if row.has_presence and (one is None or _equal(one, row.default)):
                continue
            given[row.field] = one if row.is_plain else row.write(one)
        for name, oneof in self._oneofs:
            given |= oneof.write(getattr(value, name))
        return self._message(**given)


def _row(attribute: str, field: Field, codec: Codec | OrDefault, default: object) -> _Row:
    skips_zero = isinstance(codec, OrDefault)
    codec = codec.codec if isinstance(codec, OrDefault) else codec
    read, write = codec.read, codec.write
    repeated = is_repeated(field)
    if repeated and codec is PLAIN:
        read, write = _plain_tuple, list
    elif repeated and not getattr(codec, "whole", False):
        read, write = _each(codec)
    if default is not MISSING and (repeated or field.enum_type is not None):
        skips_zero = True
    return _Row(
        attribute, field.name, read, write, default, field.has_presence, skips_zero, codec is PLAIN and not repeated
    )


def _usual(field: Field, numbers: Codec) -> Codec:
    if is_map(field):
        return BY_NAME
    if field.message_type is not None:
        return USUAL[field.message_type.name]
    if field.enum_type is not None:
        raise TypeError(f"the field {field.full_name} is an enum and needs a table of its members")
    return numbers if field.cpp_type in (field.CPPTYPE_DOUBLE, field.CPPTYPE_FLOAT) else PLAIN


def _default(attribute: Any) -> object:  # noqa: ANN401  a field of a dataclass
    return attribute.default if attribute.default_factory is MISSING else attribute.default_factory()


def _in_oneof(field: Field, oneofs: Iterable[tuple[str, OneOf]]) -> bool:
    return field.containing_oneof is not None and field.containing_oneof.name in (name for name, _ in oneofs)


def _plain_tuple(given: Iterable[Any], what: str) -> tuple:
    return tuple(given)


def _each(codec: Codec) -> tuple[Callable[[Any, str], tuple], Callable[[Any], list]]:
    """Return what reads and what writes each entry of a repeated field."""
    read, write = codec.read, codec.write
    return (
        lambda given, what: tuple(read(one, f"{what}[{place}]") for place, one in enumerate(given)),
        lambda values: [write(one) for one in values],
    )


def _equal(value: object, default: object) -> bool:
    if isinstance(value, np.ndarray):
        # Ten times as fast as NumPy's comparison; -0.0 + 0.0 is 0.0.
        return isinstance(default, np.ndarray) and (value + 0.0).tobytes() == default.tobytes()
    return value == default
