"""Signals by name: set, get, watch, wait for."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from typing import Unpack

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import Stamp, stamp_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, table_html, told
from virtualrobot._wire.signal_values import GivenValue, SignalValue, set_command, value_message, value_of
from virtualrobot.errors import CallTimeoutError, InvalidArgumentError
from virtualrobot.scene.editor import Direct, SignalOptions
from virtualrobot.v1 import signal_pb2

_COMPARED = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@dataclass(frozen=True, slots=True)
class Signal:
    """A signal at one instant.

    Attributes:
        name: its name.
        value: a bool, an int, a float, a str, or a tuple of bools for a group.
        description: its purpose in words.
        unit: of a number.
        direction: "input", "output" or "internal", seen from its owner.
        owner: the node that it belongs to; empty means nobody.
    """

    name: str
    value: SignalValue
    description: str
    unit: str
    direction: str
    owner: str

    @staticmethod
    def of(message: signal_pb2.Signal) -> Signal:
        """Return the signal that a message tells."""
        direction = signal_pb2.SignalDirection.Name(message.direction).removeprefix("SIGNAL_DIRECTION_").lower()
        value = value_of(message.value)
        return Signal(message.name, value, message.description, message.unit, direction, message.owner)


@dataclass(frozen=True, slots=True)
class SignalChange:
    """Values of signals that are new or changed at one instant.

    Attributes:
        stamp: the instant.
        values: the values by name.
        removed: signals that are gone.
    """

    stamp: Stamp
    values: dict[str, SignalValue]
    removed: tuple[str, ...]


class SignalWatch:
    """Changes of signals as they come, in order and without a gap, until it is closed, which any thread may do."""

    def __init__(self, services: Services, names: Sequence[str]) -> None:
        """Watch these signals, or all."""
        self._stream = services.signal.WatchSignals(signal_pb2.WatchSignalsRequest(names=names))

    def __iter__(self) -> Iterator[SignalChange]:
        """Yield all values, then each change."""
        for response in self._stream:
            values = {signal.name: value_of(signal.value) for signal in response.signals}
            yield SignalChange(stamp_of(response.stamp), values, tuple(response.removed_names))

    def close(self) -> None:
        """End it; whoever waits for a change comes to the end."""
        self._stream.cancel()

    def __enter__(self) -> SignalWatch:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()


@checked
class Signals(MutableMapping[str, SignalValue]):
    """The signals of one kernel, like a dictionary of names to values.

    Example:
        >>> client.signals.create("gripper closed")
        >>> client.signals["gripper closed"] = True
        >>> client.signals.create("pressure", 0.0, unit="bar")
        >>> client.signals.wait_for("pressure", 5.5, comparison=">=", timeout=10.0)
    """

    def __init__(self, services: Services) -> None:
        """Handle the signals of one kernel."""
        self._services = services

    def create(self, name: str, value: GivenValue = False, **options: Unpack[SignalOptions]) -> None:
        """Add a signal, as `Editor.create_signal` does."""
        Direct(self._services).create_signal(name, value, **options)

    def read(self, names: Sequence[str] = ()) -> list[Signal]:
        """Return all signals, or these."""
        response = self._services.signal.GetSignals(signal_pb2.GetSignalsRequest(names=names))
        return [Signal.of(message) for message in response.signals]

    def set(self, values: Mapping[str, GivenValue]) -> None:
        """Set several signals at the same instant; all or none when one is unknown or takes no such value."""
        commands = [set_command(name, value) for name, value in values.items()]
        self._services.apply(commands)

    def watch(self, names: Sequence[str] = ()) -> Iterator[dict[str, SignalValue]]:
        """Yield the values of all signals, or of these, and then those that are new or changed; no change is lost."""
        with self._services.signal.WatchSignals(signal_pb2.WatchSignalsRequest(names=names)) as stream:
            for response in stream:
                yield {signal.name: value_of(signal.value) for signal in response.signals}

    def follow(self, names: Sequence[str] = ()) -> SignalWatch:
        """Return a watch of all signals, or of these, which tells each change with its instant.

        Example:
            >>> with client.signals.follow(["box arrived"]) as watch:
            ...     for change in watch:
            ...         print(change.stamp.tick, change.values)
        """
        return SignalWatch(self._services, names)

    def wait_for(
        self, name: str, value: GivenValue = True, timeout: float | None = None, comparison: str = "=="
    ) -> None:
        """Wait until a signal compares so with this value; return at once when it does already.

        `comparison` is one of `==`, `!=`, `<`, `<=`, `>`, `>=`; the last four are for integers and numbers.

        Raises:
            CallTimeoutError: when it does not within `timeout` seconds of the wall clock.
            UnknownNameError: when there is no such signal.
            InvalidArgumentError: when the signal's type can't be compared so.
        """
        if comparison not in _COMPARED:
            raise InvalidArgumentError(f"a comparison is one of {', '.join(_COMPARED)}, not {comparison!r}")
        request = signal_pb2.WatchSignalsRequest(names=[name])
        try:
            with self._services.signal.WatchSignals(request, timeout=timeout) as stream:
                for response in stream:
                    if any(
                        _holds(one.name, value_of(one.value), comparison, value)
                        for one in response.signals
                        if one.name == name
                    ):
                        return
        except CallTimeoutError as error:
            wanted = {True: "on", False: "off"}[value] if isinstance(value, bool) else f"{comparison} {value!r}"
            raise CallTimeoutError(f"the signal {name!r} was not {wanted} within {timeout} s") from error

    def __getitem__(self, name: str) -> SignalValue:
        """Return the value of a signal."""
        return self.read([name])[0].value

    def __setitem__(self, name: str, value: GivenValue) -> None:
        """Set a signal that exists; see `create`."""
        self.set({name: value})

    def __delitem__(self, name: str) -> None:
        """Take a signal out of the world."""
        Direct(self._services).remove_signal(name)

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter([signal.name for signal in self.read()])

    def __len__(self) -> int:
        """Return the count of signals."""
        return len(self.read())

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that IPython completes."""
        return list(self)

    def _repr_html_(self) -> str:
        """Return a table for notebooks."""
        rows = [[one.name, repr(one.value), one.unit, one.direction, one.description] for one in self.read()]
        return table_html("Signals", [["signal", "value", "unit", "direction", "description"], *rows])

    def __repr__(self) -> str:
        """Return names and values."""
        return told("Signals", lambda: listed((f"{one.name!r} = {one.value!r}" for one in self.read()), "none yet"))


def _holds(name: str, value: SignalValue, comparison: str, other: GivenValue) -> bool:
    other = value_of(value_message(other))
    ordered = not isinstance(value, bool | str | tuple) and not isinstance(other, bool | str | tuple)
    alike = ordered or type(value) is type(other)
    if not alike or (comparison not in ("==", "!=") and not ordered):
        raise InvalidArgumentError(
            f"the signal {name!r} is {value!r}, which {comparison!r} cannot compare with {other!r}"
        )
    return bool(_COMPARED[comparison](value, other))
