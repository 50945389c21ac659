"""A pick whose part lies a little off: does the gripper, which forgives two standard deviations, still get it?"""

import math

from virtualrobot_apps.studies.work import Cell


def pick(cell: Cell) -> dict[str, float]:
    """Return how far the part is off, and whether it was got.

    Both coordinates are normal with the deviation `sigma`, so the distance r follows a Rayleigh law and
    P(r <= 2 sigma) = 1 - exp(-2) = 0.8647, for each sigma.
    """
    sigma = cell.parameters["sigma"]
    off = sigma * math.hypot(cell.parameters["x"], cell.parameters["y"])
    return {"off": off, "got": off <= 2.0 * sigma}
