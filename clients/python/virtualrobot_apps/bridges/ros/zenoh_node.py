"""Zenoh without ROS: a hub as a node of ROS 2 on rmw_zenoh, in the bytes that other transports share.

Source: rmw_zenoh_cpp (branch jazzy), docs/design.md, liveliness_utils.cpp and attachment_helpers.cpp: names of keys,
tokens by which nodes and their ends are known, and what goes along with a message.
"""

from __future__ import annotations

import asyncio
import hashlib
import itertools
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import zenoh
import zenoh.ext

from virtualrobot_apps.bridges.ros.action_server import ActionServer, change_action
from virtualrobot_apps.bridges.ros.hub import ROSAPI, Action, Hub, HubError, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import hash_of, hash_of_service
from virtualrobot_apps.bridges.ros.messages.values import refusal
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

ROUTER = "tcp/localhost:7447"
"""The router of rmw_zenoh, by which nodes find each other."""

MOST_CALLS, DEPTH = 64, 10
"""Calls of a service that go on at once, and the depth of queues that is told."""

_TOKENS = "@ros2_lv"
_KIND, _NAME = 5, 9
"""Places in a token: of which kind an end is (MP and MS publish and subscribe, SS serves), and its mangled name."""
_ATTACHMENT = struct.Struct("<qqB16s")
"""Behind a message: its number, the wall clock (ns), and who tells it, with a length."""


def dds_name(type: str) -> str:
    """Return the name of a type as ROS 2 writes it for its middleware: `std_msgs::msg::dds_::String_`."""
    package, kind, base = type.split("/")
    return f"{package}::{kind}::dds_::{base}_"


def key_of(domain: int, name: str, type: str) -> str:
    """Return the key of a topic or a service."""
    return f"{domain}/{name.strip('/')}/{dds_name(type)}/{_hash(type)}"


def _hash(type: str) -> str:
    return hash_of(type) if "/msg/" in type or type.endswith("_FeedbackMessage") else hash_of_service(type)


@dataclass
class _Told:
    """A topic that is told while somebody reads it: `readers` are the tokens of those who do."""

    topic: Topic
    publisher: Any
    token: Any
    gid: bytes
    readers: set[str] = field(default_factory=set)
    numbers: itertools.count[int] = field(default_factory=lambda: itertools.count(1))
    end: Callable[[], None] | None = None


