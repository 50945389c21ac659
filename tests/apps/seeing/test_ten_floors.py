"""Ten goals on ten furnished floors by seed, counted: in a kernel for those who hunt, and some of them in the plane."""

from __future__ import annotations

import time

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.seeing.navigation import floors, journeys
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.navigator import Goal
from virtualrobot_apps.seeing.navigation.planning import Costmap, Planner, length
from virtualrobot_apps.seeing.navigation.poses import Floats, distance, planar
from virtualrobot_apps.seeing.navigation.vehicle import Vehicle, sensors_of

from tests.apps.seeing.flat_vehicles import UGV, drive, vehicle

FLOORS, GOALS = 10, 10
MOST = 1.3
"""Length of a way, in shortest ones, up to which it is good."""
ROBOT = "ugv"


def shortest(grid: Grid, footprint: Footprint, start: Floats, goal: Floats) -> float:
    """Return the length (m) of the planner's way on the true map."""
    return length(Planner(Costmap.of(grid, footprint, np.zeros((0, 2)))).way(start, goal))


@pytest.mark.long
def test_goals_on_floors_in_the_plane(rng: np.random.Generator, seed: int) -> None:
    """Wheels turn 3% more than the vehicle moves; every goal is come to, in ways that are short, without a touch."""
    for number in range(2):
        boxes = floors.floor(seed + number)
        grid = floors.true_grid(boxes, 0.05)
        begin, *goals = floors.places(boxes, 3, seed + number, 0.45)
        ugv = vehicle(grid, (*begin, 0.0), Goal(*begin))
        ugv.slips = lambda time: 0.03
        for goal in goals:
            best = shortest(grid, UGV, ugv.pose, goal)
            ugv.navigator.go(Goal(*goal))
            ugv.way.clear()
            nearest = drive([ugv], lambda time, boxes=boxes: boxes, rng)
            assert ugv.navigator.reached and nearest > 0.0, (seed + number, goal, ugv.told)
            assert distance(ugv.pose, goal) < 0.2, (seed + number, goal, ugv.told)
            assert length(np.array(ugv.way)) < MOST * best, (seed + number, goal)


@pytest.mark.hunted
@pytest.mark.timeout(0)
def test_ten_goals_on_ten_floors(seed: int, hunt_seconds: float) -> None:
    """By lidar and encoders in a kernel, whose collision check and poses judge; floors end when the time is over."""
    over, failed, gone = time.monotonic() + hunt_seconds, [], 0
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        for number in range(seed, seed + FLOORS):
            if time.monotonic() > over:
                break
            gone += GOALS
            failed += [f"floor {number}: {words}" for words in _failures(client, number)]
    print(f"{gone - len(failed)} of {gone} goals")
    assert not failed


def _failures(client: virtualrobot.Client, number: int) -> list[str]:
    """Return in words what went wrong on the way to GOALS goals on a floor."""
    boxes = floors.floor(number)
    begin, *goals = floors.places(boxes, GOALS + 1, number, 0.45)
    floors.build(client, boxes)
    client.load_robot(f"model://{ROBOT}", name=ROBOT, base="planar", pose=virtualrobot.pose(*begin))
    grid = floors.true_grid(boxes, 0.05)
    ugv = Vehicle(client, ROBOT, *sensors_of(client, ROBOT))
    found: list[str] = []
    here = np.array([*begin, 0.0])
    for goal in goals:
        track, clear, told = [here], [], list[str]()

        def watch(_: Floats, track: list[Floats] = track, clear: list[float] = clear) -> None:
            track.append(planar(client.scene.pose(f"{ROBOT}.base")))
            if len(track) % 5 == 0:
                clear.append(client.collisions.distance(ROBOT, to=[floors.NODE]).distance)

        (reached,) = journeys.go(client, ugv, grid, [Goal(*goal)], here, say=told.append, watch=watch)
        best, way = shortest(grid, ugv.footprint, here, goal), length(np.array(track)[:, :2])
        here = track[-1]
        where = f"({goal[0]:.2f}, {goal[1]:.2f})"
        if not reached or distance(here, goal) > 0.2:
            found.append(f"{where} not reached, {distance(here, goal):.2f} m off: {told}")
        elif min(clear) <= 0.0:
            found.append(f"{where}: touches something")
        elif way > MOST * best:
            found.append(f"{where}: {way:.2f} m, and {best:.2f} m is the shortest way")
    return found
