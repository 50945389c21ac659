"""Messages as ROS 1 (Noetic) has them: types by their MD5 sums, values and bytes from and to those of ROS 2.

Source: wiki.ros.org, "ROS/Technical Overview" and "msg": MD5 sums of texts with constants first, types by their sums.
"""

from __future__ import annotations

import hashlib
from functools import cache
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from virtualrobot_apps.bridges.ros.messages.types import (
    ARRAY,
    BASE,
    FILE,
    MESSAGE,
    NO_FIELD,
    STORE,
    Description,
    definitions,
)
from virtualrobot_apps.bridges.ros.messages.values import default_of

ACTION_PARTS = ("Goal", "Result", "Feedback")

_HEADER = "std_msgs/msg/Header"
_BUILT_IN = {"builtin_interfaces/msg/Time": "time", "builtin_interfaces/msg/Duration": "duration"}
_GOAL_ID, _STATUS = "actionlib_msgs/GoalID goal_id", "actionlib_msgs/GoalStatus status"
_CARRIERS = {
    "ActionGoal": (_GOAL_ID, "Goal goal"),
    "ActionResult": (_STATUS, "Result result"),
    "ActionFeedback": (_STATUS, "Feedback feedback"),
}
"""Messages by which actionlib carries an action, behind a header; source: genaction.py of actionlib_msgs."""


def part_of(action: str, part: str) -> str:
    """Return the name of a message of an action, which ROS 1 puts among the messages: `control_msgs/msg/XGoal`."""
    package, _, base = action.split("/")
    return f"{package}/msg/{base}{part}"


def short(name: str) -> str:
    """Return the name of a type as ROS 1 writes it: `std_msgs/String`."""
    package, _, base = name.split("/")
    return f"{package}/{base}"


def _store() -> Any:  # noqa: ANN401 the class is rosbags' own
    """Return the types of Noetic; those that it lacks are as ROS 2 has them, where our file has nothing else."""
    store = get_typestore(Stores.ROS1_NOETIC)
    texts = {_among_messages(name): lines for name, lines in definitions(FILE.parent / "ros1.yaml")}
    for action in [name.removesuffix("_Goal") for name in STORE.fielddefs if name.endswith("_Goal")]:
        for carrier, (first, second) in _CARRIERS.items():
            second = f"{short(action)}{second}"
            texts[part_of(action, carrier)] = ["std_msgs/Header header", first, second]
    found: dict[str, Any] = {}
    for name, lines in texts.items():
        found |= get_types_from_msg("\n".join(lines), name)
    for name, (constants, fields) in STORE.fielddefs.items():
        named = _among_messages(name)
        if named not in store.types and named not in found and "/action/" not in named:
            found[named] = constants, [one for one in fields if one[0] != NO_FIELD]
    store.register({name: one for name, one in found.items() if name not in store.types})
    return store


def _among_messages(name: str) -> str:
    """Return the name in ROS 1 of a message of ROS 2: the parts of an action are messages."""
    head, _, part = name.rpartition("_")
    return part_of(head, part) if "/action/" in name and part in ACTION_PARTS else name


ROS1 = _store()
"""All types that are known, as ROS 1 has them: services are `a/srv/B_Request` and `a/srv/B_Response`."""


def _md5_text(name: str) -> str:
    constants, fields = ROS1.fielddefs[name]
    lines = [f"{kind} {key}={value}" for key, kind, value in constants]
    for key, (kind, detail) in fields:
        if key == NO_FIELD:
            continue
        suffix = ""
        if int(kind) not in (BASE, MESSAGE):
            (inner, base), size = detail
            suffix = f"[{size}]" if int(kind) == ARRAY else "[]"
            kind, detail = inner, base
        if int(kind) == BASE:
            lines.append(f"{detail[0]}{suffix} {key}")
        elif detail in _BUILT_IN:
            lines.append(f"{_BUILT_IN[detail]}{suffix} {key}")
        else:
            lines.append(f"{md5_of(detail)} {key}")
    return "\n".join(lines)


@cache
def md5_of(name: str) -> str:
    """Return the MD5 sum of a message, or of a service, by which ROS 1 tells whether two have the same type."""
    parts = (name,) if "/srv/" not in name else (f"{name}_Request", f"{name}_Response")
    return hashlib.md5("".join(map(_md5_text, parts)).encode()).hexdigest()


@cache
def definition_of(name: str) -> str:
    """Return the definition of a message with those of all that it holds, as ROS 1 tells it along a connection."""
    return ROS1.generate_msgdef(name, ros_version=1)[0]


@cache
def _is_same(name: str) -> bool:
    """Return whether a type has the same fields in both, but for the number of a header and capital letters."""
    if name not in STORE.fielddefs or name not in ROS1.fielddefs:
        return False
    if name == _HEADER or name in _BUILT_IN:
        return True
    here, there = STORE.fielddefs[name][1], ROS1.fielddefs[name][1]
    if [(key.lower(), str(one)) for key, one in here] != [(key.lower(), str(one)) for key, one in there]:
        return False
    return all(_is_same(inner) for _, one in here if (inner := _message_in(one)) is not None)


def _message_in(one: Description) -> str | None:
    kind, detail = one
    if int(kind) == BASE:
        return None
    return detail if int(kind) == MESSAGE else _message_in(detail[0])


def ros1_bytes(name: str, value: object, cdr: bytes | None = None) -> bytes:
    """Return a message of ROS 2 as ROS 1 has it; fields that ROS 1 lacks are left out, others of its own are zero."""
    named = _among_messages(name)
    if name in STORE.types and _is_same(name):
        return bytes(STORE.cdr_to_ros1(STORE.serialize_cdr(value, name) if cdr is None else cdr, name))
    return bytes(ROS1.serialize_ros1(converted(value, named, ROS1), named))


def from_ros1_bytes(name: str, data: bytes) -> Any:  # noqa: ANN401 each type is a class of its own
    """Return a message of ROS 2 for bytes of ROS 1; raises whatever rosbags does for those that are none."""
    if name not in STORE.types:
        return ROS1.deserialize_ros1(data, name)
    if _is_same(name):
        return STORE.deserialize_cdr(STORE.ros1_to_cdr(data, name), name)
    return converted(ROS1.deserialize_ros1(data, _among_messages(name)), name, STORE)


def converted(value: Any, name: str, store: Any) -> Any:  # noqa: ANN401 each type is a class of its own
    """Return a message as a type of a store, by the names of its fields; what the value lacks is zero."""
    lower = {key.lower(): key for key in vars(value)}  # camera_info has D in ROS 1, and d in ROS 2
    made: dict[str, object] = {}
    for key, one in store.fielddefs[name][1]:
        named = key if hasattr(value, key) else lower.get(key.lower())
        made[key] = default_of(one, store) if named is None else _converted(getattr(value, named), one, store)
    return store.types[name](**made)


def _converted(value: Any, one: Description, store: Any) -> Any:  # noqa: ANN401 a message or any of its parts
    kind, detail = one
    if int(kind) == MESSAGE:
        return converted(value, detail, store)
    if int(kind) != BASE and int(detail[0][0]) == MESSAGE:
        return [converted(item, detail[0][1], store) for item in value]
    return value
