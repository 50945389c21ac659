"""The user's own ROS 2: a hub as a node of its rclpy, on whatever middleware that has, in the bytes that others share.

Messages are those of the ROS that was sourced; what it lacks, or has with other fields, is said and left out.
"""

# pyright: reportMissingImports=false
# rclpy comes with ROS 2.

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import MultiThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message

from virtualrobot_apps.bridges.ros.action_server import ActionServer, change_action
from virtualrobot_apps.bridges.ros.hub import ROSAPI, Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import NO_FIELD, fields
from virtualrobot_apps.bridges.ros.messages.values import refusal
from virtualrobot_apps.bridges.ros.transport import Transport, TransportError

QUEUE, SMALL_QUEUE = 100, 5
"""Messages of a topic that wait to be sent or taken, and of one whose newest counts."""

MOST_CALLS = 32
"""Calls that go on at once, each in a thread of rclpy's; those for results of goals wait as long as these run."""

_SPIN_SECONDS = 0.5

_PARTS = {"_SendGoal": "SendGoalService", "_GetResult": "GetResultService", "_FeedbackMessage": "FeedbackMessage"}
"""Names within an action's class of what carries it, by the ends of their types; source: rosidl_generator_py."""


class _UnlikeError(Exception):
    """A type that the ROS here has otherwise, or not at all."""


@dataclass
class _Told:
    """A topic that is told while somebody reads it."""

    topic: Topic
    publisher: Any
    end: Callable[[], None] | None = None


class RclpyNode(Transport):
    """A node of the user's ROS 2 with the topics, services and actions of a world; the domain is that of ROS_DOMAIN_ID.

    Attributes:
        name: name of the node.
    """

    def __init__(self, *, name: str = "virtualrobot", say: Callable[[str], None] = print) -> None:
        """Join nothing yet; `say` is told what the ROS here lacks."""
        self.name, self._say = name, say
        self._told: dict[str, _Told] = {}
        self._others: dict[str, Callable[[], object]] = {}
        self._actions: dict[str, ActionServer] = {}
        self._calls: set[Future[RosValue]] = set()
        self._missing: set[str] = set()
        self._closed = False

    async def open(self, hub: Hub) -> str:
        """Join with all that the hub has, and what comes later."""
        self._hub, self._loop = hub, asyncio.get_running_loop()
        self._context = Context()
        try:
            rclpy.init(args=[], context=self._context)
            self._node = rclpy.create_node(
                self.name, context=self._context, enable_rosout=False, start_parameter_services=False
            )
        except Exception as error:  # whatever the middleware raises that can't be loaded, or can't join
            raise TransportError(f"rclpy can't join: {error}") from error
        self._executor = MultiThreadedExecutor(MOST_CALLS, context=self._context)
        self._executor.add_node(self._node)
        self._services = ReentrantCallbackGroup()
        hub.changed.append(self._change)
        for one in (*hub.topics.values(), *hub.services.values(), *hub.actions.values()):
            self._change(one, True)
        self._thread = threading.Thread(target=self._spin, name="rclpy", daemon=True)
        self._thread.start()
        return f"rclpy: node /{self.name}, on {rclpy.get_rmw_implementation_identifier()}"

    async def close(self) -> None:
        """Leave."""
        self._hub.changed.remove(self._change)
        for one in self._told.values():
            if one.end is not None:
                one.end()
        for server in self._actions.values():
            server.close()
        for call in tuple(self._calls):
            call.cancel()
        self._closed = True
        await asyncio.to_thread(self._leave)

    def _leave(self) -> None:
        self._executor.wake()
        self._thread.join()
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def _spin(self) -> None:
        while not self._closed:
            self._executor.spin_once(_SPIN_SECONDS)

    def _soon(self, call: Callable[..., object], *arguments: object) -> None:
        """Let the hub's loop call something, from a thread of rclpy's."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(call, *arguments)

    def _change(self, one: Topic | Service | Action, is_there: bool) -> None:
        """Carry what is there, and no more what has gone."""
        if one.name.startswith(ROSAPI):
            return
        if isinstance(one, Action):
            return self._change_action(one, is_there)
        if not is_there:
            if (told := self._told.pop(one.name, None)) is not None:
                if told.end is not None:
                    told.end()
                self._node.destroy_publisher(told.publisher)
            if (end := self._others.pop(_own_key(one), None)) is not None:
                end()
            return
        try:
            if isinstance(one, Service):
                self._serve(one)
            elif one.is_told and one.name not in self._told:
                self._tell(one)
            elif one.take is not None and _own_key(one) not in self._others:
                self._listen(one)
        except _UnlikeError as error:
            self._leave_out(one.name, error)

    def _leave_out(self, name: str, error: _UnlikeError) -> None:
        if str(error) not in self._missing:
            self._say(f"rclpy: {error}; what needs it is left out, such as {name}")
        self._missing.add(str(error))

    def _change_action(self, action: Action, is_there: bool) -> None:
        if is_there:
            probe = ActionServer(action, lambda: self._hub.now)
            try:  # whole or not at all
                for one in (*probe.services, *probe.topics):
                    class_of(one.type)
            except _UnlikeError as error:
                return self._leave_out(action.name, error)
        change_action(self._actions, action, is_there, self._hub, self._change)

    def _tell(self, topic: Topic) -> None:
        depth = QUEUE if topic.reliable else SMALL_QUEUE
        quality = QoSProfile(
            depth=1 if topic.latched else depth,
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE,
        )
        matched = PublisherEventCallbacks(
            matched=lambda info: self._soon(self._want, topic.name, info.current_count > 0)
        )
        publisher = self._node.create_publisher(class_of(topic.type), topic.name, quality, event_callbacks=matched)
        self._told[topic.name] = _Told(topic, publisher)

    def _want(self, name: str, wanted: bool) -> None:
        """Read a topic while somebody here does; what is latched is read once, and kept by its publisher."""
        told = self._told.get(name)
        if told is None or wanted == (told.end is not None):
            return
        if wanted:
            told.end = self._hub.read(told.topic, lambda message: told.publisher.publish(message.cdr))
        elif told.end is not None:
            told.end()
            told.end = None

    def _listen(self, topic: Topic) -> None:
        # Best effort meets publishers of both kinds.
        quality = QoSProfile(depth=QUEUE, reliability=ReliabilityPolicy.BEST_EFFORT)
        subscription = self._node.create_subscription(
            class_of(topic.type), topic.name, lambda cdr: self._soon(self._hub.hear_cdr, topic, cdr), quality, raw=True
        )
        self._others[_own_key(topic)] = lambda: self._node.destroy_subscription(subscription)

    def _serve(self, service: Service) -> None:
        kind = class_of(service.type)

        def packed(told: RosValue) -> Any:  # noqa: ANN401 classes of the ROS here
            return deserialize_message(Message(f"{service.type}_Response", told).cdr, kind.Response)

        def answer(request: Any, response: Any) -> Any:  # noqa: ANN401 classes of the ROS here
            """Answer in a thread of rclpy's, always, as the caller waits; ROS 2 has no other way to tell a refusal."""
            try:
                value = Message.from_cdr(f"{service.type}_Request", serialize_message(request)).value
                call = asyncio.run_coroutine_threadsafe(_answered(service, value), self._loop)
                self._calls.add(call)
                try:
                    return packed(call.result())
                finally:
                    self._calls.discard(call)
            except BaseException as error:  # whatever a service raises or tells amiss, and the end of this one
                return packed(refusal(service.type, str(error) or repr(error)))

        served = self._node.create_service(kind, service.name, answer, callback_group=self._services)
        self._others[_own_key(service)] = lambda: self._node.destroy_service(served)


