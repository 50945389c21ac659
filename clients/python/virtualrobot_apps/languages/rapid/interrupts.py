"""Interrupts of RAPID: what orders them, and the traps that they call between two statements of the program."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.signals import SignalChange, SignalValue, SignalWatch

from virtualrobot_apps.languages.rapid.faults import CAUGHT, RapidFault, RapidStopped, as_fault

EDGE = 2.0
"""Trigger value of an interrupt at each change of a signal."""
LOOK_SECONDS = 0.02
"""Time (s of the wall clock) from one look to the next while an interrupt waits for a time or a persistent."""


@dataclass(slots=True)
class Interrupt:
    """An interrupt: its trap, whether it sleeps, and what orders it.

    That is a signal that gets a value, a time (s), or a persistent whose value changes: the list that holds it, its
    index there, and the value before.
    """

    number: float
    trap: Callable[[], object]
    asleep: bool = False
    single: bool = False
    signal: str = ""
    value: float = EDGE
    period: float = 0.0
    due: float = 0.0
    data: tuple[list[Any], int] | None = None
    before: object = None


class Interrupts:
    """Interrupts of one task. Signals and the clock are watched in threads; traps run in the task's own."""

    def __init__(
        self, client: Client, ask: Callable[[], None], now: Callable[[], float], *, watches: bool = True
    ) -> None:
        """Begin without any; `ask` has the task serve soon, `now` tells the time of the simulation.

        Where it `watches` nothing, `look` tells it what has changed.
        """
        self._client, self._ask, self._now = client, ask, now
        self._lock = threading.Lock()
        self._all: dict[float, Interrupt] = {}
        self._pending: deque[Interrupt] = deque()
        self._enabled, self._serving, self._closed = True, False, threading.Event()
        self._watches = watches
        self._values: dict[str, int] = {}
        self._watch: SignalWatch | None = None
        self._clock: threading.Thread | None = None
        self._count = 0

    def connect(self, trap: Callable[[], object]) -> float:
        """Return the number of a new interrupt that calls a trap."""
        with self._lock:
            self._count += 1
            self._all[float(self._count)] = Interrupt(float(self._count), trap)
            return float(self._count)

    def _found(self, number: float) -> Interrupt:
        found = self._all.get(number)
        if found is None:
            raise RapidFault("ERR_UNKINO", f"there is no interrupt {number:g}; CONNECT it with a trap first")
        return found

    def on_signal(self, number: float, signal: str, value: float, single: bool) -> None:
        """Order an interrupt when a signal gets a value, or at each change of it."""
        found = self._found(number)
        with self._lock:
            self._ordered(found)
            found.signal, found.value, found.single = signal, value, single
        if self._watches and self._watch is None:
            self._watch = self._client.signals.follow()
            changes = iter(self._watch)
            self._change(next(changes).values)
            threading.Thread(target=self._follow, args=(changes,), name="rapid signals", daemon=True).start()
        elif not self._watches and not self._values:
            self._change({one.name: one.value for one in self._client.signals.read()})

    def on_time(self, number: float, period: float, single: bool) -> None:
        """Order an interrupt after so many seconds of the simulation, and again and again unless it is `single`."""
        found = self._found(number)
        if period < (0.01 if single else 0.1):
            raise RapidFault("ERR_ARGVALERR", f"ITimer takes 0.1 s or more (single: 0.01 s), not {period:g}")
        with self._lock:
            self._ordered(found)
            found.period, found.due, found.single = period, self._now() + period, single
        self._begin_looking()

    def on_change(self, number: float, holder: list[Any], index: int, single: bool) -> None:
        """Order an interrupt when the value that a list holds has changed."""
        found = self._found(number)
        with self._lock:
            self._ordered(found)
            found.data, found.before, found.single = (holder, index), deepcopy(holder[index]), single
        self._begin_looking()

    def _begin_looking(self) -> None:
        if self._clock is None and self._watches:
            self._clock = threading.Thread(target=self._tick, name="rapid timer", daemon=True)
            self._clock.start()

    def _ordered(self, found: Interrupt) -> None:
        if found.signal or found.period or found.data is not None:
            raise RapidFault("ERR_INOISSAFE", "this interrupt is ordered already; IDelete it first")

    def delete(self, number: float) -> None:
        """Forget an interrupt; one that is not there is no fault."""
        with self._lock:
            found = self._all.pop(number, None)
            self._pending = deque(one for one in self._pending if one is not found)

    def sleep(self, number: float, asleep: bool) -> None:
        """Leave the orders of an interrupt out from now on, or no more."""
        self._found(number).asleep = asleep

    def enable(self, enabled: bool) -> None:
        """Keep traps back, or call those that were kept back and all later ones."""
        self._enabled = enabled
        if enabled and self._pending:
            self._ask()

    def serve(self, run: Callable[[Interrupt], None]) -> None:
        """Have the traps called that wait, one after the other, by `run`."""
        if self._serving or not self._enabled:
            return
        self._serving = True
        try:
            while self._enabled and self._pending:
                with self._lock:
                    one = self._pending.popleft()
                try:
                    run(one)
                except CAUGHT as error:
                    raise RapidStopped(f"{as_fault(error)}, in a trap, whose errors nothing handles") from error
        finally:
            self._serving = False

    def order(self, number: float) -> None:
        """Have the trap of an interrupt called soon; any thread may call it."""
        with self._lock:
            found = self._all.get(number)
            if found is not None:
                self._raise(found)

    def look(self, now: float, values: Mapping[str, SignalValue]) -> None:
        """Have the traps called soon that the time of the simulation (s) and the signals' values order."""
        with self._lock:
            self._pass(now)
            self._change(values)

    def close(self) -> None:
        """End the threads."""
        self._closed.set()
        if self._watch is not None:
            self._watch.close()

    def _raise(self, one: Interrupt) -> None:
        if one.asleep:
            return
        self._pending.append(one)
        if one.single:
            one.signal, one.period, one.data = "", 0.0, None
        self._ask()

    def _change(self, values: Mapping[str, SignalValue]) -> None:
        """Do what values of signals order that were others before; a signal's first value orders nothing."""
        for name, value in values.items():
            if not isinstance(value, int):  # which bools are
                continue
            before, self._values[name] = self._values.get(name, value), value
            for one in list(self._all.values()) if before != value else ():
                if one.signal == name and one.value in (EDGE, float(value)):
                    self._raise(one)

    def _pass(self, now: float) -> None:
        """Do what a time orders, and what persistents do that have changed."""
        for one in list(self._all.values()):
            if one.data is not None and (value := one.data[0][one.data[1]]) != one.before:
                one.before = deepcopy(value)
                self._raise(one)
            if one.period and now >= one.due:
                one.due += one.period
                self._raise(one)

    def _follow(self, changes: Iterator[SignalChange]) -> None:
        with suppress(VirtualRobotError):  # closed, or the kernel is gone, which the program notices itself
            for change in changes:
                with self._lock:
                    self._change(change.values)

    def _tick(self) -> None:
        with suppress(VirtualRobotError):
            while not self._closed.wait(LOOK_SECONDS):
                if any(one.period or one.data is not None for one in list(self._all.values())):
                    now = self._now()
                    with self._lock:
                        self._pass(now)
