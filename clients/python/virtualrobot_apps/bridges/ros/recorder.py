"""Recorder: all that a hub's topics tell goes into an MCAP file in the form of ROS 2."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from queue import SimpleQueue

from virtualrobot.recording.mcap_file import McapFile, Schema

from virtualrobot_apps.bridges.ros.hub import Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import text_of
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError


class Recorder(Transport):
    """Recorder of the topics that the world tells, those that come later among them; all sensors read meanwhile.

    What is written has the type's definition beside it, so that readers need no ROS, and simulation time as its time.
    """

    def __init__(self, file: Path) -> None:
        """Write nothing yet."""
        self._path = file
        self._waiting: SimpleQueue[tuple[str, Message] | None] = SimpleQueue()
        self._ends: dict[str, Callable[[], None]] = {}

    async def open(self, hub: Hub) -> str:
        """Begin the file, which must not be there yet."""
        try:
            self._stream = self._path.open("xb")
        except OSError as error:
            raise TransportError(f"{self._path} can't be written: {error.strerror}") from error
        self._hub = hub
        self._thread = threading.Thread(target=self._write, name="recorder", daemon=True)
        self._thread.start()
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
        if is_there and one.is_told and one.name not in self._ends:
            self._ends[one.name] = self._hub.read(one, partial(self._take, one.name))
        elif not is_there:
            self._ends.pop(one.name, None)

    def _take(self, topic: str, message: Message) -> None:
        self._waiting.put((topic, message))

    def _write(self) -> None:
        schemas: dict[str, Schema] = {}
        with self._stream:
            file = McapFile(self._stream, {"bridge": "ros"}, "ros2")
            while (one := self._waiting.get()) is not None:
                topic, message = one
                if message.type not in schemas:
                    definition = text_of(message.type).encode()
                    schemas[message.type] = Schema(message.type, "ros2msg", definition, "cdr")
                file.write_encoded(topic, schemas[message.type], message.cdr, message.time)
            file.close()
