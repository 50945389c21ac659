"""Blocks of connections: states of operators that remember something, from one tick to another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from virtualrobot_apps.connections.expressions import GREATEST_INTEGER, LEAST_INTEGER, Value


class Block(Protocol):
    """State of an operator in a cell that runs."""

    due: int | None
    """Tick at which it has to be evaluated though nothing changes."""

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick, not before that of the last step, for the values of its inputs."""
        ...


class Function:
    """A pure function of its inputs."""

    due: int | None = None

    def __init__(self, function: Callable[..., Value]) -> None:
        """Give what a function of the inputs gives."""
        self._function = function

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick; see `Block`."""
        return self._function(*values)


class Pulse:
    """On for some ticks from each edge of its input on; edges meanwhile are not counted."""

    due: int | None = None

    def __init__(self, ticks: int, falling: bool = False) -> None:
        """Be on for so many ticks, after edges off where `falling`."""
        self._ticks, self._falling = ticks, falling
        self._before: bool | None = None

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick; see `Block`."""
        now = bool(values[0]) != self._falling
        if self.due is not None and tick >= self.due:
            self.due = None
        if self.due is None and now and self._before is False:
            self.due = tick + self._ticks
        self._before = now
        return self.due is not None


class DelayOn:
    """On when its input has been on for some ticks."""

    due: int | None = None

    def __init__(self, ticks: int, off: bool = False) -> None:
        """Wait for so many ticks; with `off` on and off change places."""
        self._ticks, self._off = ticks, off
        self._since: int | None = None

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick; see `Block`."""
        if bool(values[0]) == self._off:
            self._since = self.due = None
            return self._off
        if self._since is None:
            # A delay of switching off begins as if its input had been off for ever.
            self._since = tick
        end = self._since + self._ticks
        self.due = end if tick < end else None
        return self._off if tick < end else not self._off


class DelayOff(DelayOn):
    """On until its input has been off for some ticks; off where that was never on."""

    def __init__(self, ticks: int) -> None:
        """Wait for so many ticks."""
        super().__init__(ticks, off=True)
        self._begun = False

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick; see `Block`."""
        self._begun = self._begun or bool(values[0])
        return super().step(tick, values) if self._begun else False


class SetReset:
    """On from `set` to `reset`, which wins where both are on."""

    due: int | None = None

    def __init__(self, first: Value) -> None:
        """Begin with a value."""
        self._on = bool(first)

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick; see `Block`."""
        to_on, to_off = values
        self._on = (self._on or bool(to_on)) and not to_off
        return self._on


class Counter:
    """Number of rising edges of `up` less those of `down`; zero while `reset` is on."""

    due: int | None = None

    def __init__(self, first: Value) -> None:
        """Begin with a value."""
        self._count = int(first) if isinstance(first, int) else 0
        self._before: tuple[bool, bool] | None = None

    def step(self, tick: int, values: Sequence[Value]) -> Value:
        """Return its value at a tick; see `Block`."""
        up, down, reset = map(bool, values)
        before = self._before or (up, down)
        self._before = (up, down)
        change = int(up and not before[0]) - int(down and not before[1])
        self._count = 0 if reset else min(max(self._count + change, LEAST_INTEGER), GREATEST_INTEGER)
        return self._count
