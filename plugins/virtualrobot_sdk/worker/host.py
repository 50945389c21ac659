"""Inside the worker process: loads the plugin, makes the component and does what the parent asks of it."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, Any

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, FilesNeeded, PluginError
from virtualrobot_sdk.registration import ComponentKind, Registration
from virtualrobot_sdk.worker.answers import Outcome, pack
from virtualrobot_sdk.worker.blame import describe_error, package_of, traceback_of

if TYPE_CHECKING:
    from virtualrobot_sdk.models import Model

    Loaded = tuple[str, tuple[Registration, ...], tuple[Model, ...]]
    """Plugin's API version, components and models."""


class Host:
    """Owns the component of this process; each public method is what the parent may ask for."""

    def __init__(self) -> None:
        """Start without a component."""
        self._plugins: dict[tuple[str, str, str], Loaded] = {}
        self._component: object | None = None
        self._package = ""

    def describe(self, name: str, value: str, group: str) -> object:
        """Load the plugin of this entry point and return its Description."""
        # What not every worker needs is imported where it is needed: the process shall start quickly.
        from virtualrobot_sdk.worker.description import describe

        return describe(*self._load(name, value, group))

    def make(
        self,
        name: str,
        value: str,
        group: str,
        kind: ComponentKind,
        component: str,
        settings: Mapping[str, Any],
        arguments: tuple[object, ...],
    ) -> None:
        """Make the component that the plugin registered under this kind and name."""
        _, registrations, _ = self._load(name, value, group)
        make = factory_of(registrations, name, kind, component, settings)
        self._package = package_of(value)
        self._component = None
        self._component = make(*arguments)

    def make_from(self, path: str, arguments: tuple[object, ...]) -> None:
        """Make the component with the factory at `module:attribute`."""
        self._package = package_of(path)
        self._component = None
        self._component = _factory(path)(*arguments)

    def call(self, method: str, arguments: tuple[object, ...]) -> object:
        """Call a method of the component, or read an attribute."""
        if self._component is None:
            raise PluginError(f"{method} was asked for before a component was made")
        value = getattr(self._component, method)
        return value(*arguments) if callable(value) else value

    def answer(self, operation: str, arguments: tuple[Any, ...]) -> bytes:
        """Return what the parent reads: the packed result, or what was raised instead."""
        asked = arguments[0] if operation == "call" else operation
        try:
            result = getattr(self, operation)(*arguments)
        except BaseException as error:
            # Also SystemExit: to end the process is the parent's right alone.
            return pack_error(error, self._package)
        try:
            return pack(Outcome.RESULT, result)
        except Exception as error:
            reason = f"{asked} gave a {type(result).__name__} that cannot travel between processes"
            return pack(Outcome.FAULT, FaultKind.NONSENSE, f"{reason}: {describe_error(error, self._package)}")

    def _load(self, name: str, value: str, group: str) -> Loaded:
        from virtualrobot_sdk.loading import load

        key = name, value, group
        if key not in self._plugins:
            self._plugins[key] = load(EntryPoint(name, value, group))
        return self._plugins[key]


def factory_of(
    registrations: Sequence[Registration], plugin: str, kind: ComponentKind, component: str, settings: Mapping[str, Any]
) -> Callable[..., object]:
    """Return the factory that a plugin registered under a kind and a name, with its settings given already.

    Raises PluginError where the plugin has no such component, and ArgumentError for settings that it has not.
    """
    from virtualrobot_sdk.settings import make_settings

    found = next((one for one in registrations if one.kind is kind and one.name == component), None)
    if found is None:
        names = ", ".join(one.name for one in registrations if one.kind is kind) or "none"
        raise PluginError(f"plugin {plugin!r} has no {kind.value} {component!r}; it has {names}")
    made = make_settings(found.config_type, settings)
    if found.config_type is None:
        return found.factory
    return lambda *arguments: found.factory(*arguments, made)


def pack_error(error: BaseException, package: str) -> bytes:
    """Return the answer for what a component or its plugin raised."""
    match error:
        case ArgumentError():
            return pack(Outcome.REFUSED, str(error), {str(k): str(v) for k, v in error.metadata.items()})
        case FilesNeeded():
            return pack(Outcome.FILES_NEEDED, tuple(map(str, error.names)))
        case PluginError():
            if error.__cause__ is not None:
                # The author finds in the log what one sentence does not hold.
                sys.stderr.write(traceback_of(error.__cause__))
            return pack(Outcome.PLUGIN_ERROR, str(error))
        case ComponentFault():
            return pack(Outcome.FAULT, error.kind, error.reason, error.details)
    return pack(Outcome.FAULT, FaultKind.RAISED, describe_error(error, package), traceback_of(error))


def _factory(path: str) -> Callable[..., object]:
    module, colon, attribute = path.partition(":")
    if not colon or not module or not attribute:
        raise PluginError(f"{path!r} names no factory; write module:attribute")
    try:
        found = importlib.import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as error:
        raise PluginError(f"{path!r} cannot be imported: {describe_error(error, package_of(path))}") from error
    if not callable(found):
        raise PluginError(f"{path!r} is {found!r}; a factory is something to call")
    return found
