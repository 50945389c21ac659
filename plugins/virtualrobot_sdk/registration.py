"""Registration of a plugin's components, each with a name, a factory, settings, and the process that it runs in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any


class ComponentKind(Enum):
    """Kind of a component."""

    KINEMATICS = "kinematics"
    MOBILE_KINEMATICS = "mobile_kinematics"
    PHYSICS_ENGINE = "physics_engine"
    RAY_CASTER = "ray_caster"
    SENSOR_MODEL = "sensor_model"
    ROBOT_DRIVER = "robot_driver"
    IMPORTER = "importer"
    VEHICLE_DYNAMICS = "vehicle_dynamics"


class Isolation(Enum):
    """Process that a component runs in."""

    IN_PROCESS = "in_process"
    """In the kernel's own process: fastest, and a hang or a crash takes the kernel with it."""
    PROCESS = "process"
    """In a process of its own, with a deadline for each call."""


@dataclass(frozen=True, slots=True)
class Registration:
    """One component that a plugin offers.

    Attributes:
        kind: the component's kind.
        name: unique among the components of its kind.
        factory: makes it: `factory(chain, settings)` for kinematics, `factory(settings)` for importers; without
            `config_type` there is no `settings`.
        config_type: a frozen dataclass of its settings, or None when it has none.
        isolation: the process that it runs in.
        deadline_seconds: the longest that a call may take in a process of its own.
        description: one line for people: the first of the factory's docstring.
        endings: for importers: the endings of the files that it reads, in small letters, with their dot.
    """

    kind: ComponentKind
    name: str
    factory: Callable[..., Any]
    config_type: type | None = None
    isolation: Isolation = Isolation.PROCESS
    deadline_seconds: float = 1.0
    description: str = ""
    endings: tuple[str, ...] = ()
