"""Subscriptions of Robot Web Services: resources whose changes are told over a WebSocket."""

from __future__ import annotations

import itertools
import re
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from virtualrobot_apps.emulators.abb.answers import Item
from virtualrobot_apps.emulators.abb.controller import Controller
from virtualrobot_apps.emulators.abb.refused import Refused
from virtualrobot_apps.emulators.abb.resources.execution import execution_state
from virtualrobot_apps.emulators.abb.resources.machine import controller_state, logical, signal
from virtualrobot_apps.emulators.abb.resources.system import message_item
from virtualrobot_apps.languages.rapid.values import value_text

MOST, MOST_RESOURCES = 64, 1000
"""Number of subscriptions, and of resources in one."""
CLAIM_SECONDS = 60.0
"""Time (s) after which a subscription is given up whose WebSocket nobody has opened."""
PRIORITIES = {"0": "low", "1": "medium", "2": "high"}


class Watch(Protocol):
    """A resource that is looked at; one thread calls it."""

    def changes(self) -> list[Item]:
        """Return what has changed since it was asked last; at first, the state that it has."""
        ...

    def close(self) -> None:
        """Look no longer."""
        ...


class StateWatch:
    """A resource that has a state."""

    def __init__(self, read: Callable[[], Item]) -> None:
        """Tell what `read` returns, when it is another one than before."""
        self._read, self._last = read, None

    def changes(self) -> list[Item]:
        """Return the state where it is another one."""
        before, self._last = self._last, self._read()
        return [] if self._last == before else [self._last]

    def close(self) -> None:
        """Have nothing to give back."""


class SignalWatch:
    """A signal, of which no change is left out."""

    def __init__(self, controller: Controller, href: str, path: str) -> None:
        """Watch a signal; raises Refused where there is none."""
        found = signal(controller, path)
        self._controller, self._href, self._name = controller, href, found.name
        self._values: deque[Any] = deque([found.value])
        self._last: object = None
        controller.listeners.add(self._take)

    def _take(self, values: Mapping[str, Any]) -> None:
        if self._name in values:
            self._values.append(values[self._name])

    def changes(self) -> list[Item]:
        """Return all values that it has had."""
        items = []
        while self._values:
            value = self._values.popleft()
            if value != self._last:
                self._last = value
                told = {"lvalue": logical(value), "lstate": "not simulated"}
                items.append(Item("ios-signalstate-ev", self._name, told, self._href))
        return items

    def close(self) -> None:
        """Hear of it no longer."""
        self._controller.listeners.discard(self._take)


class LogWatch:
    """New messages of the log."""

    def __init__(self, controller: Controller) -> None:
        """Begin with the next message."""
        self._log, self._number = controller.log, controller.log.newest

    def changes(self) -> list[Item]:
        """Return where the new messages are."""
        new = self._log.since(self._number)
        self._number = new[-1].number if new else self._number
        return [
            Item("elog-message-ev", f"{one.number}", {"seqnum": one.number}, f"/rw/elog/0/{one.number}") for one in new
        ]

    def close(self) -> None:
        """Have nothing to give back."""


class QueueWatch:
    """Messages of a queue, which are taken out as they are told."""

    def __init__(self, controller: Controller, href: str, name: str) -> None:
        """Take messages out of a queue that is there."""
        if name not in controller.queues:
            raise Refused("INVALIDARG", f"there is no queue {name!r}", 404)
        self._queue, self._href, self._name = controller.queues[name], href, name

    def changes(self) -> list[Item]:
        """Return the messages that have come."""
        items = []
        while self._queue:
            items.append(message_item(self._name, self._queue.popleft(), "dipc-msg-ev", self._href))
        return items

    def close(self) -> None:
        """Have nothing to give back."""


def _execution(controller: Controller, href: str) -> Watch:
    """State of execution: running or stopped."""
    return StateWatch(
        lambda: Item("rap-ctrlexecstate-ev", "ctrlexecstate", {"ctrlexecstate": execution_state(controller)}, href)
    )


def _cycle(controller: Controller, href: str) -> Watch:
    """Cycle: once or forever."""
    return StateWatch(lambda: Item("rap-execcycle-ev", "rapidexeccycle", {"rapidexeccycle": controller.cycle}, href))


def _task(controller: Controller, href: str, task: str) -> Watch:
    """State of a task: ready, started or stopped."""
    unit = controller.unit(task)

    def read() -> Item:
        values = {"task-name": unit.name, "pgmtaskexec-state": controller.state_of(unit)}
        return Item("rap-execstate-ev", "execstatechange", values, href)

    return StateWatch(read)


def _datum(controller: Controller, href: str, path: str) -> Watch:
    """A datum of RAPID."""
    parts = path.split("/")
    controller.symbol(parts)

    def read() -> Item:
        return Item("rap-data", f"RAPID/{path}", {"value": value_text(controller.symbol(parts).holder[0])}, href)

    return StateWatch(read)


def _motors(controller: Controller, href: str) -> Watch:
    """State of the controller: motoron or motoroff."""
    return StateWatch(lambda: Item("pnl-ctrlstate-ev", "ctrlstate", {"ctrlstate": controller_state(controller)}, href))


def _mode(controller: Controller, href: str) -> Watch:
    """The operating mode, which stays."""
    return StateWatch(lambda: Item("pnl-opmode-ev", "opmode", {"opmode": "AUTO"}, href))


def _speed(controller: Controller, href: str) -> Watch:
    """The speed of its robots' motions in percent."""

    def read() -> Item:
        percent = round(100.0 * controller.speed)
        return Item("pnl-speedratio-ev", "speedratio", {"speedratio": percent}, href)

    return StateWatch(read)


