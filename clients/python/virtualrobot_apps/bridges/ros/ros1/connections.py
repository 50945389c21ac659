"""Topics and services of a hub over TCPROS: who reads a topic, whom it is read from, who calls."""

from __future__ import annotations

import asyncio
import struct
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress

from virtualrobot_apps.bridges.ros.hub import Hub, HubError, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.ros1 import definition_of, from_ros1_bytes, md5_of, ros1_bytes, short
from virtualrobot_apps.bridges.ros.ros1.tcpros import (
    MOST_MESSAGE,
    TcprosError,
    block,
    header,
    read_block,
    read_header,
)
from virtualrobot_apps.bridges.ros.ros1.xmlrpc import XmlRpcError, call

QUEUE, SMALL_QUEUE = 100, 5
"""Messages that wait for a reader, and of a topic whose newest counts."""

AGAIN_SECONDS = 1.0
"""Time (s) after which a publisher that does not answer is asked again."""

ANY = "*"
"""MD5 sum and type of who takes all, such as `rostopic`."""


def check_type(name: str, type: str, fields: dict[str, str]) -> None:
    """Raise TcprosError where a peer means another type by a topic or a service."""
    wanted, sum = fields.get("type", ANY), fields.get("md5sum", ANY)
    if sum not in (ANY, md5_of(type)):
        raise TcprosError(
            f"{name} has the type {short(type)} with the MD5 sum {md5_of(type)}, not {wanted[:80]} with {sum[:80]}"
        )


class Publication:
    """A topic and those who read it; what is latched they get at once."""

    def __init__(self, hub: Hub, topic: Topic, node: str) -> None:
        """Have no reader yet."""
        self._hub, self.topic, self._node = hub, topic, node
        self.readers: dict[asyncio.StreamWriter, str] = {}

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, fields: dict[str, str]) -> None:
        """Tell a reader all that comes, until it has gone."""
        topic = self.topic
        check_type(topic.name, topic.type, fields)
        told = {
            "callerid": self._node,
            "topic": topic.name,
            "type": short(topic.type),
            "md5sum": md5_of(topic.type),
            "latching": str(int(topic.latched)),
            "message_definition": definition_of(topic.type),
        }
        writer.write(header(told))
        depth = 1 if topic.latched else QUEUE if topic.reliable else SMALL_QUEUE
        waiting: deque[Message] = deque(maxlen=depth)
        some = asyncio.Event()

        def take(message: Message) -> None:
            waiting.append(message)
            some.set()

        async def write() -> None:
            while True:
                await some.wait()
                some.clear()
                while waiting:
                    writer.write(block(waiting.popleft().ros1))
                    await writer.drain()

        self.readers[writer] = fields.get("callerid", "")
        end = self._hub.read(topic, take)
        writing = asyncio.create_task(write())
        try:
            gone = asyncio.create_task(_gone(reader))
            await asyncio.wait((gone, writing), return_when=asyncio.FIRST_COMPLETED)
            gone.cancel()
        finally:
            writing.cancel()
            end()
            del self.readers[writer]


async def _gone(reader: asyncio.StreamReader) -> None:
    """Return when a peer that has nothing to say has gone."""
    with suppress(OSError):
        while await reader.read(1 << 10):
            pass


class Incoming:
    """A topic that the world hears, and those who publish it; each is followed until the master takes it away."""

    def __init__(self, hub: Hub, topic: Topic, node: str, say: Callable[[str], None]) -> None:
        """Follow nobody yet; what nobody can be told is said once."""
        self._hub, self.topic, self._node, self._say = hub, topic, node, say
        self.publishers: dict[str, asyncio.Task[None]] = {}
        self._said: set[str] = set()

    def update(self, uris: Iterable[str]) -> None:
        """Follow these publishers, and no others."""
        wanted = set(uris)
        for uri in [one for one in self.publishers if one not in wanted]:
            self.publishers.pop(uri).cancel()
        for uri in wanted - self.publishers.keys():
            self.publishers[uri] = asyncio.create_task(self._follow(uri))

    def close(self) -> None:
        """Follow nobody any more."""
        self.update(())

    async def _follow(self, uri: str) -> None:
        while True:
            try:
                await self._read(uri)
            except TcprosError as error:
                self._tell(f"{self.topic.name} is not heard from {uri}: {error}")
            except (OSError, EOFError, XmlRpcError):
                pass  # it has gone, or begins; the master says when it is no more
            await asyncio.sleep(AGAIN_SECONDS)

    async def _read(self, uri: str) -> None:
        answer = await call(uri, "requestTopic", self._node, self.topic.name, [["TCPROS"]])
        try:
            code, words, (_, host, port) = answer
            host, port = str(host), int(port)
        except (TypeError, ValueError) as error:
            raise TcprosError(f"it offers no TCPROS but {str(answer)[:100]}") from error
        if code != 1:
            raise TcprosError(str(words)[:200])
        reader, writer = await asyncio.open_connection(host, port)
        try:
            type = self.topic.type
            told = {
                "callerid": self._node,
                "topic": self.topic.name,
                "type": short(type),
                "md5sum": md5_of(type),
                "message_definition": definition_of(type),
                "tcp_nodelay": "1",
            }
            writer.write(header(told))
            fields = await read_header(reader)
            if "error" in fields:
                raise TcprosError(fields["error"][:200])
            check_type(self.topic.name, type, fields)
            while True:
                self._hear(uri, await read_block(reader, MOST_MESSAGE))
        finally:
            writer.close()

    def _hear(self, uri: str, data: bytes) -> None:
        try:
            self._hub.hear(self.topic, from_ros1_bytes(self.topic.type, data))
        except (HubError, ValueError) as error:
            self._tell(f"{self.topic.name} from {uri}: {error}")
        except Exception as error:  # bytes of another type: rosbags raises whatever it likes
            self._tell(f"{self.topic.name} from {uri}: no message of {short(self.topic.type)}: {error}")

    def _tell(self, words: str) -> None:
        if words not in self._said and len(self._said) < QUEUE:
            self._said.add(words)
            self._say(words)


async def serve_calls(
    service: Service, node: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, fields: dict[str, str]
) -> None:
    """Answer calls of a service over a connection: one, or as many as come where the caller wants to keep it."""
    type = service.type
    check_type(service.name, type, fields)
    told = {
        "callerid": node,
        "type": short(type),
        "md5sum": md5_of(type),
        "request_type": f"{short(type)}Request",
        "response_type": f"{short(type)}Response",
    }
    writer.write(header(told))
    await writer.drain()
    while fields.get("probe") != "1":
        request = await read_block(reader, MOST_MESSAGE)
        try:
            answer = await service.answer(from_ros1_bytes(f"{type}_Request", request))
            good, data = True, ros1_bytes(f"{type}_Response", answer)
        except Exception as error:  # whatever a service raises, and rosbags for bytes of another type
            good, data = False, (str(error) or repr(error)).encode()
        writer.write(struct.pack("B", good) + block(data))
        await writer.drain()
        if fields.get("persistent") != "1":
            return
