"""Parameters, which all clients of a bridge share, and the services of rosapi for them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any, TypeAlias

from virtualrobot_apps.bridges.ros.mapping.basics import RosValue

Value: TypeAlias = Any
"""A value as JSON has them; an object is a namespace: parameters by the rest of their names."""

MOST = 10_000
MOST_LETTERS = 1 << 20
"""Numbers of parameters, and of letters of a value as text, that are kept at most."""


class ParameterError(ValueError):
    """Refusal of a name or a value; its text is for people."""


class Parameters:
    """Values by names with slashes, `/arm/speed`. `/use_sim_time` is true from the begin."""

    def __init__(self) -> None:
        """Hold what a simulation says of itself."""
        self._values: dict[str, Value] = {"/use_sim_time": True}
        self.computed: Callable[[str], Callable[[], Value] | None] = lambda _: None
        """Gives what computes the value of a parameter as it is asked for, which takes a while; None for others."""

    def names(self) -> list[str]:
        """Return the names of all, sorted."""
        return sorted(self._values)

    def has(self, name: str) -> bool:
        """Return whether there is one of this name, or a namespace."""
        return _whole(name) in self._values or bool(self._within(_whole(name)))

    def get(self, name: str) -> Value:
        """Return a value; of a namespace an object.

        Raises:
            ParameterError: when there is neither.
        """
        name = _whole(name)
        if name in self._values:
            return self._values[name]
        within = self._within(name)
        if not within:
            raise ParameterError(f"there is no parameter {name[:80]!r}")
        tree: dict[str, Value] = {}
        for key in within:
            *spaces, last = key[len(name.rstrip("/")) + 1 :].split("/")
            place = tree
            for one in spaces:
                place = place.setdefault(one, {})
            place[last] = self._values[key]
        return tree

    def set(self, name: str, value: Value) -> None:
        """Set a value in place of what was there; an object sets a namespace.

        Raises:
            ParameterError: for a name that is none, and when there are too many.
        """
        name = _whole(name)
        found = dict(_leaves(name, value))
        for key in found:
            _whole(key)
        others = {
            key: one
            for key, one in self._values.items()
            if key != name and not key.startswith(f"{name.rstrip('/')}/") and not name.startswith(f"{key}/")
        }
        if len(others) + len(found) > MOST:
            raise ParameterError(f"there are {MOST} parameters at most")
        self._values = others | found

    def delete(self, name: str) -> None:
        """Take a parameter or a namespace away; raises ParameterError when there is none."""
        name = _whole(name)
        if not self.has(name):
            raise ParameterError(f"there is no parameter {name[:80]!r}")
        for key in [key for key in self._values if key == name or key in self._within(name)]:
            del self._values[key]

    def _within(self, name: str) -> list[str]:
        return [key for key in sorted(self._values) if key.startswith(f"{name.rstrip('/')}/")]


Answer: TypeAlias = Callable[[RosValue], dict[str, object] | Awaitable[dict[str, object]]]


def answers(parameters: Parameters) -> dict[str, tuple[str, Answer]]:
    """Return for each service of rosapi the type, without its package, and the values that it answers."""

    def get(asked: RosValue) -> dict[str, object] | Awaitable[dict[str, object]]:
        if (compute := parameters.computed(_whole(asked.name))) is not None:
            return asyncio.to_thread(lambda: {"value": json.dumps(compute())})
        if not parameters.has(asked.name) and asked.default_value:
            return {"value": asked.default_value}
        return {"value": json.dumps(parameters.get(asked.name))}

    def put(asked: RosValue) -> dict[str, object]:
        if len(asked.value) > MOST_LETTERS:
            raise ParameterError(f"a value has {MOST_LETTERS} letters at most")
        try:
            value = json.loads(asked.value, parse_constant=_refused)
        except (ValueError, RecursionError) as error:
            raise ParameterError(f"the value of a parameter is JSON, not {asked.value[:60]!r} ({error})") from error
        parameters.set(asked.name, value)
        return {}

    def delete(asked: RosValue) -> dict[str, object]:
        parameters.delete(asked.name)
        return {}

    return {
        "get_param": ("GetParam", get),
        "set_param": ("SetParam", put),
        "has_param": ("HasParam", lambda asked: {"exists": parameters.has(asked.name)}),
        "delete_param": ("DeleteParam", delete),
        "get_param_names": ("GetParamNames", lambda _: {"names": parameters.names()}),
    }


def _refused(word: str) -> None:
    raise ValueError(f"{word} is no number in JSON")


def _whole(name: str) -> str:
    """Return a name with the slash in front that some clients leave out."""
    name = "/" + name.strip("/")
    if len(name) > 255 or any(one.isspace() for one in name) or "//" in name:
        raise ParameterError(f"{name[:80]!r} is no name of a parameter: it has no spaces, and single slashes")
    return name


def _leaves(name: str, value: Value) -> list[tuple[str, Value]]:
    if not isinstance(value, dict) or not value:
        return [(name, value)]
    found: list[tuple[str, Value]] = []
    todo = [(name.rstrip("/"), value)]
    while todo:
        space, values = todo.pop()
        for key, one in values.items():
            if isinstance(one, dict) and one:
                todo.append((f"{space}/{key}", one))
            else:
                found.append((f"{space}/{key}", one))
    return found
