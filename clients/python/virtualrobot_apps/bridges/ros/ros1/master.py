"""A master of ROS 1: who publishes, subscribes and serves what, and parameters; for where there is no roscore.

Source: wiki.ros.org, "ROS/Master_API" and "ROS/Parameter Server API". Parameters are those that clients of rosbridge
share. Roscore's /rosout, which gathers logs, is left out.
"""

from __future__ import annotations

import asyncio
import json
import os
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

from virtualrobot_apps.bridges.ros.parameters import MOST_LETTERS, ParameterError, Parameters
from virtualrobot_apps.bridges.ros.ros1.xmlrpc import XmlRpcError, XmlRpcServer, call

MOST = 10_000
"""Registrations that are kept at most."""

GOOD, BAD = 1, -1

_MOST_NAME = 255


class MasterError(ValueError):
    """A refusal; its text is for people."""


class Master:
    """A master. Its methods in XML-RPC are those that `_METHODS` names; each answers a code, words and a value."""

    def __init__(self, parameters: Parameters) -> None:
        """Know nobody yet."""
        self._parameters = parameters
        self._server = XmlRpcServer(self._answer)
        self._nodes: dict[str, str] = {}
        self._types: dict[str, str] = {}
        self._tables: dict[str, dict[str, dict[str, str]]] = {"Publisher": {}, "Subscriber": {}, "Service": {}}
        self._watched: dict[str, dict[str, str]] = {}
        self._due: dict[tuple[str, str], Callable[[], Awaitable[object]]] = {}
        self._telling: set[asyncio.Task[None]] = set()
        self._methods: dict[str, Callable[..., Any]] = {
            "getUri": lambda _: self.uri,
            "getPid": lambda _: os.getpid(),
            "registerPublisher": lambda *asked: self._register("Publisher", *asked),
            "registerSubscriber": lambda *asked: self._register("Subscriber", *asked),
            "registerService": self._register_service,
            "unregisterPublisher": lambda *asked: self._unregister("Publisher", *asked),
            "unregisterSubscriber": lambda *asked: self._unregister("Subscriber", *asked),
            "unregisterService": lambda *asked: self._unregister("Service", *asked),
            "lookupNode": self._lookup_node,
            "lookupService": self._lookup_service,
            "getPublishedTopics": self._published,
            "getTopicTypes": lambda _: [[name, type] for name, type in sorted(self._types.items())],
            "getSystemState": lambda _: [
                [[name, sorted(nodes)] for name, nodes in sorted(table.items())] for table in self._tables.values()
            ],
            "getParam": lambda caller, key: self._parameters.get(resolved(caller, key)),
            "hasParam": lambda caller, key: self._parameters.has(resolved(caller, key)),
            "getParamNames": lambda _: self._parameters.names(),
            "setParam": self._set,
            "deleteParam": self._delete,
            "searchParam": self._search,
            "subscribeParam": self._watch,
            "unsubscribeParam": self._unwatch,
        }

    @property
    def uri(self) -> str:
        """Address of the master, once it is open."""
        return self._server.uri

    async def open(self, host: str, port: int) -> None:
        """Serve; port 0 is any. Raises OSError when the address can't be had."""
        await self._server.open(host, port)

    async def close(self) -> None:
        """End it; nodes are not told."""
        await self._server.close()
        for task in self._telling:
            task.cancel()

    async def _answer(self, name: str, arguments: tuple[Any, ...]) -> object:
        if name == "system.multicall":  # roslaunch sets parameters by it
            (calls,) = arguments
            return [[await self._answer(one["methodName"], tuple(one["params"]))] for one in calls[:MOST]]
        if (method := self._methods.get(name)) is None:
            raise MasterError(f"there is no method {name[:60]!r}")
        try:
            if not arguments or not isinstance(arguments[0], str):
                raise MasterError("the name of who calls comes first")
            value = method(*arguments)
        except (MasterError, ParameterError) as error:
            return [BAD, str(error), 0]
        return [GOOD, name, value]

    def _register(self, kind: str, caller: str, topic: str, type: str, api: str) -> list[str]:
        """Register a publisher or a subscriber; return where the nodes at the other end are."""
        self._join(kind, topic, caller, api, api)
        text(type)
        if type != "*" or topic not in self._types:
            if kind == "Publisher" or topic not in self._types:
                self._types[topic] = type
        if kind == "Publisher":
            self._tell_subscribers(topic)
        other = "Subscriber" if kind == "Publisher" else "Publisher"
        return sorted(set(self._tables[other].get(topic, {}).values()))

    def _register_service(self, caller: str, service: str, service_api: str, api: str) -> int:
        self._tables["Service"].pop(service, None)  # the one that comes last counts
        self._join("Service", service, caller, service_api, api)
        return 1

    def _join(self, kind: str, name: str, caller: str, place: str, api: str) -> None:
        table = self._tables[kind]
        if sum(map(len, table.values())) >= MOST:
            raise MasterError(f"{MOST} registrations are kept")
        for one in (named(name), named(caller)):
            if len(one) > _MOST_NAME:
                raise MasterError(f"{one[:60]!r} is too long for a name")
        if not text(api).startswith("http://") or not text(place).startswith(("http://", "rosrpc://")):
            raise MasterError(f"{api[:60]!r} is no address of a node: http://HOST:PORT/")
        before = self._nodes.get(caller)
        if before is not None and before != api:
            self._forget(caller)
            self._later((before, "shutdown"), lambda: call(before, "shutdown", "/master", f"another {caller} has come"))
        self._nodes[caller] = api
        table.setdefault(name, {})[caller] = place

    def _unregister(self, kind: str, caller: str, name: str, api: str) -> int:
        nodes = self._tables[kind].get(name, {})
        if nodes.get(caller) != api:
            return 0
        del nodes[caller]
        self._tidy(kind, name)
        if kind == "Publisher":
            self._tell_subscribers(name)
        if not any(caller in nodes for table in self._tables.values() for nodes in table.values()):
            del self._nodes[caller]
        return 1

    def _forget(self, caller: str) -> None:
        """Take away all that a node has registered, as another one has its name now."""
        for kind, table in self._tables.items():
            for name in [name for name, nodes in table.items() if caller in nodes]:
                del table[name][caller]
                self._tidy(kind, name)
                if kind == "Publisher":
                    self._tell_subscribers(name)
        for nodes in self._watched.values():
            nodes.pop(caller, None)

    def _tidy(self, kind: str, name: str) -> None:
        if not self._tables[kind][name]:
            del self._tables[kind][name]
        if not any(name in self._tables[one] for one in ("Publisher", "Subscriber")):
            self._types.pop(name, None)

    def _lookup_node(self, _: str, node: str) -> str:
        if node not in self._nodes:
            raise MasterError(f"there is no node {text(node)[:60]!r}")
        return self._nodes[node]

    def _lookup_service(self, _: str, service: str) -> str:
        nodes = self._tables["Service"].get(service)
        if not nodes:
            raise MasterError(f"there is no service {text(service)[:60]!r}")
        return next(iter(nodes.values()))

    def _published(self, _: str, space: str) -> list[list[str]]:
        beginning = f"{space.rstrip('/')}/"
        return [[one, self._types[one]] for one in sorted(self._tables["Publisher"]) if one.startswith(beginning)]

    def _set(self, caller: str, key: str, value: object) -> int:
        try:
            size = len(json.dumps(value))
        except (TypeError, ValueError, RecursionError) as error:
            raise MasterError(f"numbers, words, lists and tables are parameters: {error}") from error
        if size > MOST_LETTERS:
            raise MasterError(f"a value has {MOST_LETTERS} letters at most")
        name = resolved(caller, key)
        self._parameters.set(name, value)
        self._tell_watchers(name, value)
        return 0

    def _delete(self, caller: str, key: str) -> int:
        name = resolved(caller, key)
        self._parameters.delete(name)
        self._tell_watchers(name, {})
        return 0

    def _search(self, caller: str, key: str) -> str:
        """Return the name of a parameter in the caller's namespace, or one about it, that begins as the key does."""
        first = text(key).strip("/").split("/")[0]
        for space in spaces(caller):
            if self._parameters.has(f"{space}/{first}"):
                return f"{space}/{key.strip('/')}"
        raise MasterError(f"there is no parameter {key[:60]!r} above {caller[:60]}")

    def _watch(self, caller: str, api: str, key: str) -> object:
        name = resolved(caller, key)
        if sum(map(len, self._watched.values())) >= MOST:
            raise MasterError(f"{MOST} parameters are watched")
        self._watched.setdefault(name, {})[caller] = text(api)
        return self._parameters.get(name) if self._parameters.has(name) else {}

    def _unwatch(self, caller: str, api: str, key: str) -> int:
        nodes = self._watched.get(resolved(caller, key), {})
        return int(nodes.pop(caller, None) is not None)

    def _tell_watchers(self, name: str, value: object) -> None:
        for watched, nodes in self._watched.items():
            if f"{name}/".startswith(f"{watched.rstrip('/')}/"):
                key, told = name, value
            elif watched.startswith(f"{name}/"):
                key, told = watched, self._parameters.get(watched) if self._parameters.has(watched) else {}
            else:
                continue
            for api in nodes.values():
                self._later(
                    (api, f"parameter {key}"), lambda a=api, k=key, v=told: call(a, "paramUpdate", "/master", k, v)
                )

    def _tell_subscribers(self, topic: str) -> None:
        """Tell those who read a topic who publishes it now."""
        for api in set(self._tables["Subscriber"].get(topic, {}).values()):
            self._later((api, topic), lambda a=api: call(a, "publisherUpdate", "/master", topic, self._places(topic)))

    def _places(self, topic: str) -> list[str]:
        return sorted(set(self._tables["Publisher"].get(topic, {}).values()))

    def _later(self, key: tuple[str, str], tell: Callable[[], Awaitable[object]]) -> None:
        """Tell a node something soon; of what waits under one key the newest counts, and one goes after the other."""
        waits = key in self._due
        self._due[key] = tell
        if not waits:
            task = asyncio.create_task(self._tell(key))
            self._telling.add(task)
            task.add_done_callback(self._telling.discard)

    async def _tell(self, key: tuple[str, str]) -> None:
        done = None
        while (tell := self._due[key]) is not done:
            done = tell
            try:
                await tell()
            except XmlRpcError:
                break  # the node has gone without a word
        del self._due[key]


def text(value: object) -> str:
    """Return a word; raises MasterError for what is none."""
    if not isinstance(value, str):
        raise MasterError(f"a word belongs here, not {str(value)[:60]!r}")
    return value


def named(value: object) -> str:
    """Return a name from the root; raises MasterError for what is none."""
    name = text(value)
    if not name.startswith("/") or len(name) < 2 or any(one.isspace() for one in name):
        raise MasterError(f"{name[:60]!r} is no name: it begins with / and has no spaces")
    return name


def spaces(node: str) -> Iterator[str]:
    """Yield the name of a node and the namespaces about it, the root last, as ''."""
    space = "/" + node.strip("/")
    while space:
        yield space
        space = space.rpartition("/")[0]
    yield ""


def resolved(caller: str, key: object) -> str:
    """Return the name of a parameter from the root; `~a` is the caller's own, `a` one of its namespace."""
    name = text(key)
    if name.startswith("/"):
        return name
    if name.startswith("~"):
        return f"/{caller.strip('/')}/{name[1:].strip('/')}"
    return f"/{caller.strip('/')}".rpartition("/")[0] + f"/{name}"
