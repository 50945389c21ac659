"""Random scenes: every field of the schema, with awkward names and numbers."""

from __future__ import annotations

import math

import numpy as np
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.json_format import ParseDict
from google.protobuf.message import Message
from virtualrobot.v1 import scene_pb2
from virtualrobot_kernel.messages.fields import STRUCT, Field, is_map, is_repeated, map_value

WORDS = [
    "on", "off", "yes", "No", "5", "1.0", "1e5", "0x10", "null", "~", "true", "", " ", "a b", " a", "a ", "- a", "a: b",
    "a #b", "#a", "'", '"', "\\", "\n", "a\nb\n", "\t", "é", "日本", "🤖", "\x7f", "\x85", "\u2028", "\ufeff", "\x00",
    "\x1b", "@a", "`", "%a", "&a", "*a", "!a", "|", ">", "[", "{", "}", ",", "?", ":", "-", "--- a", "...", "=", "<<",
    "arm.link_1", "y", "n", "x" * 200, "package://a/b.stl", "2026-01-01", "1:30", ".5", "+1", "1_000", ".inf", ".nan",
    "/a b/c.stl",
]  # fmt: skip
"""Texts that YAML readers are known to take for something else."""

NUMBERS = [0.1, 1 / 3, -0.0, 5e-324, 1.7976931348623157e308, 1e16, 1e-7, -1.0, 123456789.125, math.pi, 1e5, 1e22]

INTEGERS = {
    FieldDescriptor.CPPTYPE_INT32: (32, True),
    FieldDescriptor.CPPTYPE_UINT32: (32, False),
    FieldDescriptor.CPPTYPE_INT64: (64, True),
    FieldDescriptor.CPPTYPE_UINT64: (64, False),
}


def random_scene(rng: np.random.Generator) -> scene_pb2.SceneFile:
    """Return a scene whose fields are filled at random; not one that a world would take."""
    scene = scene_pb2.SceneFile()
    _fill(scene, rng, depth=0)
    scene.schema_version = 1
    return scene


def _fill(message: Message, rng: np.random.Generator, depth: int) -> None:
    if message.DESCRIPTOR.full_name == STRUCT:
        ParseDict(_plain_items(rng, depth), message)
        return
    for field in message.DESCRIPTOR.fields:
        if rng.random() < (0.3 if depth else 0.05):
            continue
        if field.containing_oneof is not None and message.WhichOneof(field.containing_oneof.name):
            if rng.random() < 0.8:
                continue
            message.ClearField(message.WhichOneof(field.containing_oneof.name) or "")
        _set(message, field, rng, depth)


def _plain_items(rng: np.random.Generator, depth: int) -> dict[str, object]:
    return {str(rng.choice(WORDS)): _plain(rng, depth + 1) for _ in range(rng.integers(4))}


def _plain(rng: np.random.Generator, depth: int) -> object:
    kinds = [
        lambda: None,
        lambda: bool(rng.integers(2)),
        lambda: float(rng.choice(NUMBERS)),
        lambda: str(rng.choice(WORDS)),
        lambda: [_plain(rng, depth + 1) for _ in range(rng.integers(4))],
        lambda: _plain_items(rng, depth),
    ]
    return kinds[rng.integers(len(kinds) if depth < 6 else 4)]()


def _set(message: Message, field: Field, rng: np.random.Generator, depth: int) -> None:
    entry = field.message_type
    if is_map(field):
        for _ in range(rng.integers(3)):
            getattr(message, field.name)[str(rng.choice(WORDS))] = _scalar(map_value(field), rng)
    elif is_repeated(field):
        for _ in range(rng.integers(0, 4)):
            if entry is not None:
                _fill(getattr(message, field.name).add(), rng, depth + 1)
            else:
                getattr(message, field.name).append(_scalar(field, rng))
    elif entry is not None:
        getattr(message, field.name).SetInParent()
        _fill(getattr(message, field.name), rng, depth + 1)
    else:
        setattr(message, field.name, _scalar(field, rng))


def _scalar(field: Field, rng: np.random.Generator) -> object:
    if field.type == FieldDescriptor.TYPE_BYTES:
        return rng.bytes(int(rng.integers(20)))
    if field.cpp_type == FieldDescriptor.CPPTYPE_STRING:
        return str(rng.choice(WORDS))
    if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL:
        return bool(rng.integers(2))
    if field.cpp_type == FieldDescriptor.CPPTYPE_ENUM:
        return int(rng.choice([value.number for value in field.enum_type.values]))
    if field.cpp_type == FieldDescriptor.CPPTYPE_DOUBLE:
        return float(rng.choice(NUMBERS)) if rng.random() < 0.5 else float(rng.normal() * 10.0 ** rng.integers(-9, 9))
    bits, signed = INTEGERS[field.cpp_type]
    if rng.random() < 0.5:
        return int(rng.integers(10))
    return int(rng.integers(2**bits, dtype=np.uint64)) - signed * 2 ** (bits - 1)
