"""Chosen tool centre point of a robot."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Selection, State
from virtualrobot_kernel.world.structure import Node, Structure, ToolData


def chosen_tcp(structure: Structure, state: State, robot: Node, tip: int = 0) -> tuple[Node | None, Pose]:
    """Return the chosen tool (None: none) and tool_t_tcp (4, 4).

    For the chain of a group that ends at the link `tip` (a uid) only tools count that are fixed to it: the chosen one,
    else the first with its first tool centre point.
    """
    selection = state.selections.get(robot.uid, Selection())
    tool = structure.nodes.get(selection.tool)
    if tip and not (tool and is_fixed_to(structure, tool, tip)):
        tool = next((one for one in structure.tools_of(robot.uid) if is_fixed_to(structure, one, tip)), None)
        if tool is not None and isinstance(tool.data, ToolData):
            return tool, next(iter(tool.data.tool_center_points.values()), np.eye(4))
    if tool is None or not isinstance(tool.data, ToolData):
        return None, np.eye(4)
    return tool, tool.data.tool_center_points.get(selection.tool_center_point, np.eye(4))


def world_t_tcp(
    structure: Structure, state: State, world_t_node: NDArray[np.float64], robot: Node, tip: int = 0
) -> Pose:
    """Return the pose (4, 4) of the chosen tool centre point: without a tool of the flange, or of the `tip` of a group.

    `world_t_node` is (N, 4, 4).
    """
    tool, point = chosen_tcp(structure, state, robot, tip)
    if tool is None:
        return world_t_node[structure.rows[tip or structure.robots[robot.uid].flange]]
    return world_t_node[structure.rows[tool.uid]] @ point


def refuse_limited(structure: Structure, state: State, robots: Iterable[int]) -> None:
    """Raise KernelError where a robot (a uid) has a speed limit, and what moves it can't be planned for that."""
    for uid in robots:
        if uid in state.tcp_speed_limits:
            name = structure.nodes[uid].name
            raise KernelError(
                f"the tool centre point of {name!r} has a speed limit of {state.tcp_speed_limits[uid]:g} m/s, which "
                "setpoints of joints and of groups and motions that go along with a frame can't keep: they are made as "
                "they go; move it by planned motions, jogs and setpoints of its tool, or lift the limit",
                reason=Reason.WRONG_STATE,
                robot=name,
            )


def is_fixed_to(structure: Structure, tool: Node, tip: int) -> bool:
    """Return whether a tool hangs below a node (a uid) and no joint moves it against that."""
    for node in structure.ancestors(tool.uid):
        if node.uid == tip:
            return True
        if node.is_moved:
            return False
    return False
