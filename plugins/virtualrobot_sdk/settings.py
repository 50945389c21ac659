"""A component's settings: a frozen dataclass says them; from it come the JSON schema and the check of what is given.

Limits and descriptions are written with msgspec's `Meta`:

    @dataclass(frozen=True)
    class Settings:
        gain: Annotated[float, msgspec.Meta(gt=0, description="Step of each iteration.")] = 0.5
        method: Literal["newton", "secant"] = "newton"
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping
from typing import Any, TypeVar

import msgspec

from virtualrobot_sdk.errors import ArgumentError

Settings = TypeVar("Settings")
Schema = dict[str, Any]

_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "text",
    "bool": "true or false",
    "array": "a list",
    "object": "a group of settings",
    "null": "nothing",
}
_EXACT = 2.0**53
"""Below it a float64 holds every whole number, so that one written 3.0 is the whole number 3."""


def schema(config_type: type | None) -> Schema:
    """Return the JSON schema (draft 2020-12) of the settings, in the order of the fields; {} for None.

    Raises TypeError when a field has a type that has no JSON form, NameError when the name of a type is unknown.
    """
    if config_type is None:
        return {}
    whole = msgspec.json.schema(config_type)
    others = {name: _closed(part) for name, part in sorted(whole["$defs"].items())}
    name = whole["$ref"].removeprefix("#/$defs/")
    own = others[name] if _refers(others, whole["$ref"]) else others.pop(name)
    return {**own, "$defs": others} if others else own


def make_settings(config_type: type[Settings] | None, given: Mapping[str, Any]) -> Settings | None:
    """Return the settings made from plain values (as JSON or a protobuf Struct has them: 3.0 counts as 3).

    Raises:
        ArgumentError: a setting is unknown, missing or has a wrong value; the message names it and what is right.
    """
    if config_type is None:
        if given:
            name = next(iter(given))
            raise ArgumentError(f"this component has no settings; {name!r} was given", setting=name)
        return None
    whole = schema(config_type)
    looked_at: dict[str, tuple[Any, Schema]] = {}
    plain = _plain(given, whole, "$", whole.get("$defs", {}), looked_at)
    try:
        return msgspec.convert(plain, config_type)
    except msgspec.ValidationError as error:
        raise _refusal(str(error), looked_at) from error


def _closed(part: Schema) -> Schema:
    return {**part, "additionalProperties": False} if "properties" in part else part


def _refers(value: object, reference: str) -> bool:
    """Return whether `value` holds the reference anywhere: settings that hold their own kind again."""
    if isinstance(value, dict):
        return value.get("$ref") == reference or any(_refers(v, reference) for v in value.values())
    return isinstance(value, list) and any(_refers(v, reference) for v in value)


def _plain(
    value: object, part: Schema, path: str, parts: Mapping[str, Schema], looked_at: dict[str, tuple[Any, Schema]]
) -> object:
    """Return `value` as dicts, lists and scalars; refuse unknown names and numbers that are not finite.

    `looked_at` gets each value and its schema by its path, written as msgspec writes it.
    """
    part = _branch(part, value, parts)
    looked_at[path] = value, part
    if isinstance(value, Mapping):
        inner = part.get("properties")
        result = {}
        for name, v in value.items():
            if inner is not None and name not in inner:
                raise _unknown(f"{path}.{name}"[2:], str(name), inner)
            # What may have any name is `[...]` in msgspec's paths.
            below = part.get("additionalProperties") if inner is None else inner[name]
            where = f"{path}[...]" if inner is None else f"{path}.{name}"
            result[name] = _plain(v, below if isinstance(below, dict) else {}, where, parts, looked_at)
        if inner is None:
            looked_at[f"{path}[...]"] = value, part
        return result
    if isinstance(value, list | tuple):
        each = part.get("prefixItems")
        rest = part.get("items")
        below = [each[i] if each and i < len(each) else rest for i in range(len(value))]
        return [
            _plain(v, b if isinstance(b, dict) else {}, f"{path}[{i}]", parts, looked_at)
            for i, (v, b) in enumerate(zip(value, below, strict=True))
        ]
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ArgumentError(f"setting {path[2:]!r} is {value}; it must be finite", setting=path[2:], value=value)
        return int(value) if value.is_integer() and abs(value) < _EXACT else value
    return value


def _branch(part: Schema, value: object, parts: Mapping[str, Schema]) -> Schema:
    """Return the schema that holds for `value`, with references and alternatives followed."""
    if "$ref" in part:
        return parts.get(part["$ref"].removeprefix("#/$defs/"), part)
    sort = "object" if isinstance(value, Mapping) else "array" if isinstance(value, list | tuple) else None
    for alternative in part.get("anyOf", ()):
        followed = _branch(alternative, value, parts)
        if sort is not None and followed.get("type") == sort:
            return followed
        if isinstance(value, str) and "enum" in followed:
            return followed
    return part


def _unknown(path: str, name: str, known: Mapping[str, Schema]) -> ArgumentError:
    names = list(known)
    close = difflib.get_close_matches(name, names, n=1)
    # Groups of any names, such as the arguments of a xacro file: what is in them is often given without the group.
    groups = [one for one, part in known.items() if part.get("type") == "object" and "properties" not in part]
    if not close and len(groups) == 1 and path == name:
        close = [f"{path.removesuffix(name)}{groups[0]}.{name}"]
    right = f"did you mean {close[0]!r}?" if close else f"there is {', '.join(names)}" if names else "there is none"
    return ArgumentError(f"there is no setting {path!r}; {right}", setting=path, known=", ".join(names))


def _in_words(types: re.Match[str]) -> str:
    return " or ".join(_WORDS.get(name, name) for name in types[1].split(" | "))


def _refusal(said: str, looked_at: Mapping[str, tuple[Any, Schema]]) -> ArgumentError:
    """Return what msgspec said as an error in our words."""
    text, at, path = said.rpartition(" - at `")
    text, path = (text, path.rstrip("`")) if at else (said, "$")
    name = path[2:] if path.startswith("$.") else path[1:]
    if missing := re.fullmatch(r"Object missing required field `(.+)`", text):
        name = f"{name}.{missing[1]}" if name else missing[1]
        return ArgumentError(f"setting {name!r} is missing", setting=name)
    value, part = looked_at.get(path, (None, {}))
    if text.startswith("Invalid enum value") and "enum" in part:
        right = "it must be one of " + ", ".join(map(repr, part["enum"]))
    elif text.startswith("Expected "):
        right = "it must be " + re.sub("`([^`]+)`", _in_words, text.removeprefix("Expected ").partition(", got ")[0])
    else:
        # The dataclass itself refused it, in its __post_init__.
        return ArgumentError(f"setting {name!r}: {text}" if name else text, setting=name)
    shown = repr(value)
    shown = shown if len(shown) <= 80 else shown[:77] + "..."
    return ArgumentError(f"setting {name!r} is {shown}; {right}", setting=name, value=shown)
