"""ROS 1 without ROS: a hub as a node at a master, by XML-RPC and TCPROS; where there is no master it brings one.

Source: wiki.ros.org, "ROS/Slave_API", "ROS/Master_API", "ROS/TCPROS".
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

from virtualrobot_apps.bridges.ros.hub import ROSAPI, Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.ros1 import short
from virtualrobot_apps.bridges.ros.ros1.actions import ActionlibServer
from virtualrobot_apps.bridges.ros.ros1.connections import Incoming, Publication, serve_calls
from virtualrobot_apps.bridges.ros.ros1.master import BAD, GOOD, Master
from virtualrobot_apps.bridges.ros.ros1.tcpros import TcprosError, header, read_header
from virtualrobot_apps.bridges.ros.ros1.xmlrpc import XmlRpcError, XmlRpcServer, call
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

MASTER = "http://127.0.0.1:11311"
"""Address at which ROS 1 looks for its master."""

LOOK_SECONDS = 1.0
"""Time (s) after which it is seen whether the master still knows this node."""

_DESCRIPTION = "/robot_description"
_MOST_CONNECTIONS = 1000
_LOOPBACK = ("127.0.0.1", "localhost", "::1")


class Ros1Node(Transport):
    """A node of ROS 1 with the topics, services and actions of a world.

    Attributes:
        master: address of the master.
        name: name of the node.
    """

    def __init__(
        self,
        master: str = MASTER,
        host: str = "127.0.0.1",
        *,
        name: str = "/virtualrobot",
        say: Callable[[str], None] = print,
    ) -> None:
        """Join nothing yet; `host` is this machine as other nodes reach it, where it listens, and `say` is told."""
        self.master, self._host, self.name, self._say = master, host, name, say
        self._own: Master | None = None
        self._slave = XmlRpcServer(self._answer)
        self._told: dict[str, Publication] = {}
        self._heard: dict[str, Incoming] = {}
        self._services: dict[str, Service] = {}
        self._actions: dict[str, ActionlibServer] = {}
        self._registered: set[tuple[str, str, str]] = set()
        self._descriptions: dict[str, Callable[[], None]] = {}
        self._connections: set[asyncio.Task[None]] = set()
        self._tasks: set[asyncio.Task[None]] = set()
        self._changed = asyncio.Event()
        self._left = False

    async def open(self, hub: Hub) -> str:
        """Join the master, or bring one, with all that the hub has and what comes later."""
        self._hub = hub
        try:
            await self._slave.open(self._host, 0)
            self._server = await asyncio.start_server(self._connected, self._host, 0)
        except OSError as error:
            raise TransportError(f"ROS 1 can't be served at {self._host}: {error.strerror}") from error
        self._port = self._server.sockets[0].getsockname()[1]
        hub.changed.append(self._change)
        try:
            found = await self._find_master()
            for one in (*hub.topics.values(), *hub.services.values(), *hub.actions.values()):
                self._change(one, True)
            await self._reconcile()
        except (TransportError, XmlRpcError) as error:
            await self._end()
            raise TransportError(str(error)) from error
        self._keeping = asyncio.create_task(self._keep())
        return f"ROS 1: node {self.name} at {found}"

    async def close(self) -> None:
        """Leave the master."""
        self._keeping.cancel()
        await self._end()

    async def _end(self) -> None:
        await self._leave()
        if self._own is not None:
            await self._own.close()

    async def _find_master(self) -> str:
        """Return in words where the master is, whose parameter says that time is simulated where nothing says it."""
        place = urlsplit(self.master)
        if place.scheme != "http" or not place.hostname:
            raise TransportError(f"{self.master!r} is no address of a master: http://HOST:11311")
        try:
            known = await self._ask("lookupNode", self.name)
        except XmlRpcError as error:
            if place.hostname not in (*_LOOPBACK, self._host):
                raise TransportError(f"there is no master: {error}") from error
            self._own = Master(self._hub.parameters)
            try:
                await self._own.open(place.hostname, 11311 if place.port is None else place.port)
            except OSError as failed:
                raise TransportError(
                    f"{self.master}: {error}, and no master can be there: {failed.strerror}"
                ) from error
            self.master = self._own.uri
            return f"a master of its own, {self.master}"
        if known is not None:
            try:
                await call(known, "getPid", self.name)
            except XmlRpcError:
                pass  # it ended without a word; this one takes its place
            else:
                raise TransportError(f"the master {self.master} has a node {self.name} already, at {known}")
        if place.hostname not in _LOOPBACK and self._host in _LOOPBACK:
            raise TransportError(f"nodes of the master {self.master} can't reach {self._host}: say --ros1-host")
        if not await self._ask("hasParam", "/use_sim_time"):
            await self._ask("setParam", "/use_sim_time", True)
        return f"the master {self.master}"

    async def _ask(self, method: str, *arguments: object) -> Any:  # noqa: ANN401 whatever the master answers
        """Return what the master answers; None where it refuses."""
        answer = await call(self.master, method, self.name, *arguments)
        if not isinstance(answer, list) or len(answer) != 3:
            raise XmlRpcError(f"{self.master} is no master: it answers {str(answer)[:60]}")
        return answer[2] if answer[0] == GOOD else None

    def _change(self, one: Topic | Service | Action, is_there: bool) -> None:
        """Carry what is there, and no more what has gone."""
        if self._left or one.name.startswith(ROSAPI):
            return
        if isinstance(one, Topic):
            self._change_topic(one, is_there)
        elif isinstance(one, Service):
            if is_there:
                self._services[one.name] = one
            else:
                self._services.pop(one.name, None)
        elif is_there:
            server = self._actions[one.name] = ActionlibServer(one, lambda: self._hub.now)
            for topic in server.topics:
                self._change_topic(topic, True)
        elif (server := self._actions.pop(one.name, None)) is not None:
            server.close()
            for topic in server.topics:
                self._change_topic(topic, False)
        self._changed.set()

    def _change_topic(self, topic: Topic, is_there: bool) -> None:
        if not is_there:
            self._told.pop(topic.name, None)
            if (heard := self._heard.pop(topic.name, None)) is not None:
                heard.close()
            self._descriptions.pop(topic.name, lambda: None)()
        elif topic.is_told and topic.name not in self._told:
            self._told[topic.name] = Publication(self._hub, topic, self.name)
            if topic.name.endswith(_DESCRIPTION):
                # ROS 1 looks for descriptions among the parameters.
                self._descriptions[topic.name] = self._hub.read(topic, lambda one: self._describe(topic.name, one))
        elif topic.take is not None and topic.name not in self._heard:
            self._heard[topic.name] = Incoming(self._hub, topic, self.name, self._say)

    def _describe(self, name: str, message: Message) -> None:
        async def tell() -> None:
            try:
                await self._ask("setParam", name, getattr(message.value, "data", ""))
            except XmlRpcError:
                pass  # the master has gone; it is told when it is back

        self._start(tell())

    def _start(self, work: Any) -> None:  # noqa: ANN401 a coroutine
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _wanted(self) -> Iterator[tuple[str, str, str]]:
        for one in self._told.values():
            yield "Publisher", one.topic.name, short(one.topic.type)
        for one in self._heard.values():
            yield "Subscriber", one.topic.name, short(one.topic.type)
        for name in self._services:
            yield "Service", name, ""

    async def _keep(self) -> None:
        """Say to the master what has changed, and all of it when it has been gone."""
        gone = False
        while not self._left:
            try:
                async with asyncio.timeout(LOOK_SECONDS):
                    await self._changed.wait()
            except TimeoutError:
                pass
            self._changed.clear()
            try:
                known = await self._ask("lookupNode", self.name)
                if known != self._slave.uri and known is not None and self._registered:
                    self._say(f"another node is called {self.name} at {self.master}: this one has left ROS 1")
                    return await self._leave()
                if known is None and self._registered:
                    self._registered.clear()
                    for name, publication in self._told.items():
                        if name in self._descriptions and publication.topic.last is not None:
                            self._describe(name, publication.topic.last)
                await self._reconcile()
                if gone:
                    self._say(f"the master {self.master} is back")
                gone = False
            except XmlRpcError as error:
                if not gone:
                    self._say(f"{error}; it is tried again each {LOOK_SECONDS:g} s")
                gone = True

    async def _reconcile(self) -> None:
        """Register what the master doesn't know yet, and take away what has gone."""
        wanted = set(self._wanted())
        for one in sorted(self._registered - wanted):
            await self._unregister(*one)
        for kind, name, type in sorted(wanted - self._registered):
            if kind == "Service":
                await self._ask("registerService", name, self._service_place, self._slave.uri)
            else:
                others = await self._ask(f"register{kind}", name, type, self._slave.uri)
                if kind == "Subscriber" and name in self._heard:
                    self._heard[name].update(map(str, others or ()))
            self._registered.add((kind, name, type))

    async def _unregister(self, kind: str, name: str, type: str) -> None:
        place = self._service_place if kind == "Service" else self._slave.uri
        await self._ask(f"unregister{kind}", name, place)
        self._registered.discard((kind, name, type))

    @property
    def _service_place(self) -> str:
        return f"rosrpc://{self._host}:{self._port}"

    async def _leave(self) -> None:
        if self._left:
            return
        self._left = True
        self._hub.changed.remove(self._change)
        try:
            for one in sorted(self._registered):
                await self._unregister(*one)
        except XmlRpcError:
            pass  # the master has gone
        for end in self._descriptions.values():
            end()
        for one in (*self._heard.values(), *self._actions.values()):
            one.close()
        self._server.close()
        for task in (*self._connections, *self._tasks):
            task.cancel()
        await asyncio.gather(*self._connections, *self._tasks, return_exceptions=True)
        await self._slave.close()

    async def _answer(self, method: str, arguments: tuple[Any, ...]) -> list[object]:
        """Answer what the master and other nodes ask."""
        caller, *asked = arguments
        match method, asked:
            case "requestTopic", [str() as name, list() as protocols]:
                if name not in self._told:
                    return [BAD, f"{self.name} does not publish {name[:80]}", 0]
                if not any(one[:1] == ["TCPROS"] for one in protocols if isinstance(one, list)):
                    return [BAD, "TCPROS is the one that is spoken", 0]
                return [GOOD, "", ["TCPROS", self._host, self._port]]
            case "publisherUpdate", [str() as name, list() as uris]:
                if name in self._heard:
                    self._heard[name].update(one for one in map(str, uris) if one != self._slave.uri)
                return [GOOD, "", 0]
            case "getPublications", []:
                return [GOOD, "", [[one.topic.name, short(one.topic.type)] for one in self._told.values()]]
            case "getSubscriptions", []:
                return [GOOD, "", [[one.topic.name, short(one.topic.type)] for one in self._heard.values()]]
            case "getBusInfo", []:
                return [GOOD, "", self._links()]
            case "getBusStats", []:
                return [GOOD, "not counted", [[], [], []]]
            case "getMasterUri", []:
                return [GOOD, "", self.master]
            case "getPid", []:
                return [GOOD, "", os.getpid()]
            case "paramUpdate", [_, _]:
                return [GOOD, "", 0]
            case "shutdown", _:
                self._say(f"{str(caller)[:60]} has ended {self.name}: ROS 1 is left")
                self._start(self._leave_later())
                return [GOOD, "", 0]
        raise ValueError(f"there is no method {method[:60]!r} that takes {len(asked)} arguments")

    async def _leave_later(self) -> None:
        await asyncio.sleep(0.1)  # the answer goes out first
        self._tasks.clear()  # this one among them: it goes on
        await self._leave()

    def _links(self) -> list[list[object]]:
        found: list[list[object]] = []
        for one in self._told.values():
            found += [[0, node, "o", "TCPROS", one.topic.name, 1] for node in one.readers.values()]
        for one in self._heard.values():
            found += [[0, uri, "i", "TCPROS", one.topic.name, 1] for uri in one.publishers]
        return [[number, *link[1:]] for number, link in enumerate(found)]

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a connection of TCPROS: somebody who reads a topic, or calls a service."""
        task = asyncio.current_task()
        assert task is not None
        self._connections.add(task)
        try:
            if len(self._connections) > _MOST_CONNECTIONS:
                raise TcprosError(f"there are {_MOST_CONNECTIONS} connections already")
            fields = await read_header(reader)
            if (service := self._services.get(fields.get("service", ""))) is not None:
                await serve_calls(service, self.name, reader, writer, fields)
            elif (told := self._told.get(fields.get("topic", ""))) is not None:
                await told.serve(reader, writer, fields)
            else:
                name = fields.get("topic") or fields.get("service") or ""
                raise TcprosError(f"{self.name} has no topic and no service {name[:80]!r}")
        except TcprosError as error:
            writer.write(header({"error": str(error)}))
        except (OSError, EOFError):
            pass  # it has gone
        finally:
            self._connections.discard(task)
            writer.close()
