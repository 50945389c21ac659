"""DDS without ROS: a hub as a node of ROS 2, by Cyclone DDS, in the bytes that other transports share.

Services and actions are those of ROS 2 on rmw_cyclonedds. On Fast DDS it tells answers apart by identities that Cyclone
can't write, and a service that seems to be there and never answers is worse than none: they are offered on request.
"""

from __future__ import annotations

import asyncio
import itertools
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from cyclonedds.core import DDSException, Listener, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from virtualrobot_apps.bridges.ros.action_server import ActionServer, change_action
from virtualrobot_apps.bridges.ros.dds.services import DdsService
from virtualrobot_apps.bridges.ros.dds.types import Heard, Matched, hashed, idl_type, quality
from virtualrobot_apps.bridges.ros.hub import ROSAPI, Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import STORE, make
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

GRAPH, GRAPH_TYPE = "ros_discovery_info", "rmw_dds_common/msg/ParticipantEntitiesInfo"
"""Topic by which ROS 2 tells which node readers and writers belong to."""

QUEUE, SMALL_QUEUE = 100, 5
"""Messages of a topic that wait to be written, and of one whose newest counts."""


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
        services: whether services and actions are offered, too, to ROS 2 on rmw_cyclonedds.
    """

    domain: int = 0
    name: str = "virtualrobot"
    services: bool = False
    _written: dict[str, _Written] = field(default_factory=dict)
    _read: dict[str, DataReader] = field(default_factory=dict)
    _served: dict[str, DdsService] = field(default_factory=dict)
    _actions: dict[str, ActionServer] = field(default_factory=dict)

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
            self._participant, DdsTopic(self._participant, GRAPH, raw), qos=told + hashed(GRAPH_TYPE)
        )
        self._numbers = itertools.count(1)
        hub.changed.append(self._changed)
        for one in (*hub.topics.values(), *hub.services.values(), *hub.actions.values()):
            self._change(one, True)
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
        for one in (*self._served.values(), *self._actions.values()):
            one.close()
        for table in (self._written, self._read, self._served, self._actions):
            table.clear()
        del self._graph, self._participant

    def _changed(self, one: Topic | Service | Action, is_there: bool) -> None:
        if self._change(one, is_there):
            self._tell_graph()

    def _change(self, one: Topic | Service | Action, is_there: bool) -> bool:
        """Carry what is there, and no more what has gone; return whether it is carried at all."""
        if isinstance(one, Topic):
            if is_there:
                self._add(one)
            else:
                self._remove(one.name)
            return True
        if not self.services or one.name.startswith(ROSAPI):
            return False
        if isinstance(one, Action):
            change_action(self._actions, one, is_there, self._hub, self._change)
        elif is_there:
            identity = f"{self._participant.guid.hex}.{next(self._numbers)}"
            self._served[one.name] = DdsService(self._participant, one, identity)
        elif (served := self._served.pop(one.name, None)) is not None:
            served.close()
        return True

    def _add(self, topic: Topic) -> None:
        name, type = f"rt{topic.name}", topic.type
        if topic.is_told and topic.name not in self._written:
            depth = QUEUE if topic.reliable else SMALL_QUEUE
            qos = quality(latched=topic.latched, depth=1 if topic.latched else depth)
            listener = Matched(lambda count: self._loop.call_soon_threadsafe(self._wanted, topic, count > 0))
            place = DdsTopic(self._participant, name, idl_type(type, raw=True))
            writer = DataWriter(self._participant, place, qos=qos + hashed(type), listener=listener)
            self._written[topic.name] = _Written(writer, listener, deque(maxlen=depth))
        elif topic.take is not None and topic.name not in self._read:
            listener = Heard(lambda cdr, _: self._loop.call_soon_threadsafe(self._hub.hear_cdr, topic, cdr))
            place = DdsTopic(self._participant, name, idl_type(type, raw=True))
            # Best effort meets writers of both kinds, and of a command the newest counts.
            qos = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(1))
            self._read[topic.name] = DataReader(self._participant, place, qos=qos + hashed(type), listener=listener)

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

    def _tell_graph(self) -> None:
        """Say which node readers and writers belong to; without it they belong to none that ROS 2 lists."""

        def gid(entity: Any) -> Any:  # noqa: ANN401 any entity of Cyclone
            return make("rmw_dds_common/msg/Gid", data=np.frombuffer(entity.guid.bytes, np.uint8))

        served = self._served.values()
        node = make(
            "rmw_dds_common/msg/NodeEntitiesInfo",
            node_namespace="/",
            node_name=self.name,
            reader_gid_seq=[gid(one) for one in (*self._read.values(), *(one.reader for one in served))],
            writer_gid_seq=[gid(one.writer) for one in (*self._written.values(), *served)],
        )
        info = make(GRAPH_TYPE, gid=gid(self._participant), node_entities_info_seq=[node])
        self._graph.write(idl_type(GRAPH_TYPE, raw=True)(bytes(STORE.serialize_cdr(info, GRAPH_TYPE))))
