"""Logic of connections: what signals become from others as time goes by. Nothing here knows of a kernel or of a clock.

Time is a number of ticks. A `Logic` is told which signals have changed at which tick, and says which values come of it,
at which tick: equal changes at equal ticks give equal values. What runs out between two changes (a delay, a pulse)
is evaluated at its own tick.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from virtualrobot_apps.cell_io.yaml_file import Item

Value = bool | int | float | str | tuple[bool, ...]
"""Value of a signal."""

KIND_NAMES: dict[type, str] = {bool: "boolean", int: "integer", float: "number", str: "text", tuple: "group"}

LEAST_INTEGER, GREATEST_INTEGER = -(2**63), 2**63 - 1


@dataclass(frozen=True, eq=False)
class Expression:
    """Source of a value: a signal, a constant, or an operator and what it works on.

    Attributes:
        operator: name of the operator, `signal` or `constant`.
        inputs: what it works on, in the order of its operator's inputs; those left out are false.
        item: where it stands in the file.
        signal: name of the signal.
        constant: the value of a constant.
        seconds: of a delay or pulse (s).
        index: of a bit, from 0.
    """

    operator: str
    item: Item
    inputs: tuple[Expression, ...] = ()
    signal: str = ""
    constant: Value = False
    seconds: float = 0.0
    index: int = 0

    def signals(self) -> Iterable[str]:
        """Yield the names of the signals that it depends on."""
        if self.operator == "signal":
            yield self.signal
        for one in self.inputs:
            yield from one.signals()


@dataclass(frozen=True, eq=False)
class Connection:
    """A signal, and the expression that gives its value."""

    target: str
    source: Expression
    item: Item


class Block(Protocol):
    """State of an operator in a cell that runs."""

    due: int | None
    """Tick at which it has to be evaluated though nothing changes."""

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick, not before that of the last step, for the values of its inputs."""
        ...


class _Function:
    """A pure function of its inputs."""

    due: int | None = None

    def __init__(self, function: Callable[..., Value]) -> None:
        self._function = function

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        return self._function(*values)


class _Pulse:
    """On for some ticks from each edge of its input on; edges meanwhile are not counted."""

    due: int | None = None

    def __init__(self, ticks: int, falling: bool = False) -> None:
        self._ticks, self._falling = ticks, falling
        self._before: bool | None = None

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        now = bool(values[0]) != self._falling
        if self.due is not None and tick >= self.due:
            self.due = None
        if self.due is None and now and self._before is False:
            self.due = tick + self._ticks
        self._before = now
        return self.due is not None


class _DelayOn:
    """On when its input has been on for some ticks."""

    due: int | None = None

    def __init__(self, ticks: int, off: bool = False) -> None:
        self._ticks, self._off = ticks, off
        self._since: int | None = None

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        if bool(values[0]) == self._off:
            self._since = self.due = None
            return self._off
        if self._since is None:
            # A delay of switching off begins as if its input had been off for ever.
            self._since = tick
        end = self._since + self._ticks
        self.due = end if tick < end else None
        return self._off if tick < end else not self._off


class _DelayOff(_DelayOn):
    """On until its input has been off for some ticks; off where that was never on."""

    def __init__(self, ticks: int) -> None:
        super().__init__(ticks, off=True)
        self._begun = False

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        self._begun = self._begun or bool(values[0])
        return super().step(tick, values) if self._begun else False


class _SetReset:
    """On from `set` to `reset`, which wins where both are on."""

    due: int | None = None

    def __init__(self, first: Value) -> None:
        self._on = bool(first)

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        to_on, to_off = values
        self._on = (self._on or bool(to_on)) and not to_off
        return self._on


class _Counter:
    """Number of rising edges of `up` less those of `down`; zero while `reset` is on."""

    due: int | None = None

    def __init__(self, first: Value) -> None:
        self._count = int(first) if isinstance(first, int) else 0
        self._before: tuple[bool, bool] | None = None

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        up, down, reset = map(bool, values)
        before = self._before or (up, down)
        self._before = (up, down)
        change = int(up and not before[0]) - int(down and not before[1])
        self._count = 0 if reset else min(max(self._count + change, LEAST_INTEGER), GREATEST_INTEGER)
        return self._count


def _bit(group: Value, index: int) -> bool:
    return isinstance(group, tuple) and index < len(group) and group[index]


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
    return Operator(about, inputs, lambda *_: _Function(function))


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
    "rising": Operator("on for a tick when it goes on", ("input",), lambda *_: _Pulse(1)),
    "falling": Operator("on for a tick when it goes off", ("input",), lambda *_: _Pulse(1, falling=True)),
    "pulse": Operator(
        "on for `seconds` when `input` goes on, whatever that does meanwhile",
        ("input",),
        lambda _, ticks, __: _Pulse(ticks),
        settings=("seconds",),
    ),
    "delay_on": Operator(
        "on when `input` has been on for `seconds`",
        ("input",),
        lambda _, ticks, __: _DelayOn(ticks),
        settings=("seconds",),
    ),
    "delay_off": Operator(
        "off when `input` has been off for `seconds`",
        ("input",),
        lambda _, ticks, __: _DelayOff(ticks),
        settings=("seconds",),
    ),
    "set_reset": Operator(
        "on from `set` to `reset`, which wins", ("set", "reset"), lambda _, __, first: _SetReset(first)
    ),
    "count": Operator(
        "times that `up` went on, less those that `down` did; 0 while `reset` is on",
        ("up", "down", "reset"),
        lambda _, __, first: _Counter(first),
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
        lambda expression, *_: _Function(lambda group: _bit(group, expression.index)),
        settings=("index",),
    ),
    "group": _function("a list as one group", MANY, lambda *values: tuple(map(bool, values))),
    **{
        name: _function(f"compares two of a list: {sign}", TWO, function)
        for (name, function), sign in zip(COMPARISONS.items(), ("=", "≠", "<", "≤", ">", "≥"), strict=True)
    },
}
"""All operators by name."""


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


