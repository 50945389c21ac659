"""Cartesian line: the tool centre point moves straight while its orientation turns about one fixed axis (slerp)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from virtualrobot_kernel.motion.cartesian_path import SHORTEST_LENGTH, ConstantSpeedPath, turn_between
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.pose_check import check_pose


@dataclass(frozen=True, eq=False)
class Line(ConstantSpeedPath):
    """Path on a line: start + u * translation, with the translation (3,) in m in the base frame."""

    kind: ClassVar[str] = "lin"
    noun: ClassVar[str] = "line"

    translation: Array

    @property
    def length(self) -> float:
        """Length of the line in m."""
        return float(np.linalg.norm(self.translation))

    def position(self, u: float) -> Array:
        """Return the position (3,) at the fraction `u` in m, base frame."""
        return self.base_t_start[:3, 3] + u * self.translation

    def twist(self, u: float) -> Array:
        """Return the twist (6,) by u, the same everywhere: m, then rad, base frame, at the TCP."""
        del u
        return np.concatenate([self.translation, self.rotation])


def line_between(base_t_start: Array, base_t_goal: Array) -> Line:
    """Return the line between two poses (4, 4); the turn takes the shorter way.

    Raises KernelError when `base_t_goal` is not a pose.
    """
    check_pose(base_t_goal, "the goal of a LIN motion")
    translation = base_t_goal[:3, 3] - base_t_start[:3, 3]
    if np.linalg.norm(translation) < SHORTEST_LENGTH:
        translation = np.zeros(3)
    start = np.array(base_t_start, dtype=np.float64)
    return Line(start, turn_between(base_t_start, base_t_goal), translation)
