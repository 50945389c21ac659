"""Nodes: messages to frozen specifications, and nodes of a snapshot to messages."""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import replace

from virtualrobot.v1 import geometry_pb2, nodes_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import (
    BY_NAME,
    NOT_NEGATIVE,
    PLAIN,
    POSE,
    Codec,
    EnumTable,
    OrDefault,
    Pair,
    named,
)
from virtualrobot_kernel.messages.figures import figure, figure_message
from virtualrobot_kernel.messages.robots import ROBOT
from virtualrobot_kernel.messages.sensing import SENSORS
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import GREATEST, is_identity, pose, pose_message, vector, vector_message
from virtualrobot_kernel.world.about import About, or_none
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    GREATEST_FIELD,
    LEAST_DISTANCE,
    LEAST_FIELD,
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
    TargetData,
    ToolData,
    ToolWidth,
    ViewpointData,
)
from virtualrobot_kernel.world.widths import check_widths


def _axis(message: geometry_pb2.Vector3, what: str) -> tuple[float, float, float]:
    x, y, z = vector(message, what)
    length = math.hypot(x, y, z)
    if length < 1e-9:
        raise KernelError(f"{what} is zero; give a direction", field=what)
    return (x, y, z) if abs(length - 1.0) < 1e-15 else (x / length, y / length, z / length)


def _check_limits(limits: JointLimits, what: str) -> None:
    lower, upper = limits.lower, limits.upper
    if not lower <= upper or lower == math.inf or upper == -math.inf:
        raise KernelError(
            f"{what} are {lower:g} to {upper:g}; the lower one must be the lesser, and a number between them",
            field=what,
        )


def _check_joint(joint: Joint, what: str) -> None:
    if joint.type is not JointType.FIXED and not joint.name:
        raise KernelError(f"{what} has no name", field=what)


def _check_viewpoint(viewpoint: ViewpointData, what: str) -> None:
    if not LEAST_FIELD <= viewpoint.field_of_view <= GREATEST_FIELD:
        raise KernelError(
            f"{what}.field_of_view_radians is {viewpoint.field_of_view:g}; it goes from {LEAST_FIELD:g} to "
            f"{GREATEST_FIELD:g} rad",
            field=f"{what}.field_of_view_radians",
            value=viewpoint.field_of_view,
        )
    if not LEAST_DISTANCE <= viewpoint.distance <= GREATEST:
        raise KernelError(
            f"{what}.distance_meters is {viewpoint.distance:g}; it goes from {LEAST_DISTANCE:g} to {GREATEST:g} m",
            field=f"{what}.distance_meters",
            value=viewpoint.distance,
        )


def _joint_message(joint: Joint) -> nodes_pb2.Joint:
    message = JOINT.write(joint)
    if joint.type not in (JointType.FIXED, JointType.FLOATING):
        message.axis.CopyFrom(vector_message(joint.axis))
    if joint.type is JointType.FIXED:
        message.ClearField("limits")
    return message


def _part(message: nodes_pb2.Part, what: str) -> PartData:
    part = PART.read(message, what)
    if part.inertial is None:
        return part
    if part.mass not in (0.0, part.inertial.mass):
        raise KernelError(
            f"{what}.mass_kilograms is {part.mass:g} and that of its inertial {part.inertial.mass:g}; give one or the "
            "same",
            field=f"{what}.mass_kilograms",
        )
    return replace(part, mass=part.inertial.mass)


