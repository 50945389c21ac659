"""Calibrations of a robot's links: how good they become, by so many postures and so much noise of what measures.

For a study file: `function: virtualrobot_apps.studies.calibration:calibrate`,
`setup: virtualrobot_apps.studies.worlds:open_world`.
"""

from __future__ import annotations

import numpy as np

from virtualrobot_apps.studies.parameters import Floats, check_deviations
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import KinematicErrors, World

_UNUSED = 300
"""Number of postures by which a calibration is judged that has not seen them."""


def calibrate(cell: Cell) -> dict[str, float | None]:
    """Return how well a robot is known after a calibration by points.

    Its parameters: `robot`, a name; `postures`, the number of random ones in which the tool centre point is measured;
    `noise`, the standard deviation of each measured coordinate (m); `lengths` and `angles`, those of the errors that
    each link has, in each direction (m) and about each axis (rad).

    Its results: `rank`, how many of the errors the points tell apart; `condition` of these, 100 or less is good;
    `before` and `after`, the mean distance (m) of the tool centre point from where it is thought to be, in 300 postures
    that were not measured; `worst`, the greatest one after; `found_noise`, what the fit says of the noise (m),
    None where no more was measured than it takes.
    """
    world: World = cell.shared
    world.restore()
    robot, parameters = cell.parameters["robot"], cell.parameters
    if parameters["postures"] < 1:
        raise ValueError(f"postures is 1 or more, not {parameters['postures']:g}")
    check_deviations(parameters, "noise", "lengths", "angles")
    chain, limits = world.kinematic_errors(robot), world.joint_limits(robot)
    planted = cell.rng.normal(size=(chain.count // 6, 6)) * np.repeat([parameters["lengths"], parameters["angles"]], 3)
    postures, unused = (drawn(cell.rng, limits, int(count)) for count in (parameters["postures"], _UNUSED))
    points = chain.poses(planted.ravel(), postures)[:, :3, 3]
    found = chain.fit(postures, points + cell.rng.normal(size=points.shape) * parameters["noise"])
    before, after = (
        _off(chain, planted.ravel(), errors, unused) for errors in (0.0 * found.parameters, found.parameters)
    )
    return {
        "rank": found.rank,
        "condition": found.condition,
        "before": float(before.mean()),
        "after": float(after.mean()),
        "worst": float(after.max()),
        "found_noise": found.deviation if np.isfinite(found.deviation) else None,
    }


def drawn(rng: np.random.Generator, limits: Floats, count: int) -> Floats:
    """Return random postures (count, k) within limits (k, 2), of joints without any within pi rad or m of zero."""
    finite = np.isfinite(limits).all(axis=1)
    lower, upper = np.where(finite, limits[:, 0], -np.pi), np.where(finite, limits[:, 1], np.pi)
    return rng.uniform(lower, upper, (count, len(limits)))


def _off(chain: KinematicErrors, real: Floats, known: Floats, postures: Floats) -> Floats:
    apart = chain.poses(real, postures)[:, :3, 3] - chain.poses(known, postures)[:, :3, 3]
    return np.linalg.norm(apart, axis=1)
