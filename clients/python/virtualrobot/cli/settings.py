"""Settings of components on the command line: `--set name=value`, read as the component's schema has them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import click


def settings_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the option `--set`, as the argument `values`."""
    return click.option(
        "--set", "values", multiple=True, metavar="NAME=VALUE", help="A setting of the component; may be repeated."
    )(function)


def settings_from(values: Sequence[str], schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings from `name=value` words; a name with dots (`arguments.prefix=left_`) is one of a group.

    A value is text where the schema says so, else JSON (`0.5`, `true`, `[1, 2]`), and text when it is no JSON.
    """
    settings: dict[str, Any] = {}
    for word in values:
        path, separator, text = word.partition("=")
        names = path.split(".")
        if not separator or not all(names):
            raise click.UsageError(f"--set {word}: write name=value, or group.name=value")
        group, part = settings, schema
        for name in names[:-1]:
            group, part = group.setdefault(name, {}), _below(part, name, schema)
            if not isinstance(group, dict):
                raise click.UsageError(f"--set {word}: {name} was given a value before")
        group[names[-1]] = _value(text, _below(part, names[-1], schema))
    return settings


def settings_lines(schema: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each setting that a JSON schema describes: name, type, default, and what it is for."""
    required = schema.get("required", ())
    for name, part in schema.get("properties", {}).items():
        default = "" if name in required or "default" not in part else f" [{shown(part['default'])}]"
        about = f"  {part['description']}" if "description" in part else ""
        yield f"{name}: {_type_words(_resolved(part, schema))}{default}{about}"


def shown(value: object) -> str:
    """Return a setting's value as it is given to `--set`."""
    return value if isinstance(value, str) else json.dumps(value)


def _below(part: Mapping[str, Any], name: str, schema: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the schema of what `name` is within `part`; {} when it tells nothing."""
    part = _resolved(part, schema)
    inner = part.get("properties", {}).get(name, part.get("additionalProperties"))
    return _resolved(inner, schema) if isinstance(inner, Mapping) else {}


def _resolved(part: Mapping[str, Any], schema: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a schema, or the one that it refers to."""
    name = str(part.get("$ref", "")).removeprefix("#/$defs/")
    return schema.get("$defs", {}).get(name, part) if name else part


def _value(text: str, part: Mapping[str, Any]) -> Any:  # noqa: ANN401 any JSON
    if part.get("type") == "string":
        return text
    try:
        return json.loads(text)
    except ValueError:
        return text


def _type_words(part: Mapping[str, Any]) -> str:
    if "enum" in part:
        return " or ".join(map(shown, part["enum"]))
    if "anyOf" in part:
        return " or ".join(map(_type_words, part["anyOf"]))
    return str(part.get("type", "any"))
