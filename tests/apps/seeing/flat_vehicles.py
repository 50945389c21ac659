"""Vehicles in the plane: rays are met by formula, with the noise of the LDS-01, and vehicles do as told at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from virtualrobot_apps.seeing.navigation.floors import Box
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.localising import Localiser
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator, Observation
from virtualrobot_apps.seeing.navigation.poses import Floats, arc, compose, moved, wrapped
from virtualrobot_apps.seeing.navigation.sonars import Sonar
from virtualrobot_apps.seeing.navigation.vehicle import PERIOD

from tests.apps.seeing.flat_lidar import COUNT, REACH, distances, scan_at

LONGEST = 120.0
"""Time (s) after which nobody is on the way any more."""
SCANNED = 4
"""Periods from one scan to the next."""
UGV = Footprint(-0.14, 0.14, -0.15, 0.15)
BEHIND = Footprint(-0.205, 0.1, -0.134, 0.134)
"""That of the model `ugv`, which turns about its wheels, near its front."""


@dataclass
class Driven:
    """Vehicle at a pose (3,) with its navigator.

    `slips` is by what part more its wheels turn than it moves; -1: encoders stand. `sonars` hear `low`, too, which the
    lidar's rays pass above.
    """

    navigator: Navigator
    pose: Floats
    odometry: Floats
    slips: Callable[[float], float] = lambda time: 0.0
    told: list[str] = field(default_factory=list)
    way: list[Floats] = field(default_factory=list)
    periods: int = 0
    sonars: tuple[Sonar, ...] = ()
    low: tuple[Box, ...] = ()

    def hears(self, sonar: Sonar, boxes: Sequence[Box]) -> float:
        """Return the least distance in the cone of a sonar (m); inf: none."""
        lengths = distances([*boxes, *self.low], compose(self.pose, sonar.base_t_sonar))
        angles = wrapped(np.arange(COUNT) * 2.0 * np.pi / COUNT)
        return float(lengths[np.abs(angles) < sonar.half_angle].min())

    def corners(self) -> Floats:
        """Return its outline (n, 2)."""
        return moved(self.pose, self.navigator.footprint.outline())

    def body(self) -> Box:
        """Return the box about it, parallel to the walls, as others' rays meet it."""
        low, high = self.corners().min(axis=0), self.corners().max(axis=0)
        (x, y), (wide, deep) = 0.5 * (low + high), high - low
        return Box(float(x), float(y), float(wide), float(deep), 1.0, "#888")

    def step(self, boxes: Sequence[Box], rng: np.random.Generator) -> None:
        """Go on by a period."""
        time = self.periods * PERIOD
        seen = scan_at(boxes, self.pose, self.odometry, rng, time) if self.periods % SCANNED == 0 else None
        heard = tuple((one, self.hears(one, boxes)) for one in self.sonars)
        v, w = self.navigator.step(Observation(time, self.odometry, seen, heard))
        self.way.append(self.pose[:2])
        self.pose = compose(self.pose, arc(np.array([v, w]), np.array(PERIOD)))
        turned = 1.0 + self.slips(time)
        told = np.array([v, w]) * ([0.0, 0.0] if turned == 0.0 else [turned, 1.0])
        self.odometry = compose(self.odometry, arc(told, np.array(PERIOD)))
        self.periods += 1


def vehicle(grid: Grid, start: Sequence[float] | Floats, goal: Goal, footprint: Footprint = UGV) -> Driven:
    """Return a vehicle on its way to a goal."""
    told: list[str] = []
    pose = np.array(start, np.float64)
    navigator = Navigator(Localiser(grid, pose), footprint, say=told.append, reach=REACH)
    navigator.go(goal)
    return Driven(navigator, pose, pose.copy(), told=told)


def drive(vehicles: Sequence[Driven], boxes: Callable[[float], Sequence[Box]], rng: np.random.Generator) -> float:
    """Drive vehicles until all are at an end; return how near their outlines have come to anything (m)."""
    begun, nearest = vehicles[0].periods, np.inf
    while any(one.navigator.end is None for one in vehicles):
        period = vehicles[0].periods
        if (period - begun) * PERIOD > LONGEST:
            break
        for one in vehicles:
            around = [*boxes(period * PERIOD), *(other.body() for other in vehicles if other is not one)]
            one.step(around, rng)
            nearest = min(nearest, *(float(box.apart(one.corners()).min()) for box in (*around, *one.low)))
    return nearest


def room(wide: float, deep: float) -> list[Box]:
    """Return the walls of an empty room whose corner is at 0."""
    wall = 0.1
    return [
        Box(0.5 * wide, -0.5 * wall, wide, wall, 1.0, "white"),
        Box(0.5 * wide, deep + 0.5 * wall, wide, wall, 1.0, "white"),
        Box(-0.5 * wall, 0.5 * deep, wall, deep, 1.0, "white"),
        Box(wide + 0.5 * wall, 0.5 * deep, wall, deep, 1.0, "white"),
    ]


def known(boxes: Sequence[Box], wide: float, deep: float) -> Grid:
    """Return the map of a room."""
    resolution, margin = 0.05, 0.2
    shape = (round((deep + 2.0 * margin) / resolution), round((wide + 2.0 * margin) / resolution))
    grid = Grid(resolution, np.full(2, -margin), np.zeros(shape))
    places = grid.middles(*np.indices(shape))
    inside = (places > 0.0).all(axis=2) & (places < [wide, deep]).all(axis=2)
    grid.log_odds[inside] = -4.0
    for box in boxes:
        grid.log_odds[box.apart(places) <= 0.0] = 4.0
    return grid
