"""Ways of a UGV to goals on furnished floors by seed, in a kernel whose poses and distances judge them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import virtualrobot
from virtualrobot_apps.seeing.navigation import floors, journeys
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.navigator import Goal
from virtualrobot_apps.seeing.navigation.planning import Costmap, Planner, length
from virtualrobot_apps.seeing.navigation.poses import Floats, distance, planar
from virtualrobot_apps.seeing.navigation.vehicle import Vehicle, sensors_of

ROBOT = "ugv"
CLEARANCE = 0.45
"""Distance (m) of goals from everything."""
CHECKED = 5
"""Periods from one check of what the vehicle touches to the next."""
NEAR = 0.2
"""Distance (m) from its goal up to which it has truly come to it."""


@dataclass(frozen=True, slots=True)
class Gone:
    """Way to a goal that is over.

    reached: whether it has truly come there. ratio: its length, in shortest ones.
    clear: least distance (m) from anything.
    """

    goal: tuple[float, float]
    reached: bool
    ratio: float
    clear: float
    told: tuple[str, ...]


def shortest(grid: Grid, footprint: Footprint, start: Floats, goal: Floats) -> float:
    """Return the length (m) of the planner's way on the true map."""
    return length(Planner(Costmap.of(grid, footprint, np.zeros((0, 2)))).way(start, goal))


def ways(client: virtualrobot.Client, number: int, count: int) -> Iterator[Gone]:
    """Yield the ways to so many goals on the floor of a seed, by lidar and encoders on its true map."""
    boxes = floors.floor(number)
    begin, *goals = floors.places(boxes, count + 1, number, CLEARANCE)
    floors.build(client, boxes)
    client.load_robot(f"model://{ROBOT}", name=ROBOT, base="planar", pose=virtualrobot.pose(*begin))
    grid = floors.true_grid(boxes, 0.05)
    ugv = Vehicle(client, ROBOT, *sensors_of(client, ROBOT))
    here = np.array([*begin, 0.0])
    for goal in goals:
        track, clear, told = [here], [], list[str]()

        def watch(_: Floats, track: list[Floats] = track, clear: list[float] = clear) -> None:
            track.append(planar(client.scene.pose(f"{ROBOT}.base")))
            if len(track) % CHECKED == 0:
                clear.append(client.collisions.distance(ROBOT, to=[floors.NODE]).distance)

        (reached,) = journeys.go(client, ugv, grid, [Goal(*goal)], here, say=told.append, watch=watch)
        best, way = shortest(grid, ugv.footprint, here, goal), length(np.array(track)[:, :2])
        here = track[-1]
        there = reached and distance(here, goal) < NEAR
        yield Gone((float(goal[0]), float(goal[1])), there, way / best, min(clear), tuple(told))
