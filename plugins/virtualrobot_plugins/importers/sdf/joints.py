"""Joints of SDFormat: types, axes and limits, of whatever version."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.xml import Element

from virtualrobot_plugins.importers.sdf.elements import (
    Matrix,
    Notes,
    Place,
    child,
    flag,
    number,
    numbers,
    text,
    vector_message,
)
from virtualrobot_plugins.importers.sdf.scopes import LinkElement, Scope

WORLD = "__world__"
"""The name here of the frame that SDFormat calls `world`; real models have links of that name."""

ACCELERATION_PER_VELOCITY = 4.0
"""1/s: as for URDF, full speed is reached in a quarter of a second, since the file tells no acceleration."""

JERK_PER_ACCELERATION = 10.0
"""1/s: as for URDF, full acceleration is reached in a tenth of a second."""

ENDLESS = 1e16
"""SDFormat's own number for a joint without limit."""

_AXES = {"fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1, "revolute2": 2, "universal": 2}
_RIGID = ("ball", "screw")


@dataclass(frozen=True, slots=True)
class JointSpec:
    """A joint between two links.

    Attributes:
        name: unique in the model.
        parent: full name of a link, or WORLD.
        child: full name of a link.
        model_t_joint: (4, 4) its pose at position 0 in the model's frame (m).
        axes: as scene files have them, in the joint's frame; none for a fixed joint, two for universal ones.
        element: for errors.
        place: for errors.
    """

    name: str
    parent: str
    child: str
    model_t_joint: Matrix
    axes: tuple[dict[str, Any], ...]
    element: Element
    place: Place


def read_joint(scope: Scope, prefix: str, model_t_scope: Matrix, joint: LinkElement, notes: Notes) -> JointSpec:
    """Return a joint of a model, whose names get `prefix` before them."""
    place, element = joint.place.inside(f"joint {joint.name!r}"), joint.element
    kind = element.get("type", "").strip()
    if kind not in _AXES and kind not in _RIGID:
        raise place.error(element, f"the type {kind!r} is not read; known: {', '.join((*_AXES, *_RIGID))}")
    if kind in _RIGID:
        notes.warn(place, element, f"a {kind} joint is not moved here: it is fixed at zero")
    ends = []
    for tag in ("parent", "child"):
        name = text(element, tag)
        if not name:
            raise place.error(element, f"a joint needs <{tag}>")
        in_world = name == "world" and tag == "parent" and name not in scope.frames
        ends.append(WORLD if in_world else prefix + scope.link_of(name, element))
    if ends[0] == ends[1]:
        raise place.error(element, f"it connects the link {ends[0]!r} with itself")
    scope_t_joint = scope.scope_t(joint.name, element)
    axes = tuple(
        _axis(scope, scope_t_joint, place, element, f"axis{number + 1}" if number else "axis", kind, prefix, notes)
        for number in range(_AXES.get(kind, 0))
    )
    return JointSpec(prefix + joint.name, ends[0], ends[1], model_t_scope @ scope_t_joint, axes, element, place)


def _axis(
    scope: Scope,
    scope_t_joint: Matrix,
    place: Place,
    joint: Element,
    tag: str,
    kind: str,
    prefix: str,
    notes: Notes,
) -> dict[str, Any]:
    """Return type, axis, limits and mimic of one axis as scene files have them."""
    element = child(joint, tag)
    if element is None:
        raise place.error(joint, f"a {kind} joint needs <{tag}>")
    direction = _direction(scope, scope_t_joint, place, element)
    limit = child(element, "limit")
    lower = _finite(None if limit is None else number(place, limit, "lower", -ENDLESS))
    upper = _finite(None if limit is None else number(place, limit, "upper", ENDLESS))
    if lower is not None and upper is not None and lower > upper:
        raise place.error(element, f"the lower limit {lower:g} is above the upper one {upper:g}")
    sliding = kind == "prismatic"
    endless = kind == "continuous" or (lower is None and upper is None and not sliding)
    limits: dict[str, float] = {}
    if lower is not None and not endless:
        limits["lower"] = lower
    if upper is not None and not endless:
        limits["upper"] = upper
    velocity = -1.0 if limit is None else number(place, limit, "velocity", -1.0)
    if 0.0 < velocity < ENDLESS:
        limits["velocity"] = velocity
        limits["acceleration"] = ACCELERATION_PER_VELOCITY * velocity
        limits["jerk"] = JERK_PER_ACCELERATION * limits["acceleration"]
    effort = -1.0 if limit is None else number(place, limit, "effort", -1.0)
    if 0.0 < effort < ENDLESS:
        limits["effort"] = effort
    name = "JOINT_TYPE_PRISMATIC" if sliding else "JOINT_TYPE_CONTINUOUS" if endless else "JOINT_TYPE_REVOLUTE"
    axis = {"type": name, "axis": vector_message(direction), "limits": limits}
    mimic = child(element, "mimic")
    if mimic is not None:
        axis["mimic"] = _mimic(place, mimic, prefix, notes)
    return axis


def _direction(scope: Scope, scope_t_joint: Matrix, place: Place, element: Element) -> NDArray[np.float64]:
    """Return the axis as a unit vector in the joint's frame.

    Up to version 1.4 it is given in the model's frame; in 1.5 and 1.6 when `use_parent_model_frame` says so; since 1.7
    in the frame that `expressed_in` names.
    """
    given = numbers(place, element, "xyz", 3, (0.0, 0.0, 1.0))
    length = float(np.linalg.norm(given))
    if not 0.0 < length < np.inf:
        raise place.error(element, "<xyz> is 0 0 0, which is no direction")
    xyz = child(element, "xyz")
    frame = "" if xyz is None else xyz.get("expressed_in", "").strip()
    in_model = place.version < (1, 5) or flag(place, element, "use_parent_model_frame")
    if frame:
        given = scope.scope_t(frame, element)[:3, :3] @ given
    elif not in_model:
        return given / length
    return scope_t_joint[:3, :3].T @ given / length


def _finite(value: float | None) -> float | None:
    return None if value is None or abs(value) >= ENDLESS else value


def _mimic(place: Place, element: Element, prefix: str, notes: Notes) -> dict[str, Any]:
    """Return position = multiplier (leader - reference) + offset in the form of scene files."""
    leader = element.get("joint", "").strip()
    if not leader:
        raise place.error(element, "<mimic> needs the attribute 'joint'")
    if element.get("axis", "axis").strip() != "axis":
        notes.warn(place, element, f"it follows the first axis of {leader!r}")
    multiplier = number(place, element, "multiplier", 1.0)
    offset = number(place, element, "offset", 0.0) - multiplier * number(place, element, "reference", 0.0)
    if not np.isfinite([multiplier, offset]).all():
        raise place.error(element, "<mimic>: a number is not finite")
    return {"joint": prefix + leader, "multiplier": multiplier, "offset": offset}
