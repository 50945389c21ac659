"""Commands that mount tools on robots and take them off."""

from __future__ import annotations

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.apply_nodes import attached
from virtualrobot_kernel.world.apply_robots import chosen_tool, select_tool
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import MountTool, SelectTool, UnmountTool
from virtualrobot_kernel.world.consistency import refuse_while_robot_moves, refuse_while_tools_move
from virtualrobot_kernel.world.structure import Kind, Node, Structure, robots_of_tool
from virtualrobot_kernel.world.tcp import is_fixed_to


def mount_tool(change: Change, command: MountTool, forward: Forward) -> Change:
    """Attach a tool, or what brings one, to a robot, and choose it."""
    structure = change.structure
    robot, index = structure.robot(command.robot)
    node = _gripper_of(structure, structure.node(command.node))
    parent = structure.node(command.parent) if command.parent else structure.nodes[index.flange]
    _check_free(structure, robot, node, parent)
    _refuse_while_moving(change, robot, node)
    place = np.eye(4) if command.parent_t_node is None else command.parent_t_node
    after = attached(change, node, parent, place, forward)
    mounted = _tools_by(after.structure, robot, node)
    if not mounted:
        raise KernelError(
            f"what hangs at {parent.name!r} is no tool of {robot.name!r}; name one of its links, or an adapter on one",
            parent=parent.name,
            robot=robot.name,
        )
    return select_tool(after, SelectTool(robot.name, mounted[0].name, command.tool_center_point), forward)


def unmount_tool(change: Change, command: UnmountTool, forward: Forward) -> Change:
    """Attach a robot's tool, or what brings it, to something else; without a pose it stays where it is in the world."""
    structure = change.structure
    robot, _ = structure.robot(command.robot)
    node = structure.node(command.node) if command.node else chosen_tool(change, command.robot)[0]
    node = as_mounted(structure, robot, node)
    hangs = robot.uid in {above.uid for above in structure.ancestors(node.parent)}
    if not hangs or node.kind is Kind.LINK or not _tools_by(structure, robot, node):
        tools = ", ".join(repr(tool.name) for tool in structure.tools_of(robot.uid))
        raise KernelError(
            f"{node.name!r} is no tool that can be taken off {robot.name!r}; its tools are {tools or 'none'}",
            reason=Reason.WRONG_STATE,
            node=node.name,
            robot=robot.name,
        )
    _refuse_while_moving(change, robot, node)
    parent = structure.node(command.parent)
    after = attached(change, node, parent, command.parent_t_node, forward)
    if _tools_by(after.structure, robot, node):
        raise KernelError(
            f"{parent.name!r} is fixed to {robot.name!r}, whose tool {node.name!r} would be still; name another rack",
            node=node.name,
            parent=parent.name,
        )
    return after


def as_mounted(structure: Structure, robot: Node, node: Node) -> Node:
    """Return what hangs on a robot for a tool of it: its gripper, or the tool itself; other nodes as they are."""
    above = [*robots_of_tool(structure.nodes, node.uid)] if node.kind is Kind.TOOL else []
    grippers = above[: above.index(robot.uid)] if robot.uid in above else []
    return structure.nodes[grippers[-1]] if grippers else node


def _gripper_of(structure: Structure, node: Node) -> Node:
    """Return what is mounted when a node is to be: for the tool of a gripper the gripper, or its changer."""
    if node.kind is not Kind.TOOL:
        return node
    robots = [uid for uid in robots_of_tool(structure.nodes, node.uid) if is_fixed_to(structure, node, uid)]
    return structure.nodes[robots[-1]] if robots else node


def _tools_by(structure: Structure, robot: Node, node: Node) -> list[Node]:
    """Return the tools of a robot that a node brings, or is."""
    own = structure.tools.get(robot.uid, ())
    return [one for one in structure.below(node.uid) if one.uid in own]


def _check_free(structure: Structure, robot: Node, node: Node, parent: Node) -> None:
    """Raise KernelError unless a node brings a tool that is no robot's yet, and no other tool hangs at the parent."""
    below = {one.uid: one for one in structure.below(node.uid)}
    tools = [one.uid for one in below.values() if one.kind is Kind.TOOL]
    if node.kind is Kind.LINK or not tools:
        raise KernelError(
            f"{node.name!r} is no tool and brings none; name a tool, or what a tool is fixed to, such as a gripper",
            node=node.name,
        )
    if parent.uid in below:
        raise KernelError(
            f"cannot mount {node.name!r} at {parent.name!r}, which hangs below it", node=node.name, parent=parent.name
        )
    holders = [uid for tool in tools for uid in robots_of_tool(structure.nodes, tool) if uid not in below]
    if holders:
        holder = structure.nodes[holders[0]].name
        raise KernelError(
            f"{node.name!r} is mounted on {holder!r} already; unmount it there first",
            reason=Reason.WRONG_STATE,
            node=node.name,
            robot=holder,
        )
    others = (tool for tool in _tools_by(structure, robot, parent) if tool.uid != parent.uid)
    hanging = next((tool for tool in others if is_fixed_to(structure, tool, parent.uid)), None)
    if hanging is not None:
        raise KernelError(
            f"the tool {hanging.name!r} hangs at {parent.name!r} already; unmount it first, or name an adapter of its "
            f"own for {node.name!r}",
            reason=Reason.WRONG_STATE,
            tool=hanging.name,
            parent=parent.name,
        )


def _refuse_while_moving(change: Change, robot: Node, node: Node) -> None:
    """Raise KernelError (ROBOT_BUSY) while a robot moves, or what is mounted on it or taken off."""
    below = tuple(change.structure.below(node.uid))
    refuse_while_tools_move(change, below)
    for one in (robot, *(one for one in below if one.kind is Kind.ROBOT)):
        refuse_while_robot_moves(change, one)
