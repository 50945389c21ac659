"""Component that is tried: looked for in processes of their own, which a broken plugin may hang or crash."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from virtualrobot_sdk.errors import ComponentFault, PluginError
from virtualrobot_sdk.hookspecs import COMPONENT_DEADLINE_SECONDS, ENTRY_POINT_GROUP, HOOKS
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.worker import Worker

LOADING_SECONDS = 20.0
"""Deadline for importing a plugin, and for making a component (s)."""


@dataclass(frozen=True, slots=True)
class Subject:
    """A component that is tried, and how it is made.

    Attributes:
        component: as its author writes it.
        value: the plugin's module, or a factory as `module:attribute`.
        name: the name that the plugin registered; empty for a factory.
        settings: plain values.
        deadline_seconds: the longest that a call may take.
    """

    component: str
    value: str
    name: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    deadline_seconds: float = COMPONENT_DEADLINE_SECONDS


def locate(kind: ComponentKind, component: str, settings: Mapping[str, Any]) -> Subject:
    """Return the component of this kind and name.

    Args:
        kind: the component's kind.
        component: `my_arm` (of an installed plugin), `my_package/my_arm` (the plugin's module and the component's
            name) or `my_package.arm:MyArm` (something that makes the component, without settings).
        settings: plain values.

    Raises:
        PluginError: there is none, or its plugin fails; says which plugins do and why.
        ComponentFault: the plugin named before the slash hangs or crashes when it is imported.
    """
    module, slash, name = component.rpartition("/")
    if ":" in component and not slash:
        if settings:
            raise PluginError(f"{component!r} takes no settings; name its plugin: MODULE/COMPONENT")
        return Subject(component, component, "", {}, HOOKS[kind].deadline_seconds)
    points = [EntryPoint(module, module, ENTRY_POINT_GROUP)] if slash else entry_points(group=ENTRY_POINT_GROUP)
    known, failed, others = [], [], []
    for point in points:
        try:
            with Worker(point.name) as worker:
                offered = worker.describe(point, deadline_seconds=LOADING_SECONDS).components
        except (PluginError, ComponentFault) as error:
            if slash:
                raise
            failed.append(f"; plugin {point.name!r} failed: {error}")
            continue
        for one in offered:
            if one.kind is kind and one.name == name:
                return Subject(component, point.value, name, dict(settings), one.deadline_seconds)
        known += [one.name for one in offered if one.kind is kind]
        others += [one.kind.value for one in offered if one.name == name]
    where = f"{module!r} registers no" if slash else "no plugin has"
    there = f"there are {', '.join(known)}" if known else "there is none"
    other = f"; {name!r} is a {others[0]}, whose suite is a class of virtualrobot_sdk.testing" if others else ""
    raise PluginError(f"{where} {kind.value} {name!r}; {there}{other}{''.join(failed)}")
