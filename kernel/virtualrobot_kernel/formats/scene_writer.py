"""Messages as YAML 1.2 text: stable, readable, exact. A small writer, so that the text depends on nothing else."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from typing import Any

from google.protobuf.json_format import MessageToDict
from google.protobuf.message import Message

from virtualrobot_kernel.messages.fields import STRUCT, Field, is_map, is_repeated, map_value

# What any YAML reader, of version 1.1 too, takes as text without quotes.
_PLAIN = re.compile(r"[A-Za-z_/.][A-Za-z0-9_/.+-]*( [A-Za-z0-9_/.+-]+)*")
_RESERVED = frozenset("null true false yes no on off".split())
_NUMBER_LIKE = re.compile(r"[-+.]?[0-9_.]+([eE][-+]?[0-9]*)?|\.(inf|nan)", re.IGNORECASE)
# json.dumps leaves these as they are, but YAML reads some as line breaks and refuses others.
_UNPRINTABLE = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff]")


def to_plain(message: Message) -> dict[str, object]:
    """Return a message in the protobuf JSON mapping with the contract's names; entries of maps by name.

    `MessageToDict` leaves the entries of a map in an order that differs from run to run.
    """
    if message.DESCRIPTOR.full_name == STRUCT:
        return _sorted(MessageToDict(message))
    plain: dict[str, object] = {}
    for field, value in message.ListFields():
        if is_map(field):
            value_field = map_value(field)
            plain[field.name] = {key: _plain_value(value_field, value[key]) for key in sorted(value)}
        elif is_repeated(field):
            plain[field.name] = [_plain_value(field, item) for item in value]
        else:
            plain[field.name] = _plain_value(field, value)
    return plain


def _plain_value(field: Field, value: Any) -> object:  # noqa: ANN401  a field's value has the field's type
    if field.message_type is not None:
        return to_plain(value)
    if field.enum_type is not None:
        named = field.enum_type.values_by_number.get(value)
        return value if named is None else named.name
    return base64.b64encode(value).decode() if isinstance(value, bytes) else value


def _sorted(value: Any) -> Any:  # noqa: ANN401  plain values of any kind
    """Return plain values with all names in the order of the alphabet."""
    if isinstance(value, dict):
        return {key: _sorted(value[key]) for key in sorted(value)}
    return [_sorted(item) for item in value] if isinstance(value, list) else value


def write_yaml(value: dict) -> str:
    """Return a mapping of mappings, lists, text, numbers, truth values and nulls as YAML, keys in their order."""
    return "".join(f"{line}\n" for line in _mapping(value, "")) or "{}\n"


def _mapping(value: dict, indent: str) -> Iterator[str]:
    for key, item in value.items():
        name = _scalar(str(key))
        if isinstance(item, dict) and not _on_one_line(item):
            yield f"{indent}{name}:"
            yield from _mapping(item, indent + "  ")
        elif isinstance(item, list) and not _on_one_line(item):
            yield f"{indent}{name}:"
            yield from _list(item, indent)
        else:
            yield f"{indent}{name}: {_inline(item)}"


def _list(value: list, indent: str) -> Iterator[str]:
    for item in value:
        if isinstance(item, dict) and item and not _on_one_line(item):
            lines = _mapping(item, indent + "  ")
            yield f"{indent}- {next(lines)[len(indent) + 2 :]}"
            yield from lines
        else:
            yield f"{indent}- {_inline(item)}"


def _on_one_line(value: dict | list) -> bool:
    """Return whether it is empty, a list of numbers, or up to four numbers by name."""
    items = value.values() if isinstance(value, dict) else value
    few = isinstance(value, list) or len(value) <= 4
    return few and all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in items)


def _inline(value: object) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_scalar(str(key))}: {_inline(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_inline(item) for item in value) + "]"
    return _scalar(value)


def _scalar(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "null"
    if isinstance(value, (int, float)):
        return repr(value)
    text = str(value)
    if _PLAIN.fullmatch(text) and text.lower() not in _RESERVED and not _NUMBER_LIKE.fullmatch(text):
        return text
    quoted = json.dumps(text, ensure_ascii=False)
    return _UNPRINTABLE.sub(lambda match: f"\\u{ord(match[0]):04x}", quoted)
