"""Velocities of nodes: what joints and forces do to them, one link after the other. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, LinkData, Structure

Floats = NDArray[np.float64]
Twist = tuple[Floats, Floats]
"""Velocity of a node's origin (m/s) and angular velocity (rad/s), both in the axes of the world."""

_STILL: Twist = (np.zeros(3), np.zeros(3))


def node_twists(snapshot: Snapshot, uids: Sequence[int]) -> Floats:
    """Return the twists (n, 6) of nodes: velocities of their origins, then angular velocities, in the world's axes."""
    known: dict[int, Twist] = {}
    return np.array([np.concatenate(_twist(snapshot, uid, known)) for uid in uids]).reshape(-1, 6)


def _twist(snapshot: Snapshot, uid: int, known: dict[int, Twist]) -> Twist:
    structure, state = snapshot.structure, snapshot.state
    chain = [uid]
    while chain[-1] not in known and (parent := structure.nodes[chain[-1]].parent):
        chain.append(parent)
    for below in reversed(chain):
        if below in known:
            continue
        node, world_t_node = structure.nodes[below], snapshot.world_t(below)
        if below in state.twists:
            moved = state.twists[below]
            known[below] = moved[:3], world_t_node[:3, :3] @ moved[3:]
        elif not node.parent:
            known[below] = _STILL
        else:
            velocity, turning = known[node.parent]
            world_t_parent = snapshot.world_t(node.parent)
            velocity = velocity + np.cross(turning, world_t_node[:3, 3] - world_t_parent[:3, 3])
            added = _of_joint(snapshot, below, world_t_parent[:3, :3], world_t_node[:3, :3])
            known[below] = velocity + added[0], turning + added[1]
    return known[uid]


def _of_joint(snapshot: Snapshot, uid: int, world_r_parent: Floats, world_r_node: Floats) -> Twist:
    """Return what the joint before a node does to it; nothing where there is none that moves."""
    structure, state = snapshot.structure, snapshot.state
    data = structure.nodes[uid].data
    if not isinstance(data, LinkData) or data.joint is None or not data.joint.type.coordinate_count:
        return _STILL
    forest, row = structure.forest, structure.rows[uid]
    first = _rates(structure)[int(forest.q_index[row])]
    frame = world_r_parent @ state.parent_t_node[row][:3, :3]
    axis = frame @ forest.axis[row]
    if data.joint.type is JointType.FLOATING:
        return frame @ state.v[first : first + 3], world_r_node @ state.v[first + 3 : first + 6]
    if data.joint.type is JointType.PLANAR:
        x, y, turn = state.v[first : first + 3]
        return frame @ _plane(forest.axis[row]) @ np.array([x, y]), axis * turn
    rate = float(forest.multiplier[row]) * state.v[first]
    if data.joint.type is JointType.PRISMATIC:
        return axis * rate, np.zeros(3)
    return np.zeros(3), axis * rate


def _plane(axis: Floats) -> Floats:
    """Return x and y (3, 2) of the plane normal to an axis, as `numeric.forest` has them."""
    x, y, z = axis
    if x == y == 0.0:
        return np.array([[1.0, 0.0], [0.0, z], [0.0, 0.0]])
    f = 1.0 / (1.0 + z) if z > 0.0 else (1.0 - z) / (x * x + y * y)
    return np.array([[1.0 - x * x * f, -x * y * f], [-x * y * f, 1.0 - y * y * f], [-x, -y]])


@lru_cache(maxsize=4)
def _rates(structure: Structure) -> dict[int, int]:
    """Return where the velocities of each joint begin, by where its coordinates do."""
    robots = structure.robots.values()
    return {q: v for robot in robots for q, v in zip(robot.q_start, robot.v_start, strict=True)}
