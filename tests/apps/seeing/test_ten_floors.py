"""Ten goals on ten furnished floors by seed, counted: in a kernel for those who hunt, and some of them in the plane."""

from __future__ import annotations

import time

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.seeing.navigation import floors
from virtualrobot_apps.seeing.navigation.navigator import Goal
from virtualrobot_apps.seeing.navigation.planning import length
from virtualrobot_apps.seeing.navigation.poses import distance

from tests.apps.seeing import floors_by_seed
from tests.apps.seeing.flat_vehicles import UGV, drive, vehicle

FLOORS, GOALS = 10, 10
MOST = 1.3
"""Length of a way, in shortest ones, up to which it is good."""


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
            best = floors_by_seed.shortest(grid, UGV, ugv.pose, goal)
            ugv.navigator.go(Goal(*goal))
            ugv.way.clear()
            nearest = drive([ugv], lambda time, boxes=boxes: boxes, rng)
            assert ugv.navigator.reached and nearest > 0.0, (seed + number, goal, ugv.told)
            assert distance(ugv.pose, goal) < 0.2, (seed + number, goal, ugv.told)
            assert length(np.array(ugv.way)) < MOST * best, (seed + number, goal)


@pytest.mark.long
def test_goals_on_a_floor_in_a_kernel(seed: int) -> None:
    """By lidar and encoders, judged by the kernel's poses and distances: short ways that touch nothing."""
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        for gone in floors_by_seed.ways(client, seed, 2):
            assert gone.reached and gone.clear > 0.0 and gone.ratio < MOST, (seed, gone)


@pytest.mark.hunted
@pytest.mark.timeout(0)
def test_ten_goals_on_ten_floors(seed: int, hunt_seconds: float) -> None:
    """The same for all of them; floors end when the time is over."""
    over, failed, gone = time.monotonic() + hunt_seconds, [], 0
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        for number in range(seed, seed + FLOORS):
            if time.monotonic() > over:
                break
            found = list(floors_by_seed.ways(client, number, GOALS))
            gone += len(found)
            failed += [(number, one) for one in found if not one.reached or one.clear <= 0.0 or one.ratio > MOST]
    print(f"{gone - len(failed)} of {gone} goals")
    assert not failed
