"""Warnings of an export for properties of a robot that URDF has no word for."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from virtualrobot_kernel.formats.export.names import listed
from virtualrobot_kernel.formats.limits import joint_limits
from virtualrobot_kernel.world.figures import Figure, Frame, Label, Lines, Material, Points
from virtualrobot_kernel.world.structure import (
    AUTOMATIC_KINEMATICS,
    Joint,
    JointType,
    Kind,
    LinkData,
    Node,
    RobotData,
    ToolData,
)


def losses(
    robot: Node,
    nodes: Sequence[Node],
    left_out: Sequence[Node],
    figures: Mapping[int, Sequence[Figure]],
    tool_states: Mapping[int, str],
) -> list[str]:
    """Return a sentence for each sort of thing that is lost or becomes something else.

    Args:
        robot: the robot.
        nodes: its links, adapters, tools and grippers, which are written.
        left_out: what hangs on those and is not written.
        figures: those that the written nodes show now, by uid.
        tool_states: the state of the tool that a node belongs to, by uid.
    """
    found = []
    for node in nodes:
        if node.kind is Kind.ROBOT:
            found.append(f"the gripper {node.name!r} is written as links of {robot.name!r}")
        if node.kind is Kind.ADAPTER:
            found.append(f"the adapter {node.name!r} is written as a fixed link")
        if isinstance(node.data, ToolData):
            state = tool_states[node.uid]
            found.append(f"the tool {node.name!r} is written as a fixed link{f' in its state {state!r}' * bool(state)}")
    if left_out:
        found.append(f"left out, because they are no part of the robot: {listed([node.name for node in left_out])}")
    hidden = [node.name for node in nodes if node.hidden]
    if hidden:
        found.append(f"URDF hides nothing: {listed(hidden)} will be seen")
    marks = [
        node.name
        for node in (robot, *nodes)
        if any(isinstance(figure.geometry, (Points, Lines, Frame, Label)) for figure in figures[node.uid])
    ]
    if marks:
        found.append(f"URDF has no points, lines, frames and labels: those of {listed(marks)} are left out")
    unsaid = _settings(robot)
    joints = [node.data.joint for node in nodes if isinstance(node.data, LinkData)]
    if any(map(_has_own_rates, joints)):
        unsaid.append("limits of acceleration and jerk")
    if any(_has_own_feel(figure.material) for node in nodes for figure in figures[node.uid]):
        unsaid.append("reflectance and friction")
    if any(_has_own_finish(figure.material) for node in nodes for figure in figures[node.uid]):
        unsaid.append("roughness and metalness")
    if any(_touches_its_own_way(figure.material) for node in nodes for figure in figures[node.uid]):
        unsaid.append("restitution, rolling friction and stiffness of surfaces")
    if unsaid:
        found.append(f"URDF has no place for {', '.join(unsaid)} of {robot.name!r}")
    return found


def _settings(robot: Node) -> list[str]:
    data = robot.data if isinstance(robot.data, RobotData) else RobotData()
    settings = {
        "the flange": bool(data.flange),
        "postures": bool(data.postures),
        "joint groups": bool(data.groups),
        "actuators": bool(data.actuators),
        "pairs of links that may touch": bool(data.allowed_collisions),
        "the kinematics component": data.kinematics != AUTOMATIC_KINEMATICS or bool(data.kinematics_settings),
        "what makes it a craft": data.craft is not None,
        "that it is dynamic, and its motors": data.dynamic or bool(data.motors),
    }
    return [name for name, given in settings.items() if given]


def _has_own_rates(joint: Joint) -> bool:
    """Return whether acceleration and jerk are others than a reader of the file would assume."""
    if joint.type is JointType.FIXED:
        return False
    given, assumed = joint.limits, joint_limits(velocity=joint.limits.velocity)
    return not (
        math.isclose(given.acceleration, assumed.acceleration, rel_tol=1e-9)
        and math.isclose(given.jerk, assumed.jerk, rel_tol=1e-9)
    )


def _has_own_feel(material: Material | None) -> bool:
    plain = Material()
    return material is not None and (material.reflectance, material.friction) != (plain.reflectance, plain.friction)


def _has_own_finish(material: Material | None) -> bool:
    plain = Material()
    return material is not None and (material.roughness, material.metalness) != (plain.roughness, plain.metalness)


def _touches_its_own_way(material: Material | None) -> bool:
    return material is not None and any(
        (
            *(material.restitution, material.rolling_friction, material.spinning_friction),
            *(material.stiffness, material.damping),
        )
    )
