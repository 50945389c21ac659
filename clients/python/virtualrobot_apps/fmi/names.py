"""Names of variables: a state of the lockstep as structured names of FMI, and outputs of a controller as its command.

Source: FMI 3.0.2, 2.4.7.5.1 (variable naming convention `structured`): dots between parts, arrays counted from 1, and
parts in apostrophes where they are no identifiers.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

from virtualrobot._wire.names import did_you_mean
from virtualrobot.errors import InvalidArgumentError

Value: TypeAlias = bool | float | str

TWIST = ("vx", "vy", "omega")
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*")
_COMMAND = re.compile(r"(twist|positions|velocities|signals)\.(.+)|(twist)\[([123])\]|(twist)|(done)")


def part(name: str) -> str:
    """Return a name of the world as a part of a structured name; dots in it divide it."""
    return name if _IDENTIFIER.fullmatch(name) else "'" + name.replace("\\", "\\\\").replace("'", "\\'") + "'"


def plain(name: str) -> str:
    """Return the name of the world for a part of a structured name; the inverse of `part`."""
    if len(name) > 1 and name[0] == name[-1] == "'":
        return re.sub(r"\\(.)", r"\1", name[1:-1])
    return name


def flattened(state: Mapping[str, Any]) -> dict[str, list[Value]]:
    """Return the values of a state by their names; a list stands there whole, row by row, and each of its values.

    What is not known (null), as a distance without an echo, is infinity.
    """
    found: dict[str, list[Value]] = {}
    for key, value in state.items():
        _add(found, part(key), value)
    return found


def _add(found: dict[str, list[Value]], name: str, value: Any) -> None:  # noqa: ANN401 anything of JSON
    if isinstance(value, Mapping):
        for key, one in value.items():
            _add(found, f"{name}.{part(key)}", one)
    elif isinstance(value, list):
        leaves = list(_leaves(value, ()))
        found[name] = [one for _, one in leaves]
        for place, one in leaves:
            found[f"{name}[{','.join(str(number + 1) for number in place)}]"] = [one]
    else:
        found[name] = [float("inf") if value is None else value]


def _leaves(value: Any, place: tuple[int, ...]) -> Iterable[tuple[tuple[int, ...], Value]]:  # noqa: ANN401
    if not isinstance(value, list):
        yield place, float("inf") if value is None else value
        return
    for number, one in enumerate(value):
        yield from _leaves(one, (*place, number))


def values_for(name: str, count: int, state: Mapping[str, list[Value]]) -> list[Value]:
    """Return the values of a controller's input.

    Raises:
        InvalidArgumentError: for a name that the state hasn't, and another number of values.
    """
    if name not in state:
        near = did_you_mean(name, state) or "; those of the robot begin with 'robot.'"
        raise InvalidArgumentError(f"the state has no value for the FMU's input {name!r}{near}")
    if len(state[name]) != count:
        raise InvalidArgumentError(
            f"the FMU's input {name!r} takes {count} values, and the state has {len(state[name])}"
        )
    return state[name]


def is_command(name: str) -> bool:
    """Return whether an output of this name is part of a command."""
    return _COMMAND.fullmatch(name) is not None


def command_of(outputs: Mapping[str, list[Value]]) -> dict[str, Any]:
    """Return the command that a controller's outputs are, as the lockstep takes it; others are left out.

    `twist.vx`, `twist.vy`, `twist.omega`, or `twist[1]` to `twist[3]`, or `twist` as an array; `positions.JOINT`,
    `velocities.JOINT`, `signals.NAME`, and `done`.
    """
    found: dict[str, Any] = {}
    for name, values in outputs.items():
        match = _COMMAND.fullmatch(name)
        if match is None:
            continue
        kind, inner, _, number, whole, done = match.groups()
        if done:
            found["done"] = bool(values[0])
        elif whole:
            found["twist"] = values
        elif number or kind == "twist":
            if number is None and inner not in TWIST:
                raise InvalidArgumentError(f"a twist has the parts {', '.join(TWIST)}, not {inner[:40]!r}")
            row = found.setdefault("twist", [0.0, 0.0, 0.0])
            row[int(number) - 1 if number else TWIST.index(inner)] = values[0]
        else:
            found.setdefault(kind, {})[plain(inner)] = values[0]
    return found
