"""Player of recordings: messages of a bag come again, in simulation time, for the world and for those who read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection

from virtualrobot_apps.bridges.ros.bag import why
from virtualrobot_apps.bridges.ros.hub import Hub, HubError, Topic
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.ros1 import converted
from virtualrobot_apps.bridges.ros.messages.types import STORE, UnknownTypeError, known
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

CLOCK, _CLOCK_TYPE = "/clock", "rosgraph_msgs/msg/Clock"


class Player(Transport):
    """Player of a bag of ROS 1 or ROS 2: its first message comes at once, the others when as much time has gone by.

    What the world tells itself is left out.
    """

    def __init__(self, file: Path, say: Callable[[str], None] = print) -> None:
        """Play nothing yet."""
        self._path, self._say = file, say
        self._files = ExitStack()
        self._topics: dict[str, Topic] = {}
        self._said: set[str] = set()
        self._first: int | None = None
        self._count = 0

    async def open(self, hub: Hub) -> str:
        """Begin to play."""
        self._hub = hub
        try:
            self._reader = self._files.enter_context(AnyReader([self._path], default_typestore=STORE))
        except Exception as error:  # of a damaged bag rosbags raises whatever it likes
            raise TransportError(f"{self._path} can't be read as a bag: {why(error)}") from error
        connections = [one for one in self._reader.connections if self._is_played(one)]
        self._left = self._messages(connections)
        self._next = next(self._left, None)
        self._begin = self._next[0] if self._next else 0
        self._end = hub.read(hub.shared(CLOCK, _CLOCK_TYPE), self._play)
        if self._next is None:
            self._finish()
            return f"nothing of {self._path} is played: the world tells all of its topics itself"
        return f"playing {len(self._topics)} topics of {self._path}"

    async def close(self) -> None:
        """Play no more."""
        self._finish()

    def _is_played(self, connection: Connection) -> bool:
        name = connection.topic
        try:
            type = known(connection.msgtype)
            topic = self._hub.topics.get(name)
            if name == CLOCK or (topic is not None and topic.is_told and topic.take is None):
                return False
            self._topics[name] = self._hub.shared(name, type)
        except (HubError, UnknownTypeError) as error:
            self._tell(f"{name} is left out: {error}")
            return False
        self._topics[name].writers.add(self)
        return True

    def _messages(self, connections: list[Connection]) -> Iterator[tuple[int, str, Any]]:
        """Yield time (ns), topic and value of each message in the order of their times."""
        for connection, time, data in self._reader.messages(connections=connections) if connections else ():
            found = self._reader.deserialize(data, connection.msgtype)
            yield time, connection.topic, converted(found, connection.msgtype, STORE)  # by the names of fields

    def _play(self, clock: Message) -> None:
        """Play what is due; the first time that is told is that of the first message."""
        if self._first is None:
            self._first = clock.time
        try:
            while self._next is not None and self._next[0] - self._begin <= clock.time - self._first:
                _, name, value = self._next
                self._hear(self._topics[name], value)
                self._next = next(self._left, None)
        except Exception as error:  # of a damaged bag rosbags raises whatever it likes
            self._tell(f"{self._path} can't be read on: {why(error)}")
            self._next = None
        if self._next is None:
            self._say(f"{self._count} messages of {self._path} are played")
            self._finish()

    def _hear(self, topic: Topic, value: Any) -> None:  # noqa: ANN401 each type is a class of its own
        try:
            self._hub.hear(topic, value)
            self._count += 1
        except (HubError, ValueError) as error:
            self._tell(f"{topic.name} of {self._path}: {error}")

    def _tell(self, words: str) -> None:
        if words not in self._said:
            self._said.add(words)
            self._say(words)

    def _finish(self) -> None:
        """Read and write no more; a second time does nothing."""
        self._end()
        for topic in self._topics.values():
            self._hub.unadvertise(topic, self)
        self._topics = {}
        self._files.close()
