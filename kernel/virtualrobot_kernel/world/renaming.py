"""Renaming of joints and nodes, and of all references to them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TypeVar

from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.sensing import ContactSensor, Encoders, MotionSensor
from virtualrobot_kernel.world.structure import (
    Joint,
    JointType,
    Kind,
    LinkData,
    Node,
    NodeData,
    RobotData,
    Structure,
    TargetData,
    ToolData,
    ToolWidth,
)
from virtualrobot_kernel.world.targets import taught_with

K = TypeVar("K", str, float)


def with_joint_renamed(structure: Structure, link: Node, joint: Joint, nodes: Mapping[int, Node]) -> dict[int, Node]:
    """Return `nodes` with the new name wherever they named the joint of a link that becomes `joint`.

    Joints that mimic it, the robot's postures, groups and actuators, the states of its tools, its encoders and the
    targets that were taught with it name it; the component's settings are its own affair. `structure` and `link` are as
    they were before.
    """
    assert isinstance(link.data, LinkData)
    old, new = link.data.joint.name, joint.name
    robot = structure.robot_of(link.uid)
    result = dict(nodes)
    if robot is None or old == new or link.data.joint.type is JointType.FIXED:  # nothing names fixed joints
        return result
    names = {old: new, **dict(zip(link.data.joint.coordinate_names, joint.coordinate_names, strict=False))}
    sensors = (
        node.uid
        for node in structure.below(robot.uid)
        if node.kind is Kind.MOTION_SENSOR and structure.robot_of(node.uid) is robot
    )
    targets = (node.uid for node in taught_with(structure.nodes.values(), robot.name))
    links, tools = structure.robots[robot.uid].links, (tool.uid for tool in structure.own_tools_of(robot.uid))
    for uid in (robot.uid, *links, *tools, *sensors, *targets):
        data = nodes[uid].data
        for before, after in names.items():
            data = _with_other_name(data, before, after)
        if data is not nodes[uid].data and uid != link.uid:
            result[uid] = replace(nodes[uid], data=data)
    return result


def with_nodes_renamed(before: Structure, after: Structure) -> Structure:
    """Return `after`, where nodes have other names than in `before`; sensors and targets that named them follow."""
    names = {
        node.name: after.nodes[uid].name
        for uid, node in before.nodes.items()
        if uid in after.nodes and after.nodes[uid].name != node.name
    }
    for node in tuple(after.nodes.values()):
        data = node.data
        if isinstance(data, ContactSensor) and not names.keys().isdisjoint((data.watched, *data.ignored)):
            ignored = tuple(names.get(name, name) for name in data.ignored)
            data = replace(data, watched=names.get(data.watched, data.watched), ignored=ignored)
            after = index.replaced(after, replace(node, data=data))
        if isinstance(data, TargetData) and not names.keys().isdisjoint((data.robot, data.tool)):
            data = replace(data, robot=names.get(data.robot, data.robot), tool=names.get(data.tool, data.tool))
            after = index.replaced(after, replace(node, data=data))
    return after


def _with_other_name(data: NodeData, old: str, new: str) -> NodeData:
    """Return the data itself when it does not name the joint."""
    if isinstance(data, LinkData):
        mimic = data.joint.mimic
        if mimic is not None and mimic.joint == old:
            return replace(data, joint=replace(data.joint, mimic=replace(mimic, joint=new)))
    if isinstance(data, MotionSensor) and isinstance(data.kind, Encoders) and old in data.kind.joints:
        joints = tuple(new if name == old else name for name in data.kind.joints)
        return replace(data, kind=replace(data.kind, joints=joints))
    if isinstance(data, ToolData):
        widths = {one.width: one.joint_positions for one in data.widths}
        if _named(old, (*data.states.values(), *widths.values())):
            told = (ToolWidth(*one) for one in _renamed(widths, old, new).items())
            return replace(data, states=_renamed(data.states, old, new), widths=tuple(told))
    if isinstance(data, TargetData) and old in data.joint_positions:
        return replace(data, joint_positions=_renamed({"": data.joint_positions}, old, new)[""])
    if isinstance(data, RobotData) and _named(old, _places_of_names(data)):
        groups = (
            replace(group, joint_names=tuple(new if name == old else name for name in group.joint_names))
            for group in data.groups
        )
        actuators = (
            replace(one, terms=tuple((new if name == old else name, ratio) for name, ratio in one.terms))
            for one in data.actuators
        )
        return replace(
            data, postures=_renamed(data.postures, old, new), groups=tuple(groups), actuators=tuple(actuators)
        )
    return data


def _places_of_names(data: RobotData) -> Iterable[Iterable[str]]:
    """Yield whatever of a robot names joints."""
    yield from data.postures.values()
    yield from (group.joint_names for group in data.groups)
    yield from (dict(actuator.terms) for actuator in data.actuators)


def _named(name: str, places: Iterable[Iterable[str]]) -> bool:
    return any(name in place for place in places)


def _renamed(positions: Mapping[K, Mapping[str, float]], old: str, new: str) -> dict[K, dict[str, float]]:
    """Return joint positions by posture, state or width with another name of a joint."""
    return {
        key: {new if name == old else name: value for name, value in joints.items()}
        for key, joints in positions.items()
    }
