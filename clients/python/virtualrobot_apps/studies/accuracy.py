"""Quality of a process over positions: how exact a robot's tool is where, by how exact its joints are.

For a study file: `function: virtualrobot_apps.studies.accuracy:accuracy`,
`setup: virtualrobot_apps.studies.worlds:open_world`.
"""

from __future__ import annotations

import math

import numpy as np

from virtualrobot_apps.studies.parameters import Floats, check_deviations
from virtualrobot_apps.studies.placement import OUT_OF_REACH, touches
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import KinematicErrors, World

_STEP = 1e-6
"""Difference of a joint by which slopes are taken (rad or m): they are exact to about its square."""


def accuracy(cell: Cell) -> dict[str, float | str | None]:
    """Return how exact a robot is at a place, in that of its free postures in which it is most exact.

    Its parameters: `robot` and `target`, names of nodes; `dx`, `dy` and `dz`, by how much the place is beside the
    target in the world's frame (m; without them, 0), with the target's orientation; `joints`, the standard deviation
    of each joint (rad, or m where it slides).

    Its results: `deviation`, the standard deviation of the tool centre point's distance from the place, the root of
    the mean of its square (m); `along`, that of its part along the tool's z axis, such as a depth, and `across`, that
    of the rest; `dexterity`, the least speed (m/s) that the joints' unit speed gives the point in any direction, near 0
    at a singular posture; all of these None where no posture is free, and then `reason` says why.

    To first order in the errors: J J^T is the covariance of the point for joints of variance 1, J being the linear rows
    of the Jacobian (Alan Smith, Robert Cheeseman, "On the representation and estimation of spatial uncertainty", 1986).
    """
    world: World = cell.shared
    world.restore()
    parameters = cell.parameters
    check_deviations(parameters, "joints")
    pose = world.pose(parameters["target"])
    pose[:3, 3] += [parameters.get(name, 0.0) for name in ("dx", "dy", "dz")]
    found = world.postures(parameters["robot"], pose[None])
    nothing = dict.fromkeys(("deviation", "along", "across", "dexterity"))
    if not found.free.any():
        pair = next((one for one in found.touching if one), None)
        return nothing | {"reason": touches(pair) if pair else OUT_OF_REACH}
    chain = world.kinematic_errors(parameters["robot"])
    slopes = [jacobian(chain, q) for q in found.positions[found.free]]
    best = int(np.argmin([np.linalg.norm(one) for one, _ in slopes]))
    linear, axis = slopes[best]
    sigma = float(parameters["joints"])
    whole, along = sigma * float(np.linalg.norm(linear)), sigma * float(np.linalg.norm(axis @ linear))
    return {
        "deviation": whole,
        "along": along,
        "across": math.sqrt(max(0.0, whole**2 - along**2)),
        "dexterity": float(np.linalg.svd(linear, compute_uv=False)[-1]) if linear.shape[1] >= 3 else 0.0,
        "reason": None,
    }


def jacobian(chain: KinematicErrors, joints: Floats) -> tuple[Floats, Floats]:
    """Return the linear rows (3, k) of the Jacobian at joints (k,), and the tool's z axis (3,), in the base's frame."""
    steps = _STEP * np.eye(len(joints))
    poses = chain.poses(np.zeros(chain.count), np.concatenate([joints + steps, joints - steps, joints[None]]))
    points, count = poses[:, :3, 3], len(joints)
    return (points[:count] - points[count : 2 * count]).T / (2.0 * _STEP), poses[-1, :3, 2]
