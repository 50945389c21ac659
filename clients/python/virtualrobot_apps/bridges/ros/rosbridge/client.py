"""The client of somebody's rosbridge_server: programs of that ROS get what the world tells, and reach what it hears.

The protocol is the same from both ends: what the server asks of those who have advertised a topic, a service or an
action is what a client asks of the server here, so a session answers it.

Source: ROSBRIDGE_PROTOCOL.md of rosbridge_suite (branch ros2).
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from virtualrobot_apps.bridges.ros.hub import ROSAPI, Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.rosbridge.connections import WebSocketConnection
from virtualrobot_apps.bridges.ros.rosbridge.session import Session
from virtualrobot_apps.bridges.ros.rosbridge.subscription import Subscription
from virtualrobot_apps.bridges.ros.rosbridge.wire import MOST_BYTES
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

AGAIN_SECONDS = 1.0
"""Time (s) after which a server that has gone is looked for again."""

_OPEN_SECONDS = 10.0
_MOST_SAID = 100


class RosbridgeClient(Transport):
    """Client of a server of rosbridge, which it looks for again whenever it has gone."""

    def __init__(self, url: str, *, token: str = "", say: Callable[[str], None] = print) -> None:
        """Connect to nothing yet; a token goes along as `Authorization: Bearer`, and `say` is told what happens."""
        self._url, self._say = url, say
        self._headers = {"Authorization": f"Bearer {token}"} if token else None
        self._task: asyncio.Task[None] | None = None

    async def open(self, hub: Hub) -> str:
        """Connect, and advertise what there is."""
        try:
            socket = await self._connect()
        except (OSError, TimeoutError, WebSocketException, ValueError) as error:
            raise TransportError(f"nobody speaks rosbridge at {self._url}: {error}") from error
        self._task = asyncio.create_task(self._keep(hub, socket))
        return f"client of rosbridge at {self._url}"

    async def close(self) -> None:
        """Leave the server, which forgets what was advertised."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    async def _connect(self) -> ClientConnection:
        return await connect(
            self._url,
            additional_headers=self._headers,
            open_timeout=_OPEN_SECONDS,
            max_size=MOST_BYTES,
            compression=None,
        )

    async def _keep(self, hub: Hub, socket: ClientConnection) -> None:
        while True:
            async with socket:
                with suppress(ConnectionClosed):
                    await _Link(hub, socket, self._say).run()
            self._say(f"{self._url} has gone; it is looked for again each {AGAIN_SECONDS:g} s")
            socket = await self._again()
            self._say(f"{self._url} is back")

    async def _again(self) -> ClientConnection:
        while True:
            await asyncio.sleep(AGAIN_SECONDS)
            with suppress(OSError, TimeoutError, WebSocketException):
                return await self._connect()


class _Told(Subscription):
    """Subscription of the server, which reads JSON by Python: infinity is a word, and `null` would be refused."""

    def _pack(self, message: Message) -> str:
        return f'{{"op":"publish","topic":{json.dumps(self.topic)},"msg":{message.json_with_infinity}}}'


class _Link(Session):
    """A session with a server: it has subscribed to what the world tells, and all is advertised to it."""

    subscription = _Told

    def __init__(self, hub: Hub, socket: ClientConnection, say: Callable[[str], None]) -> None:
        """Carry nothing yet."""
        super().__init__(hub, WebSocketConnection(socket))
        self._say = say
        self._said: set[str] = set()
        self._carried: set[tuple[type, str]] = set()
        self._operations["status"] = self._complained

    async def run(self) -> None:
        """Carry what the hub has, and what comes later, until the connection ends."""
        self.hub.changed.append(self._change)
        try:
            for one in (*self.hub.topics.values(), *self.hub.services.values(), *self.hub.actions.values()):
                self._change(one, True)
            await super().run()
        finally:
            self.hub.changed.remove(self._change)

    def status(self, level: str, words: str, number: object = None) -> None:
        """Say here what the server has sent wrong: it asked for nothing."""
        self._tell(f"from the server: {words}")

    def _complained(self, op: dict[str, Any]) -> None:
        if op.get("level") in ("error", "warning"):
            self._tell(f"the server says: {str(op.get('msg'))[:300]}")

    def _tell(self, words: str) -> None:
        """Say something once."""
        if words not in self._said and len(self._said) < _MOST_SAID:
            self._said.add(words)
            self._say(words)

    def _change(self, one: Topic | Service | Action, is_there: bool) -> None:
        """Carry what is there, and no more what has gone."""
        key = type(one), one.name
        if is_there == (key in self._carried) or one.name.startswith(ROSAPI):
            return
        match one:
            case Topic() if not is_there:
                told = any(topic == one.name for topic, _ in self._subscriptions)
                if told:
                    self._unsubscribe({"topic": one.name})
                self.reply({"op": "unadvertise" if told else "unsubscribe", "topic": one.name})
            case Topic(is_told=True):
                self.reply({"op": "advertise", "topic": one.name, "type": one.type, "latch": one.latched})
                self._subscribe({"op": "subscribe", "topic": one.name})
            case Topic() if one.take is not None:
                self.reply({"op": "subscribe", "topic": one.name, "type": one.type})
            case Topic():
                return  # one of other clients alone
            case Service():
                way = "advertise_service" if is_there else "unadvertise_service"
                self.reply({"op": way, "service": one.name, **({"type": one.type} if is_there else {})})
            case Action():
                way = "advertise_action" if is_there else "unadvertise_action"
                self.reply({"op": way, "action": one.name, **({"type": one.type} if is_there else {})})
        (self._carried.add if is_there else self._carried.discard)(key)
