"""A component of any kind in its worker process, its calls watched for what can only be seen there."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import gc
import time
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import EntryPoint
from typing import Any

import numpy as np

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, FilesNeeded, PluginError
from virtualrobot_sdk.hookspecs import ENTRY_POINT_GROUP
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.seclusion import Seclusion
from virtualrobot_sdk.worker.blame import describe_error, package_of, traceback_of


class Stage:
    """Owns the component; whatever else is asked for by name is the component's method or attribute of that name.

    Arguments of each call are arrays that cannot be written to, and a call that changes them all the same is a fault;
    so is an answer that changes with the next call.
    """

    def __init__(self, kind: ComponentKind, value: str, name: str, settings: Mapping[str, Any]) -> None:
        """Make the component.

        Args:
            kind: the component's kind.
            value: the plugin's module, or with an empty `name` a factory as `module:attribute`.
            name: the name that the plugin registered.
            settings: plain values.
        """
        self._package = package_of(value)
        self._last: dict[str, tuple[object, bytes]] = {}
        self._seclusion = Seclusion() if kind is ComponentKind.IMPORTER else None
        self._component = self._contained("making it", _made, kind, value, name, settings)

    def __getattr__(self, name: str) -> object:
        """Return the component's attribute, a method with its calls watched."""
        found = getattr(self._component, name)
        return functools.partial(self._watched, name, found) if callable(found) else found

    def seconds(self, method: str, arguments: tuple[object, ...], times: int) -> list[float]:
        """Return how long each of some equal calls took, the collector at rest, after one that is not told."""
        function = getattr(self._component, method)
        found: list[float] = []
        gc.disable()
        try:
            for _ in range(times + 1):
                started = time.perf_counter()
                self._contained(method, function, *arguments)
                found.append(time.perf_counter() - started)
        finally:
            gc.enable()
        return found[1:]

    def touched(self) -> list[str]:
        """Return which files, hosts and processes the calls of an importer touched until now."""
        return list(self._seclusion.events) if self._seclusion else []

    def _watched(self, method: str, function: Callable[..., Any], *arguments: object) -> object:
        for array in _arrays(arguments):
            array.setflags(write=False)
        before = _bits(arguments)
        answer = self._contained(method, function, *arguments)
        if _bits(arguments) != before:
            raise ComponentFault(FaultKind.NONSENSE, f"{method} changes an array that it was given")
        earlier, bits = self._last.get(method, (None, _bits(None)))
        self._last[method] = answer, _bits(answer)
        if _bits(earlier) != bits:
            raise ComponentFault(FaultKind.NONSENSE, f"an answer of {method} changes with a later call")
        return answer

    def _contained(self, asked: str, function: Callable[..., Any], *arguments: object) -> Any:  # noqa: ANN401
        """Return what `function` returns; what it raises names the author's line and not this file's."""
        with self._seclusion or contextlib.nullcontext():
            try:
                return function(*arguments)
            except (ArgumentError, FilesNeeded, PluginError, ComponentFault):
                raise
            except Exception as error:
                said = f"{asked} raised {describe_error(error, self._package)}"
                raise ComponentFault(FaultKind.RAISED, said, traceback_of(error)) from error


def _made(kind: ComponentKind, value: str, name: str, settings: Mapping[str, Any]) -> object:
    from virtualrobot_sdk.loading import load
    from virtualrobot_sdk.settings import make_settings

    if not name:
        return EntryPoint("", value, "").load()()
    _, registrations, _ = load(EntryPoint(value, value, ENTRY_POINT_GROUP))
    one = next((r for r in registrations if r.kind is kind and r.name == name), None)
    if one is None:
        names = ", ".join(r.name for r in registrations if r.kind is kind) or "none"
        raise PluginError(f"{value!r} registers no {kind.value} {name!r}; it has {names}")
    made = make_settings(one.config_type, settings)
    return one.factory() if one.config_type is None else one.factory(made)


def _arrays(value: object) -> Iterator[np.ndarray]:
    """Yield the arrays in arguments and answers: in sequences, mappings and dataclasses too."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple | list):
        for one in value:
            yield from _arrays(one)
    elif isinstance(value, Mapping):
        yield from _arrays(list(value.values()))
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        yield from _arrays([getattr(value, field.name) for field in dataclasses.fields(value)])


def _bits(value: object) -> bytes:
    return b"".join(array.tobytes() for array in _arrays(value))
