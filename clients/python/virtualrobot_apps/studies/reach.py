"""Reach and dexterity maps: which share of all orientations a robot's tool centre point takes at a place.

For a study file: `function: virtualrobot_apps.studies.reach:reach`,
`setup: virtualrobot_apps.studies.worlds:open_world`.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from virtualrobot_apps.studies.parameters import Floats
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import World

_GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))


def reach(cell: Cell) -> dict[str, float]:
    """Return how well a robot reaches a place of its scene.

    Its parameters: `robot`, a name; `x`, `y`, `z` in the world's frame (m); `directions`, the number of directions in
    which the tool's z axis points, even over the sphere; `turns`, the number of angles about each of them.

    Its results: `reached`, the share of these orientations that the robot reaches, within limits; `free`, the share
    that it reaches and touches nothing; `branches`, the mean number of postures that are free.
    """
    world: World = cell.shared
    rotations = orientations(int(cell.parameters["directions"]), int(cell.parameters["turns"]))
    poses = np.tile(np.eye(4), (len(rotations), 1, 1))
    poses[:, :3, :3] = rotations
    poses[:, :3, 3] = [cell.parameters[name] for name in "xyz"]
    world.restore()
    found = world.postures(cell.parameters["robot"], poses)
    free = found.target[found.free]
    return {
        "reached": len(np.unique(found.target)) / len(poses),
        "free": len(np.unique(free)) / len(poses),
        "branches": len(free) / len(poses),
    }


@cache
def orientations(directions: int, turns: int) -> Floats:
    """Return rotations (directions * turns, 3, 3) whose z axes are a Fibonacci lattice on the sphere.

    Richard Swinbank, R. James Purser, "Fibonacci grids: a novel approach to global modelling", 2006.
    """
    if directions < 1 or turns < 1:
        raise ValueError(f"directions and turns are 1 or more, not {directions} and {turns}")
    number = np.arange(directions)
    height = 1.0 - (2.0 * number + 1.0) / directions
    around = _GOLDEN_ANGLE * number
    z = np.stack([np.sqrt(1.0 - height**2) * np.cos(around), np.sqrt(1.0 - height**2) * np.sin(around), height], axis=1)
    # Any axis across will do as the first one; the one that is least along z is well off it.
    across = np.eye(3)[np.abs(z).argmin(axis=1)]
    x = np.cross(across, z)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(z, x)
    angle = 2.0 * np.pi * np.arange(turns) / turns
    c, s = np.cos(angle)[None, :, None], np.sin(angle)[None, :, None]
    turned = (
        c * x[:, None] + s * y[:, None],
        c * y[:, None] - s * x[:, None],
        np.broadcast_to(z[:, None], (directions, turns, 3)),
    )
    return np.stack(turned, axis=-1).reshape(-1, 3, 3)
