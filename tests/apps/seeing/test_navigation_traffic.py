"""Vehicles that meet what their map has not: boxes that are put in the way, another vehicle, wheels that slip.

In the plane, with rays by formula, and the noise of the LDS-01; vehicles do what they are told at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest
from virtualrobot_apps.seeing.navigation.floors import Box
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.localising import Localiser
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator, Observation
from virtualrobot_apps.seeing.navigation.poses import Floats, arc, compose, distance, moved
from virtualrobot_apps.seeing.navigation.vehicle import PERIOD

from tests.apps.seeing.flat_lidar import scan_at

pytestmark = pytest.mark.long
LONGEST = 120.0
"""Time (s) after which nobody is on the way any more."""
SCANNED = 4
"""Periods from one scan to the next."""
UGV = Footprint(-0.14, 0.14, -0.15, 0.15)
HUSKY = Footprint(-0.495, 0.495, -0.335, 0.335)
"""That of Clearpath's data sheet: 990 x 670 mm."""


@dataclass
class Driven:
    """Vehicle at a pose (3,) with its navigator; `slips` is by what part more its wheels turn than it moves."""

    navigator: Navigator
    pose: Floats
    odometry: Floats
    slips: Callable[[float], float] = lambda time: 0.0
    told: list[str] = field(default_factory=list)

    def corners(self) -> Floats:
        """Return its outline (n, 2)."""
        return moved(self.pose, self.navigator.footprint.outline())

    def body(self) -> Box:
        """Return the box about it, parallel to the walls, as others' rays meet it."""
        low, high = self.corners().min(axis=0), self.corners().max(axis=0)
        (x, y), (wide, deep) = 0.5 * (low + high), high - low
        return Box(float(x), float(y), float(wide), float(deep), 1.0, "#888")

    def step(self, boxes: Sequence[Box], time: float, period: int, rng: np.random.Generator) -> None:
        """Go on by a period."""
        seen = scan_at(boxes, self.pose, self.odometry, rng, time) if period % SCANNED == 0 else None
        v, w = self.navigator.step(Observation(time, self.odometry, seen))
        self.pose = compose(self.pose, arc(np.array([v, w]), np.array(PERIOD)))
        turned = 1.0 + self.slips(time)
        self.odometry = compose(self.odometry, arc(np.array([v * turned, w]), np.array(PERIOD)))


def vehicle(grid: Grid, start: Sequence[float], goal: Goal, footprint: Footprint = UGV) -> Driven:
    """Return a vehicle on its way to a goal."""
    told: list[str] = []
    pose = np.array(start, np.float64)
    navigator = Navigator(Localiser(grid, pose), footprint, say=told.append)
    navigator.go(goal)
    return Driven(navigator, pose, pose.copy(), told=told)


def drive(vehicles: Sequence[Driven], boxes: Callable[[float], Sequence[Box]], rng: np.random.Generator) -> float:
    """Drive vehicles until all are at an end; return how near their outlines have come to anything (m)."""
    period, nearest = 0, np.inf
    while any(one.navigator.end is None for one in vehicles) and (time := period * PERIOD) < LONGEST:
        for one in vehicles:
            around = [*boxes(time), *(other.body() for other in vehicles if other is not one)]
            one.step(around, time, period, rng)
            nearest = min(nearest, *(float(box.apart(one.corners()).min()) for box in around))
        period += 1
    return nearest


def room(wide: float, deep: float) -> list[Box]:
    """Return the walls of an empty room whose corner is at 0."""
    wall = 0.1
    return [
        Box(0.5 * wide, -0.5 * wall, wide, wall, 1.0, "#fff"),
        Box(0.5 * wide, deep + 0.5 * wall, wide, wall, 1.0, "#fff"),
        Box(-0.5 * wall, 0.5 * deep, wall, deep, 1.0, "#fff"),
        Box(wide + 0.5 * wall, 0.5 * deep, wall, deep, 1.0, "#fff"),
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


def test_husky_crosses_a_room_in_which_boxes_are_put_in_its_way(rng: np.random.Generator) -> None:
    walls = room(7.0, 4.5)
    husky = vehicle(known(walls, 7.0, 4.5), (1.0, 2.3, 0.0), Goal(6.0, 2.3), HUSKY)
    boxes = [Box(3.2, 2.4, 0.5, 0.5, 1.0, "#a52"), Box(5.0, 1.5, 0.4, 0.6, 1.0, "#a52")]
    put = [2.0, 6.0]
    nearest = drive(
        [husky], lambda time: [*walls, *(box for box, at in zip(boxes, put, strict=True) if time > at)], rng
    )
    assert husky.navigator.reached, husky.told
    assert distance(husky.pose, (6.0, 2.3)) < 0.25 and nearest > 0.0


def test_two_vehicles_share_an_aisle(rng: np.random.Generator) -> None:
    """Each begins where the other one wants to go; each sees the other one by its lidar alone."""
    wide, deep = 6.0, 1.6
    walls = room(wide, deep)
    grid = known(walls, wide, deep)
    first = vehicle(grid, (0.7, 0.8, 0.0), Goal(5.3, 0.8))
    second = vehicle(grid, (5.3, 0.8, np.pi), Goal(0.7, 0.8))
    nearest = drive([first, second], lambda time: walls, rng)
    assert first.navigator.reached and second.navigator.reached, (first.told, second.told)
    assert nearest > 0.0


def test_a_goal_that_is_taken_is_waited_for_near_it(rng: np.random.Generator) -> None:
    """A box on a goal may go; one that stays ends the way 10 s after it was come to, in words with numbers."""
    walls = room(4.0, 2.0)
    crate = Box(3.3, 1.0, 0.3, 0.3, 1.0, "#a52")
    waits = vehicle(known(walls, 4.0, 2.0), (0.6, 1.0, 0.0), Goal(3.3, 1.0))
    nearest = drive([waits], lambda time: [*walls, crate], rng)
    assert not waits.navigator.reached and nearest > 0.0
    assert 0.3 < distance(waits.pose, (3.3, 1.0)) < 1.1, waits.told
    assert waits.told[0] == "something stands on its goal now: goes on towards it"
    assert waits.told[-1].startswith("gives up: the goal (3.30, 1.00) is"), waits.told
    assert waits.told[-1].endswith("with what stands there now")


def test_wheels_that_slip_are_told_and_the_lidar_goes_on(rng: np.random.Generator) -> None:
    """For 3 s the wheels turn four times as much as they move it: it says so, and comes to its goal all the same."""
    boxes = [*room(4.0, 3.0), Box(2.2, 0.4, 0.5, 0.5, 1.0, "#a52"), Box(1.2, 2.7, 0.6, 0.3, 1.0, "#a52")]
    slips = vehicle(known(boxes, 4.0, 3.0), (0.6, 1.5, 0.0), Goal(3.4, 1.8))
    slips.slips = lambda time: 3.0 if 1.0 < time < 4.0 else 0.0
    nearest = drive([slips], lambda time: boxes, rng)
    assert slips.navigator.reached and nearest > 0.0, slips.told
    assert distance(slips.pose, (3.4, 1.8)) < 0.25, slips.told
    assert distance(slips.odometry, slips.pose) > 1.0
    assert any(one.startswith("its wheels slip: odometry says") for one in slips.told), slips.told
