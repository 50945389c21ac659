"""Logic of connections: what signals become from others as time goes by. Nothing here knows of a kernel or of a clock.

Time is a number of ticks. A `Logic` is told which signals have changed at which tick, and says which values come of it,
at which tick: equal changes at equal ticks give equal values. What runs out between two changes (a delay, a pulse)
is evaluated at its own tick.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from virtualrobot_apps.connections.blocks import Block
from virtualrobot_apps.connections.expressions import Connection, Expression, Value
from virtualrobot_apps.connections.operators import OPERATORS


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
