"""Random messages of the contract, led by their descriptors, and damage of those that there are."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.json_format import ParseDict
from google.protobuf.message import Message
from virtualrobot_kernel.messages.fields import STRUCT, Field, is_map, is_repeated, map_value

DEEPEST = 7
"""Greatest depth of a message that is made."""

DOUBLES = (
    0.0, 1.0, -1.0, 0.5, 0.1, -0.0, 2.0, 10.0, 1e-3, 1e-9, 1e9, 5e-324, 1.7976931348623157e308, -1e308, 3.14159265,
    float("nan"), float("inf"), float("-inf"),
)  # fmt: skip
INTEGERS = (
    0,
    1,
    2,
    3,
    4,
    7,
    10,
    100,
    1000,
    65536,
    2**31 - 1,
    2**32 - 1,
    2**63 - 1,
    2**64 - 1,
    -1,
    -2,
    -(2**31),
    -(2**63),
)
TEXTS = ("", " ", "world", "nobody", "é", "\x00", "a" * 300, "a.b", "/", "../x.stl", "-1", "{}", "*", "a,b")
BITS = {
    FieldDescriptor.CPPTYPE_INT32: (-(2**31), 2**31 - 1),
    FieldDescriptor.CPPTYPE_UINT32: (0, 2**32 - 1),
    FieldDescriptor.CPPTYPE_INT64: (-(2**63), 2**63 - 1),
    FieldDescriptor.CPPTYPE_UINT64: (0, 2**64 - 1),
}

Words = Mapping[str, Sequence[object]]
"""Values that fields of a name have had in messages which make sense."""


def words_of(messages: Sequence[Message]) -> dict[str, list[object]]:
    """Return the values of all fields of plain types in messages, by the field's name."""
    words: dict[str, list[object]] = {}
    for message in messages:
        for part in parts(message):
            for field, value in part.ListFields():
                if is_map(field):
                    words.setdefault(field.name, []).extend(value)
                elif field.message_type is None:
                    words.setdefault(field.name, []).extend(value if is_repeated(field) else [value])
    return {name: list(dict.fromkeys(values)) for name, values in words.items()}


def parts(message: Message) -> Iterator[Message]:
    """Yield a message and all messages in it."""
    yield message
    for field, value in message.ListFields():
        if is_map(field):
            if map_value(field).message_type is not None:
                for key in value:
                    yield from parts(value[key])
        elif field.message_type is not None:
            for one in value if is_repeated(field) else (value,):
                yield from parts(one)


class Maker:
    """Maker of random messages and of damaged ones, from a generator and words."""

    def __init__(self, rng: random.Random, words: Words) -> None:
        """Draw from `rng`."""
        self._rng, self._words = rng, words

    def fill(self, message: Message, depth: int = 0) -> None:
        """Set a random choice of a message's fields."""
        if message.DESCRIPTOR.full_name == STRUCT:
            ParseDict(self._rng.choice(({}, {"a": 1}, {"a": [None, {"b": "c"}]}, {"max_range": -1})), message)
            return
        fields = message.DESCRIPTOR.fields
        many = self._rng.choice((1, 2, 3, len(fields)))
        for field in self._rng.sample(list(fields), min(many, len(fields))):
            self._set(message, field, depth)

    def damage(self, message: Message) -> None:
        """Change, take away, add or double something in a message, anywhere."""
        rng = self._rng
        part = rng.choice(list(parts(message)))
        given = [field for field, _ in part.ListFields()]
        if not given or rng.random() < 0.25:
            if part.DESCRIPTOR.fields:
                self._set(part, rng.choice(part.DESCRIPTOR.fields), 3)
            return
        field = rng.choice(given)
        kind = rng.random()
        if kind < 0.15:
            part.ClearField(field.name)
        elif kind < 0.4 and is_repeated(field) and not is_map(field):
            values = getattr(part, field.name)
            if kind < 0.2:
                del values[rng.randrange(len(values)) :]
            else:
                values.extend([rng.choice(values)] * rng.choice((1, 1, 3, 30)))
        else:
            self._set(part, field, 3)

    def _set(self, message: Message, field: Field, depth: int) -> None:
        name = field.name
        if is_map(field):
            value_field = map_value(field)
            target = getattr(message, name)
            key = self._scalar(field.message_type.fields_by_name["key"], name)
            if value_field.message_type is not None:
                if depth < DEEPEST:
                    self.fill(target[key], depth + 1)
            else:
                target[key] = self._scalar(value_field, value_field.name)
        elif is_repeated(field):
            target = getattr(message, name)
            for _ in range(self._rng.choice((1, 1, 2, 3))):
                if field.message_type is None:
                    target.append(self._scalar(field, name))
                elif depth < DEEPEST:
                    self.fill(target.add(), depth + 1)
        elif field.message_type is not None:
            getattr(message, name).SetInParent()
            if depth < DEEPEST:
                self.fill(getattr(message, name), depth + 1)
        else:
            setattr(message, name, self._scalar(field, name))

    def _scalar(self, field: Field, name: str) -> object:
        rng, kind = self._rng, field.cpp_type
        known = self._words.get(name, ())
        if kind == FieldDescriptor.CPPTYPE_STRING and field.type == FieldDescriptor.TYPE_BYTES:
            return rng.randbytes(rng.choice((0, 1, 8, 24, 64)))
        if kind == FieldDescriptor.CPPTYPE_STRING:
            return str(rng.choice(known)) if known and rng.random() < 0.85 else rng.choice(TEXTS)
        if kind == FieldDescriptor.CPPTYPE_BOOL:
            return rng.random() < 0.5
        if kind == FieldDescriptor.CPPTYPE_ENUM:
            return rng.choice([*(one.number for one in field.enum_type.values), 99])
        if kind in BITS:
            least, most = BITS[kind]
            return rng.choice([one for one in INTEGERS if least <= one <= most])
        return rng.choice(DOUBLES) if rng.random() < 0.4 else rng.uniform(-1.0, 1.0)
