"""`virtualrobot demo maze`: a Boe-Bot passes mazes by the right-hand rule, from square to square.

The program knows its three sonars and the counts of its wheels. Whether it has passed, and where it has been, is judged
by its true place.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.chart import plan
from virtualrobot_apps.vehicles.boebot.cockpit import RADIUS, TRACK, Cockpit
from virtualrobot_apps.vehicles.boebot.maze import Maze, Square, generated, right_hand
from virtualrobot_apps.vehicles.boebot.wall_follower import (
    NEAR,
    SPEED,
    TURNING,
    Distances,
    Steering,
    remaining_of,
    turn_of,
)
from virtualrobot_apps.vehicles.boebot.worlds import WALL, center_of, maze_world

SONARS = ("sonar_left", "sonar_front", "sonar_right")
ENCODERS = "encoders"
SENSORS = (*SONARS, ENCODERS)
PERIOD = 0.1
"""Time between two commands along a passage (s)."""
RIGHT_ANGLE = 0.5 * math.pi / TURNING
"""Time for a right angle (s): 5.236 s, 1309 ticks of 4 ms."""
REST = 0.3
"""Time in which it comes to rest (s)."""
BRAKE_WAY = 0.018
"""Way (m) on which it comes to rest from SPEED: v^2 / 2a, with 20 rad/s^2 of its wheels, and some for the jerk."""
SECONDS_A_SQUARE = 20.0
"""Simulation time for each square of the rule's way after which a run is given up; it takes a quarter of it."""


@dataclass(frozen=True, eq=False)
class Run:
    """A run through a maze.

    passed: it came to the exit. reason: why it did not, else empty. seconds: simulation time (s). ticks: as many ticks.
    squares: true squares, one after the other. turned: (n,) how far it truly turned at each turn (rad). places: (m, 2)
    its true way (m).
    """

    maze: Maze
    passed: bool
    reason: str
    seconds: float
    ticks: int
    squares: list[Square]
    turned: NDArray[np.float64]
    places: NDArray[np.float64]


class Driver:
    """Drives by the rule; it keeps where it is in its square by sonars and wheels."""

    def __init__(self, cockpit: Cockpit, maze: Maze) -> None:
        """Begin in the middle of the first square, with SENSORS read."""
        self._cockpit, self._maze = cockpit, maze
        self._steering = Steering()
        self._wheels = cockpit.wheels()
        self._remaining = 0.0
        self.squares: list[Square] = [self._square()]
        self.turned: list[float] = []
        self.places: list[tuple[float, float]] = [cockpit.pose[:2]]

    def run(self, longest: float) -> str:
        """Drive until the exit or for `longest` (s); return why it ended before the exit, else nothing."""
        distances = self._sense()
        while self.squares[-1] != self._maze.exit:
            if self._cockpit.now > longest:
                return f"not there after {longest:.0f} s"
            if turn := turn_of(distances):
                distances = self._turn(turn)
            if turn < 1:
                distances = self._advance(distances)
        return ""

    def _advance(self, distances: Distances) -> Distances:
        """Go on to the middle of the next square, so that it would rest there; return what the sonars say then."""
        self._remaining += WALL
        while self._remaining > BRAKE_WAY:
            seconds = min(PERIOD, (self._remaining - BRAKE_WAY) / SPEED)
            self._drive(SPEED, self._steering.rate(), seconds, SENSORS)
            way = self._roll()
            distances = self._sense()
            self._steering.seen(way, distances)
            ahead = remaining_of(distances.front)
            if ahead is not None and abs(ahead - self._remaining) < 0.25 * WALL:
                self._remaining = 0.5 * (self._remaining + ahead)
        return distances

    def _turn(self, quarter: int) -> Distances:
        """Come to rest, turn by a right angle, to the left (1) or to the right (-1); return what the sonars say."""
        self._drive(0.0, 0.0, REST, (ENCODERS,))
        self._roll()
        before = self._cockpit.pose[2]
        self._drive(0.0, quarter * TURNING, RIGHT_ANGLE)
        self._drive(0.0, 0.0, REST, SENSORS)
        self.turned.append(math.remainder(self._cockpit.pose[2] - before, 2.0 * math.pi))
        # The wheels' counts are too coarse to say how exact the turn was; the sonars will tell along the passage.
        self._wheels = self._cockpit.wheels()
        self._remaining = -self._steering.turned(quarter, -self._remaining)
        return self._sense()

    def _drive(self, speed: float, turning: float, seconds: float, sensors: Sequence[str] = ()) -> None:
        self._cockpit.drive(speed, turning, self._cockpit.ticks_of(seconds), sensors)
        self.places.append(self._cockpit.pose[:2])
        square = self._square()
        if square != self.squares[-1]:
            self.squares.append(square)

    def _roll(self) -> float:
        """Count how far the wheels have rolled; return the way of the middle (m)."""
        now = self._cockpit.wheels()
        left, right = RADIUS * (now - self._wheels)
        self._wheels = now
        way = 0.5 * float(left + right)
        self._remaining -= way
        self._steering.rolled(way, float(right - left) / TRACK)
        return way

    def _sense(self) -> Distances:
        return Distances(*map(self._cockpit.distance, SONARS))

    def _square(self) -> Square:
        """Return the square in which the robot truly is."""
        x, y, _ = self._cockpit.pose
        return math.floor(y / WALL), math.floor(x / WALL)