def in_order(connections: Iterable[Connection]) -> list[Connection]:
    """Return connections so that each comes after those whose targets it depends on.

    Raises:
        MalformedFileError: when one depends on itself, over others or not.
    """
    by_target = {one.target: one for one in connections}
    done: dict[str, Connection] = {}
    for start in by_target:
        # By hand, since a chain of a thousand connections is deeper than calls may be.
        way = {} if start in done else {start: _needs(by_target, start)}
        while way:
            name, waiting = next(reversed(way.items()))
            if not waiting:
                done[name] = by_target[name]
                del way[name]
                continue
            needed = waiting.pop()
            if needed in way:
                names = list(way)
                chain = " <- ".join(map(repr, [*names[names.index(needed) :], needed]))
                raise by_target[name].item.error(f"a loop: {chain}; what has to keep its state is a 'set_reset'")
            if needed not in done:
                way[needed] = _needs(by_target, needed)
    return list(done.values())


def _needs(by_target: Mapping[str, Connection], name: str) -> list[str]:
    return sorted({one for one in by_target[name].source.signals() if one in by_target}, reverse=True)


@dataclass(slots=True)
class _Running:
    """An expression in a cell that runs."""

    expression: Expression
    inputs: list[_Running]
    block: Block | None

    def value(self, tick: int, signals: Mapping[str, Value]) -> Value:
        if self.block is None:
            return signals[self.expression.signal] if self.expression.signal else self.expression.constant
        return self.block.step(tick, [one.value(tick, signals) for one in self.inputs])

    def blocks(self) -> Iterable[Block]:
        if self.block is not None:
            yield self.block
        for one in self.inputs:
            yield from one.blocks()


@dataclass(frozen=True)
class Result:
    """Values of signals that have changed at a tick."""

    tick: int
    values: dict[str, Value]


class Logic:
    """Connections that run: told changes of signals, it says what comes of them.

    Example:
        >>> logic = Logic(connections, 0.004, values, tick=0)
        >>> logic.advance(250, {"part present": True})
        [Result(tick=250, values={'motor': True})]
    """

    def __init__(
        self, connections: Iterable[Connection], tick_length: float, values: Mapping[str, Value], tick: int
    ) -> None:
        """Begin at a tick with the values of all signals.

        Counters and set-reset that alone give a signal begin with its value. Edges are those after the first `advance`.
        """
        self.tick = tick
        self._tick_length = tick_length
        self._values = dict(values)
        self._connections = [
            (one.target, self._running(one.source, values[one.target])) for one in in_order(connections)
        ]
        self._blocks = [block for _, running in self._connections for block in running.blocks()]
        self._float = {name for name, value in values.items() if isinstance(value, float)}

    @property
    def due(self) -> int | None:
        """Tick at which something runs out next; None when nothing will."""
        return min((block.due for block in self._blocks if block.due is not None), default=None)

    @property
    def driven_values(self) -> dict[str, Value]:
        """Values of the signals that it drives, by name."""
        return {target: self._values[target] for target, _ in self._connections}

    def advance(self, tick: int, changes: Mapping[str, Value]) -> list[Result]:
        """Return what becomes of signals up to a tick, at which these have changed, in order.

        What runs out before that tick is evaluated first, at its own tick. A change that comes late, at a tick before
        the latest, counts as one at the latest.
        """
        tick = max(tick, self.tick)
        results = []
        while (due := self.due) is not None and due < tick:
            results.append(self._evaluated(due))
        driven = set(self.driven_values)
        self._values.update((name, value) for name, value in changes.items() if name not in driven)
        results.append(self._evaluated(tick))
        return [one for one in results if one.values]

    def _evaluated(self, tick: int) -> Result:
        self.tick = tick
        changed: dict[str, Value] = {}
        for target, running in self._connections:
            value = running.value(tick, self._values)
            if target in self._float:
                value = float(value)  # type: ignore[arg-type]
            if value != self._values[target]:
                changed[target] = self._values[target] = value
        return Result(tick, changed)

    def _running(self, expression: Expression, first: Value = False) -> _Running:
        made = OPERATORS.get(expression.operator)
        ticks = max(1, math.ceil(expression.seconds / self._tick_length - 1e-6))
        block = None if made is None else made.make(expression, ticks, first)
        return _Running(expression, [self._running(one) for one in expression.inputs], block)
