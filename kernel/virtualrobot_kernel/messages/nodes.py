"""Nodes: messages to frozen specifications, and nodes of a snapshot to messages."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from virtualrobot.v1 import nodes_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.figures import figure, figure_message
from virtualrobot_kernel.messages.robots import robot_data, robot_message
from virtualrobot_kernel.messages.sensing import sensing_data, sensing_message
from virtualrobot_kernel.messages.values import (
    by_name,
    finite,
    is_identity,
    not_negative,
    pose,
    pose_message,
    vector,
    vector_message,
)
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    WORLD_NAME,
    Inertial,
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    Mimic,
    Node,
    NodeData,
    NodeSpec,
    PartData,
    RobotData,
    ToolData,
)

JOINT_TYPES = {
    nodes_pb2.JOINT_TYPE_UNSPECIFIED: JointType.FIXED,
    nodes_pb2.JOINT_TYPE_FIXED: JointType.FIXED,
    nodes_pb2.JOINT_TYPE_REVOLUTE: JointType.REVOLUTE,
    nodes_pb2.JOINT_TYPE_CONTINUOUS: JointType.CONTINUOUS,
    nodes_pb2.JOINT_TYPE_PRISMATIC: JointType.PRISMATIC,
    nodes_pb2.JOINT_TYPE_FLOATING: JointType.FLOATING,
    nodes_pb2.JOINT_TYPE_PLANAR: JointType.PLANAR,
}
SENSING = frozenset({"range_sensor", "camera_sensor", "contact_sensor", "motion_sensor", "light"})
"""The kinds of nodes whose messages are converted field by field."""
JOINT_TYPE_NUMBERS = {kind: number for number, kind in JOINT_TYPES.items()}


def node_spec(message: nodes_pb2.Node) -> NodeSpec:
    """Return what a message says of a node to create; raise KernelError that names the field that is wrong."""
    what = message.name or "node"
    kind = message.WhichOneof("kind")
    if kind is None:
        names = ", ".join(
            field.name for field in message.DESCRIPTOR.oneofs_by_name["kind"].fields if field.name != "world"
        )
        raise KernelError(f"the node {message.name!r} does not say what it is; give one of {names}", node=message.name)
    return NodeSpec(
        name=message.name,
        kind=Kind(kind),
        parent=message.parent or WORLD_NAME,
        parent_t_node=pose(message.parent_t_node, f"{what}.parent_t_node"),
        hidden=message.hidden,
        figures=figures(message, what),
        data=node_data(message, what),
        running=runs(message),
    )


def runs(message: nodes_pb2.Node) -> bool:
    """Return whether a message says of a sensor that it reads at its rate."""
    kind = message.WhichOneof("kind")
    return kind in SENSING and getattr(getattr(message, kind), "running", False)


def figures(message: nodes_pb2.Node, what: str) -> tuple:
    """Return the figures of a node."""
    return tuple(figure(item, f"{what}.figures[{i}]") for i, item in enumerate(message.figures))


def node_data(message: nodes_pb2.Node, what: str) -> NodeData:
    """Return what only this kind of node has, or None."""
    kind = message.WhichOneof("kind")
    if kind == "part":
        return _part(message.part, what)
    if kind == "robot":
        return robot_data(message.robot, what)
    if kind == "link":
        return LinkData(_joint(message.link.joint, what), _told_inertial(message.link, what))
    if kind == "tool":
        return _tool(message.tool, what)
    return sensing_data(getattr(message, kind), f"{what}.{kind}") if kind in SENSING else None


def _joint(message: nodes_pb2.Joint, what: str) -> Joint:
    kind = JOINT_TYPES.get(message.type)
    if kind is None:
        raise KernelError(f"{what}.link.joint.type {message.type} is not a JointType", node=what)
    axis = np.array(vector(message.axis, f"{what}.link.joint.axis") if message.HasField("axis") else (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise KernelError(f"the axis of the joint {message.name!r} of {what!r} is zero; give a direction", node=what)
    if kind is not JointType.FIXED and not message.name:
        raise KernelError(f"the joint of the link {what!r} has no name", node=what)
    x, y, z = (axis if abs(length - 1.0) < 1e-15 else axis / length).tolist()
    mimic = None
    if message.HasField("mimic"):
        given = message.mimic
        multiplier = given.multiplier if given.HasField("multiplier") else 1.0
        mimic = Mimic(
            given.joint, finite(multiplier, f"{what}.mimic.multiplier"), finite(given.offset, f"{what}.mimic.offset")
        )
    limits = joint_limits(message.limits if message.HasField("limits") else nodes_pb2.JointLimits(), message.name)
    return Joint(message.name, kind, (x, y, z), limits, mimic)


def joint_limits(message: nodes_pb2.JointLimits, what: str) -> JointLimits:
    """Return limits with the kernel's defaults filled in."""
    default = JointLimits()
    lower = message.lower if message.HasField("lower") else -math.inf
    upper = message.upper if message.HasField("upper") else math.inf
    if not lower <= upper or lower == math.inf or upper == -math.inf:
        raise KernelError(
            f"the limits of the joint {what!r} are {lower:g} to {upper:g}; the lower one must be the lesser, and a "
            "number between them",
            joint=what,
        )
    rates = {}
    for name in ("velocity", "acceleration", "jerk"):
        value = getattr(message, name)
        if not (math.isfinite(value) and value >= 0.0):
            raise KernelError(
                f"the {name} limit of the joint {what!r} must be 0 (the default) or above, not {value:g}", joint=what
            )
        rates[name] = value or getattr(default, name)
    return JointLimits(lower, upper, **rates, effort=not_negative(message.effort, f"{what}.effort"))


