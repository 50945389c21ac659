"""DDS without ROS: topics of a hub as a node of ROS 2, by Cyclone DDS, in the bytes that other transports share.

Services and actions are not offered: ROS 2 on Fast DDS tells answers apart by identities that Cyclone can't write, and
a service that seems to be there and never answers is worse than none.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from cyclonedds.core import DDSException, Listener, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic
from cyclonedds.util import duration

from virtualrobot_apps.bridges.ros.hub import Action, Hub, HubError, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import ARRAY, BASE, MESSAGE, STORE, Description, fields, hash_of, make
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

GRAPH, GRAPH_TYPE = "ros_discovery_info", "rmw_dds_common/msg/ParticipantEntitiesInfo"
"""Topic by which ROS 2 tells which node readers and writers belong to."""

QUEUE, SMALL_QUEUE = 100, 5
"""Messages of a topic that wait to be written, and of one whose newest counts."""

_BLOCKING_MILLISECONDS = 100
_BASES: dict[str, Any] = {"bool": bool, "string": str, "wstring": str, "byte": types.byte, "char": types.uint8}
_BASES |= {
    name: getattr(types, name)
    for name in ("float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")
}
_made: dict[tuple[str, bool], Any] = {}


def idl_type(name: str, *, raw: bool = False) -> Any:  # noqa: ANN401 a class that is made of a definition
    """Return the IDL type of a message, so that what discovery tells of it is true.

    A `raw` one is made from bytes and read as bytes: Cyclone's own coder, in Python, takes 50 ms for a picture.
    """
    if (name, raw) not in _made:
        package, kind, base = name.split("/")
        members = {key: _member(one) for key, one in fields(name).items()}
        made = make_idl_struct(f"{base}_", f"{package}.{kind}.dds_.{base}_", members)
        if raw:
            _make_raw(made)
        _made[name, raw] = made
    return _made[name, raw]


def _make_raw(made: Any) -> None:  # noqa: ANN401
    def begin(self: IdlStruct, cdr: bytes) -> None:
        self.cdr = cdr  # pyright: ignore[reportAttributeAccessIssue]

    def message(kind: Any, data: bytes, *_: object, **__: object) -> Any:  # noqa: ANN401
        return kind(bytes(data))

    def end(kind: Any, *_: object, **__: object) -> Any:  # noqa: ANN401
        return kind(b"")  # the end of a writer tells a key alone, and is no message

    made.__init__ = begin
    made.serialize = lambda self, *_, **__: self.cdr
    made.deserialize, made.deserialize_key = classmethod(message), classmethod(end)


def _member(one: Description) -> Any:  # noqa: ANN401
    kind, detail = int(one[0]), one[1]
    if kind == BASE:
        return _BASES[detail[0]]
    if kind == MESSAGE:
        return idl_type(detail)
    inner = _member(detail[0])
    return types.array[inner, detail[1]] if kind == ARRAY else types.sequence[inner]


def quality(*, latched: bool, depth: int) -> Qos:
    """Return the quality of service of a topic: reliable, which all readers may read; latched: transient local."""
    durability = Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile
    reliability = Policy.Reliability.Reliable(duration(milliseconds=_BLOCKING_MILLISECONDS))
    return Qos(reliability, durability, Policy.History.KeepLast(depth))


@dataclass
class _Written:
    """A topic that is written while somebody in the domain reads it; its listener is kept alive here."""

    writer: DataWriter
    listener: Listener
    waiting: deque[Message]
    end: Callable[[], None] | None = None


@dataclass
class DdsNode(Transport):
    """A node of ROS 2 with the topics of a world; QoS as data: reliable, `/tf_static` and descriptions transient local.

    Attributes:
        domain: number of the domain, as in ROS_DOMAIN_ID.
        name: name of the node.
    """

    domain: int = 0
    name: str = "virtualrobot"
    _written: dict[str, _Written] = field(default_factory=dict)
    _read: dict[str, DataReader] = field(default_factory=dict)

    async def open(self, hub: Hub) -> str:
        """Join the domain with all topics that the hub has, and those that come later."""
        self._hub, self._loop = hub, asyncio.get_running_loop()
        try:
            self._participant = DomainParticipant(self.domain)
        except DDSException as error:
            raise TransportError(f"the DDS domain {self.domain} can't be joined: {error}") from error
        self._work = threading.Condition()
        self._closed = False
        raw = idl_type(GRAPH_TYPE, raw=True)
        told = quality(latched=True, depth=1)
        self._graph = DataWriter(
            self._participant, DdsTopic(self._participant, GRAPH, raw), qos=told + _hashed(GRAPH_TYPE)
        )
        hub.changed.append(self._changed)
        for topic in tuple(hub.topics.values()):
            self._add(topic)
        self._tell_graph()
        self._thread = threading.Thread(target=self._write, name="DDS", daemon=True)
        self._thread.start()
        return f"DDS domain {self.domain}: node /{self.name}"

    async def close(self) -> None:
        """Leave the domain."""
        self._hub.changed.remove(self._changed)
        with self._work:
            self._closed = True
            self._work.notify()
        await asyncio.to_thread(self._thread.join)
        for one in self._written.values():
            if one.end is not None:
                one.end()
        self._written.clear()
        self._read.clear()
        del self._graph, self._participant

    def _changed(self, one: Topic | Service | Action, is_there: bool) -> None:
        if not isinstance(one, Topic):
            return
        if is_there:
            self._add(one)
        else:
            self._remove(one.name)
        self._tell_graph()

    def _add(self, topic: Topic) -> None:
        name, type = f"rt{topic.name}", topic.type
        if topic.is_told and topic.name not in self._written:
            depth = QUEUE if topic.reliable else SMALL_QUEUE
            qos = quality(latched=topic.latched, depth=1 if topic.latched else depth)
            listener = _Matched(lambda count: self._loop.call_soon_threadsafe(self._wanted, topic, count > 0))
            place = DdsTopic(self._participant, name, idl_type(type, raw=True))
            writer = DataWriter(self._participant, place, qos=qos + _hashed(type), listener=listener)
            self._written[topic.name] = _Written(writer, listener, deque(maxlen=depth))
        elif topic.take is not None and topic.name not in self._read:
            listener = _Heard(lambda cdr: self._loop.call_soon_threadsafe(self._hear, topic, cdr))
            place = DdsTopic(self._participant, name, idl_type(type, raw=True))
            # Best effort meets writers of both kinds, and of a command the newest counts.
            qos = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(1))
            self._read[topic.name] = DataReader(self._participant, place, qos=qos + _hashed(type), listener=listener)

    def _remove(self, name: str) -> None:
        if (written := self._written.pop(name, None)) is not None and written.end is not None:
            written.end()
        self._read.pop(name, None)

    def _wanted(self, topic: Topic, wanted: bool) -> None:
        """Read a topic while somebody in the domain does; what is latched is read once, and kept by its writer."""
        written = self._written.get(topic.name)
        if written is None or wanted == (written.end is not None):
            return
        if wanted:

            def take(message: Message) -> None:
                with self._work:
                    written.waiting.append(message)
                    self._work.notify()

            written.end = self._hub.read(topic, take)
        elif written.end is not None:
            written.end()
            written.end = None

    def _write(self) -> None:
        """Write what waits, what is small first; the queue of a slow reader loses the oldest."""
        while True:
            with self._work:
                while not self._closed and not (due := [one for one in self._written.values() if one.waiting]):
                    self._work.wait()
                if self._closed:
                    return
            for one in due:
                message = one.waiting.popleft()
                try:
                    one.writer.write(idl_type(message.type, raw=True)(message.cdr))
                except DDSException:
                    continue  # a reader that asks for each one has been too slow for 100 ms

    def _hear(self, topic: Topic, cdr: bytes) -> None:
        try:
            self._hub.hear(topic, Message.from_cdr(topic.type, cdr).value)
        except (HubError, ValueError):
            pass  # ROS 2 has no way to tell the writer
        except Exception:
            pass  # bytes of another type: rosbags raises whatever it likes

    def _tell_graph(self) -> None:
        """Say which node readers and writers belong to; without it they belong to none that ROS 2 lists."""

        def gid(entity: Any) -> Any:  # noqa: ANN401 any entity of Cyclone
            return make("rmw_dds_common/msg/Gid", data=np.frombuffer(entity.guid.bytes, np.uint8))

        node = make(
            "rmw_dds_common/msg/NodeEntitiesInfo",
            node_namespace="/",
            node_name=self.name,
            reader_gid_seq=[gid(one) for one in self._read.values()],
            writer_gid_seq=[gid(one.writer) for one in self._written.values()],
        )
        info = make(GRAPH_TYPE, gid=gid(self._participant), node_entities_info_seq=[node])
        self._graph.write(idl_type(GRAPH_TYPE, raw=True)(bytes(STORE.serialize_cdr(info, GRAPH_TYPE))))


def _hashed(name: str) -> Qos:
    """Return the user data by which ROS 2 knows the hash of a type (REP 2016)."""
    return Qos(Policy.Userdata(f"typehash={hash_of(name)};".encode()))


class _Matched(Listener):
    """Listener of a writer, called in a thread of Cyclone's with the count of readers."""

    def __init__(self, tell: Callable[[int], object]) -> None:
        super().__init__()
        self._tell = tell

    def on_publication_matched(self, writer: Any, status: Any) -> None:  # noqa: ANN401
        self._tell(status.current_count)


class _Heard(Listener):
    """Listener of a reader, called in a thread of Cyclone's with the bytes of each message."""

    def __init__(self, tell: Callable[[bytes], object]) -> None:
        super().__init__()
        self._tell = tell

    def on_data_available(self, reader: Any) -> None:  # noqa: ANN401
        for one in reader.take(32):
            if cdr := getattr(one, "cdr", b""):
                self._tell(cdr)
