"""Configurations of arms as RAPID tells them: the quadrants of axes 1, 4 and 6, and where the wrist is."""

from __future__ import annotations

import math
from collections.abc import Sequence

from virtualrobot.robots.robot import Robot


def confdata(joints: Sequence[float], branch: str) -> list[float]:
    """Return cf1, cf4, cf6 and cfx of six joints (rad) and the name of their branch.

    A quadrant counts from 0 for 0 to 90 degrees, and from -1 for 0 to -90. cfx is 4 where the wrist's centre is behind
    axis 1, plus 2 where it is behind the lower arm, plus 1 where axis 5 is negative. Source: ABB, *Technical reference
    manual, RAPID Instructions, Functions and Data types* (3HAC050917), *confdata*. The branch `down` is on the other
    side of the lower arm when the wrist is behind axis 1.
    """
    words = branch.split()
    behind_axis, down = "back" in words, "down" in words
    quadrants = [float(math.floor(math.degrees(joints[axis]) / 90.0 + 1e-9)) for axis in (0, 3, 5)]
    return [*quadrants, 4.0 * behind_axis + 2.0 * (down != behind_axis) + 1.0 * (joints[4] < 0.0)]


def configuration_at(robot: Robot, joints: Sequence[float]) -> list[float]:
    """Return the configuration of a robot whose joints (rad) are there."""
    return confdata(joints, robot.solve_forward(joints, with_configuration=True).configuration)
