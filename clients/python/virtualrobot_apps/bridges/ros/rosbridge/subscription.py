"""A subscription of a client: how often it gets messages, how many wait, and how they are packed."""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from virtualrobot_apps.bridges.ros.hub import HubError
from virtualrobot_apps.bridges.ros.messages.cbor import to_cbor
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.rosbridge.wire import MOST_BYTES, fragments, png

PACKINGS = ("none", "png", "cbor", "cbor-raw")
MOST_QUEUE = 10_000
BACKLOG_MESSAGES, BACKLOG_BYTES = 100, 1 << 20
"""So many messages without `queue_length` wait at most, and so many bytes of them; beyond that the newest count."""


class Subscription:
    """Wish of one client for a topic under one id; `ready` is called with it when something waits.

    Attributes:
        topic: name of the topic.
        size: bytes of the message that was packed last.
    """

    def __init__(self, topic: str, op: Mapping[str, Any], ready: Callable[[Subscription], None]) -> None:
        """Read what a message `subscribe` asks for; raises HubError for what can't be."""
        self.topic, self._ready = topic, ready
        self._period = number(op, "throttle_rate", 0.0, 3.6e6) / 1000.0
        self._queue = int(number(op, "queue_length", 0, MOST_QUEUE))
        self._fragment = int(number(op, "fragment_size", 0, MOST_BYTES))
        self._packing = op.get("compression") or "none"
        if self._packing not in PACKINGS:
            raise HubError(f"'compression' is one of {', '.join(PACKINGS)}, not {str(self._packing)[:40]!r}")
        self._waiting: deque[Message] = deque(maxlen=self._queue or BACKLOG_MESSAGES)
        self._next = 0.0
        self._count = 0
        self.size = 0
        # A map in CBOR is its parts behind each other: three of them, of which the message comes last.
        self._head = b"\xa3" + to_cbor({"op": "publish", "topic": topic})[1:] + to_cbor("msg")
        self.end: Callable[[], None] = lambda: None

    def take(self, message: Message) -> None:
        """Take a message of the topic; where too much waits the oldest is lost."""
        if not self._queue:
            most = 1 if self._period else max(1, BACKLOG_BYTES // (self.size or 1))
            while len(self._waiting) >= most:
                self._waiting.popleft()
        self._waiting.append(message)
        self._ready(self)

    def due(self, now: float) -> float | None:
        """Return the seconds until a message may go, 0 when one may go now; None when none waits."""
        return max(0.0, self._next - now) if self._waiting else None

    def packed(self) -> list[str | bytes]:
        """Return what goes out for the next message."""
        message = self._waiting.popleft()
        self._next = time.monotonic() + self._period
        data = self._pack(message)
        self.size = len(data)
        if isinstance(data, str) and self._fragment and len(data) > self._fragment:
            self._count += 1
            return [*fragments(data, self._fragment, f"{self.topic}:{self._count}")]
        return [data]

    def _pack(self, message: Message) -> str | bytes:
        if self._packing == "cbor":
            return b"".join((self._head, *message.cbor_parts))  # which are made once for all
        if self._packing == "cbor-raw":
            seconds, nanos = divmod(message.time, 1_000_000_000)
            raw = {"secs": seconds, "nsecs": nanos, "bytes": message.cdr}
            return to_cbor({"op": "publish", "topic": self.topic, "msg": raw})
        text = f'{{"op":"publish","topic":{json.dumps(self.topic)},"msg":{message.json}}}'
        return json.dumps({"op": "png", "data": png(text)}) if self._packing == "png" else text


def number(op: Mapping[str, Any], key: str, least: float, most: float) -> float:
    """Return a number of a message; absent and null are 0. Raises HubError for what is none, or out of range."""
    value = op.get(key)
    if value is None:
        return 0.0
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise HubError(f"{key!r} is a number from {least:g} to {most:g}, not {str(value)[:40]!r}")
    return value