async def _answered(service: Service, request: RosValue) -> RosValue:
    return await service.answer(request)


def class_of(type: str) -> Any:  # noqa: ANN401 each type is a class of its own, made by ROS
    """Return the class of a message or a service in the ROS here.

    Raises:
        _UnlikeError: where there is none, or one with other fields.
    """
    package, kind, base = type.split("/")
    own = next((end for end in _PARTS if base.endswith(end) and kind == "action"), "")
    try:
        module = import_module(f"{package}.{kind}")
    except Exception as error:  # whatever a package raises that can't be loaded
        raise _UnlikeError(f"this ROS has no package {package} with {kind} ({error})") from error
    try:
        found = getattr(module, base.removesuffix(own))
        if own:
            found = getattr(found.Impl, _PARTS[own])
    except AttributeError as error:
        raise _UnlikeError(f"{package} of this ROS has no {kind} {base.removesuffix(own)}") from error
    is_message = kind == "msg" or own == "_FeedbackMessage"
    parts = {"": found} if is_message else {"_Request": found.Request, "_Response": found.Response}
    for end, one in parts.items():
        theirs, ours = [*one.get_fields_and_field_types()], [name for name in fields(type + end) if name != NO_FIELD]
        if theirs != ours:
            raise _UnlikeError(f"{type} has other fields in this ROS: {', '.join(theirs)}, not {', '.join(ours)}")
    return found


def _own_key(one: Topic | Service) -> str:
    # The same name may be that of a service and a topic.
    return f"{type(one).__name__} {one.name}"
