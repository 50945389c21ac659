"""Types of messages, services and actions: those of ROS 2 Jazzy by rosbags, and those that it lacks by our file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from virtualrobot._wire.names import did_you_mean

Description: TypeAlias = tuple[Any, Any]
"""Description of a field by rosbags: its kind (1 base, 2 message, 3 array, 4 sequence), and what it is of."""

FILE = Path(__file__).parent.parent / "definitions" / "interfaces.yaml"
NO_FIELD = "structure_needs_at_least_one_member"
"""Name of the byte that ROS 2 puts into messages without a field; nobody sees it."""

BASE, MESSAGE, ARRAY, _SEQUENCE = 1, 2, 3, 4
_EVENT_INFO = "service_msgs/msg/ServiceEventInfo"
PARTS = {"srv": ("request", "response"), "action": ("goal", "result", "feedback")}

_UUID, _STAMP = "unique_identifier_msgs/UUID goal_id", "builtin_interfaces/Time stamp"


class UnknownTypeError(ValueError):
    """A type that nobody has defined here; its text says which one was meant."""


def full(name: str) -> str:
    """Return the long form of a name: `std_msgs/String` is `std_msgs/msg/String`, as ROS 1 and ROS 2 write it."""
    parts = name.split("/")
    return name if len(parts) != 2 else f"{parts[0]}/msg/{parts[1]}"


def known(name: object) -> str:
    """Return the long form of the name of a message that is known.

    Raises:
        UnknownTypeError: for another one, with the nearest name.
    """
    if isinstance(name, str) and full(name) in STORE.types:
        return full(name)
    hint = did_you_mean(full(str(name)[:80]), STORE.types)
    raise UnknownTypeError(f"the type {str(name)[:80]!r} is not known{hint}")


def of_kind(name: object, kind: str) -> str:
    """Return the name of a service or an action (`kind` is `srv` or `action`) in its long form, if it is known.

    Raises:
        UnknownTypeError: for another one, with the nearest name.
    """
    first = PARTS[kind][0].capitalize()
    parts = str(name)[:80].split("/")
    long = f"{parts[0]}/{kind}/{parts[-1]}"
    if isinstance(name, str) and f"{long}_{first}" in STORE.types:
        return long
    ends = [one.removesuffix(f"_{first}") for one in STORE.types if f"/{kind}/" in one and one.endswith(f"_{first}")]
    raise UnknownTypeError(f"the {kind} type {str(name)[:80]!r} is not known{did_you_mean(long, ends)}")


@cache
def fields(name: str) -> dict[str, Description]:
    """Return the descriptions of a message's fields by their names, in their order."""
    return dict(STORE.fielddefs[name][1])


@cache
def hash_of(name: str) -> str:
    """Return the hash of a type, `RIHS01_...`, by which ROS 2 tells whether two have the same one (REP 2016)."""
    return STORE.hash_rihs01(name)


@cache
def hash_of_service(name: str) -> str:
    """Return the hash of a service: that of a message with its request, its response and its event (REP 2016)."""
    request, response, event = (f"{name}_{part}" for part in ("Request", "Response", "Event"))
    bounded = [("request", (_SEQUENCE, ((MESSAGE, request), 1))), ("response", (_SEQUENCE, ((MESSAGE, response), 1)))]
    info = {
        **fields(_EVENT_INFO),
        "client_gid": (ARRAY, ((BASE, ("uint8", 0)), 16)),
    }  # a char is one for ROS 2's hashes
    store: Any = get_typestore(Stores.EMPTY)
    store.fielddefs = {
        **STORE.fielddefs,
        _EVENT_INFO: ([], [*info.items()]),
        event: ([], [("info", (MESSAGE, _EVENT_INFO)), *bounded]),
        name: ([], [(f"{key}_message", (MESSAGE, f"{name}_{key.capitalize()}")) for key in (*PARTS["srv"], "event")]),
    }
    return store.hash_rihs01(name)


@cache
def text_of(name: str) -> str:
    """Return the definition of a message with those of all that it holds, as bag files have it."""
    return STORE.generate_msgdef(name, ros_version=2)[0]


def make(name: str, /, **values: object) -> Any:  # noqa: ANN401 each type is a class of its own, made by rosbags
    """Return a message of a type with all of its values."""
    return STORE.types[name](**values)


def definitions(file: Path = FILE) -> Iterator[tuple[str, list[str]]]:
    """Yield each message of a file: those of services and actions by their parts, and what carries an action."""
    for package, kinds in yaml.safe_load(file.read_text("utf-8")).items():
        for kind, interfaces in kinds.items():
            for base, parts in interfaces.items():
                name = f"{package}/{kind}/{base}"
                if kind == "msg":
                    yield name, parts
                    continue
                for part in PARTS[kind]:
                    yield f"{name}_{part.capitalize()}", parts[part]
                if kind == "action":
                    yield from _carriers(name)


def _carriers(name: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the messages by which ROS 2 carries an action; source: the design of actions (design.ros2.org)."""
    yield f"{name}_SendGoal_Request", [_UUID, f"{name}_Goal goal"]
    yield f"{name}_SendGoal_Response", ["bool accepted", _STAMP]
    yield f"{name}_GetResult_Request", [_UUID]
    yield f"{name}_GetResult_Response", ["int8 status", f"{name}_Result result"]
    yield f"{name}_FeedbackMessage", [_UUID, f"{name}_Feedback feedback"]


def _parsed(definitions: Iterable[tuple[str, list[str]]]) -> dict[str, Any]:
    """Return the fields of messages as rosbags has them, by their names."""
    found: dict[str, Any] = {}
    for name, lines in definitions:
        # rosbags calls `a/srv/B` `a/srv/msg/B`, and gives an empty message no byte.
        parsed = get_types_from_msg("\n".join(lines or [f"uint8 {NO_FIELD}"]), name)
        found |= {
            key.replace("/srv/msg/", "/srv/").replace("/action/msg/", "/action/"): one for key, one in parsed.items()
        }
    return found


def replace(file: Path) -> None:
    """Put types of a file in place of those that have their names, before any of their messages is made."""
    found = _parsed(definitions(file))
    for name in found:
        STORE.types.pop(name, None)
        STORE.fielddefs.pop(name, None)
    STORE.register(found)
    for cached in (fields, hash_of, hash_of_service, text_of):
        cached.cache_clear()


def _store(definitions: Iterable[tuple[str, list[str]]]) -> Any:  # noqa: ANN401 the class is rosbags' own
    store = get_typestore(Stores.ROS2_JAZZY)
    found = _parsed(definitions)
    store.register({name: one for name, one in found.items() if name not in store.types})
    return store


STORE = _store(definitions())
"""All types that are known."""
