"""Places of the base of a mobile manipulator from which its arm may reach a pose."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DISTANCES = (0.5, 0.65, 0.8, 0.35, 0.95)
"""Distances (m) of the base's origin from the pose, seen from above."""

AROUND = 16
"""Number of directions from which it is looked at."""


def places_round(base_t_goal: Floats) -> Iterator[Floats]:
    """Yield poses (4, 4) of a base, seen from now: this one, then the nearest round a pose, headed for it."""
    yield np.eye(4)
    x, y = base_t_goal[:2, 3].tolist()
    found: list[tuple[float, float, float, float]] = []
    for distance in DISTANCES:
        for place in range(AROUND):
            angle = math.atan2(-y, -x) + place * math.tau / AROUND
            at_x, at_y = x + distance * math.cos(angle), y + distance * math.sin(angle)
            heading = math.remainder(angle + math.pi, math.tau)
            found.append((math.hypot(at_x, at_y) + 0.5 * abs(heading), at_x, at_y, heading))
    for _, at_x, at_y, heading in sorted(found):
        pose = np.eye(4)
        pose[:2, :2] = [[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]]
        pose[:2, 3] = at_x, at_y
        yield pose


def moved(begin: tuple[float, float, float], base: Floats) -> tuple[float, float, float]:
    """Return x, y and heading of a pose (4, 4) that is told from a base at x, y and a heading."""
    x, y, heading = begin
    across, up = base[:2, 3].tolist()
    cosine, sine = math.cos(heading), math.sin(heading)
    turned = math.atan2(base[1, 0], base[0, 0])
    return x + cosine * across - sine * up, y + sine * across + cosine * up, heading + turned
