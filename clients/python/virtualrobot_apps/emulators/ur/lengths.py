"""Model of Universal Robots that a robot in a kernel is, by its lengths."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from virtualrobot.geometry import rotation_vector_of
from virtualrobot.robots.robot import Robot

from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.kinematics import MODELS, Floats, Model

USUAL = "ur5e"
"""Model of an arm that has the lengths of none, and of one without a kernel."""
NEAR = 0.003
"""Difference (m) of ways of the flange up to which an arm is a model's."""
_POSTURES = np.array(
    [[0.0, -1.5, 1.2, -1.0, -1.5, 0.0], [0.9, -0.8, 0.7, 0.4, 0.3, 0.0], [-0.7, -2.0, 1.9, -0.5, 1.1, 0.0]]
)


def model_of(robot: Robot) -> str | None:
    """Return the model whose lengths a robot has, by the ways of its flange between postures; None: that of none."""
    names = robot.joint_names
    if len(names) != _POSTURES.shape[1]:
        return None
    lower, upper = np.array([(robot.limits[name].lower, robot.limits[name].upper) for name in names]).T
    if (lower > _POSTURES.min(axis=0)).any() or (upper < _POSTURES.max(axis=0)).any():
        return None  # the joints of Universal Robots' arms turn further
    flanges = [
        robot.solve_forward(dict(zip(names, posture, strict=True))).world_t_link[robot.flange] for posture in _POSTURES
    ]
    ways = _ways(flanges)
    off = {
        name: float(np.abs(_ways([kinematics.forward(one, posture) for posture in _POSTURES]) - ways).max())
        for name, one in MODELS.items()
    }
    best = min(off, key=off.__getitem__)
    return best if off[best] <= NEAR else None


def _ways(flanges: list[Floats]) -> Floats:
    """Return the distances (m) between positions of poses (4, 4), which are the same in every frame."""
    return np.array([float(np.linalg.norm(a[:3, 3] - b[:3, 3])) for a, b in combinations(flanges, 2)], dtype=np.float64)


def turn_of_flange(robot: Robot, model: Model) -> Floats:
    """Return the rotation (3, 3) from the frame of a robot's flange to that of the model's, by turns of both."""
    names, turns = robot.joint_names, []
    for frames in (
        [robot.solve_forward(dict(zip(names, one, strict=True))).world_t_link[robot.flange] for one in _POSTURES],
        [kinematics.forward(model, one) for one in _POSTURES],
    ):
        turns.append([rotation_vector_of(a[:3, :3].T @ b[:3, :3]) for a, b in combinations(frames, 2)])
    # The same turns seen from both: the rotation between is the nearest one (Kabsch).
    left, _, right = np.linalg.svd(np.array(turns[1]).T @ np.array(turns[0]))
    return left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
