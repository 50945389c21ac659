"""Signals of a world as topics: each change is told, and what is published on a topic beside it sets the signal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.signals import SignalChange

from virtualrobot_apps.bridges.ros.following import Following
from virtualrobot_apps.bridges.ros.hub import Hub, HubError, Refused, Topic
from virtualrobot_apps.bridges.ros.in_order import InOrder
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.mapping.names import topic_name
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.messages.values import default

PLACE = "signals"

Value = bool | int | float | str | tuple[bool, ...]

TYPES: dict[type, str] = {
    bool: "std_msgs/msg/Bool",
    int: "std_msgs/msg/Int64",
    float: "std_msgs/msg/Float64",
    str: "std_msgs/msg/String",
    tuple: "std_msgs/msg/UInt8MultiArray",
}
"""Types of messages by those of signals; a group of booleans is a list of 0 and 1."""


def topics_of(name: str) -> tuple[str, str]:
    """Return the topic that tells a signal, and the one that sets it."""
    told = topic_name(PLACE, name)
    return told, f"{told}/set"


def message_of(value: Value) -> RosValue:
    """Return the message of a value."""
    type = TYPES[kind_of(value)]
    if isinstance(value, tuple):
        return make(type, layout=default("std_msgs/msg/MultiArrayLayout"), data=np.array(value, np.uint8))
    return make(type, data=value)


def value_of(message: RosValue) -> Value:
    """Return the value of a message.

    Raises:
        ValueError: for a list that has other numbers than 0 and 1.
    """
    if not isinstance(message.data, np.ndarray):
        return message.data
    if (message.data > 1).any():
        raise ValueError("a group of booleans is a list of 0 and 1")
    return tuple(bool(one) for one in message.data)


def kind_of(value: Value) -> type:
    """Return the type of a value; a text is a str, whatever it is made of."""
    return next(one for one in TYPES if isinstance(value, one))


@dataclass(frozen=True)
class _Signal:
    kind: type
    told: str
    set: str


class SignalTopics:
    """Signals on a hub, whose loop calls `open` and `close`; `soon` lets that loop call something from any thread."""

    def __init__(self, client: Client, hub: Hub, say: Callable[[str], None], soon: Callable[..., None]) -> None:
        """Tell nothing yet."""
        self._client, self._hub, self._say = client, hub, say
        self._known: dict[str, _Signal] = {}
        self._setting = InOrder("values of signals", self._set)
        self._following = Following("signals", client.signals.follow, self._take, soon)

    def open(self) -> None:
        """Tell all signals, and those that come later."""
        self._following.open()

    def close(self) -> None:
        """Tell no more."""
        self._following.close()
        for name in tuple(self._known):
            self._remove(name)

    def _take(self, change: SignalChange, _: bool) -> None:
        for name in change.removed:
            self._remove(name)
        for name, value in change.values.items():
            kind = kind_of(value)
            if name in self._known and self._known[name].kind is not kind:
                self._remove(name)
            if name in self._known or self._add(name, kind):
                time = round(change.stamp.simulation_time * 1e9)
                self._hub.publish(self._known[name].told, Message(TYPES[kind], message_of(value), time))

    def _add(self, name: str, kind: type) -> bool:
        signal = _Signal(kind, *topics_of(name))
        taken = [one for one in self._known.values() if {one.told, one.set} & {signal.told, signal.set}]
        try:
            if taken:
                raise HubError(f"the topic {signal.told} is that of another signal")
            self._hub.declare(Topic(signal.told, TYPES[kind], latched=True, is_told=True))
            try:
                self._hub.declare(Topic(signal.set, TYPES[kind], take=partial(self._hear, name)))
            except HubError:
                self._hub.withdraw(signal.told)
                raise
        except HubError as error:
            self._say(f"the signal {name!r} is not told: {error}")
            return False
        self._known[name] = signal
        return True

    def _remove(self, name: str) -> None:
        if (signal := self._known.pop(name, None)) is not None:
            for topic in (signal.told, signal.set):
                self._hub.withdraw(topic)

    def _hear(self, name: str, message: RosValue, refused: Refused) -> None:
        self._setting.put((name, value_of(message), refused))

    def _set(self, wish: tuple[str, Value, Refused]) -> None:
        name, value, refused = wish
        try:
            self._client.signals.set({name: value})
        except VirtualRobotError as error:
            self._say(f"the signal {name!r} is not set: {error}")
            refused(str(error))