JOINT_TYPES = EnumTable(JointType, nodes_pb2.JointType, JointType.FIXED)
RATE = OrDefault(NOT_NEGATIVE)
LIMITS = Table(
    JointLimits,
    nodes_pb2.JointLimits,
    lower=PLAIN,
    upper=PLAIN,
    velocity=RATE,
    acceleration=RATE,
    jerk=RATE,
    effort=NOT_NEGATIVE,
    check=_check_limits,
)
JOINT = Table(
    Joint,
    nodes_pb2.Joint,
    type=JOINT_TYPES,
    axis=Pair(_axis, vector_message),
    limits=LIMITS,
    mimic=Table(Mimic, nodes_pb2.Mimic),
    check=_check_joint,
)
INERTIAL = Table(Inertial, nodes_pb2.Inertial, mass=NOT_NEGATIVE)
PART = Table(PartData, nodes_pb2.Part, mass=NOT_NEGATIVE, inertial=INERTIAL)
LINK = Table(LinkData, nodes_pb2.Link, joint=Pair(JOINT.read, _joint_message), inertial=INERTIAL)
TOOL = Table(
    ToolData,
    nodes_pb2.Tool,
    tool_center_points=named(nodes_pb2.ToolCenterPoint, "tool_t_tcp", POSE),
    states=named(nodes_pb2.ToolState, "joint_positions", BY_NAME),
    inertial=INERTIAL,
    widths=Table(ToolWidth, nodes_pb2.ToolWidth),
    check=lambda tool, what: check_widths(tool.widths, what),
)
TARGET = Table(TargetData, nodes_pb2.Target)
VIEWPOINT = Table(
    ViewpointData,
    nodes_pb2.Viewpoint,
    distance=OrDefault(NOT_NEGATIVE),
    field_of_view=OrDefault(NOT_NEGATIVE),
    check=_check_viewpoint,
)
DATA: dict[str, Codec] = {
    "part": Pair(_part, PART.write),
    "robot": ROBOT,
    "link": LINK,
    "tool": TOOL,
    "target": TARGET,
    "viewpoint": VIEWPOINT,
    **SENSORS,
}
"""Codec of what only one kind of node has, by its field in `Node`."""

ALL_FIELDS = frozenset(nodes_pb2.Node.DESCRIPTOR.fields_by_name)


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
        about=or_none(About(message.description, tuple(message.tags), message.icon, message.locked)),
    )


def runs(message: nodes_pb2.Node) -> bool:
    """Return whether a message says of a sensor that it reads at its rate."""
    kind = message.WhichOneof("kind")
    return kind in SENSORS and getattr(getattr(message, kind), "running", False)


def figures(message: nodes_pb2.Node, what: str) -> tuple:
    """Return the figures of a node."""
    return tuple(figure(item, f"{what}.figures[{i}]") for i, item in enumerate(message.figures))


def node_data(message: nodes_pb2.Node, what: str) -> NodeData:
    """Return what only this kind of node has, or None."""
    kind = message.WhichOneof("kind")
    return DATA[kind].read(getattr(message, kind), f"{what}.{kind}") if kind in DATA else None


def node_message(snapshot: Snapshot, node: Node, fields: Container[str] | None = None) -> nodes_pb2.Node:
    """Return a node as it is in a snapshot; with `fields` no more than these of its message."""
    told = ALL_FIELDS if fields is None else fields
    structure, kind = snapshot.structure, node.kind.value
    message = nodes_pb2.Node()
    if "uid" in told:
        message.uid = node.uid
    if "name" in told:
        message.name = node.name
    if "parent" in told and node.parent in structure.nodes:
        message.parent = structure.nodes[node.parent].name
    if "hidden" in told:
        message.hidden = node.hidden
    if node.about is not None:
        about = node.about
        for field in ("description", "icon", "locked"):
            if field in told:
                setattr(message, field, getattr(about, field))
        if "tags" in told:
            message.tags.extend(about.tags)
    if "figures" in told:
        message.figures.extend(figure_message(item) for item in node.figures)
    if "parent_t_node" in told:
        place = snapshot.state.parent_t_node[structure.rows[node.uid]]
        if not is_identity(place):
            message.parent_t_node.CopyFrom(pose_message(place))
    if kind in told:
        own = getattr(message, kind)
        own.SetInParent()
        if kind in DATA and node.data is not None:
            own.CopyFrom(DATA[kind].write(node.data))
        if node.kind is Kind.ROBOT:
            own.joint_names.extend(structure.robots[node.uid].joint_names)
        elif node.uid in snapshot.state.running_sensors:
            own.running = True
    return message
