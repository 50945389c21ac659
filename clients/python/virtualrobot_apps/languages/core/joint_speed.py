"""Speeds of the tool centre point on joint moves, by which controllers' languages tell how fast joints go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import turn_between
from virtualrobot.robots.robot import Robot

PLACES = 8
"""Number of pieces in which the way of a joint move is looked at for its speed."""


@dataclass(frozen=True, slots=True)
class FullSpeed:
    """Joint move at the joints' greatest speeds, without accelerations.

    Attributes:
        seconds: how long it takes (s).
        speed: the greatest speed of the tool centre point (m/s).
        turning: how fast it turns at most (rad/s).
    """

    seconds: float
    speed: float
    turning: float


def full_speed(
    robot: Robot,
    joints: Sequence[str],
    start: NDArray[np.float64],
    goal: NDArray[np.float64],
    velocities: NDArray[np.float64],
) -> FullSpeed:
    """Return how fast a joint move of a robot is at the joints' greatest speeds.

    `start`, `goal` (n,) are rad or m of the `joints`, `velocities` (n,) their greatest speeds; the tool centre point is
    the chosen one. Nothing is asked of the kernel where nothing moves.
    """
    seconds = float(np.max(np.abs(goal - start) / velocities))
    if seconds < 1e-9:
        return FullSpeed(0.0, 0.0, 0.0)
    shares = np.linspace(0.0, 1.0, PLACES + 1)[:, None]
    ways = [
        robot.solve_forward(dict(zip(joints, row, strict=True))).world_t_tcp
        for row in (start + shares * (goal - start)).tolist()
    ]
    each = seconds / PLACES
    fastest = max(float(np.linalg.norm(b[:3, 3] - a[:3, 3])) for a, b in pairwise(ways)) / each
    return FullSpeed(seconds, fastest, max(turn_between(a, b) for a, b in pairwise(ways)) / each)
