"""Points of a cloud near an arm, as a law of avoidance wants them: about joints and the middles between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from virtualrobot import Robot

Floats = NDArray[np.float64]
FIXED = 2
"""Number of links at the foot of an arm that hardly move: they have no points."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Point of an arm's link and one of a cloud: points (2, 3) in the world's frame, and their distance (m)."""

    first: str
    distance: float
    points: Floats


class NearPoints:
    """Tells which points of a cloud are near an arm in a posture."""

    def __init__(self, robot: Robot, cloud: Floats, reach: float, count: int) -> None:
        """Take a cloud (n, 3) in the world's frame; `count` points of it within `reach` (m) are told at each place."""
        self._robot, self._tree, self._cloud = robot, KDTree(cloud), cloud
        self._reach, self._count = reach, count

    def __call__(self, at: Mapping[str, float]) -> Sequence[Seen]:
        """Return what is near with joints at positions by name, the nearest first."""
        return sorted(self._near(at), key=lambda one: one.distance)

    def _near(self, at: Mapping[str, float]) -> Iterator[Seen]:
        poses = list(self._robot.solve_forward(dict(at)).world_t_link.items())[FIXED:]
        links, places = [link for link, _ in poses], np.array([pose[:3, 3] for _, pose in poses])
        own, mine = [*links, *links[:-1]], np.vstack([places, 0.5 * (places[:-1] + places[1:])])
        away, which = self._tree.query(mine, k=self._count, distance_upper_bound=self._reach)
        away, which = (np.reshape(one, (len(mine), self._count)) for one in (away, which))
        for link, place, distances, numbers in zip(own, mine, away, which, strict=True):
            for distance, number in zip(distances, numbers, strict=True):
                if np.isfinite(distance):
                    yield Seen(link, float(distance), np.array([place, self._cloud[number]]))
