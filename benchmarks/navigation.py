"""Navigation of a vehicle: a step of its control on a floor, a plan on a map of more than a million cells, and ways.

Steps and plans are measured in a plane world, whose lidar's rays are met by formula; their times are those of a core,
as all of this is computed in one thread. Ways to ten goals on each of ten floors are driven in a kernel, in steps, so
that no load changes their numbers.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.seeing.navigation import floors
from virtualrobot_apps.seeing.navigation.floors import CORRIDOR, START
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import MOST, Grid
from virtualrobot_apps.seeing.navigation.localising import Localiser
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator, Observation
from virtualrobot_apps.seeing.navigation.planning import Costmap, Planner, length
from virtualrobot_apps.seeing.navigation.poses import Floats, arc, compose
from virtualrobot_apps.seeing.navigation.regions import Distances
from virtualrobot_apps.seeing.navigation.vehicle import PERIOD

from benchmarks.rows import Row, row
from tests.apps.seeing.flat_lidar import scan_at
from tests.apps.seeing.floors_by_seed import Gone, ways

FOOTPRINT = Footprint(-0.14, 0.14, -0.15, 0.15)
"""About that of a UGV (m)."""
RESOLUTION = 0.05
SCANNED = 4
"""Periods from one scan to the next: 5 Hz, as of the LDS-01."""
GOALS, MOST_PERIODS = 4, 2000
ACROSS, ALONG = 5, 5
"""Floors beside each other, and rows of them."""
DOOR = 20
"""Width of a door (cells)."""
PLANS = 10
FLOORS, GOALS_OF_FLOOR = 10, 10
"""Floors by seed, and goals on each."""
MOST_RATIO = 1.3
"""Length of a way, in shortest ones, up to which it is good."""
STEP_SECONDS, PLAN_SECONDS = 0.02, 0.2
"""Budgets."""


def run() -> list[Row]:
    """Measure."""
    steps, reached = control_steps()
    note = f"{reached} of {GOALS} goals reached, {len(steps)} steps"
    name = "a step of control"
    rows = [
        row(f"{name}, median", 1e3 * float(np.median(steps)), 1e3 * STEP_SECONDS, "20 ms", "ms of a core", 1.0, note),
        row(
            f"{name}, 99th percentile",
            1e3 * float(np.quantile(steps, 0.99)),
            1e3 * STEP_SECONDS,
            "20 ms",
            "ms of a core",
            1.0,
        ),
        row(f"{name}, the longest", 1e3 * max(steps), 1e3 * STEP_SECONDS, "20 ms", "ms of a core", None, "with a plan"),
    ]
    grid = building()
    taken, plans, way = planned(grid)
    name, cost = "a map taken in: distances from its walls", 1e3 * taken
    rows.append(row(name, cost, 1e3 * PLAN_SECONDS, "200 ms", "ms of a core", None))
    first, *plans = plans
    rows.append(row("the first plan on a map", 1e3 * first, 1e3 * PLAN_SECONDS, "200 ms", "ms of a core", 1.0))
    note = f"{grid.log_odds.size:,} cells, a way of {length(way):.0f} m"
    rows.append(
        row("a plan, median", 1e3 * float(np.median(plans)), 1e3 * PLAN_SECONDS, "200 ms", "ms of a core", 1.0, note)
    )
    return [*rows, *driven()]


def driven() -> list[Row]:
    """Return how ways to goals on floors by seed went, by lidar and encoders in a kernel."""
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        return judged([way for seed in range(1, 1 + FLOORS) for way in ways(client, seed, GOALS_OF_FLOOR)])


def judged(found: Sequence[Gone]) -> list[Row]:
    """Return rows about ways that are over."""
    ratios = [way.ratio for way in found if way.reached]
    touched, least = sum(way.clear <= 0.0 for way in found), min(way.clear for way in found)
    name, note = f"of {len(found)} goals on {FLOORS} floors", f"{1e3 * least:.0f} mm at least from everything"
    return [
        row(f"{name}, not reached", len(found) - len(ratios), 0.5, "none", "goals", 1.0),
        row(f"{name}, touched something on the way", touched, 0.5, "none", "goals", 1.0, note),
        row("the longest way, in shortest ones", max(ratios), MOST_RATIO, "1.3", "of 1", 1.0),
        row("a way, median", float(np.median(ratios)), MOST_RATIO, "1.3", "of 1", None),
    ]


def control_steps() -> tuple[list[float], int]:
    """Return the time (s) of each step of control on the way to goals, and how many of these were reached.

    The vehicle does what it is told at once; odometry is right, and scans have the noise of the LDS-01.
    """
    boxes, rng = floors.floor(1), np.random.default_rng(1)
    pose, times, reached, period = np.array(START), list[float](), 0, 0
    navigator = Navigator(Localiser(floors.true_grid(boxes, RESOLUTION), pose), FOOTPRINT)
    for place in floors.places(boxes, GOALS, 1, 0.4):
        navigator.go(Goal(*place.tolist()))
        for _ in range(MOST_PERIODS):
            now = period * PERIOD
            scan = scan_at(boxes, pose, pose, rng, now) if period % SCANNED == 0 else None
            begin = time.process_time()
            twist = navigator.step(Observation(now, pose, scan))
            times.append(time.process_time() - begin)
            pose = compose(pose, arc(np.array(twist), np.array(PERIOD)))
            period += 1
            if navigator.end is not None:
                break
        reached += navigator.reached
    return times, reached


def building() -> Grid:
    """Return the map of a building of floors that are joined: by their corridors in a row, and rows by doors."""
    numbers = iter(range(1, 1 + ALONG * ACROSS))
    rows = [[floors.true_grid(floors.floor(next(numbers)), RESOLUTION) for _ in range(ACROSS)] for _ in range(ALONG)]
    found = np.vstack([np.hstack([one.log_odds for one in each]) for each in rows])
    height, width = len(rows[0][0].log_odds), len(rows[0][0].log_odds.T)
    low, high = (round((y - rows[0][0].origin[1]) / RESOLUTION) for y in CORRIDOR)
    for below in range(0, len(found), height):
        for edge in range(width, ACROSS * width, width):
            found[below + low + DOOR // 4 : below + high - DOOR // 4, edge - DOOR : edge + DOOR] = -MOST
    for edge in range(height, len(found), height):
        beside = found[edge - 3 * DOOR : edge + 3 * DOOR]
        free = np.convolve((beside < 0.0).sum(axis=0), np.ones(DOOR), "valid")
        at = int(np.argmax(free))
        beside[:, at : at + DOOR] = -MOST
    return Grid(RESOLUTION, np.zeros(2), found)


def planned(grid: Grid) -> tuple[float, list[float], Floats]:
    """Return the time (s) of taking a building in, of plans from its one end to the other, and the last way.

    Each has a costmap of its own, with something that stands beside its end; they share the distances to walls,
    as those of a vehicle do, which measures them when it is given its map.
    """
    begin = np.array(START[:2]) + 4.0 * RESOLUTION
    rows, columns = len(grid.log_odds), len(grid.log_odds.T)
    end = begin + np.array([columns * (ACROSS - 1) / ACROSS, rows * (ALONG - 1) / ALONG]) * RESOLUTION
    start = time.process_time()
    distances = Distances(~grid.free)
    taken, times, way = time.process_time() - start, list[float](), np.zeros((2, 2))
    for number in range(PLANS):
        seen = end[None] + np.array([1.0, 0.05 * number])
        start = time.process_time()
        way = Planner(Costmap.of(grid, FOOTPRINT, seen, distances)).way(begin, end)
        times.append(time.process_time() - start)
    return taken, times, way
