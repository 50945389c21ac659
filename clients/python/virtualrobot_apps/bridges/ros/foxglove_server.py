"""Foxglove: topics of a hub as channels of a Foxglove server, in the bytes that other transports share."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any

import foxglove
from foxglove.websocket import ServerListener

from virtualrobot_apps.bridges.ros.hub import Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import text_of
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

PORT = 8765
"""The port that Foxglove takes."""


class FoxgloveServer(Transport):
    """Server for Foxglove and Lichtblick on this machine: it is read, and takes nothing; what nobody shows isn't read.

    Attributes:
        port: where it serves, once it is open.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = PORT) -> None:
        """Serve nothing yet; port 0 is any free one."""
        self._host, self.port = host, port
        self._channels: dict[str, foxglove.Channel] = {}
        self._readers: dict[str, int] = {}
        self._ends: dict[str, Callable[[], None]] = {}

    async def open(self, hub: Hub) -> str:
        """Serve the topics that the world tells, those that come later among them."""
        self._hub, self._context = hub, foxglove.Context()
        try:
            self._server = foxglove.start_server(
                name="virtualrobot",
                host=self._host,
                port=self.port,
                context=self._context,
                server_listener=_Listener(asyncio.get_running_loop(), self._count),
            )
        except Exception as error:  # the SDK raises a bare one
            raise TransportError(f"Foxglove can't be served at {self._host}:{self.port}: {error}") from error
        self.port = self._server.port
        hub.changed.append(self._changed)
        for topic in tuple(hub.topics.values()):
            self._changed(topic, True)
        return f"Foxglove at ws://{self._host}:{self.port}"

    async def close(self) -> None:
        """Cut all off."""
        self._hub.changed.remove(self._changed)
        for end in self._ends.values():
            end()
        await asyncio.to_thread(self._server.stop)

    def _changed(self, one: Topic | Service | Action, is_there: bool) -> None:
        if not isinstance(one, Topic):
            return
        if is_there and one.is_told and one.name not in self._channels:
            schema = foxglove.Schema(name=one.type, encoding="ros2msg", data=text_of(one.type).encode())
            self._channels[one.name] = foxglove.Channel(
                one.name, schema=schema, message_encoding="cdr", context=self._context
            )
        elif not is_there and one.name in self._channels:
            self._ends.pop(one.name, lambda: None)()
            self._readers.pop(one.name, None)
            self._channels.pop(one.name).close()

    def _count(self, name: str, change: int) -> None:
        """Count the readers of a topic; with the first one it is read, and who comes later gets what is latched."""
        topic = self._hub.topics.get(name)
        if topic is None or name not in self._channels:
            return
        before = self._readers.get(name, 0)
        now = self._readers[name] = max(0, before + change)
        if before == 0 and now > 0:
            self._ends[name] = self._hub.read(topic, partial(self._log, self._channels[name]))
        elif now == 0 and name in self._ends:
            self._ends.pop(name)()
        elif change > 0 and topic.last is not None:
            self._log(self._channels[name], topic.last)

    def _log(self, channel: foxglove.Channel, message: Message) -> None:
        channel.log(message.cdr, log_time=message.time)


class _Listener(ServerListener):
    """Listener of subscriptions, called in threads of the SDK's."""

    def __init__(self, loop: asyncio.AbstractEventLoop, count: Callable[[str, int], None]) -> None:
        self._loop, self._tell = loop, count

    def on_subscribe(self, client: Any, channel: Any) -> None:  # noqa: ANN401
        self._soon(channel.topic, 1)

    def on_unsubscribe(self, client: Any, channel: Any) -> None:  # noqa: ANN401
        self._soon(channel.topic, -1)

    def _soon(self, topic: str, change: int) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._tell, topic, change)
