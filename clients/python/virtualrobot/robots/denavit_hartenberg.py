"""Serial arms as tables of Denavit-Hartenberg parameters."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from virtualrobot._wire.arguments import PoseLike
from virtualrobot._wire.messages import pose_message
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.robots.values import JointLimits
from virtualrobot.v1 import nodes_pb2, scene_pb2

Row: TypeAlias = Mapping[str, Any] | Sequence[float]

_CONVENTIONS = {
    "standard": scene_pb2.DENAVIT_HARTENBERG_CONVENTION_STANDARD,
    "modified": scene_pb2.DENAVIT_HARTENBERG_CONVENTION_MODIFIED,
}
_TYPES = {
    "revolute": nodes_pb2.JOINT_TYPE_REVOLUTE,
    "continuous": nodes_pb2.JOINT_TYPE_CONTINUOUS,
    "prismatic": nodes_pb2.JOINT_TYPE_PRISMATIC,
}
_FIELDS = {"a": "a_meters", "alpha": "alpha_radians", "d": "d_meters", "theta": "theta_radians"}
_LIMITS = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")
_NO_LIMIT = {"lower": -math.inf, "upper": math.inf}


def table_message(
    rows: Iterable[Row], convention: str, base_t_first: PoseLike | None, last_t_flange: PoseLike | None
) -> scene_pb2.DenavitHartenberg:
    """Return a table as a message; the arguments are those of `Client.load_denavit_hartenberg`."""
    if convention not in _CONVENTIONS:
        raise InvalidArgumentError(f"a convention is {' or '.join(_CONVENTIONS)}, not {convention!r}")
    messages = [_row_message(row, number) for number, row in enumerate(rows, 1)]
    table = scene_pb2.DenavitHartenberg(convention=_CONVENTIONS[convention], rows=messages)
    for field, pose in (("base_t_first", base_t_first), ("last_t_flange", last_t_flange)):
        if pose is not None:
            getattr(table, field).CopyFrom(pose_message(pose))
    return table


def _row_message(row: Row, number: int) -> scene_pb2.DenavitHartenbergRow:
    if not isinstance(row, Mapping):
        if np.shape(row) != (4,):
            raise InvalidArgumentError(
                f"row {number} of the table is {row!r}; it must be the four numbers a, alpha, d, theta or a dictionary"
            )
        row = dict(zip(_FIELDS, row, strict=True))
    if unknown := [name for name in row if name not in (*_FIELDS, "name", "type", "limits")]:
        raise InvalidArgumentError(
            f"row {number} of the table has {unknown[0]!r}; there is {', '.join(_FIELDS)}, name, type, limits"
        )
    message = scene_pb2.DenavitHartenbergRow(name=str(row.get("name", "")))
    for name, field in _FIELDS.items():
        setattr(message, field, _number(row.get(name, 0.0), f"{name} in row {number} of the table"))
    if "type" in row:
        if row["type"] not in _TYPES:
            raise InvalidArgumentError(
                f"the type in row {number} of the table is {', '.join(_TYPES)}, not {row['type']!r}"
            )
        message.type = _TYPES[str(row["type"])]
    if row.get("limits") is not None:
        message.limits.CopyFrom(_limits_message(row["limits"], f"the limits in row {number} of the table"))
    return message


def _limits_message(limits: Any, what: str) -> nodes_pb2.JointLimits:  # noqa: ANN401 three kinds, told apart here
    """Return limits given as (lower, upper), by name, or as a robot told them."""
    if isinstance(limits, JointLimits):
        limits = {name: getattr(limits, name) for name in _LIMITS}
    elif not isinstance(limits, Mapping):
        if np.shape(limits) != (2,):
            raise InvalidArgumentError(f"{what} are (lower, upper) or a dictionary, not {limits!r}")
        limits = dict(zip(_LIMITS, limits, strict=False))
    if unknown := [name for name in limits if name not in _LIMITS]:
        raise InvalidArgumentError(f"{what} have {unknown[0]!r}; there is {', '.join(_LIMITS)}")
    message = nodes_pb2.JointLimits()
    for name, value in limits.items():
        if value != _NO_LIMIT.get(name):  # absent in a message
            setattr(message, name, _number(value, f"{name} of {what}"))
    return message


def _number(value: Any, what: str) -> float:  # noqa: ANN401 what float() takes, or else refused
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InvalidArgumentError(f"{what} is {value!r}; it must be a number") from error
    if not math.isfinite(number):
        raise InvalidArgumentError(f"{what} is {number}; it must be finite")
    return number
