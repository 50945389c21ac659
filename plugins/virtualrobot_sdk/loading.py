"""Loads one plugin: imports it, checks its version and its hooks, and lets it register its components and models.

Each plugin has a plugin manager of its own, so that one which raises does not keep the others from registering.
"""

from __future__ import annotations

import difflib
import functools
import inspect
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.metadata import EntryPoint
from typing import Any

import msgspec
import pluggy

from virtualrobot_sdk import hookspecs
from virtualrobot_sdk.errors import PluginError
from virtualrobot_sdk.hookspecs import API_VERSION, HOOKS, MODELS_HOOK, PROJECT, KindOfHook
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind, Isolation, Registration
from virtualrobot_sdk.settings import schema
from virtualrobot_sdk.worker.blame import describe_error, package_of

_NAME = re.compile(r"[a-z][a-z0-9_-]*")
_HOOKS = (*(hook.hook for hook in HOOKS.values()), MODELS_HOOK)
_ENDING = re.compile(r"(\.[a-z0-9_-]+)+")
# What keeps a plugin from loading: any error of its own, and `sys.exit` in a module.
_TROUBLE = (Exception, SystemExit)


def load(entry_point: EntryPoint) -> tuple[str, tuple[Registration, ...], tuple[Model, ...]]:
    """Import the plugin and return its API version, the components and the models that it registers.

    Raises:
        PluginError: it cannot be imported, was written for another API, has a hook that does not exist or takes other
            arguments, registers something wrong or nothing at all, or raises; the message says what would be right.
    """
    package = package_of(entry_point.value)
    try:
        plugin = entry_point.load()
    except _TROUBLE as error:
        raise PluginError(f"{entry_point.value!r} cannot be imported: {describe_error(error, package)}") from error
    try:
        return _api_version(plugin, entry_point.value), *_register(plugin, package)
    except PluginError:
        raise
    except _TROUBLE as error:
        raise PluginError(f"it raises while it registers: {describe_error(error, package)}") from error


def _api_version(plugin: object, where: str) -> str:
    version = getattr(plugin, "api_version", None)
    right = f"write `api_version = {API_VERSION!r}`, the API that it is written for"
    if version is None:
        raise PluginError(f"{where!r} has no api_version: {right}")
    if not isinstance(version, str) or not re.fullmatch(r"\d+\.\d+", version):
        raise PluginError(f"its api_version is {version!r}: {right}")
    (first, second), (our_first, our_second) = (map(int, text.split(".")) for text in (version, API_VERSION))
    if first != our_first or second > our_second:
        newer = "; install a newer virtualrobot" if (first, second) > (our_first, our_second) else ""
        raise PluginError(f"it was written for API {version}; this kernel has {API_VERSION}{newer}")
    return version


def _register(plugin: object, package: str) -> tuple[tuple[Registration, ...], tuple[Model, ...]]:
    manager = pluggy.PluginManager(PROJECT)
    manager.add_hookspecs(hookspecs)
    for name, function in _functions(plugin):
        _check_hook(manager, plugin, name, function)
    manager.register(plugin, "plugin")
    found: list[Registration] = []
    models: dict[str, Model] = {}
    registrars = {hook.hook: _registrar(kind, hook, found) for kind, hook in HOOKS.items()}
    for hook, register in {**registrars, MODELS_HOOK: functools.partial(_add_model, models)}.items():
        try:
            getattr(manager.hook, hook)(register=register)
        except PluginError:
            raise
        except _TROUBLE as error:
            raise PluginError(f"{hook} raises {describe_error(error, package)}") from error
    if not found and not models:
        raise PluginError(f"it registers nothing; a plugin has one of {', '.join(_HOOKS)}, marked with @hookimpl")
    return tuple(found), tuple(models.values())


def _add_model(found: dict[str, Model], model: Model) -> None:
    if not isinstance(model, Model):
        raise PluginError(f"{model!r} is registered as a model; it must be a virtualrobot_sdk.models.Model")
    try:
        msgspec.convert(asdict(model), Model)
    except msgspec.ValidationError as error:
        raise PluginError(f"the model {model.name!r} is not as it must be: {error}") from error
    if model.name in found:
        raise PluginError(f"the model {model.name!r} is registered twice; each needs a name of its own")
    if bool(model.uri) == bool(model.scene):
        has = "both uri and" if model.uri else "neither uri nor"
        raise PluginError(f"the model {model.name!r} has {has} scene; give one of them")
    if model.uri and not model.uri.startswith("package://"):
        raise PluginError(f"the uri of the model {model.name!r} is {model.uri!r}; it must be package://PACKAGE/FILE")
    found[model.name] = model


def _functions(plugin: object) -> list[tuple[str, Callable[..., Any]]]:
    """Return what looks like a hook: what is marked as one, and what is named like one."""
    members = ((name, inspect.getattr_static(plugin, name, None)) for name in dir(plugin))
    marked = f"{PROJECT}_impl"
    return [
        (name, getattr(plugin, name))
        for name, member in members
        if inspect.isroutine(member) and (hasattr(member, marked) or name.startswith(f"{PROJECT}_register"))
    ]


