"""The chosen tool centre point of a robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import Selection, State
from virtualrobot_kernel.world.structure import Node, Structure, ToolData


def chosen_tcp(structure: Structure, state: State, robot: Node) -> tuple[Node | None, Pose]:
    """Return the chosen tool (None: none) and tool_t_tcp (4, 4)."""
    selection = state.selections.get(robot.uid, Selection())
    tool = structure.nodes.get(selection.tool)
    if tool is None or not isinstance(tool.data, ToolData):
        return None, np.eye(4)
    return tool, tool.data.tool_center_points.get(selection.tool_center_point, np.eye(4))


def world_t_tcp(structure: Structure, state: State, world_t_node: NDArray[np.float64], robot: Node) -> Pose:
    """Return where the chosen tool centre point is (4, 4), without a tool the flange; `world_t_node` is (N, 4, 4)."""
    tool, point = chosen_tcp(structure, state, robot)
    if tool is None:
        return world_t_node[structure.rows[structure.robots[robot.uid].flange]]
    return world_t_node[structure.rows[tool.uid]] @ point
