"""World of a study's scene in the memory of each worker: the setup of ready studies, and of functions of one's own."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot.errors import InvalidArgumentError, WrongStateError

from virtualrobot_apps.studies.parameters import Floats

NO_SCENE = "this study needs a scene: `scene: FILE` in the study file"
"""Message where a study names none."""


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


class Fit(Protocol):
    """Errors that fit best: see `virtualrobot_apps.studies.calibration`."""

    @property
    def parameters(self) -> Floats:
        """(count,) the errors that fit best; what the points don't tell is 0 in them."""
        ...

    @property
    def rank(self) -> int:
        """Number of directions of them that the points tell."""
        ...

    @property
    def condition(self) -> float:
        """Ratio of the best determined of these to the worst one."""
        ...

    @property
    def deviation(self) -> float:
        """Noise of one measured number, sqrt(SSR / (3 n - rank)), m."""
        ...


class KinematicErrors(Protocol):
    """Chain of a robot with six small errors behind its base and each joint: x, y, z (m), a rotation vector (rad)."""

    @property
    def count(self) -> int:
        """Number of errors."""
        ...

    def poses(self, errors: Floats, postures: Floats) -> Floats:
        """Return base_t_tcp (m, 4, 4) at postures (m, k), rad or m, with errors (count,)."""
        ...

    def fit(self, postures: Floats, points: Floats) -> Fit:
        """Return the errors with which the tool centre point was at points (m, 3) in m postures (m, k)."""
        ...

    def ranks(self, postures: Floats) -> tuple[int, int]:
        """Return how many errors can be told apart by poses, and by points, that are measured in m postures (m, k)."""
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

    def joints(self, robot: str) -> dict[str, float]:
        """Return where the joints are that lead the tool centre point, by name (rad or m)."""
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

    def touching(self, robot: str, joints: ArrayLike) -> tuple[str, str] | None:
        """Return the names of two nodes that touch and may not with the joints (k,) there (rad or m), or None."""
        ...

    def kinematic_errors(self, robot: str) -> KinematicErrors:
        """Return a robot's chain up to its tool centre point, with errors to plant and to find, in its base's frame."""
        ...

    def seen(self, sensor: str, points: ArrayLike, within: float = 0.0) -> NDArray[np.bool_]:
        """Return which of points (n, 3), m in the world, a sensor sees, with nothing before them: (n,).

        A pinhole camera sees what is in its picture, a range sensor what one of its beams passes within so many meters.
        """
        ...

    def close(self) -> None:
        """End what it has started."""
        ...


class Worlds:
    """Worlds of a scene in which a robot is made of other models; those asked for last are kept."""

    def __init__(self, scene: Path | None, most: int = 4) -> None:
        """Take a scene, and how many worlds are kept."""
        self._scene, self._most = scene, most
        self._kept = OrderedDict[tuple[str, str], World]()

    def of(self, robot: str, model: str) -> World:
        """Return the world in which a robot is a model, such as `model://ur10e`, as it was loaded; raise as it does."""
        key = robot, model
        if key not in self._kept:
            while len(self._kept) >= self._most:
                self._kept.popitem(last=False)[1].close()
            self._kept[key] = open_world(self._scene, {robot: model})
        self._kept.move_to_end(key)
        self._kept[key].restore()
        return self._kept[key]


def open_worlds(scene: Path | None) -> Worlds:
    """Return the worlds of a scene file: for `setup` of a study file whose cells choose a robot's model.

    Raises:
        InvalidArgumentError: when the study names no scene.
    """
    if scene is None:
        raise InvalidArgumentError(NO_SCENE)
    return Worlds(scene)


def open_world(scene: Path | None, models: Mapping[str, str] | None = None) -> World:
    """Return the world of a scene file, which ends with the process: for `setup` of a study file.

    Robots that `models` has by name are made of these models, such as `model://ur10e`.

    Raises:
        InvalidArgumentError: when the study names no scene.
        WrongStateError: when the kernel isn't installed here.
        Exception: what is wrong in the scene, in words.
    """
    if scene is None:
        raise InvalidArgumentError(NO_SCENE)
    found = entry_points(group="virtualrobot.kernel", name="world")
    if not found:
        raise WrongStateError("the kernel is not installed here: pip install 'virtualrobot[kernel]'")
    return next(iter(found)).load()(scene, models or {})