def _check_hook(manager: pluggy.PluginManager, plugin: object, name: str, function: Callable[..., Any]) -> None:
    if name not in _HOOKS:
        nearest = difflib.get_close_matches(name, _HOOKS, n=1)
        right = f"did you mean {nearest[0]}?" if nearest else f"there is {', '.join(_HOOKS)}"
        raise PluginError(f"there is no hook {name}; {right}")
    if manager.parse_hookimpl_opts(plugin, name) is None:
        raise PluginError(f"{name} is not marked as a hook: write @hookimpl above it")
    takes = inspect.signature(function)
    parameters = [(p.name, p.kind) for p in takes.parameters.values()]
    if parameters != [("register", inspect.Parameter.POSITIONAL_OR_KEYWORD)]:
        raise PluginError(f"{name} takes {takes}; it must take (register)")


def _registrar(kind: ComponentKind, hook: KindOfHook, found: list[Registration]) -> Callable[..., None]:
    """Return the `register` that the hook of this kind is called with; it adds to `found`."""

    def register(
        name: str,
        factory: Callable[..., Any],
        config_type: type | None = None,
        *,
        isolation: Isolation = Isolation.PROCESS,
        deadline_seconds: float = hook.deadline_seconds,
    ) -> None:
        _add(kind, hook, found, name, factory, (), config_type, isolation, deadline_seconds)

    def register_with_endings(
        name: str,
        factory: Callable[..., Any],
        endings: Sequence[str],
        config_type: type | None = None,
        *,
        isolation: Isolation = Isolation.PROCESS,
        deadline_seconds: float = hook.deadline_seconds,
    ) -> None:
        _check_endings(name, endings)
        _add(kind, hook, found, name, factory, tuple(endings), config_type, isolation, deadline_seconds)

    return register_with_endings if hook.has_endings else register


def _add(
    kind: ComponentKind,
    hook: KindOfHook,
    found: list[Registration],
    name: str,
    factory: Callable[..., Any],
    endings: tuple[str, ...],
    config_type: type | None,
    isolation: Isolation,
    deadline_seconds: float,
) -> None:
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise PluginError(
            f"the name {name!r} is not one of a component; it is made of small letters, digits, _ and -, a letter first"
        )
    if any(r.kind is kind and r.name == name for r in found):
        raise PluginError(f"{kind.value} {name!r} is registered twice; each needs a name of its own")
    _check_config_type(name, config_type)
    _check_factory(name, factory, (*hook.arguments, *(("settings",) if config_type is not None else ())))
    if not isinstance(isolation, Isolation):
        right = " or ".join(map(str, Isolation))
        raise PluginError(f"the isolation of {name!r} is {isolation!r}; it must be {right}")
    if (
        isinstance(deadline_seconds, bool)
        or not isinstance(deadline_seconds, int | float)
        or not 0.0 < deadline_seconds < math.inf
    ):
        raise PluginError(f"the deadline of {name!r} is {deadline_seconds!r}; it must be a positive number of seconds")
    described = factory.func if isinstance(factory, functools.partial) else factory
    description = (described.__doc__ or "").strip().partition("\n")[0].strip()
    found.append(
        Registration(kind, name, factory, config_type, isolation, float(deadline_seconds), description, endings)
    )


def _check_factory(name: str, factory: object, arguments: tuple[str, ...]) -> None:
    said = f"factory({', '.join(arguments)})"
    if not callable(factory):
        raise PluginError(f"the factory of {name!r} is {factory!r}; it must be something to call: {said}")
    try:
        takes = inspect.signature(factory)
    except ValueError:
        return  # Compiled ones tell nothing about what they take.
    try:
        takes.bind(*arguments)
    except TypeError as error:
        raise PluginError(f"the factory of {name!r} takes {takes}; it is called as {said}") from error


def _check_config_type(name: str, config_type: object) -> None:
    if config_type is None:
        return
    parameters = getattr(config_type, "__dataclass_params__", None)
    if not isinstance(config_type, type) or parameters is None or not parameters.frozen:
        right = "a dataclass with frozen=True, or None"
        raise PluginError(f"the config_type of {name!r} is {config_type!r}; it must be {right}")
    try:
        schema(config_type)
    except (TypeError, NameError) as error:
        raise PluginError(f"the settings {config_type.__name__} of {name!r} have no schema: {error}") from error


def _check_endings(name: str, endings: object) -> None:
    if isinstance(endings, str) or not isinstance(endings, Sequence) or not endings:
        wrong = [endings]
    else:
        wrong = [e for e in endings if not isinstance(e, str) or not _ENDING.fullmatch(e)]
    if wrong:
        right = "they are a list in small letters, each with its dot: ('.stp', '.step')"
        raise PluginError(f"the endings of {name!r} have {wrong[0]!r}; {right}")
