"""World of a study's scene in the memory of each worker: the setup of ready studies, and of functions of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot.errors import InvalidArgumentError, WrongStateError

from virtualrobot_apps.studies.parameters import Floats


class Postures(Protocol):
    """Postures of a robot at n poses, m together."""

    @property
    def target(self) -> NDArray[np.int64]:
        """(m,) which pose each is for, ascending."""
        ...

    @property
    def positions(self) -> Floats:
        """(m, k) of the joints, rad or m."""
        ...

    @property
    def free(self) -> NDArray[np.bool_]:
        """(m,) which touch nothing."""
        ...

    @property
    def touching(self) -> tuple[tuple[str, str] | None, ...]:
        """(m) names of two nodes that touch, or None."""
        ...


class World(Protocol):
    """World without a server; what it refuses raises errors in words."""

    def restore(self) -> None:
        """Go back to the world as it was loaded."""
        ...

    def place(self, node: str, parent_t_node: ArrayLike) -> None:
        """Put a node elsewhere on its parent: parent_t_node (4, 4), m."""
        ...

    def set_joints(self, robot: str, positions: Mapping[str, float]) -> None:
        """Put joints elsewhere, by name, rad or m."""
        ...

    def pose(self, node: str) -> Floats:
        """Return world_t_node (4, 4)."""
        ...

    def parent_pose(self, node: str) -> Floats:
        """Return parent_t_node (4, 4)."""
        ...

    def tool_pose(self, robot: str) -> Floats:
        """Return world_t_tcp (4, 4) of the chosen tool centre point, without a tool the flange."""
        ...

    def joint_limits(self, robot: str) -> Floats:
        """Return the limits (k, 2) of the joints that lead the tool centre point (rad or m)."""
        ...

    def postures(self, robot: str, world_t_tcp: ArrayLike) -> Postures:
        """Return all postures that bring the tool centre point to poses (n, 4, 4), without full turns."""
        ...

    def contacts(self, robot: str) -> list[tuple[str, str]]:
        """Return the names of what touches and may not wherever the arm is, such as a robot's base and a wall."""
        ...

    def close(self) -> None:
        """End what it has started."""
        ...


def open_world(scene: Path | None) -> World:
    """Return the world of a scene file, which ends with the process: for `setup` of a study file.

    Raises:
        InvalidArgumentError: when the study names no scene.
        WrongStateError: when the kernel isn't installed here.
        Exception: what is wrong in the scene, in words.
    """
    if scene is None:
        raise InvalidArgumentError("this study needs a scene: `scene: FILE` in the study file")
    found = entry_points(group="virtualrobot.kernel", name="world")
    if not found:
        raise WrongStateError("the kernel is not installed here: pip install 'virtualrobot[kernel]'")
    return next(iter(found)).load()(scene)
