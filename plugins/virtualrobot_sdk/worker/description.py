"""Description of a plugin without importing it: plain data that its worker process gives."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from virtualrobot_sdk.models import Model
from virtualrobot_sdk.registration import ComponentKind, Isolation, Registration
from virtualrobot_sdk.settings import schema


@dataclass(frozen=True, slots=True)
class ComponentDescription:
    """One component that a plugin registers; see `Registration` for what the fields mean."""

    kind: ComponentKind
    name: str
    description: str
    isolation: Isolation
    deadline_seconds: float
    endings: tuple[str, ...]
    settings_schema: dict[str, Any] = field(default_factory=dict)
    """JSON schema of its settings; empty when it has none."""


@dataclass(frozen=True, slots=True)
class Description:
    """A plugin."""

    api_version: str
    components: tuple[ComponentDescription, ...]
    models: tuple[Model, ...] = ()


def describe(api_version: str, registrations: Iterable[Registration], models: tuple[Model, ...] = ()) -> Description:
    """Return what `loading.load` returned as plain data."""
    return Description(
        api_version,
        tuple(
            ComponentDescription(
                r.kind, r.name, r.description, r.isolation, r.deadline_seconds, r.endings, schema(r.config_type)
            )
            for r in registrations
        ),
        models,
    )
