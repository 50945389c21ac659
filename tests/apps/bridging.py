"""Bridges that run in a test, and the signals that they carry."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import virtualrobot
from virtualrobot_apps.bridges.bridge import Bridge
from virtualrobot_apps.bridges.mapping import BridgeMapping, mapping_of
from virtualrobot_apps.bridges.peer import Peer
from virtualrobot_apps.cell_io.yaml_file import parse

GUARD = 60.0


def create_signals(client: virtualrobot.Client) -> None:
    """Create the signals that these bridges carry."""
    for name in ("start", "started", "there", "peer there"):
        client.signals.create(name)
    client.signals.create("parts", 0)
    client.signals.create("counted", 0)
    client.signals.create("speed", 0.0)
    client.signals.create("read speed", 0.0)


def mapping(protocol: str, entries: str, serves: bool = False, more: str = "") -> BridgeMapping:
    """Return the mapping of these lines below `signals`."""
    lines = "".join(f"- {line}\n" for line in entries.strip().splitlines())
    return mapping_of(parse(f"schema_version: 1\n{more}signals:\n{lines}", "plc.yaml"), protocol, serves)


def free_port() -> int:
    """Return a port at which nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return listening.getsockname()[1]


@contextmanager
def running(client: virtualrobot.Client, mapping: BridgeMapping, peer: Peer) -> Iterator[list[str]]:
    """Run a bridge for the length of a block; give what it says."""
    said: list[str] = []
    ended = threading.Event()
    failed: list[BaseException] = []
    bridge = Bridge(client, mapping, peer, said.append)

    def run() -> None:
        try:
            bridge.run(ended.is_set)
        except BaseException as error:
            failed.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield said
    finally:
        ended.set()
        thread.join(GUARD)
    assert not thread.is_alive(), "the bridge does not end"
    assert not failed, failed


PLACES = {
    "modbus": ("address: coil 1", "address: input_register 10, word_order: little", "address: input_register 20"),
    "opcua": ("node: ns=2;s=a", "node: ns=2;s=b", "node: ns=2;i=3"),
    "mqtt": ("topic: cell/a", "topic: cell/b", "topic: cell/c"),
}


def entries(protocol: str, incoming: bool) -> str:
    """Return the lines of a mapping whose other end has those of the other direction."""
    names = ("started", "counted", "read speed") if incoming else ("start", "parts", "speed")
    kinds = ("boolean, lost: false" if incoming else "boolean", "int32", "float32")
    way = "in" if incoming else "out"
    three = zip(names, kinds, PLACES[protocol], strict=True)
    return "\n".join(f"{{signal: {name}, direction: {way}, type: {kind}, {place}}}" for name, kind, place in three)


def check_values(client: virtualrobot.Client) -> None:
    """Values that are set at one end arrive at the other one."""
    client.signals.wait_for("there", timeout=GUARD)
    client.signals.set({"start": True, "parts": -70000, "speed": 1.5})
    client.signals.wait_for("started", timeout=GUARD)
    client.signals.wait_for("counted", -70000, timeout=GUARD)
    client.signals.wait_for("read speed", 1.5, timeout=GUARD)
    client.signals["start"] = False
    client.signals.wait_for("started", False, timeout=GUARD)
