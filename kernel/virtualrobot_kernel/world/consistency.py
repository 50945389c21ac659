"""Invariants of the tree whatever is changed: names that nodes keep lead somewhere, and there are not too many."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.motion.orientation import unit
from virtualrobot_kernel.world.actuators import check_actuators
from virtualrobot_kernel.world.change import (
    Change,
    check_joint_value,
    joint_limits,
    refuse_while_moving,
    single_joint,
)
from virtualrobot_kernel.world.crafts import check_craft
from virtualrobot_kernel.world.figures import Figure
from virtualrobot_kernel.world.groups import Group, chain_links
from virtualrobot_kernel.world.motored import check_motors
from virtualrobot_kernel.world.structure import Kind, Node, NodeData, RobotData, Structure, TargetData, ToolData
from virtualrobot_kernel.world.targets import check_target, taught_with

MOST_NODES = 100_000
"""Greatest number of nodes that a kernel may allow; each change of the tree holds up ticks by about 10 µs for each."""


def check_count(nodes: int) -> None:
    """Raise KernelError (TOO_LARGE) when a world would have too many nodes."""
    if nodes > MOST_NODES:
        raise KernelError(
            f"a world may have {MOST_NODES:,} nodes, not {nodes:,}; one node may have many figures, or a mesh",
            reason=Reason.TOO_LARGE,
            nodes=nodes,
            limit=MOST_NODES,
        )


def check_names(structure: Structure, node: Node) -> None:
    """Raise KernelError unless what a node names is there: the joints of postures, tool states, widths and targets.

    Those of postures, tool states and widths must be within limits, too.
    """
    if isinstance(node.data, RobotData):
        for name, posture in node.data.postures.items():
            _check_posture(structure, node, posture, f"the posture {name!r} of {node.name!r}")
        _check_groups(structure, node, node.data)
        _check_actuators(structure, node, node.data)
        check_craft(structure, node)
        check_motors(structure, node)
    if isinstance(node.data, TargetData):
        check_target(structure, node)
    if isinstance(node.data, ToolData):
        owner = structure.robot_of(node.uid)
        for name, positions in node.data.states.items():
            if positions and owner is None:
                raise KernelError(
                    f"the state {name!r} of the tool {node.name!r} names joints, but the tool is on no robot",
                    tool=node.name,
                )
            if owner is not None:
                _check_posture(structure, owner, positions, f"the state {name!r} of the tool {node.name!r}")
        for one in node.data.widths:
            what = f"the width {one.width:g} m of the tool {node.name!r}"
            if owner is None:
                raise KernelError(f"{what} names joints, but the tool is on no robot", tool=node.name)
            _check_posture(structure, owner, one.joint_positions, what)


def check_figures(name: str, data: NodeData, figures: Iterable[Figure]) -> None:
    """Raise UnknownNameError for a figure that is shown in a state that its node lacks: nobody would ever see it."""
    states = data.states if isinstance(data, ToolData) else {}
    for figure in figures:
        if figure.tool_state and figure.tool_state not in states:
            raise UnknownNameError(f"state of {name!r} for its figure", figure.tool_state, states)


def check_robot(change: Change, robot: int) -> None:
    """Raise KernelError unless a robot's joints are within limits, and those are there that others name.

    These are its postures, its tools and the targets that were taught with it.
    """
    structure = change.structure
    node, found = structure.nodes[robot], structure.robots[robot]
    for joint, place in zip(found.joints, found.q_start, strict=True):
        # What forces move may be a little beyond its limits: these are soft.
        if joint.type.coordinate_count == 1 and robot not in change.state.motored:
            check_joint_value(node.name, joint, float(change.state.q[place]))
    for named in (node, *structure.tools_of(robot), *taught_with(structure.nodes.values(), node.name)):
        check_names(structure, named)
    check_actuators(structure, node, change.state.q)


def check_tool_in_use(change: Change, tool: Node) -> None:
    """Raise KernelError when a tool lacks the tool centre point that a robot works with, or the state that it is in."""
    assert isinstance(tool.data, ToolData)
    for robot, selection in change.state.selections.items():
        if selection.tool == tool.uid and selection.tool_center_point not in tool.data.tool_center_points:
            name = change.structure.nodes[robot].name
            raise KernelError(
                f"{name!r} works with the tool centre point {selection.tool_center_point!r} of {tool.name!r}; "
                "keep it, or choose another one first",
                reason=Reason.WRONG_STATE,
                tool=tool.name,
                robot=name,
            )
    state = change.state.tool_states.get(tool.uid)
    if state is not None and state not in tool.data.states:
        raise KernelError(
            f"the tool {tool.name!r} is in the state {state!r}; keep that, or set another one first",
            reason=Reason.WRONG_STATE,
            tool=tool.name,
            state=state,
        )


def refuse_while_robot_moves(change: Change, node: Node) -> None:
    """Raise KernelError (ROBOT_BUSY) when the robot that a link or tool belongs to moves, or the robot itself."""
    robot = change.structure.robot_of(node.uid) if node.kind in (Kind.LINK, Kind.ROBOT, Kind.TOOL) else None
    if robot is not None:
        names = change.structure.robots[robot.uid].coordinates
        refuse_while_moving(change, robot, {(robot.uid, name) for name in names})


def refuse_while_tools_move(change: Change, nodes: Iterable[Node]) -> None:
    """Raise KernelError (ROBOT_BUSY) when a motion is about to bring a tool among the nodes into a state."""
    tools = {node.uid: node.name for node in nodes if node.kind is Kind.TOOL}
    for motion in change.state.motions:
        for _, tool, state in motion.tool_states:
            if tool in tools:
                raise KernelError(
                    f"the motion {motion.id!r} brings the tool {tools[tool]!r} into the state {state!r}; "
                    "wait for its end or cancel it",
                    reason=Reason.ROBOT_BUSY,
                    tool=tools[tool],
                    motion=motion.id,
                )


def _check_groups(structure: Structure, robot: Node, data: RobotData) -> None:
    """Raise KernelError for a joint or link that a group or a pair of links names and that the robot lacks.

    And for a group whose links no chain joins.
    """
    if not data.groups and not data.allowed_collisions:
        return
    joints = structure.robots[robot.uid].joint_names
    prefix = robot.name + "."
    links = {structure.nodes[uid].name.removeprefix(prefix) for uid in structure.robots[robot.uid].links}
    for group in data.groups:
        for joint in group.joint_names:
            if joint not in joints:
                raise UnknownNameError(f"joint of {robot.name!r} for its group {group.name!r}", joint, joints)
        if group.base_link and group.tip_link:
            chain_links(structure, robot, Group(group.name))
    named = [name for group in data.groups for name in (group.base_link, group.tip_link) if name]
    for name in (*named, *(name for pair in data.allowed_collisions for name in (pair.first, pair.second))):
        if name not in links:
            raise UnknownNameError(f"link of {robot.name!r} for its groups and allowed collisions", name, links)


def _check_actuators(structure: Structure, robot: Node, data: RobotData) -> None:
    """Raise KernelError unless the joints that actuators move are there, each with one coordinate."""
    for actuator in data.actuators:
        for joint, _ in actuator.terms:
            try:
                single_joint(structure, robot, joint)
            except KernelError as error:
                error.args = (f"the actuator {actuator.name!r} of {robot.name!r}: {error}",)
                raise


def _check_posture(structure: Structure, robot: Node, positions: Mapping[str, float], what: str) -> None:
    try:
        for joint, value in positions.items():
            check_joint_value(robot.name, single_joint(structure, robot, joint)[0], value)
        values = [*positions.values()]
        for columns in joint_limits(structure, robot, [*positions]).quaternions if positions else ():
            unit(np.array([values[column] for column in columns]), robot.name)
    except KernelError as error:
        error.args = (f"{what}: {error}",)
        raise