def main(
    client: Client, size: int, seed: int, mazes: int, plot: Path | None = None, pace: float = 0.0, seeds: int = 1
) -> list[Run]:
    """Pass mazes of sizes each a cell larger than the one before, print tables, and return the runs.

    Of each size it passes as many mazes as there are `seeds`, from `seed` on; with several runs, a table counts them.
    """
    runs: list[Run] = []
    print(f"{'maze':>8} {'seed':>5} {'squares':>8} {'turns':>6} {'time':>9} {'ticks':>8}  result", flush=True)
    for number, drawn in product(range(mazes), range(seed, seed + seeds)):
        maze = generated(size + number, drawn)
        run = passed(client, maze, pace)
        runs.append(run)
        print(
            f"{f'{maze.size} x {maze.size}':>8} {drawn:>5} {len(run.squares) - 1:>8} {len(run.turned):>6} "
            f"{run.seconds:>7.1f} s {run.ticks:>8}  {'passed' if run.passed else run.reason}",
            flush=True,
        )
    print(f"passed {sum(run.passed for run in runs)} of {len(runs)}")
    if len(runs) > 1:
        print("\n".join(["", *size_rows(runs)]))
    print()
    for row in document_rows(runs, client.clock.read().tick_length):
        print(row)
    if plot is not None:
        plot.write_text(picture(runs[-1]), "utf-8")
        print(f"picture in {plot}", flush=True)
    return runs


def size_rows(runs: Sequence[Run]) -> list[str]:
    """Return the lines of a table: of each size, how many mazes it passed, in which part of all, and its ways.

    A way is told in squares, beside the shortest one to the exit, of those that passed; time is simulation time.
    """
    rows = [
        f"{'maze':>8} {'passed':>10} {'rate':>5} {'squares':>11} {'way / shortest':>15} {'turns':>9} {'time':>18} "
        f"{'a square':>9}"
    ]
    for size in sorted({run.maze.size for run in runs}):
        ours = [run for run in runs if run.maze.size == size]
        there = [run for run in ours if run.passed]
        squares = [len(run.squares) - 1 for run in there]
        detours = [count / run.maze.shortest() for count, run in zip(squares, there, strict=True)]
        turns, times = [len(run.turned) for run in there], [run.seconds for run in there]
        cells = [
            f"{f'{size} x {size}':>8}",
            f"{f'{len(there)} of {len(ours)}':>10}",
            f"{f'{100.0 * len(there) / len(ours):.0f}%':>5}",
            f"{_range(squares, 'd'):>11}",
            f"{_range(detours, '.2f'):>15}",
            f"{_range(turns, 'd'):>9}",
            f"{_range(times, '.1f') + ' s' if there else '':>18}",
            f"{f'{sum(times) / sum(squares):.2f} s' if there else '':>9}",
        ]
        rows.append(" ".join(cells))
    return rows


def _range(values: Sequence[float], form: str) -> str:
    """Return the least and the greatest of some values; empty where there are none."""
    return f"{min(values):{form}} to {max(values):{form}}" if values else ""


def document_rows(runs: Sequence[Run], tick_length: float) -> list[str]:
    """Return the lines of a table: what the document says beside what is here."""
    ticks = round(RIGHT_ANGLE / tick_length)
    turned = np.degrees(np.abs(np.concatenate([run.turned for run in runs])))
    rows = [
        ("", "document", "here"),
        ("walls, high and thick", "0.5 m", f"{WALL:g} m"),
        ("a wall is nearer than", "0.25 cms", f"{NEAR:g} m"),
        ("turning", "0.3 rad/s", f"{TURNING:g} rad/s"),
        ("a right angle", "not told", f"{ticks} ticks, {RIGHT_ANGLE:.3f} s"),
    ]
    if len(turned):
        rows.append(("truly turned", "not told", f"{turned.min():.2f} to {turned.max():.2f} °"))
    return [f"{name:32} {document:>12} {here:>22}" for name, document, here in rows]


def passed(client: Client, maze: Maze, pace: float = 0.0) -> Run:
    """Replace the world by a maze and let the robot pass it; the clock is stepped, and stands afterwards."""
    build(client, maze)
    return drive(client, maze, pace)


def build(client: Client, maze: Maze) -> None:
    """Replace the world by a maze with the robot in its first square, and look at it from above."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "maze.yaml")
        file.write_text(maze_world(maze), "utf-8")
        client.scene.load_scene(file)
    middle = 0.5 * WALL * len(maze.walls)
    client.view.set_camera(position=(middle, -0.9 * middle, 2.6 * middle + 1.0), target=(middle, 0.9 * middle, 0.0))


def drive(client: Client, maze: Maze, pace: float = 0.0) -> Run:
    """Let the robot pass the maze around it; raises what a rule on the map raises where it goes round for ever."""
    longest = SECONDS_A_SQUARE * len(right_hand(maze))
    with Cockpit(client, pace, SENSORS) as cockpit:
        driver = Driver(cockpit, maze)
        try:
            reason = driver.run(longest)
        except WrongStateError as error:  # it was stopped, such as before a wall
            reason = str(error)
        return Run(
            maze,
            not reason,
            reason,
            cockpit.now,
            cockpit.ticks,
            driver.squares,
            np.array(driver.turned),
            np.array(driver.places),
        )


def picture(run: Run) -> str:
    """Return an SVG of the maze from above, the true way in it, and the middles of the squares that the rule passes."""
    ways = {"way": run.places, "rule": np.array([center_of(square) for square in right_hand(run.maze)])}
    walls = [
        WALL * np.array([(left, bottom), (right, bottom), (right, top), (left, top)], dtype=np.float64)
        for bottom, top, left, right in run.maze.blocks()
    ]
    return plan(ways, areas=walls)
