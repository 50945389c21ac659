"""A client of the server: what it says is done, and what it has asked for is sent."""

from __future__ import annotations

import asyncio
import hmac
import json
import time
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

from virtualrobot_apps.bridges.ros.hub import Hub, HubError, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, time_of
from virtualrobot_apps.bridges.ros.messages.types import UnknownTypeError, fields, known
from virtualrobot_apps.bridges.ros.messages.values import FieldError, from_plain
from virtualrobot_apps.bridges.ros.rosbridge.calls import Calls, text
from virtualrobot_apps.bridges.ros.rosbridge.connections import Connection
from virtualrobot_apps.bridges.ros.rosbridge.subscription import Subscription
from virtualrobot_apps.bridges.ros.rosbridge.wire import Fragments, decoded, fragments, text_of_png

LEVELS = {"none": 0, "error": 1, "warning": 2, "info": 3}
MOST_REPLIES, MOST_TASKS, MOST_SUBSCRIPTIONS = 1000, 64, 1000
SMALL_BYTES = 16_384
"""Messages up to this size go out as they come, where nothing else waits."""


class Session:
    """A client that is connected, until `run` ends."""

    subscription = Subscription
    """Class of its subscriptions."""

    def __init__(self, hub: Hub, connection: Connection, token: str = "") -> None:
        """Serve a client; one that has to say the token first does so by the operation `auth`."""
        self.hub, self._connection, self._token = hub, connection, token
        self._level = LEVELS["error"]
        self._subscriptions: dict[tuple[str, str], Subscription] = {}
        self._advertised: set[str] = set()
        self._fragments = Fragments()
        self._replies: deque[str | bytes] = deque()
        self._ready, self._is_idle = asyncio.Event(), False
        self._tasks: set[asyncio.Task[None]] = set()
        self._calls = Calls(self)
        self._too_slow = False
        self._operations: dict[str, Callable[[dict[str, Any]], None]] = {
            "auth": self._auth,
            "fragment": self._take_fragment,
            "png": lambda op: self._read(text_of_png(text(op, "data")), inner=True),
            "set_level": self._set_level,
            "status": lambda op: None,
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
            "advertise": self._advertise,
            "unadvertise": self._unadvertise,
            "publish": self._publish,
            **self._calls.operations,
        }

    async def run(self) -> None:
        """Serve until the connection ends."""
        sender = asyncio.create_task(self._send())
        try:
            async for data in self._connection:
                self.receive(data)
        finally:
            sender.cancel()
            self._close()
            for task in tuple(self._tasks):
                task.cancel()
            await asyncio.gather(sender, *self._tasks, return_exceptions=True)

    def receive(self, data: str | bytes) -> None:
        """Take a message; whatever is wrong with it is told, and nothing else happens."""
        try:
            self._read(data)
        except (HubError, FieldError, UnknownTypeError) as error:
            self.status("error", str(error))
        except Exception as error:
            # Nobody else shall suffer; whoever sees this should tell it to those who made the bridge.
            self.status("error", f"a fault of the bridge: {type(error).__name__}: {error}")

    def reply(self, message: dict[str, Any], fragment: int = 0) -> None:
        """Send a message soon, in order; a client with a thousand unread ones is cut off."""
        data = json.dumps(message, separators=(",", ":"), allow_nan=False)
        self._replies.extend(
            fragments(data, fragment, f"r{id(message)}") if fragment and len(data) > fragment else [data]
        )
        self._too_slow |= len(self._replies) > MOST_REPLIES
        self._ready.set()

    def status(self, level: str, words: str, number: object = None) -> None:
        """Tell the client how something went, if it wants to know that much."""
        if LEVELS[level] <= self._level:
            named = {"id": number} if isinstance(number, str | int) else {}
            self.reply({"op": "status", "level": level, "msg": words, **named})

    def start(self, work: Coroutine[Any, Any, None]) -> None:
        """Let something go on beside the others; raises HubError where too much of this client does."""
        if len(self._tasks) >= MOST_TASKS:
            work.close()
            raise HubError(f"{MOST_TASKS} calls and goals of this client are under way already")
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _read(self, data: str | bytes, *, inner: bool = False) -> None:
        op = decoded(data)
        name = op.get("op")
        operation = self._operations.get(name) if isinstance(name, str) else None
        if inner and name in ("fragment", "png"):
            raise HubError("fragments and pictures don't hold others")
        try:
            if operation is None:
                raise HubError(f"'op' is one of {', '.join(self._operations)}, not {str(name)[:40]!r}")
            if self._token and name != "auth":
                raise HubError("say the token first: {'op': 'auth', 'token': ...}, or /?token=... in the address")
            operation(op)
        except (HubError, FieldError, UnknownTypeError) as error:
            self.status("error", str(error), op.get("id"))

    def _auth(self, op: dict[str, Any]) -> None:
        if self._token and not hmac.compare_digest(text(op, "token").encode(), self._token.encode()):
            raise HubError("the token is another one")
        self._token = ""

    def _take_fragment(self, op: dict[str, Any]) -> None:
        if (whole := self._fragments.add(op)) is not None:
            self._read(whole, inner=True)

    def _set_level(self, op: dict[str, Any]) -> None:
        level = op.get("level")
        if not isinstance(level, str) or level not in LEVELS:
            raise HubError(f"'level' is one of {', '.join(LEVELS)}, not {str(level)[:40]!r}")
        self._level = LEVELS[level]

    def _subscribe(self, op: dict[str, Any]) -> None:
        name, key = topic_of(op), (topic_of(op), str(op.get("id", ""))[:200])
        before = self._subscriptions.get(key)
        if before is None and len(self._subscriptions) >= MOST_SUBSCRIPTIONS:
            raise HubError(f"{MOST_SUBSCRIPTIONS} subscriptions of this client are open already")
        if not op.get("type") and name not in self.hub.topics:
            raise HubError(f"there is no topic {name}; with a 'type' it is waited for")
        one = self.subscription(name, op, self._come)
        topic = self.hub.shared(name, known(op["type"]) if op.get("type") else self.hub.topics[name].type)
        self._subscriptions[key] = one
        one.end = self.hub.read(topic, one.take)
        if before is not None:
            before.end()

    def _unsubscribe(self, op: dict[str, Any]) -> None:
        name = topic_of(op)
        keys = [key for key in self._subscriptions if key[0] == name and ("id" not in op or key[1] == str(op["id"]))]
        for key in keys:
            self._subscriptions.pop(key).end()
        if not keys:
            self.status("warning", f"{name} is not subscribed to", op.get("id"))

    def _advertise(self, op: dict[str, Any]) -> None:
        topic = self.hub.shared(topic_of(op), known(op.get("type")))
        if topic.is_told and topic.take is None:
            self.hub.unadvertise(topic, self)
            raise HubError(f"{topic.name} is told by the world; nobody else publishes it")
        topic.writers.add(self)
        if not topic.is_told and topic.take is None:
            topic.latched |= op.get("latch") is True
        self._advertised.add(topic.name)

    def _unadvertise(self, op: dict[str, Any]) -> None:
        topic = self.hub.topics.get(topic_of(op))
        if topic is None or self not in topic.writers:
            return self.status("warning", f"{topic_of(op)} is not advertised", op.get("id"))
        self._advertised.discard(topic.name)
        self.hub.unadvertise(topic, self)

    def _publish(self, op: dict[str, Any]) -> None:
        name = topic_of(op)
        topic = self.hub.topics.get(name)
        if topic is None or (topic.take is None and not topic.is_told and self not in topic.writers):
            raise HubError(f"{name} is not advertised; say its type by 'advertise' first")
        loop = asyncio.get_running_loop()

        def refused(words: str) -> None:
            with suppress(RuntimeError):  # the bridge is ending
                loop.call_soon_threadsafe(self.status, "error", f"{name} does not take this: {words}", op.get("id"))

        try:
            self.hub.hear(topic, self._stamped(topic, op.get("msg", {})), refused)
        except FieldError as error:
            raise HubError(f"{name}: {error}") from error
        except ValueError as error:
            raise HubError(f"{name} does not take this: {error}") from error

    def _stamped(self, topic: Topic, value: object) -> RosValue:
        """Return a message, with the time that it is now where its header has none."""
        message = from_plain(topic.type, value)
        if isinstance(value, dict) and fields(topic.type).get("header", (0, ""))[1] == "std_msgs/msg/Header":
            if "stamp" not in (value.get("header") or {}):
                message.header.stamp = time_of(self.hub.now)
        return message

    def _come(self, one: Subscription) -> None:
        """Let what has come for a subscription go: at once where nothing else waits, else when it is its turn."""
        if not self._is_idle or self._ready.is_set() or not self._connection.is_free:
            return self._ready.set()
        if not (0 < one.size <= SMALL_BYTES and one.due(time.monotonic()) == 0.0):
            return self._ready.set()
        for data in one.packed():  # waking the sender takes longer than all this
            self._connection.put(data)

    async def _send(self) -> None:
        while True:
            self._ready.clear()
            if self._too_slow:
                return await self._connection.close(1008, "too many answers were not read")
            if self._replies:
                await self._connection.send(self._replies.popleft())
                continue
            now = time.monotonic()
            due = [(wait, one) for one in self._subscriptions.values() if (wait := one.due(now)) is not None]
            # What is small goes first: clock, joints and frames never wait behind pictures.
            if at_once := [one for wait, one in due if wait == 0.0]:
                for data in min(at_once, key=lambda one: one.size).packed():
                    await self._connection.send(data)
                continue
            if not due:
                self._is_idle = True
                await self._ready.wait()
                self._is_idle = False
                continue
            with suppress(TimeoutError):
                async with asyncio.timeout(min(wait for wait, _ in due)):
                    await self._ready.wait()

    def _close(self) -> None:
        for one in self._subscriptions.values():
            one.end()
        self._subscriptions.clear()
        for name in self._advertised:
            if (topic := self.hub.topics.get(name)) is not None:
                self.hub.unadvertise(topic, self)
        self._calls.close()


def topic_of(op: dict[str, Any]) -> str:
    """Return the name of a message's topic, which begins with a slash whether the client writes it or not."""
    return "/" + text(op, "topic").removeprefix("/")
