"""Services of rosapi: which topics, services and actions there are, and what their messages consist of."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from functools import partial

import numpy as np

from virtualrobot_apps.bridges.ros.hub import ROSAPI, Hub, HubError, Service
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, time_of
from virtualrobot_apps.bridges.ros.messages.types import (
    ARRAY,
    BASE,
    MESSAGE,
    NO_FIELD,
    Description,
    fields,
    full,
    known,
    make,
    of_kind,
    text_of,
)
from virtualrobot_apps.bridges.ros.messages.values import default, to_plain
from virtualrobot_apps.bridges.ros.parameters import Answer
from virtualrobot_apps.bridges.ros.parameters import answers as serve_parameters

NODE = "/virtualrobot"
"""Name of the bridge, the one node that clients of rosbridge see."""

_PARTS = ("goal", "result", "feedback")


def serve_rosapi(hub: Hub) -> None:
    """Add the services of rosapi to a hub."""
    answers: dict[str, tuple[str, Answer]] = {
        "topics": ("Topics", lambda _: {"topics": [*hub.topics], "types": [one.type for one in hub.topics.values()]}),
        "topics_for_type": ("TopicsForType", lambda asked: {"topics": _of_type(hub.topics.values(), full(asked.type))}),
        "topic_type": ("TopicType", lambda asked: {"type": _type(hub.topics, asked.topic)}),
        "topics_and_raw_types": ("TopicsAndRawTypes", lambda _: _raw_types(hub)),
        "publishers": ("Publishers", lambda asked: {"publishers": _nodes(hub, asked.topic, told=True)}),
        "subscribers": ("Subscribers", lambda asked: {"subscribers": _nodes(hub, asked.topic, told=False)}),
        "services": ("Services", lambda _: {"services": [*hub.services]}),
        "services_for_type": (
            "ServicesForType",
            lambda asked: {"services": _of_type(hub.services.values(), _service_type(asked.type))},
        ),
        "service_type": ("ServiceType", lambda asked: {"type": _type(hub.services, asked.service)}),
        "action_servers": ("GetActionServers", lambda _: {"action_servers": [*hub.actions]}),
        "action_type": ("ActionType", lambda asked: {"type": _type(hub.actions, asked.action)}),
        "nodes": ("Nodes", lambda _: {"nodes": [NODE]}),
        "get_time": ("GetTime", lambda _: {"time": time_of(hub.now)}),
        "message_details": ("MessageDetails", lambda asked: {"typedefs": details(known(asked.type))}),
        "service_request_details": (
            "ServiceRequestDetails",
            lambda asked: {"typedefs": details(f"{of_kind(asked.type, 'srv')}_Request")},
        ),
        "service_response_details": (
            "ServiceResponseDetails",
            lambda asked: {"typedefs": details(f"{of_kind(asked.type, 'srv')}_Response")},
        ),
        **{f"action_{part}_details": (f"Action{part.capitalize()}Details", _part_of_action(part)) for part in _PARTS},
        **serve_parameters(hub.parameters),
    }
    for name, (base, answer) in answers.items():
        type = f"rosapi_msgs/srv/{base}"
        hub.serve(Service(f"{ROSAPI}{name}", type, partial(_answered, type, answer)))


def _answered(type: str, answer: Answer, request: RosValue) -> Awaitable[RosValue]:
    async def made() -> RosValue:
        told = answer(request)
        return make(f"{type}_Response", **(told if isinstance(told, dict) else await told))

    return made()


def _part_of_action(part: str) -> Callable[[RosValue], dict[str, object]]:
    return lambda asked: {"typedefs": details(f"{of_kind(asked.type, 'action')}_{part.capitalize()}")}


def details(name: str) -> list[RosValue]:
    """Return what a message and all that it holds consist of, as `rosapi_msgs/TypeDef`."""
    found: dict[str, RosValue] = {}

    def add(type: str) -> None:
        if type in found:
            return
        told = {key: one for key, one in fields(type).items() if key != NO_FIELD}
        plain = to_plain(default(type))
        inner = [_inner(one) for one in told.values()]
        found[type] = make(
            "rosapi_msgs/msg/TypeDef",
            type=type,
            fieldnames=[*told],
            fieldtypes=inner,
            fieldarraylen=_lengths(told.values()),
            examples=[str(plain[key]) for key in told],
            constnames=[],
            constvalues=[],
        )
        for one in inner:
            if "/" in one:
                add(one)

    add(name)
    return list(found.values())


def _inner(one: Description) -> str:
    kind, detail = int(one[0]), one[1]
    if kind == BASE:
        return detail[0]
    return detail if kind == MESSAGE else _inner(detail[0])


def _lengths(told: Iterable[Description]) -> RosValue:
    kinds = [(int(one[0]), one[1]) for one in told]
    lengths = [-1 if kind in (BASE, MESSAGE) else detail[1] if kind == ARRAY else 0 for kind, detail in kinds]
    return np.array(lengths, np.int32)


def _of_type(found: Iterable[RosValue], type: str) -> list[str]:
    return [one.name for one in found if one.type == type]


def _service_type(name: str) -> str:
    parts = name.split("/")
    return f"{parts[0]}/srv/{parts[-1]}"


def _type(table: dict[str, RosValue], name: str) -> str:
    if (one := table.get("/" + name.removeprefix("/"))) is None:
        raise HubError(f"there is no {name[:80]!r}")
    return one.type


def _raw_types(hub: Hub) -> dict[str, object]:
    types = [one.type for one in hub.topics.values()]
    return {"topics": [*hub.topics], "types": types, "typedefs_full_text": [text_of(one) for one in types]}


def _nodes(hub: Hub, name: str, *, told: bool) -> list[str]:
    topic = hub.topics.get("/" + name.removeprefix("/"))
    if topic is None:
        return []
    there = (topic.is_told or topic.writers) if told else (topic.take or topic.readers)
    return [NODE] if there else []