class ZenohNode(Transport):
    """A node of ROS 2 on rmw_zenoh with the topics, services and actions of a world.

    Attributes:
        router: address of the router.
        domain: number of the domain, as in ROS_DOMAIN_ID.
        name: name of the node.
    """

    def __init__(self, router: str = ROUTER, domain: int = 0, *, name: str = "virtualrobot") -> None:
        """Join nothing yet."""
        self.router, self.domain, self.name = router, domain, name
        self._numbers = itertools.count(0)
        self._told: dict[str, _Told] = {}
        self._others: dict[str, tuple[Any, ...]] = {}
        self._readers: dict[str, set[str]] = {}
        self._actions: dict[str, ActionServer] = {}
        self._calls: set[asyncio.Task[None]] = set()

    async def open(self, hub: Hub) -> str:
        """Join with all that the hub has, and what comes later; a router that is not there yet is looked for."""
        self._hub, self._loop = hub, asyncio.get_running_loop()
        try:
            config = zenoh.Config()
            for key, value in {
                "mode": '"peer"',
                "connect/endpoints": f'["{self.router}"]',
                "connect/timeout_ms": "-1",
                "connect/exit_on_failure": "false",
                "listen/endpoints": '["tcp/localhost:0"]',
                "scouting/multicast/enabled": "false",
                "timestamping/enabled": "true",  # caches of what is latched need it
            }.items():
                config.insert_json5(key, value)
            self._session = await asyncio.to_thread(zenoh.open, config)
        except zenoh.ZError as error:
            raise TransportError(f"zenoh can't join at {self.router}: {error}") from error
        self._place = f"{_TOKENS}/{self.domain}/{self._session.info.zid()}/{next(self._numbers)}"
        liveliness = self._session.liveliness()
        self._node = liveliness.declare_token(f"{self._place}/0/NN/%/%/{self.name}")
        hub.changed.append(self._change)
        for one in (*hub.topics.values(), *hub.services.values(), *hub.actions.values()):
            self._change(one, True)
        self._watch = liveliness.declare_subscriber(
            f"{_TOKENS}/{self.domain}/*/*/*/MS/**",
            lambda sample: self._soon(self._seen, str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT),
            history=True,
        )
        there = "" if list(self._session.info.routers_zid()) else "; nobody is there yet"
        return f"zenoh domain {self.domain}: node /{self.name}, router {self.router}{there}"

    async def close(self) -> None:
        """Leave."""
        self._hub.changed.remove(self._change)
        for one in self._told.values():
            if one.end is not None:
                one.end()
        for server in self._actions.values():
            server.close()
        for task in self._calls:
            task.cancel()
        await asyncio.gather(*self._calls, return_exceptions=True)
        await asyncio.to_thread(self._session.close)  # pyright: ignore[reportArgumentType] made by a macro

    def _soon(self, call: Callable[..., object], *arguments: object) -> None:
        """Let the hub's loop call something, from a thread of zenoh's."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(call, *arguments)

    def _change(self, one: Topic | Service | Action, is_there: bool) -> None:
        """Carry what is there, and no more what has gone."""
        if one.name.startswith(ROSAPI):
            return
        if isinstance(one, Action):
            change_action(self._actions, one, is_there, self._hub, self._change)
        elif not is_there:
            if (told := self._told.pop(one.name, None)) is not None:
                if told.end is not None:
                    told.end()
                _undeclare(told.publisher, told.token)
            _undeclare(*self._others.pop(_own_key(one), ()))
        elif isinstance(one, Service):
            key = key_of(self.domain, one.name, one.type)
            queryable = self._session.declare_queryable(
                key, lambda query: self._soon(self._begin, one, key, query), complete=True
            )
            self._others[_own_key(one)] = queryable, self._token("SS", one.name, one.type)[0]
        elif one.is_told and one.name not in self._told:
            self._tell(one)
        elif one.take is not None and _own_key(one) not in self._others:
            key = key_of(self.domain, one.name, one.type)
            subscriber = self._session.declare_subscriber(
                key, lambda sample: self._soon(self._hub.hear_cdr, one, sample.payload.to_bytes())
            )
            self._others[_own_key(one)] = subscriber, self._token("MS", one.name, one.type)[0]

    def _token(self, kind: str, name: str, type: str, latched: bool = False) -> tuple[Any, bytes]:
        """Return a token that tells an end of the node, and its identity."""
        # Only what is not ROS 2's default is told: reliable, volatile, the last ten.
        quality = ":1:,1:,:,:,," if latched else f"::,{DEPTH}:,:,:,,"
        key = (
            f"{self._place}/{next(self._numbers)}/{kind}/%/%/{self.name}/"
            f"{name.replace('/', '%')}/{dds_name(type)}/{_hash(type)}/{quality}"
        )
        return self._session.liveliness().declare_token(key), hashlib.md5(key.encode()).digest()

    def _tell(self, topic: Topic) -> None:
        key = key_of(self.domain, topic.name, topic.type)
        # Clock, joints and frames go before pictures.
        priority = zenoh.Priority.INTERACTIVE_HIGH if topic.reliable else zenoh.Priority.DATA
        if topic.latched:
            publisher = zenoh.ext.declare_advanced_publisher(
                self._session, key, cache=zenoh.ext.CacheConfig(1), publisher_detection=True, priority=priority
            )
        else:
            publisher = self._session.declare_publisher(key, priority=priority)
        token, gid = self._token("MP", topic.name, topic.type, topic.latched)
        told = self._told[topic.name] = _Told(topic, publisher, token, gid)
        told.readers = self._readers.setdefault(topic.name, set())
        self._want(told)

    def _seen(self, token: str, is_there: bool) -> None:
        """Count the readers of a topic: it is read while there are some."""
        parts = token.split("/")
        if len(parts) <= _NAME or token.startswith(self._place):
            return
        name = parts[_NAME].replace("%", "/")
        readers = self._readers.setdefault(name, set())
        (readers.add if is_there else readers.discard)(token)
        if (told := self._told.get(name)) is not None:
            self._want(told)
        elif not readers:
            del self._readers[name]

    def _want(self, told: _Told) -> None:
        if told.readers and told.end is None:

            def put(message: Message) -> None:
                attachment = _ATTACHMENT.pack(next(told.numbers), time.time_ns(), len(told.gid), told.gid)
                told.publisher.put(message.cdr, attachment=attachment)

            told.end = self._hub.read(told.topic, put)
        elif not told.readers and told.end is not None:
            told.end()
            told.end = None

    def _begin(self, service: Service, key: str, query: zenoh.Query) -> None:
        task = self._loop.create_task(self._call(service, key, query))
        self._calls.add(task)
        task.add_done_callback(self._calls.discard)

    async def _call(self, service: Service, key: str, query: zenoh.Query) -> None:
        """Answer a request: always, as its caller waits; ROS 2 has no other way to tell a refusal."""
        type = service.type
        with query:
            asked = query.attachment.to_bytes() if query.attachment else b""
            if len(asked) != _ATTACHMENT.size:
                query.reply_err("a request has behind it its number, a time and who asks: 33 bytes")
                return
            try:
                if len(self._calls) > MOST_CALLS:
                    raise HubError(f"{MOST_CALLS} calls go on at once; ask again later")
                data = query.payload.to_bytes() if query.payload else b""
                answer = await service.answer(Message.from_cdr(f"{type}_Request", data).value)
            except Exception as error:  # whatever a service raises, and rosbags for bytes of another type
                answer = refusal(type, str(error) or repr(error))
            number, _, size, gid = _ATTACHMENT.unpack(asked)
            attachment = _ATTACHMENT.pack(number, time.time_ns(), size, gid)
            query.reply(key, Message(f"{type}_Response", answer).cdr, attachment=attachment)


def _own_key(one: Topic | Service | Action) -> str:
    return f"{type(one).__name__} {one.name}"


def _undeclare(*entities: Any) -> None:  # noqa: ANN401 publishers, tokens and others
    for one in entities:
        one.undeclare()
