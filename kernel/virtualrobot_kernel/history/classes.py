"""Classes of what the journal keeps: all that commands and states consist of, found by their annotations.

A class that a command or a state names is so taken by itself. Only what stands behind `object` or a protocol is named
here: the kinds of running motions, and what motions wait for. When the fields of a class change, it gets the next
version in `VERSIONS` and a migration in `MIGRATIONS`; then `python tools/freeze_classes.py` adds it to
`schema.json`, where no version ever changes.
"""

from __future__ import annotations

import dataclasses
import inspect
import typing
from collections.abc import Iterable, Mapping
from enum import Enum
from functools import cache

from virtualrobot_kernel.history.codec import Codec, Migration, hints_of
from virtualrobot_kernel.history.world_image import WorldImage
from virtualrobot_kernel.motion import limits
from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.program import Program, Stage, Wait
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.setpoint_motion import SetpointMotion
from virtualrobot_kernel.motion.tool_setpoints import ToolSetpointMotion
from virtualrobot_kernel.motion.tracking_motion import TrackingMotion
from virtualrobot_kernel.world.awaited_part import AwaitedPart
from virtualrobot_kernel.world.commands import Command, StartMotion, StartSetpointMotion, UpdateNode
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.figures import Material
from virtualrobot_kernel.world.physics_commands import SetDynamics
from virtualrobot_kernel.world.records import Values
from virtualrobot_kernel.world.sensing import CameraSensor
from virtualrobot_kernel.world.state import Motion, State
from virtualrobot_kernel.world.structure import Node, NodeSpec, PartData, RobotData
from virtualrobot_kernel.world.tolerances import AwaitedJoints

RUNNING = (PlanExecution, ProgramRun, SetpointMotion, ToolSetpointMotion, TrackingMotion)
"""Kinds of running motions."""

ROOTS = (Command, WorldImage, *RUNNING, AwaitedPart, AwaitedJoints)

PARTS = (Node, Motion, Plan, Program)
"""Classes whose values are long-lived: a checkpoint writes each once, and later ones name it."""

TAGS: Mapping[type, str] = {limits.JointLimits: "limits.JointLimits"}
"""Name in documents of a class, where that isn't its own: two have the same name, or it was renamed."""

VERSIONS: Mapping[type, int] = {
    **{State: 7, RobotData: 4, Craft: 2, PartData: 2, SetDynamics: 2, Material: 3},
    **{Node: 2, NodeSpec: 2, UpdateNode: 2, Values: 2},
    **{CameraSensor: 2, Motion: 2, StartMotion: 2, StartSetpointMotion: 2, Stage: 2, Wait: 2},
    ToolSetpointMotion: 2,
}
"""Version of each class whose fields aren't those of its first one."""

MIGRATIONS: Mapping[tuple[str, int], Migration] = {
    ("Motion", 1): lambda fields: [*fields, None, ()],  # path_tolerances, deviations
    ("StartMotion", 1): lambda fields: [*fields, None, None],  # from_here, path_tolerances
    ("Stage", 1): lambda fields: [*fields, ()],  # zones
    ("Wait", 1): lambda fields: [*fields, "PART_TIMEOUT"],  # cause
    ("CameraSensor", 1): lambda fields: [*fields, None, None],  # water_attenuation_per_meter, water_color
    ("Craft", 1): lambda fields: [*fields, None],  # water
    ("RobotData", 1): lambda fields: [*fields, None],  # craft
    ("RobotData", 2): lambda fields: [*fields, False, ()],  # dynamic, motors
    ("RobotData", 3): lambda fields: [*fields, 0.0],  # payload_kilograms
    ("SetDynamics", 1): lambda fields: [*fields, ()],  # motored
    ("StartSetpointMotion", 1): lambda fields: [*fields, None, ()],  # lead, preconditions
    ("ToolSetpointMotion", 1): lambda fields: [*fields, None],  # axes
    ("State", 1): lambda fields: [*fields, {}],  # tcp_speed_limits
    ("State", 2): lambda fields: [*fields, None],  # dynamics
    ("State", 3): lambda fields: [*fields, None, None, {}],  # physics, moved_parts, twists
    ("State", 4): lambda fields: [*fields, {}, {}],  # motored, efforts
    ("State", 5): lambda fields: [*fields, None, None],  # contacts, told_contacts
    ("State", 6): lambda fields: [*fields, None],  # stop
    # restitution, rolling_friction, spinning_friction, stiffness, damping
    ("Material", 1): lambda fields: [*fields, 0.0, 0.0, 0.0, 0.0, 0.0],
    ("Material", 2): lambda fields: [*fields, 0.62, 0.0],  # roughness, metalness
    ("PartData", 1): lambda fields: [*fields, False],  # dynamic
    ("Node", 1): lambda fields: [*fields, None],  # about
    ("NodeSpec", 1): lambda fields: [*fields, None],  # about
    ("UpdateNode", 1): lambda fields: [*fields, None, None, None, None],  # description, tags, icon, locked
    ("Values", 1): lambda fields: [*fields, {}],  # about
}
"""Function that makes the written fields of a class (its tag, a version) those of the next version."""


def reached(roots: Iterable[object] = ROOTS) -> list[type]:
    """Return the classes that annotations lead to from some roots: dataclasses, named tuples, enums."""
    found: dict[type, None] = {}
    left = list(roots)
    while left:
        hint = left.pop()
        if arguments := typing.get_args(hint):
            left += arguments
            continue
        if not inspect.isclass(hint) or hint in found:
            continue
        if issubclass(hint, Enum):
            found[hint] = None
        elif names := _fields(hint):
            found[hint] = None
            hints = hints_of(hint)
            left += [hints[name] for name in names]
        elif dataclasses.is_dataclass(hint):
            found[hint] = None
    return sorted(found, key=lambda cls: (cls.__module__, cls.__qualname__))


@cache
def world_codec() -> Codec:
    """Return the codec of commands, states and all that they consist of; it is made once."""
    return Codec(reached(), tags=TAGS, versions=VERSIONS, migrations=MIGRATIONS, parts=PARTS)


def _fields(cls: type) -> tuple[str, ...]:
    if dataclasses.is_dataclass(cls):
        return tuple(field.name for field in dataclasses.fields(cls) if field.init)
    return getattr(cls, "_fields", ()) if issubclass(cls, tuple) else ()
