"""OPC UA: client and server, by asyncua."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Mapping
from typing import Any, TypeVar

from asyncua import ua
from asyncua.client.client import Client
from asyncua.common.node import Node
from asyncua.server.server import Server
from asyncua.ua.object_ids import ObjectIds
from virtualrobot.errors import InvalidArgumentError, MalformedFileError

from virtualrobot_apps.bridges.mapping import BridgeMapping, Entry
from virtualrobot_apps.bridges.peer import Peer, PeerError
from virtualrobot_apps.bridges.words import Raw

NAMESPACE = "urn:virtualrobot:signals"
"""Namespace of the nodes that a server of ours makes: number 2, the first after those of OPC UA and of the server."""

_TYPES = {
    "boolean": ua.VariantType.Boolean,
    "int16": ua.VariantType.Int16,
    "uint16": ua.VariantType.UInt16,
    "int32": ua.VariantType.Int32,
    "uint32": ua.VariantType.UInt32,
    "int64": ua.VariantType.Int64,
    "float32": ua.VariantType.Float,
    "float64": ua.VariantType.Double,
    "text": ua.VariantType.String,
}
_FIRST = {"boolean": False, "text": "", "float32": 0.0, "float64": 0.0}

Result = TypeVar("Result")


class _Changes:
    """Handler of a subscription: what has changed waits in a queue."""

    def __init__(self, entries: Mapping[ua.NodeId, Entry]) -> None:
        self._entries = entries
        self.waiting: asyncio.Queue[dict[Entry, object] | PeerError] = asyncio.Queue()

    def datachange_notification(self, node: Node, value: object, data: Any) -> None:  # noqa: ANN401 of asyncua
        """Take a change."""
        entry = self._entries[node.nodeid]
        status = data.monitored_item.Value.StatusCode
        # What the server calls bad is no number, and told as such.
        self.waiting.put_nowait({entry: value if status is None or status.is_good() else f"{status.name}"})

    def status_change_notification(self, status: Any) -> None:  # noqa: ANN401 of asyncua
        """Take the end of the subscription."""
        self.waiting.put_nowait(PeerError(f"the subscription has ended: {status}"))

    async def next(self, seconds: float | None = None) -> dict[Entry, object]:
        """Return the next change; nothing after some seconds without one."""
        try:
            found = await asyncio.wait_for(self.waiting.get(), seconds)
        except TimeoutError:
            return {}
        if isinstance(found, PeerError):
            raise found
        return found


def node_ids(mapping: BridgeMapping) -> dict[ua.NodeId, Entry]:
    """Return the entries by the ids of their nodes.

    Raises:
        MalformedFileError: for what is no id, or for one that is there twice, with its line.
    """
    found: dict[ua.NodeId, Entry] = {}
    for entry in mapping.entries:
        try:
            node = ua.NodeId.from_string(entry.place)
        except Exception as error:
            raise _fault(entry, "is no node id, such as ns=2;s=Cell.Start or ns=2;i=1001") from error
        if node in found:
            raise _fault(entry, f"is mapped in line {found[node].item.line} already")
        found[node] = entry
    return found


def _fault(entry: Entry, text: str) -> MalformedFileError:
    return entry.item.error(f"{entry.place!r} {text}")


def _variant(entry: Entry, raw: Raw) -> ua.DataValue:
    return ua.DataValue(ua.Variant(raw, _TYPES[entry.type]))


class OpcUaClient(Peer):
    """Client with a subscription of what comes in; its server is asked for a sign of life once a timeout."""

    def __init__(self, mapping: BridgeMapping, url: str) -> None:
        """Talk to `opc.tcp://HOST:PORT`."""
        if not url.startswith("opc.tcp://"):
            raise InvalidArgumentError(f"{url!r} is not opc.tcp://HOST:PORT")
        self.name = url
        self._mapping, self._ids = mapping, node_ids(mapping)
        self._client: Client | None = None
        self._changes: _Changes | None = None

    async def open(self) -> None:
        """Connect and subscribe."""
        self._client = Client(self.name, timeout=self._mapping.timeout)
        await self._answered(self._client.connect(), 2)
        incoming = {node: entry for node, entry in self._ids.items() if entry.incoming}
        for node, entry in self._ids.items():
            found = await self._answered(self._client.get_node(node).read_data_type_as_variant_type())
            if found != _TYPES[entry.type]:
                raise PeerError(f"{entry.place} is {found.name} there, and the file says {entry.type}")
        self._changes = _Changes(incoming)
        if incoming:
            period = 1000.0 * self._mapping.cycle
            subscription = await self._answered(self._client.create_subscription(period, self._changes))
            nodes = [self._client.get_node(node) for node in incoming]
            # What changes back within a period waits at the server, up to a hundred changes.
            await self._answered(
                subscription.subscribe_data_change(nodes, queuesize=100, sampling_interval=ua.Duration(0.0))
            )

    async def read(self) -> dict[Entry, object]:
        """Wait for the next change, and see now and then that the server lives."""
        assert self._changes is not None and self._client is not None
        while not (found := await self._changes.next(self._mapping.timeout)):
            await self._answered(self._client.get_node(ObjectIds.Server_ServerStatus_State).read_value())
        return found

    async def write(self, values: Mapping[Entry, Raw]) -> None:
        """Write."""
        assert self._client is not None
        nodes = [self._client.get_node(ua.NodeId.from_string(entry.place)) for entry in values]
        await self._answered(self._client.write_values(nodes, [_variant(*pair) for pair in values.items()]))

    async def close(self) -> None:
        """Disconnect; a server that says nothing is left."""
        if self._client is not None:
            client, self._client = self._client, None
            try:
                await asyncio.wait_for(client.disconnect(), self._mapping.timeout)
            except Exception:
                client.disconnect_socket()

    async def _answered(self, call: Awaitable[Result], timeouts: int = 1) -> Result:
        try:
            return await asyncio.wait_for(call, timeouts * self._mapping.timeout)
        except TimeoutError as error:
            raise PeerError(f"no answer within {timeouts * self._mapping.timeout:g} s") from error
        except (ua.UaError, OSError) as error:
            raise PeerError(str(error) or type(error).__name__) from error


class OpcUaServer(Peer):
    """Server with a variable for each signal, below Objects; clients may write those that come in."""

    def __init__(self, mapping: BridgeMapping, url: str) -> None:
        """Serve at `opc.tcp://HOST:PORT`.

        Raises:
            MalformedFileError: for a node id that is none or in another namespace than 2.
        """
        if not url.startswith("opc.tcp://"):
            raise InvalidArgumentError(f"{url!r} is not opc.tcp://HOST:PORT")
        self.name = url
        self._mapping, self._ids = mapping, node_ids(mapping)
        for node, entry in self._ids.items():
            if node.NamespaceIndex != 2:
                raise _fault(entry, "is not in namespace 2, where a bridge that serves has its nodes")
        self._server: Server | None = None
        self._nodes: dict[Entry, Node] = {}
        self._changes: _Changes | None = None

    @property
    def port(self) -> int:
        """Port that it serves at, once it is open."""
        assert self._server is not None and self._server.bserver is not None
        return self._server.bserver._server.sockets[0].getsockname()[1]  # type: ignore[union-attr]

    async def open(self) -> None:
        """Make the nodes and begin to serve."""
        server = self._server = Server()
        await server.init()
        server.set_endpoint(self.name)
        server.set_server_name("VirtualRobot")
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        await server.register_namespace(NAMESPACE)
        for node, entry in self._ids.items():
            first = _variant(entry, _FIRST.get(entry.type, 0)).Value
            self._nodes[entry] = await server.nodes.objects.add_variable(node, entry.signal, first)
            if entry.incoming:
                await self._nodes[entry].set_writable()
        try:
            await server.start()
        except OSError as error:
            raise PeerError(f"it cannot be served there: {error.strerror or error}") from error
        incoming = {node: entry for node, entry in self._ids.items() if entry.incoming}
        self._changes = _Changes(incoming)
        if incoming:
            subscription = await server.create_subscription(1000.0 * self._mapping.cycle, self._changes)
            nodes = [self._nodes[entry] for entry in incoming.values()]
            await subscription.subscribe_data_change(nodes, queuesize=100, sampling_interval=ua.Duration(0.0))

    async def read(self) -> dict[Entry, object]:
        """Wait for the next write of a client."""
        assert self._changes is not None
        return await self._changes.next()

    async def write(self, values: Mapping[Entry, Raw]) -> None:
        """Let clients read values."""
        for entry, raw in values.items():
            await self._nodes[entry].write_value(_variant(entry, raw))

    async def close(self) -> None:
        """Serve no more."""
        if self._server is not None:
            server, self._server = self._server, None
            try:
                await server.stop()
            except Exception:  # one that has not begun
                return
