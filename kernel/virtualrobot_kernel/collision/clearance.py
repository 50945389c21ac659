"""Clearance of an arm from everything else, and how it changes with the joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.collision.pool import ScenePool
from virtualrobot_kernel.collision.scene import Nearest
from virtualrobot_kernel.motion.nullspace import DISTANCE_RANGE, Near
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.relative_frame import RelativeFrame, relative_frame
from virtualrobot_kernel.planning.robots import Arm, standing_at
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]


def near_by(pool: ScenePool) -> NearOf:
    """Return what measures arms in worlds, with scenes of a pool.

    Measured are the nodes that the arm's joints move, tools and held parts included, to all that is not on the robot,
    within DISTANCE_RANGE; pairs that may touch are left out. What touches has no direction and counts with gradient 0.
    """

    def near_of(snapshot: Snapshot, arm: Arm) -> Near:
        structure, forest = snapshot.structure, snapshot.structure.forest
        if arm.locked:
            places = np.array(list(arm.locked), np.int32)
            snapshot = standing_at(snapshot, places, np.array(list(arm.locked.values())))
        uids = {row: uid for uid, row in structure.rows.items()}
        moving = [row for row in arm.path.tolist() if forest.joint_type[row] and forest.q_index[row] in arm.q_index]
        ours = [node.uid for node in structure.below(uids[moving[0]])]
        theirs = structure.nodes.keys() - {node.uid for node in structure.below(arm.robot.uid)}
        world = structure.node("").uid
        carriers: dict[int, RelativeFrame] = {}

        def gradient(there: Snapshot, one: Nearest, q: Floats) -> Floats:
            if one.distance <= 0.0:
                return np.zeros(len(q))
            if one.first not in carriers:
                carriers[one.first] = relative_frame(snapshot, world, one.first, np.eye(4), arm.q_index)
            place = np.eye(4)
            place[:3, 3] = (inverse(there.world_t(one.first)) @ [*one.points[0], 1.0])[:3]
            away = one.points[0] - one.points[1]
            linear = replace(carriers[one.first], node_t_point=place).jacobian(q)[:3]
            return away / np.linalg.norm(away) @ linear

        def near(q: Floats) -> tuple[Floats, Floats]:
            there = standing_at(snapshot, arm.q_index, q)
            with pool.scene() as scene:
                scene.place(there)
                found = scene.distances(ours, theirs, DISTANCE_RANGE)
            distances = np.array([one.distance for one in found])
            return distances, np.array([gradient(there, one, q) for one in found]).reshape(-1, len(q))

        return near

    return near_of
