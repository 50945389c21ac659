"""Bridges to ROS for tests, and clients of others: roslibpy, and bare WebSockets."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from queue import Queue
from typing import Any

import roslibpy
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.bridge import RosBridge
from virtualrobot_apps.bridges.ros.bridge_file import Choice
from virtualrobot_apps.bridges.ros.rosbridge.server import RosbridgeServer
from virtualrobot_apps.bridges.ros.transport import Transport
from websockets.sync.client import ClientConnection, connect

GUARD = 120.0
"""Seconds after which something hangs."""


@contextmanager
def bridge(
    client: Client,
    choice: Choice | None = None,
    more: Sequence[Transport] = (),
    server: RosbridgeServer | None = None,
    **options: Any,  # noqa: ANN401
) -> Iterator[tuple[str, list[str]]]:
    """Give the address of a bridge that runs, and what it says."""
    server = server or RosbridgeServer(port=0)
    said: list[str] = []
    ended, began = threading.Event(), threading.Event()
    failed: list[BaseException] = []

    def say(words: str) -> None:
        said.append(words)
        if words.startswith("rosbridge at"):
            began.set()

    def run() -> None:
        try:
            RosBridge(client, [*more, server], choice, say=say, **options).run(ended.is_set)
        except BaseException as error:
            failed.append(error)
        began.set()

    thread = threading.Thread(target=run, name="bridge", daemon=True)
    thread.start()
    try:
        assert began.wait(GUARD) and not failed, failed
        yield server.url, said
    finally:
        ended.set()
        thread.join(GUARD)
    assert not failed, failed
    assert not thread.is_alive()


@contextmanager
def roslibpy_client(url: str) -> Iterator[roslibpy.Ros]:
    """Give a client of roslibpy that is connected; its reactor goes on for the next one."""
    ros = roslibpy.Ros(url)
    ros.run(timeout=int(GUARD))
    try:
        yield ros
    finally:
        ros.close()


def told(value: Any) -> Any:  # noqa: ANN401 whatever a service tells
    """Return what a call of roslibpy has told, which is None where it has told nothing."""
    assert value is not None
    return value


class Heard:
    """Messages of a topic that roslibpy has heard, in their order."""

    def __init__(self, ros: roslibpy.Ros, topic: str, type: str, **options: Any) -> None:  # noqa: ANN401
        """Subscribe."""
        self._messages: Queue[dict[str, Any]] = Queue()
        self.topic = roslibpy.Topic(ros, topic, type, **options)
        self.topic.subscribe(self._messages.put)

    def next(self) -> dict[str, Any]:
        """Return the next message."""
        return self._messages.get(timeout=GUARD)

    def until(self, wanted: Callable[[dict[str, Any]], bool]) -> list[dict[str, Any]]:
        """Return the messages up to the first one that is wanted."""
        found = [self.next()]
        while not wanted(found[-1]):
            found.append(self.next())
        return found

    def is_there(self) -> bool:
        """Return whether a message waits."""
        return not self._messages.empty()


@contextmanager
def socket(url: str, **options: Any) -> Iterator[ClientConnection]:  # noqa: ANN401
    """Give a bare WebSocket."""
    with connect(url, max_size=None, open_timeout=GUARD, **options) as connection:
        yield connection  # pyright: ignore[reportReturnType] it is one


def say(connection: ClientConnection, **op: object) -> None:
    """Send a message in JSON."""
    connection.send(json.dumps(op))


def answer(connection: ClientConnection, **wanted: object) -> dict[str, Any]:
    """Return the next message in JSON that has these values."""
    while True:
        data = connection.recv(timeout=GUARD)
        if isinstance(data, str):
            found = json.loads(data)
            assert "a fault of the bridge" not in str(found.get("msg")), found
            if all(found.get(key) == value for key, value in wanted.items()):
                return found


def stamp_of(message: dict[str, Any]) -> int:
    """Return the time of a message (ns)."""
    stamp = message["header"]["stamp"] if "header" in message else message["clock"]
    return stamp["sec"] * 1_000_000_000 + stamp["nanosec"]