def limits_message(limits: JointLimits) -> nodes_pb2.JointLimits:
    """Return limits as a message; infinite ones are absent."""
    message = nodes_pb2.JointLimits(
        velocity=limits.velocity, acceleration=limits.acceleration, jerk=limits.jerk, effort=limits.effort
    )
    if math.isfinite(limits.lower):
        message.lower = limits.lower
    if math.isfinite(limits.upper):
        message.upper = limits.upper
    return message


def _part(message: nodes_pb2.Part, what: str) -> PartData:
    mass, told = not_negative(message.mass_kilograms, f"{what}.part.mass_kilograms"), _told_inertial(message, what)
    if told is None:
        return PartData(mass)
    if mass not in (0.0, told.mass):
        raise KernelError(
            f"{what}.part.mass_kilograms is {mass:g} and that of its inertial {told.mass:g}; give one or the same",
            field=f"{what}.part.mass_kilograms",
        )
    return PartData(told.mass, told)


def _told_inertial(message: nodes_pb2.Link | nodes_pb2.Part | nodes_pb2.Tool, what: str) -> Inertial | None:
    return inertial(message.inertial, what) if message.HasField("inertial") else None


def inertial(message: nodes_pb2.Inertial, what: str) -> Inertial:
    """Return a mass and how it is spread; raise KernelError that names the field that is wrong."""
    return Inertial(
        mass=not_negative(message.mass_kilograms, f"{what}.inertial.mass_kilograms"),
        link_t_inertial=pose(message.link_t_inertial, f"{what}.inertial.link_t_inertial"),
        diagonal=vector(message.diagonal, f"{what}.inertial.diagonal"),
        products=vector(message.products, f"{what}.inertial.products"),
    )


def _tool(message: nodes_pb2.Tool, what: str) -> ToolData:
    points: dict[str, Pose] = {}
    for point in message.tool_center_points:
        if not point.name or point.name in points:
            raise KernelError(f"the tool centre points of {what!r} must have names that differ", tool=what)
        points[point.name] = pose(point.tool_t_tcp, f"{what}.{point.name}")
    states: dict[str, Mapping[str, float]] = {}
    for state in message.states:
        if not state.name or state.name in states:
            raise KernelError(f"the states of the tool {what!r} must have names that differ", tool=what)
        states[state.name] = by_name(state.joint_positions)
    told = _told_inertial(message, what)
    return ToolData(points, states, told) if points else ToolData(states=states, inertial=told)


def node_message(snapshot: Snapshot, node: Node) -> nodes_pb2.Node:
    """Return a node as it is in a snapshot."""
    structure = snapshot.structure
    parent = structure.nodes.get(node.parent)
    message = nodes_pb2.Node(
        uid=node.uid,
        name=node.name,
        parent=parent.name if parent else "",
        hidden=node.hidden,
        figures=[figure_message(item) for item in node.figures],
    )
    place = snapshot.state.parent_t_node[structure.rows[node.uid]]
    if not is_identity(place):
        message.parent_t_node.CopyFrom(pose_message(place))
    getattr(message, node.kind.value).SetInParent()
    if isinstance(node.data, PartData):
        message.part.mass_kilograms = node.data.mass
        if node.data.inertial:
            message.part.inertial.CopyFrom(_inertial_message(node.data.inertial))
    elif isinstance(node.data, RobotData):
        message.robot.CopyFrom(robot_message(node.data, structure.robots[node.uid].joint_names))
    elif isinstance(node.data, LinkData):
        message.link.CopyFrom(_link_message(node.data))
    elif isinstance(node.data, ToolData):
        message.tool.CopyFrom(_tool_message(node.data))
    elif node.kind.value in SENSING:
        settings = getattr(message, node.kind.value)
        settings.CopyFrom(sensing_message(node.data))
        if node.uid in snapshot.state.running_sensors:
            settings.running = True
    return message


def _link_message(data: LinkData) -> nodes_pb2.Link:
    joint = data.joint
    message = nodes_pb2.Link()
    message.joint.name, message.joint.type = joint.name, JOINT_TYPE_NUMBERS[joint.type]
    if joint.type not in (JointType.FIXED, JointType.FLOATING):
        message.joint.axis.CopyFrom(vector_message(joint.axis))
    if joint.type is not JointType.FIXED:
        message.joint.limits.CopyFrom(limits_message(joint.limits))
    if joint.mimic:
        mimic = joint.mimic
        message.joint.mimic.CopyFrom(
            nodes_pb2.Mimic(joint=mimic.joint, multiplier=mimic.multiplier, offset=mimic.offset)
        )
    if data.inertial:
        message.inertial.CopyFrom(_inertial_message(data.inertial))
    return message


def _inertial_message(data: Inertial) -> nodes_pb2.Inertial:
    message = nodes_pb2.Inertial(mass_kilograms=data.mass)
    if not is_identity(data.link_t_inertial):
        message.link_t_inertial.CopyFrom(pose_message(data.link_t_inertial))
    message.diagonal.CopyFrom(vector_message(data.diagonal))
    message.products.CopyFrom(vector_message(data.products))
    return message


def _tool_message(data: ToolData) -> nodes_pb2.Tool:
    message = nodes_pb2.Tool()
    for name, tool_t_tcp in data.tool_center_points.items():
        message.tool_center_points.add(name=name, tool_t_tcp=pose_message(tool_t_tcp))
    for name, positions in data.states.items():
        message.states.add(name=name, joint_positions=positions)
    if data.inertial:
        message.inertial.CopyFrom(_inertial_message(data.inertial))
    return message