def _signal(controller: Controller, href: str, path: str) -> Watch:
    """A signal; no change is left out."""
    return SignalWatch(controller, href, path)


def _log(controller: Controller, href: str) -> Watch:
    """New messages of the log."""
    return LogWatch(controller)


def _queue(controller: Controller, href: str, name: str) -> Watch:
    """Messages of a queue, which are taken out of it."""
    return QueueWatch(controller, href, name)


SUBSCRIBABLE: dict[str, Callable[..., Watch]] = {
    "/rw/rapid/execution;ctrlexecstate": _execution,
    "/rw/rapid/execution;rapidexeccycle": _cycle,
    "/rw/rapid/tasks/{task};excstate": _task,
    "/rw/rapid/symbol/data/RAPID/{path};value": _datum,
    "/rw/panel/ctrlstate": _motors,
    "/rw/panel/opmode": _mode,
    "/rw/panel/speedratio": _speed,
    "/rw/iosystem/signals/{path};state": _signal,
    "/rw/elog/0": _log,
    "/rw/dipc/{queue}": _queue,
}
"""Resources of 1.0 that can be subscribed to, and what makes the watch of each."""
SECOND = {
    "/rw/panel/ctrlstate": "/rw/panel/ctrl-state",
    "/rw/rapid/symbol/data/RAPID/{path};value": "/rw/rapid/symbol/RAPID/{path}/data;value",
}
"""Names in 2.0 of those that are called otherwise there."""
_PANEL = re.compile(r"(/rw/panel/[\w-]+);\w+")
"""Resources of the panel, behind which clients may name their only value."""


def _pattern(template: str) -> re.Pattern[str]:
    return re.compile(re.sub(r"\\\{\w+\\\}", "(.+)", re.escape(template)))


_FIRST_PATTERNS = {_pattern(template): make for template, make in SUBSCRIBABLE.items()}
_SECOND_PATTERNS = {_pattern(SECOND.get(template, template)): make for template, make in SUBSCRIBABLE.items()}


def watch(controller: Controller, uri: str, *, second: bool = False) -> Watch:
    """Return the watch of a resource of 1.0, or 2.0 (`second`)."""
    panel = _PANEL.fullmatch(uri)
    for pattern, make in (_SECOND_PATTERNS if second else _FIRST_PATTERNS).items():
        match = pattern.fullmatch(panel[1] if panel else uri)
        if match:
            return make(controller, uri, *match.groups())
    known = (SECOND.get(one, one) if second else one for one in SUBSCRIBABLE)
    raise Refused("INVALIDARG", f"{uri!r} can't be subscribed to; there are: {', '.join(known)}")


class Subscriptions:
    """Subscriptions by their numbers; any thread calls it."""

    def __init__(self, controller: Controller, *, second: bool = False) -> None:
        """Have none; `second`: resources are called as in 2.0."""
        self._controller, self._second = controller, second
        self._numbers = itertools.count(1)
        self._watches: dict[int, dict[str, Watch]] = {}
        self._since: dict[int, float] = {}
        self._lock = threading.RLock()

    def make(self, form: Mapping[str, list[str]]) -> int:
        """Return the number of a new subscription to what a form names."""
        with self._lock:
            return self._make(form, time.monotonic())

    def _make(self, form: Mapping[str, list[str]], now: float) -> int:
        for number in [number for number, since in self._since.items() if now - since > CLAIM_SECONDS]:
            self.close(number)
        if len(self._watches) >= MOST:
            raise Refused("MAX_LIMIT_REACHED", f"there are {MOST} subscriptions already", 503)
        number = next(self._numbers)
        self._watches[number], self._since[number] = {}, now
        try:
            self.add(number, form)
        except BaseException:
            self.close(number)
            raise
        return number

    def add(self, number: int, form: Mapping[str, list[str]]) -> None:
        """Subscribe to more; all of it, or nothing where something is wrong."""
        with self._lock:
            self._add(number, form)

    def _add(self, number: int, form: Mapping[str, list[str]]) -> None:
        watches = self.of(number)
        names = form.get("resources", [])
        if not names or len(watches) + len(names) > MOST_RESOURCES:
            raise Refused("INVALIDARG", f"'resources' names 1 to {MOST_RESOURCES} identifiers, each with its URI")
        new: dict[str, Watch] = {}
        try:
            for name in names:
                uri, priority = form.get(name, [""])[0], form.get(f"{name}-p", ["0"])[0]
                if priority not in PRIORITIES:
                    told = ", ".join(f"{one} ({words})" for one, words in PRIORITIES.items())
                    raise Refused("INVALIDARG", f"the priority {name}-p is {told}, not {priority!r}")
                if uri not in watches and uri not in new:
                    new[uri] = watch(self._controller, uri, second=self._second)
        except BaseException:
            for one in new.values():
                one.close()
            raise
        watches |= new

    def of(self, number: int) -> dict[str, Watch]:
        """Return the watches of a subscription, by what they watch."""
        if number not in self._watches:
            raise Refused("UNRESOLVED_URL", f"there is no subscription {number}", 404)
        return self._watches[number]

    def claim(self, number: int) -> None:
        """Keep a subscription from now on, whose WebSocket somebody has opened."""
        self._since.pop(number, None)

    def changes(self, number: int) -> list[Item]:
        """Return what has changed of what a subscription watches."""
        items = []
        with self._lock:
            watches = self.of(number)
            for uri, one in list(watches.items()):
                try:
                    items += one.changes()
                except Refused:  # it has gone, with its module
                    one.close()
                    del watches[uri]
        return items

    def close(self, number: int) -> None:
        """Give a subscription up; harmless where there is none."""
        with self._lock:
            self._since.pop(number, None)
            for one in self._watches.pop(number, {}).values():
                one.close()
