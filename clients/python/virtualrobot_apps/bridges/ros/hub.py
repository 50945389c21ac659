"""The hub of a bridge: topics, services and actions by name, between the world and all transports.

One asyncio loop owns it: whoever is in another thread hands over by `call_soon_threadsafe`.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import TypeAlias

from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.parameters import Parameters

Reader: TypeAlias = Callable[[Message], None]

Refused: TypeAlias = Callable[[str], None]
"""Tells a publisher, from any thread, in words why something was not done that was taken already."""

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""States of a goal that is over; source: action_msgs/GoalStatus."""


ROSAPI = "/rosapi/"
"""Beginning of services that rosbridge alone has a use for: graph and master of ROS tell the same."""


class HubError(Exception):
    """Refusal of the hub; its text is for people and says what would be right."""


class GoalRefusedError(HubError):
    """A goal that an action does not accept."""


@dataclass
class Topic:
    """A topic.

    Attributes:
        name: its name.
        type: type of its messages.
        latched: whether who comes later gets the last message at once.
        reliable: whether none of its messages may be lost on the way; else the newest counts (QoS of sensor data).
        wanted: is told when the first reader comes and when the last one has gone.
        take: gets what others publish, where the world hears it, and what tells them later that it was refused;
            raises ValueError for what it can't take.
        readers: who gets its messages.
        writers: who has advertised it.
        last: the last message, of a latched one.
        is_told: whether the world tells it.
    """

    name: str
    type: str
    latched: bool = False
    reliable: bool = True
    wanted: Callable[[bool], None] | None = None
    take: Callable[[RosValue, Refused], None] | None = None
    readers: list[Reader] = field(default_factory=list)
    writers: set[object] = field(default_factory=set)
    last: Message | None = None
    is_told: bool = False


@dataclass
class Service:
    """A service: `answer` gives the response for a request, or raises an exception whose text is for the caller."""

    name: str
    type: str
    answer: Callable[[RosValue], Awaitable[RosValue]]
    owner: object = None


Feedback: TypeAlias = Callable[[RosValue], None]
Run: TypeAlias = Callable[[RosValue, Feedback, asyncio.Event], Awaitable[tuple[int, RosValue]]]


@dataclass
class Action:
    """An action: `run` gives the state of a goal that is over, and its result; `cancel` is set when it shall end."""

    name: str
    type: str
    run: Run
    owner: object = None


class Hub:
    """Topics, services and actions of a world.

    Attributes:
        topics, services, actions: by name.
        parameters: of all clients.
        changed: are called with a topic, a service or an action that is new or has gone, and whether it is there.
    """

    def __init__(self) -> None:
        """Begin empty."""
        self.topics: dict[str, Topic] = {}
        self.services: dict[str, Service] = {}
        self.actions: dict[str, Action] = {}
        self.parameters = Parameters()
        self.changed: list[Callable[[Topic | Service | Action, bool], None]] = []
        self.now = 0
        """Simulation time that was told last (ns)."""

    def declare(self, topic: Topic) -> Topic:
        """Add what the world tells or hears; those who read or write a topic of this name already keep on.

        Raises:
            HubError: when others have given the topic another type.
        """
        before = self.topics.get(topic.name)
        if before is None:
            self.topics[topic.name] = topic
            self._tell(topic, True)
            return topic
        self._check(before, topic.type)
        before.latched, before.reliable, before.is_told = topic.latched, topic.reliable, topic.is_told
        before.wanted, before.take = topic.wanted, topic.take
        if before.readers and before.wanted:
            before.wanted(True)
        return before

    def withdraw(self, name: str) -> None:
        """Take away what the world tells or hears; a topic that others read or write stays, and is theirs."""
        topic = self.topics[name]
        topic.wanted = topic.take = topic.last = None
        topic.is_told = False
        self._drop(topic)

    def shared(self, name: str, type: str) -> Topic:
        """Return a topic that somebody wants to read or write, which begins to be where there is none.

        Raises:
            HubError: when it has another type, or the name is none.
        """
        if name not in self.topics:
            if not name.startswith("/") or len(name) > 255 or any(one.isspace() for one in name):
                raise HubError(f"{name[:80]!r} is no name of a topic: it begins with / and has no spaces")
            self.topics[name] = Topic(name, type)
            self._tell(self.topics[name], True)
        self._check(self.topics[name], type)
        return self.topics[name]

    def read(self, topic: Topic, reader: Reader) -> Callable[[], None]:
        """Let somebody read a topic; what is latched comes at once. Return what ends it."""
        topic.readers.append(reader)
        if len(topic.readers) == 1 and topic.wanted:
            topic.wanted(True)
        if topic.last is not None:
            reader(topic.last)

        def end() -> None:
            if reader in topic.readers:
                topic.readers.remove(reader)
                if not topic.readers and topic.wanted:
                    topic.wanted(False)
                self._drop(topic)

        return end

    def unadvertise(self, topic: Topic, writer: object) -> None:
        """Let somebody write a topic no more."""
        topic.writers.discard(writer)
        self._drop(topic)

    def publish(self, name: str, message: Message) -> None:
        """Hand a message to all readers of a topic; one that has gone meanwhile has none."""
        topic = self.topics.get(name)
        if topic is None:
            return
        if topic.latched:
            topic.last = message
        for reader in tuple(topic.readers):
            reader(message)

    def hear(self, topic: Topic, value: RosValue, refused: Refused = lambda words: None) -> None:
        """Take what somebody outside publishes: for the world, where it hears the topic, and for other readers.

        What the world refuses later is told to `refused`, from any thread.

        Raises:
            HubError: where the world alone tells it.
            ValueError: for what the world can't take.
        """
        if topic.is_told and topic.take is None:
            raise HubError(f"{topic.name} is told by the world; nobody else publishes it")
        if topic.take is not None:
            topic.take(value, refused)
        self.publish(topic.name, Message(topic.type, value, self.now))

    def hear_cdr(self, topic: Topic, cdr: bytes) -> None:
        """Take what somebody outside publishes, in CDR; faults are passed over, since ROS 2 tells a writer of none."""
        try:
            self.hear(topic, Message.from_cdr(topic.type, cdr).value)
        except (HubError, ValueError):
            pass
        except Exception:
            pass  # bytes of another type: rosbags raises whatever it likes

    def serve(self, service: Service) -> None:
        """Add a service; raises HubError when there is one of this name."""
        if service.name in self.services:
            raise HubError(f"the service {service.name} is there already")
        self.services[service.name] = service
        self._tell(service, True)

    def act(self, action: Action) -> None:
        """Add an action; raises HubError when there is one of this name."""
        if action.name in self.actions:
            raise HubError(f"the action {action.name} is there already")
        self.actions[action.name] = action
        self._tell(action, True)

    def end(self, one: Service | Action) -> None:
        """Take a service or an action away."""
        table = self.services if isinstance(one, Service) else self.actions
        if table.get(one.name) is one:
            del table[one.name]
            self._tell(one, False)

    def _check(self, topic: Topic, type: str) -> None:
        if topic.type != type:
            raise HubError(f"the topic {topic.name} has the type {topic.type}, not {type}")

    def _drop(self, topic: Topic) -> None:
        if not (topic.is_told or topic.take or topic.readers or topic.writers) and topic.name in self.topics:
            del self.topics[topic.name]
            self._tell(topic, False)

    def _tell(self, one: Topic | Service | Action, is_there: bool) -> None:
        for told in tuple(self.changed):
            told(one, is_there)
