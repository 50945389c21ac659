"""Data of robots alone: messages to frozen values and back, settings of components included."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from google.protobuf.struct_pb2 import Struct, Value
from virtualrobot.v1 import nodes_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import by_name, finite
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.structure import Actuator, JointGroup, LinkPair, RobotData


def robot_data(message: nodes_pb2.Robot, what: str) -> RobotData:
    """Return what a message says of the robot `what`; raise KernelError that names the field that is wrong."""
    postures = {posture.name: by_name(posture.joint_positions) for posture in message.postures}
    if len(postures) != len(message.postures) or "" in postures:
        raise KernelError(f"the postures of {what!r} must have names that differ", robot=what)
    return RobotData(
        message.flange,
        message.kinematics,
        postures,
        message.source,
        settings(message.kinematics_settings, f"{what}.robot.kinematics_settings"),
        joint_groups(message.groups, what),
        tuple(LinkPair(pair.first, pair.second, pair.reason) for pair in message.allowed_collisions),
        _actuators(message, what),
    )


def joint_groups(messages: Iterable[nodes_pb2.JointGroup], robot: str) -> tuple[JointGroup, ...]:
    """Return the groups of a robot; raise KernelError unless their names differ."""
    groups = tuple(_joint_group(message, robot) for message in messages)
    if len({group.name for group in groups} - {""}) != len(groups):
        raise KernelError(f"the groups of {robot!r} must have names that differ", robot=robot)
    return groups


def _joint_group(message: nodes_pb2.JointGroup, what: str) -> JointGroup:
    return JointGroup(
        message.name,
        tuple(message.joint_names),
        message.base_link,
        message.tip_link,
        message.kinematics,
        settings(message.kinematics_settings, f"{what}.robot.groups[{message.name!r}].kinematics_settings"),
    )


def group_selection(message: nodes_pb2.GroupSelection, what: str) -> Group:
    """Return the group that a message chooses; raise KernelError for one that says it twice."""
    if message.name and (message.base_link or message.tip_link):
        raise KernelError(
            f"{what} names the group {message.name!r} and links, {message.base_link!r} and {message.tip_link!r}; give "
            "the name or the links",
            field=what,
        )
    return Group(message.name, message.base_link, message.tip_link)


def selection_message(group: Group) -> nodes_pb2.GroupSelection:
    """Return the choice of a group."""
    return nodes_pb2.GroupSelection(name=group.name, base_link=group.base, tip_link=group.tip)


def _actuators(message: nodes_pb2.Robot, what: str) -> tuple[Actuator, ...]:
    actuators = tuple(_actuator(one, f"{what}.robot.actuators[{i}]") for i, one in enumerate(message.actuators))
    if len({one.name for one in actuators} - {""}) != len(actuators):
        raise KernelError(f"the actuators of {what!r} must have names that differ", robot=what)
    return actuators


def _actuator(message: nodes_pb2.Actuator, what: str) -> Actuator:
    terms = {term.joint: finite(term.ratio, f"{what}: the ratio of {term.joint!r}") for term in message.terms}
    if not terms or len(terms) != len(message.terms) or 0.0 in terms.values():
        raise KernelError(
            f"{what}, {message.name!r}, needs terms with joints that differ and ratios other than 0", field=what
        )
    lower = finite(message.lower, f"{what}.lower") if message.HasField("lower") else -math.inf
    upper = finite(message.upper, f"{what}.upper") if message.HasField("upper") else math.inf
    if lower > upper:
        raise KernelError(f"the limits of {what}, {message.name!r}, are {lower:g} to {upper:g}; the lower one first")
    return Actuator(message.name, tuple(terms.items()), finite(message.offset, f"{what}.offset"), lower, upper)


def robot_message(data: RobotData, joint_names: tuple[str, ...]) -> nodes_pb2.Robot:
    """Return a robot's data, with the names of its joints."""
    return nodes_pb2.Robot(
        joint_names=joint_names,
        flange=data.flange,
        kinematics=data.kinematics,
        postures=posture_messages(data),
        source=data.source,
        kinematics_settings=settings_message(data.kinematics_settings),
        groups=group_messages(data),
        allowed_collisions=pair_messages(data),
        actuators=actuator_messages(data),
    )


def posture_messages(data: RobotData) -> list[nodes_pb2.NamedPosture]:
    """Return a robot's postures."""
    return [nodes_pb2.NamedPosture(name=name, joint_positions=joints) for name, joints in data.postures.items()]


def settings_message(settings: Mapping[str, Any]) -> Struct | None:
    """Return the settings of a component; None when there are none."""
    if not settings:
        return None
    message = Struct()
    message.update(settings)
    return message


def group_messages(data: RobotData) -> list[nodes_pb2.JointGroup]:
    """Return a robot's groups of joints."""
    return [
        nodes_pb2.JointGroup(
            name=group.name,
            joint_names=group.joint_names,
            base_link=group.base_link,
            tip_link=group.tip_link,
            kinematics=group.kinematics,
            kinematics_settings=settings_message(group.kinematics_settings),
        )
        for group in data.groups
    ]


def pair_messages(data: RobotData) -> list[nodes_pb2.LinkPair]:
    """Return the pairs of a robot's links that may touch."""
    return [
        nodes_pb2.LinkPair(first=pair.first, second=pair.second, reason=pair.reason) for pair in data.allowed_collisions
    ]


def actuator_messages(data: RobotData) -> list[nodes_pb2.Actuator]:
    """Return what moves a robot's joints; infinite limits are absent."""
    return [
        nodes_pb2.Actuator(
            name=one.name,
            terms=[nodes_pb2.ActuatorTerm(joint=joint, ratio=ratio) for joint, ratio in one.terms],
            offset=one.offset,
            lower=one.lower if math.isfinite(one.lower) else None,
            upper=one.upper if math.isfinite(one.upper) else None,
        )
        for one in data.actuators
    ]


def settings(message: Struct, what: str) -> dict[str, Any]:
    """Return the plain values of a component's settings, names sorted; raise KernelError for a number not finite."""
    # Sorted, since the order of a map's entries differs between processes.
    return {name: _plain(message.fields[name], f"{what}.{name}") for name in sorted(message.fields)}


def _plain(value: Value, what: str) -> Any:  # noqa: ANN401  whatever JSON can say
    kind = value.WhichOneof("kind")
    if kind == "struct_value":
        return settings(value.struct_value, what)
    if kind == "list_value":
        return [_plain(entry, f"{what}[{place}]") for place, entry in enumerate(value.list_value.values)]
    if kind == "number_value":
        return finite(value.number_value, what)
    return None if kind in (None, "null_value") else getattr(value, kind)
