"""Operators of connections: what each gives, of which inputs, and of which types these are."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from virtualrobot_apps.connections.blocks import Block, Counter, DelayOff, DelayOn, Function, Pulse, SetReset
from virtualrobot_apps.connections.expressions import KIND_NAMES, Expression, Value


@dataclass(frozen=True)
class Operator:
    """An operator: its inputs, its settings, and what is made of it.

    Attributes:
        about: what it gives, in words.
        inputs: names of its inputs; `...` means a list of two or more, and one alone stands without its name.
        optional: those that may be left out.
        settings: names of its settings, `seconds` or `index`.
        make: the state of one in a cell, from (expression, ticks of `seconds`, the target's value before).
    """

    about: str
    inputs: tuple[str, ...]
    make: Callable[[Expression, int, Value], Block]
    optional: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()


def _function(about: str, inputs: tuple[str, ...], function: Callable[..., Value]) -> Operator:
    return Operator(about, inputs, lambda *_: Function(function))


MANY = ("...",)
TWO = ("a", "b")

COMPARISONS: dict[str, Callable[[Value, Value], bool]] = {
    "equal": operator.eq,
    "not_equal": operator.ne,
    "less": operator.lt,
    "at_most": operator.le,
    "greater": operator.gt,
    "at_least": operator.ge,
}

OPERATORS: dict[str, Operator] = {
    "and": _function("on when all of a list are", MANY, lambda *values: all(values)),
    "or": _function("on when one of a list is", MANY, lambda *values: any(values)),
    "xor": _function("on when an odd number of a list is", MANY, lambda *values: sum(map(bool, values)) % 2 == 1),
    "not": _function("on when it is off", ("input",), lambda value: not value),
    "rising": Operator("on for a tick when it goes on", ("input",), lambda *_: Pulse(1)),
    "falling": Operator("on for a tick when it goes off", ("input",), lambda *_: Pulse(1, falling=True)),
    "pulse": Operator(
        "on for `seconds` when `input` goes on, whatever that does meanwhile",
        ("input",),
        lambda _, ticks, __: Pulse(ticks),
        settings=("seconds",),
    ),
    "delay_on": Operator(
        "on when `input` has been on for `seconds`",
        ("input",),
        lambda _, ticks, __: DelayOn(ticks),
        settings=("seconds",),
    ),
    "delay_off": Operator(
        "off when `input` has been off for `seconds`",
        ("input",),
        lambda _, ticks, __: DelayOff(ticks),
        settings=("seconds",),
    ),
    "set_reset": Operator(
        "on from `set` to `reset`, which wins", ("set", "reset"), lambda _, __, first: SetReset(first)
    ),
    "count": Operator(
        "times that `up` went on, less those that `down` did; 0 while `reset` is on",
        ("up", "down", "reset"),
        lambda _, __, first: Counter(first),
        optional=("up", "down", "reset"),
    ),
    "choose": _function(
        "`then` while `when` is on, else `otherwise`",
        ("when", "then", "otherwise"),
        lambda when, then, otherwise: then if when else otherwise,
    ),
    "bit": Operator(
        "the boolean `index` of the group `of`, from 0",
        ("of",),
        lambda expression, *_: Function(lambda group: _bit(group, expression.index)),
        settings=("index",),
    ),
    "group": _function("a list as one group", MANY, lambda *values: tuple(map(bool, values))),
    **{
        name: _function(f"compares two of a list: {sign}", TWO, function)
        for (name, function), sign in zip(COMPARISONS.items(), ("=", "≠", "<", "≤", ">", "≥"), strict=True)
    },
}
"""All operators by name."""


def _bit(group: Value, index: int) -> bool:
    return isinstance(group, tuple) and index < len(group) and group[index]


def kind_of(expression: Expression, signals: Mapping[str, type]) -> type:
    """Return the type of an expression's value where signals have these types.

    Raises:
        MalformedFileError: for an unknown signal or an input of the wrong type, with its line.
    """
    item = expression.item
    if expression.operator == "constant":
        return type(expression.constant)
    if expression.operator == "signal":
        return signals[expression.signal]
    kinds = [kind_of(one, signals) for one in expression.inputs]
    names = [KIND_NAMES[kind] for kind in kinds]
    if expression.operator in COMPARISONS:
        numbers = set(kinds) <= {int, float}
        if not numbers and (kinds[0] is not kinds[1] or expression.operator not in ("equal", "not_equal")):
            raise item.error(f"{expression.operator!r} can't compare {names[0]} with {names[1]}")
        return bool
    if expression.operator == "choose":
        _need(expression.inputs[0], kinds[0], bool)
        both = set(kinds[1:])
        if len(both) > 1 and not both <= {int, float}:
            raise item.error(f"'then' is {names[1]} and 'otherwise' {names[2]}: they have to be of one type")
        return float if float in both else kinds[1]
    wanted = tuple if expression.operator == "bit" else bool
    for one, kind in zip(expression.inputs, kinds, strict=True):
        _need(one, kind, wanted)
    return {"count": int, "group": tuple}.get(expression.operator, bool)


def _need(expression: Expression, kind: type, wanted: type) -> None:
    if kind is not wanted:
        about = f"the signal {expression.signal!r}" if expression.signal else "this"
        said = "a comparison makes it a boolean" if wanted is bool and kind in (int, float) else ""
        message = f"{about} is {KIND_NAMES[kind]}, and {KIND_NAMES[wanted]} is wanted"
        raise expression.item.error(f"{message}: {said}" if said else message)
