"""Recorder: what a world tells and hears goes into a file: MCAP or a folder of ROS 2, or a bag of ROS 1."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Protocol

from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import Writer as Ros2Writer
from virtualrobot.recording.mcap_file import McapFile, Schema

from virtualrobot_apps.bridges.ros.hub import Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import hash_of, text_of
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

_DEPTH = 10
_NEVER = QosTime(9_223_372_036, 854_775_807)
"""No limit of time; source: RMW_DURATION_INFINITE."""
_VERSION = 9
"""Version of a folder's description; source: rosbag2 of Jazzy."""


class File(Protocol):
    """A file that is written."""

    def write(self, topic: Topic, message: Message) -> None:
        """Write a message of a topic."""
        ...

    def close(self) -> None:
        """Write what readers need to find their way, and end it."""
        ...


class Recorder(Transport):
    """Recorder of what the world tells and hears, topics that come later among them; all sensors read meanwhile.

    What is written has the type's definition beside it, so that readers need no ROS, and simulation time as its time.
    """

    def __init__(self, file: Path) -> None:
        """Write nothing yet; a file is `.mcap` or `.bag`, and what has no suffix is a folder, as ROS 2 writes one."""
        self._path = file
        self._waiting: SimpleQueue[tuple[Topic, Message] | None] = SimpleQueue()
        self._ends: dict[str, Callable[[], None]] = {}

    async def open(self, hub: Hub) -> str:
        """Begin the file, which must not be there yet."""
        if self._path.exists():
            raise TransportError(f"{self._path} can't be written: File exists")
        kinds: dict[str, Callable[[Path], File]] = {".mcap": _Mcap, ".bag": _Bag, "": _Folder}
        if self._path.suffix not in kinds:
            raise TransportError(
                f"{self._path} ends with .mcap, or with .bag for ROS 1; a folder of ROS 2 has no suffix"
            )
        begun: Future[None] = Future()
        begin = partial(kinds[self._path.suffix], self._path)
        self._thread = threading.Thread(target=self._write, args=(begin, begun), name="recorder", daemon=True)
        self._thread.start()
        try:
            await asyncio.wrap_future(begun)
        except OSError as error:
            raise TransportError(f"{self._path} can't be written: {error.strerror}") from error
        self._hub = hub
        hub.changed.append(self._changed)
        for topic in tuple(hub.topics.values()):
            self._changed(topic, True)
        return f"recording to {self._path}"

    async def close(self) -> None:
        """Write what waits, and the index."""
        self._hub.changed.remove(self._changed)
        for end in self._ends.values():
            end()
        self._waiting.put(None)
        self._thread.join()

    def _changed(self, one: Topic | Service | Action, is_there: bool) -> None:
        if not isinstance(one, Topic):
            return
        if is_there and (one.is_told or one.take) and one.name not in self._ends:
            self._ends[one.name] = self._hub.read(one, partial(self._take, one))
        elif not is_there:
            self._ends.pop(one.name, None)

    def _take(self, topic: Topic, message: Message) -> None:
        self._waiting.put((topic, message))

    def _write(self, begin: Callable[[], File], begun: Future[None]) -> None:
        try:
            file = begin()  # here, since a database is its thread's own
        except OSError as error:
            return begun.set_exception(error)
        begun.set_result(None)
        while (one := self._waiting.get()) is not None:
            file.write(*one)
        file.close()


class _Mcap:
    """A file in MCAP, by the one writer that exists."""

    def __init__(self, path: Path) -> None:
        self._stream = path.open("xb")
        self._file = McapFile(self._stream, {"bridge": "ros"}, "ros2")
        self._schemas: dict[str, Schema] = {}

    def write(self, topic: Topic, message: Message) -> None:
        if message.type not in self._schemas:
            definition = text_of(message.type).encode()
            self._schemas[message.type] = Schema(message.type, "ros2msg", definition, "cdr")
        self._file.write_encoded(topic.name, self._schemas[message.type], message.cdr, message.time)

    def close(self) -> None:
        self._file.close()
        self._stream.close()


class _Folder:
    """A folder with a database, as `ros2 bag` writes and reads one."""

    def __init__(self, path: Path) -> None:
        self._writer: Any = Ros2Writer(path, version=_VERSION)
        self._writer.open()
        self._connections: dict[tuple[str, str], Connection] = {}

    def write(self, topic: Topic, message: Message) -> None:
        key = topic.name, message.type
        if key not in self._connections:
            told = {"msgdef": text_of(message.type), "rihs01": hash_of(message.type)}
            quality = [_quality(topic)]
            self._connections[key] = self._writer.add_connection(*key, **told, offered_qos_profiles=quality)
        self._writer.write(self._connections[key], message.time, message.cdr)

    def close(self) -> None:
        self._writer.close()


class _Bag:
    """A bag of ROS 1."""

    def __init__(self, path: Path) -> None:
        from virtualrobot_apps.bridges.ros.messages import ros1  # its types take a while to make

        self._texts = ros1
        self._writer: Any = Ros1Writer(path)
        self._writer.open()
        self._connections: dict[tuple[str, str], Connection] = {}

    def write(self, topic: Topic, message: Message) -> None:
        key = topic.name, message.type
        if key not in self._connections:
            told = {"msgdef": self._texts.definition_of(message.type), "md5sum": self._texts.md5_of(message.type)}
            self._connections[key] = self._writer.add_connection(*key, **told, latching=int(topic.latched))
        self._writer.write(self._connections[key], message.time, message.ros1)

    def close(self) -> None:
        self._writer.close()


def _quality(topic: Topic) -> Qos:
    """Return what a topic's writer offers, by which `ros2 bag play` writes it again."""
    return Qos(
        QosHistory.KEEP_LAST,
        _DEPTH,
        QosReliability.RELIABLE if topic.reliable else QosReliability.BEST_EFFORT,
        QosDurability.TRANSIENT_LOCAL if topic.latched else QosDurability.VOLATILE,
        *(_NEVER, _NEVER),
        *(QosLiveliness.AUTOMATIC, _NEVER),
        False,
    )
