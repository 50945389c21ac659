"""Tip of an arm at many postures at once, by the rows of the tree: answers for thousands of poses are checked by it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.poses import skew
from virtualrobot_sdk.reference import joint_motion

from virtualrobot_kernel.numeric.forest import FIXED, REVOLUTE
from virtualrobot_kernel.planning.robots import Arm
from virtualrobot_kernel.world.state import Snapshot

Tips = Callable[[Floats], Floats]
"""Forward kinematics of a robot: base_t_tip (m, 4, 4) at postures (m, k)."""


def tips_of(snapshot: Snapshot, arm: Arm) -> Tips:
    """Return the function of base_t_tip (m, 4, 4) of an arm by postures (m, k): what `tip_of` gives for each of them.

    It is NumPy's own arithmetic over all of them, joint after joint: for one posture `tip_of` is quicker.
    """
    forest, placed = snapshot.structure.forest, snapshot.state.parent_t_node
    coordinate = {int(place): number for number, place in enumerate(arm.q_index)}
    since, joints = np.eye(4), list[tuple[Floats, int, Floats, int, float, float]]()
    for row in arm.path.tolist():
        since = since @ placed[row]
        kind, axis, place = int(forest.joint_type[row]), forest.axis[row], int(forest.q_index[row])
        multiplier, offset = float(forest.multiplier[row]), float(forest.offset[row])
        if kind == FIXED:
            continue
        if place in arm.locked:
            since = since @ joint_motion(kind, axis, np.array(multiplier * arm.locked[place] + offset))
            continue
        joints.append((since, kind, axis, coordinate[place], multiplier, offset))
        since = np.eye(4)
    last = since

    def tips(postures: Floats) -> Floats:
        rotation, position = np.tile(np.eye(3), (len(postures), 1, 1)), np.zeros((len(postures), 3))
        for pre, kind, axis, number, multiplier, offset in joints:
            rotation, position = _behind(rotation, position, pre)
            value = multiplier * postures[:, number] + offset
            if kind == REVOLUTE:
                # O. Rodrigues' formula, as in `joint_motion`.
                across = _times(rotation, skew(axis))
                beyond = _times(across, skew(axis))
                rotation = (
                    rotation + np.sin(value)[:, None, None] * across + (1.0 - np.cos(value))[:, None, None] * beyond
                )
            else:
                position = position + value[:, None] * (rotation @ axis)
        rotation, position = _behind(rotation, position, last)
        found = np.tile(np.eye(4), (len(postures), 1, 1))
        found[:, :3, :3], found[:, :3, 3] = rotation, position
        return found

    return tips


def _behind(rotation: Floats, position: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """Return rotations (m, 3, 3) and positions (m, 3) of frames that are at `pose` (4, 4) in those given."""
    return _times(rotation, pose[:3, :3]), position + rotation @ pose[:3, 3]


def _times(rotation: Floats, matrix: Floats) -> Floats:
    """Return rotations (m, 3, 3), each times a matrix (3, 3): as one product, many times as quick as m small ones."""
    return (rotation.reshape(-1, 3) @ matrix).reshape(rotation.shape)
