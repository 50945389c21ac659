"""Ghosts: robots shown, translucent, where they are not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import array_message, array_of, color_message
from virtualrobot._wire.showing import shown
from virtualrobot.motions.paths import FreePath
from virtualrobot.motions.plans import RobotTrajectory
from virtualrobot.robots.dynamics import Samples, sample_rows
from virtualrobot.v1 import collision_pb2, view_pb2

MOST = 20
"""Largest number of configurations shown of a ghost; of more, so many are picked evenly, from the first to the last."""


Positions = Samples | FreePath | RobotTrajectory


@shown
@checked
@dataclass(frozen=True, slots=True, eq=False)
class Ghost:
    """A robot as it would look in some configurations.

    Attributes:
        robot: the robot.
        positions: rows (n, k), a column for each joint with one coordinate, in the robot's order, radians or meters; or
            values by joint name; or a path that was found, or a robot's trajectory of a plan.
        color: of everything; None means blue.
        opacity: above 0 (clear), to 1 (solid).
    """

    robot: str
    positions: Positions
    color: str | ArrayLike | None = None
    opacity: float = 0.3


def ghost_message(name: str, ghost: Ghost) -> view_pb2.Ghost:
    """Return a ghost as a message, with at most `MOST` configurations."""
    positions, names = ghost.positions, []
    if isinstance(positions, FreePath):
        positions, names = positions.waypoints, list(positions.joint_names)
    elif isinstance(positions, RobotTrajectory):
        positions, names = positions.positions, list(positions.joint_names)
    elif isinstance(positions, Mapping):
        names = [str(joint) for joint in positions]
    rows = _thinned(sample_rows(positions, names, "positions"))
    return view_pb2.Ghost(
        name=name,
        configurations=collision_pb2.RobotConfigurations(
            robot=ghost.robot, joint_names=names, positions=array_message(rows)
        ),
        color=None if ghost.color is None else color_message(ghost.color),
        opacity=ghost.opacity,
    )


def ghost_of(message: view_pb2.Ghost) -> Ghost:
    """Return a ghost as the kernel tells it."""
    told, color = message.configurations, message.color
    return Ghost(told.robot, array_of(told.positions), [color.red, color.green, color.blue], message.opacity)


def _thinned(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    if len(rows) <= MOST:
        return rows
    return rows[np.linspace(0, len(rows) - 1, MOST).round().astype(int)]
