"""States of a tool centre point along samples of joints: poses, speeds, and the arm's distance from singularities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.resolved_rate import row_weights
from virtualrobot_kernel.numeric.forest import FIXED, forward_forest
from virtualrobot_kernel.planning.relative_frame import axes_of
from virtualrobot_kernel.planning.robots import arm_of
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node
from virtualrobot_kernel.world.tcp import chosen_tcp

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ToolChain:
    """Chain of nodes from the world's root to a tool centre point, as rows of a forest of their own, root first.

    q_index (m,) says where each row's coordinates start in the world's q; `tip_t_tcp` (4, 4) is seen from the last row.
    arm (k,): places in q of the coordinates of the robot's own chain, base first.
    """

    joint_type: NDArray[np.int8]
    axis: Floats
    q_index: NDArray[np.int32]
    multiplier: Floats
    offset: Floats
    parent_t_node: Floats
    tip_t_tcp: Floats
    arm: NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class ToolStates:
    """States of a tool centre point at n samples.

    world_t_tcp (n, 4, 4). velocities (n, 3): m/s in the world's frame. jacobians (n, 6, k): by the coordinates of the
    robot's own chain, linear rows first, in the world's frame.
    """

    world_t_tcp: Floats
    velocities: Floats
    jacobians: Floats


def tool_chain(snapshot: Snapshot, robot: Node, group: Group = WHOLE) -> ToolChain:
    """Return the chain to the chosen tool centre point of a robot or its group; without a tool, to flange or tip."""
    structure, forest = snapshot.structure, snapshot.structure.forest
    arm = arm_of(snapshot, robot, group)
    tool, point = chosen_tcp(structure, snapshot.state, robot, arm.tool_tip)
    above = [structure.rows[node.uid] for node in structure.ancestors(tool.uid if tool else arm.tip)]
    rows = np.array(above[::-1], np.int32)
    return ToolChain(
        np.ascontiguousarray(forest.joint_type[rows]),
        np.ascontiguousarray(forest.axis[rows]),
        forest.q_index[rows],
        np.ascontiguousarray(forest.multiplier[rows]),
        np.ascontiguousarray(forest.offset[rows]),
        np.ascontiguousarray(snapshot.state.parent_t_node[rows]),
        point,
        arm.q_index,
    )


def tool_states(chain: ToolChain, q: Floats, v: Floats) -> ToolStates:
    """Return pose and velocity of a tool centre point, for the world's coordinates q and their rates v, (n, nq) each.

    Of a quaternion the rates of x, y, z are the angular velocity.
    """
    count, rows = len(q), len(chain.q_index)
    poses = _forward(chain, q).reshape(count, rows, 4, 4)
    world_t_tcp = poses[:, -1] @ chain.tip_t_tcp
    velocities = np.zeros((count, 3))
    jacobians = np.zeros((count, 6, len(chain.arm)))
    column_of = {int(place): column for column, place in enumerate(chain.arm)}
    for row in np.flatnonzero(chain.joint_type != FIXED):
        after, before = poses[:, row], poses[:, row - 1] @ chain.parent_t_node[row]
        moves = axes_of(int(chain.joint_type[row]), chain.axis[row])
        for place, (own, turns) in enumerate(moves, int(chain.q_index[row])):
            axis = chain.multiplier[row] * ((after if turns else before)[:, :3, :3] @ own)
            linear = np.cross(axis, world_t_tcp[:, :3, 3] - after[:, :3, 3]) if turns else axis
            velocities += linear * v[:, place, None]
            if (column := column_of.get(place)) is not None:
                jacobians[:, :3, column] += linear
                jacobians[:, 3:, column] += axis if turns else 0.0
    return ToolStates(world_t_tcp, velocities, jacobians)


def singular_values(jacobians: Floats, lever: float) -> Floats:
    """Return the smallest singular value (n,) of Jacobians (n, 6, k) whose linear rows are divided by `lever`.

    The measure by which lines and arcs are refused (`motion.resolved_rate`), with the lever arm of the move's start.
    """
    if not jacobians.shape[2]:
        return np.zeros(len(jacobians))
    return np.asarray(np.linalg.svd(jacobians * row_weights(lever)[:, None], compute_uv=False)[:, -1], np.float64)


def _forward(chain: ToolChain, q: Floats) -> Floats:
    """Return the world poses (n * m, 4, 4) of m rows at n samples: n chains side by side, in one compiled pass."""
    count, rows = len(q), len(chain.q_index)
    row = np.arange(count * rows, dtype=np.int32)
    parent = row - 1
    parent[::rows] = -1
    first = np.repeat(np.arange(count, dtype=np.int32) * q.shape[1], rows)
    poses = np.empty((count * rows, 4, 4))
    forward_forest(
        row,
        parent,
        np.tile(chain.joint_type, count),
        np.tile(chain.axis, (count, 1)),
        np.tile(chain.q_index, count) + first,
        np.tile(chain.multiplier, count),
        np.tile(chain.offset, count),
        np.tile(chain.parent_t_node, (count, 1, 1)),
        np.ascontiguousarray(q).ravel(),
        poses,
    )
    return poses
