"""Connections that run in a kernel: its signals go into the logic, and what comes of it is set."""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping

from virtualrobot import Client
from virtualrobot.clock import ClockState
from virtualrobot.errors import VirtualRobotError, WrongStateError
from virtualrobot.signals import SignalChange

from virtualrobot_apps.connections.devices import fitted
from virtualrobot_apps.connections.expressions import Value
from virtualrobot_apps.connections.file import ConnectionFile
from virtualrobot_apps.connections.logic import Logic, Result

IDLE_SECONDS = 0.5
POLL_SECONDS = 0.01


class Connections:
    """Connections of a file, running in a kernel.

    In real time `run` follows the changes of signals as they come, each with its tick. In stepped time `step` makes the
    ticks itself and looks at the signals after each, so that equal runs are equal to the tick.

    Example:
        >>> with Connections(client, read_connections("cell-io.yaml")) as connections:
        ...     connections.step(250)
    """

    def __init__(self, client: Client, file: ConnectionFile, say: Callable[[str], None] = print) -> None:
        """Check a file against a kernel, make the signals that it makes, and set all that it drives.

        Raises:
            MalformedFileError: for what does not fit, with its line; nothing has changed.
        """
        self._client, self._file, self._say = client, file, say
        known = {one.name: one.value for one in client.signals.read()}
        self._devices = fitted(client, file, known, say)
        for one in file.signals:
            if one.name not in known:
                client.signals.create(one.name, one.value, unit=one.unit or None, description=one.description or None)
        self._watch = client.signals.follow()
        self._changes: queue.Queue[SignalChange | VirtualRobotError | None] = queue.Queue()
        self._closed = False
        changes = iter(self._watch)
        first = next(changes)
        self._values: dict[str, Value] = dict(first.values)
        self._driven = set(file.driven())
        self._used = self._names()
        self._sent: dict[str, deque[Value]] = {name: deque() for name in self._driven}
        self._unsent: dict[str, Value] = {}
        self._said: set[str] = set()
        self._clock: ClockState = client.clock.read()
        self._logic = Logic(file.connections, self._clock.tick_length, self._values, first.stamp.tick)
        threading.Thread(target=self._read, args=(changes,), name="signals", daemon=True).start()
        self._advance(first.stamp.tick, {})

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Go on until it is interrupted or `until` is true, which is asked at least twice a second.

        Raises:
            KernelGoneError: when the kernel ends.
            WrongStateError: when a signal that is used is removed.
        """
        while not until():
            try:
                change = self._changes.get(timeout=self._patience())
            except queue.Empty:
                if self._logic.due is not None or self._unsent or any(one.waiting for one in self._devices):
                    self._clock = self._client.clock.read()
                    self._advance(self._clock.stamp.tick, {})
                continue
            if isinstance(change, VirtualRobotError):
                raise change
            if change is None:
                return
            self._take(change)

    def step(self, ticks: int = 1) -> None:
        """Let stepped time go on by some ticks, and evaluate after each.

        Raises:
            WrongStateError: when time follows the wall clock, or a signal that is used is gone.
        """
        for _ in range(ticks):
            seen = self._client.clock.step()
            if gone := self._used - set(seen.signals):
                raise _gone(gone)
            changes = {name: value for name, value in seen.signals.items() if value != self._values.get(name)}
            self._values.update(changes)
            self._advance(seen.stamp.tick, changes)

    def close(self) -> None:
        """End; what runs by it is stopped, signals stay as they are."""
        self._closed = True
        for device in self._devices:
            try:
                device.stop()
            except VirtualRobotError as error:
                self._say(str(error))
        self._watch.close()

    def __enter__(self) -> Connections:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def _names(self) -> set[str]:
        used = {name for one in self._file.connections for name in one.source.signals()} | self._driven
        devices = {name for one in (*self._file.tools, *self._file.belts) for name in [one.signal]}
        return used | devices | {one.velocity for one in self._file.belts if isinstance(one.velocity, str)}

    def _read(self, changes: Iterator[SignalChange]) -> None:
        try:
            for change in changes:
                self._changes.put(change)
            self._changes.put(None)
        except VirtualRobotError as error:
            if not self._closed:
                self._changes.put(error)

    def _take(self, change: SignalChange) -> None:
        if gone := self._used & set(change.removed):
            raise _gone(gone)
        foreign: dict[str, Value] = {}
        for name, value in change.values.items():
            sent = self._sent.get(name)
            if sent is None:
                foreign[name] = value
            elif value in sent:
                while sent.popleft() != value:
                    pass
            elif name not in self._said:
                self._said.add(name)
                self._say(f"{name!r} is driven by {self._file.root.file}, and somebody else has set it to {value!r}")
        self._values.update(change.values)
        self._advance(change.stamp.tick, foreign)

    def _advance(self, tick: int, changes: Mapping[str, Value]) -> None:
        for result in self._logic.advance(tick, changes):
            self._set(result)
        if self._devices:
            values = self._values | self._logic.driven_values
            told = {name: value for one in self._devices for name, value in one.update(values).items()}
            self._values.update(told)
            if new := {name: value for name, value in told.items() if value != values[name]}:
                self._set(Result(self._logic.tick, new))
                for result in self._logic.advance(self._logic.tick, new):
                    self._set(result)
        if self._unsent:
            self._set(Result(self._logic.tick, {}))

    def _set(self, result: Result) -> None:
        values = self._unsent | result.values
        try:
            self._client.signals.set(values)
        except VirtualRobotError as error:
            if str(error) not in self._said:
                self._said.add(str(error))
                self._say(f"{', '.join(map(repr, values))} cannot be set: {error}")
            self._unsent = values
            return
        for name, value in values.items():
            self._sent[name].append(value)
        self._unsent = {}

    def _patience(self) -> float:
        """Return how long nothing has to be looked at though no signal changes (s of the wall clock)."""
        if self._unsent or any(one.waiting for one in self._devices):
            return POLL_SECONDS
        if (due := self._logic.due) is None:
            return IDLE_SECONDS
        if self._clock.mode != "realtime":
            return POLL_SECONDS
        ticks = due - max(self._logic.tick, self._clock.stamp.tick)
        return min(max(ticks * self._clock.tick_length / self._clock.speed_factor, 0.001), IDLE_SECONDS)


def _gone(names: set[str]) -> WrongStateError:
    return WrongStateError(f"signals that connections use are gone: {', '.join(map(repr, sorted(names)))}")
