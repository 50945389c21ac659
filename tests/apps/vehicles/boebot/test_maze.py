"""Mazes by seed, the right-hand rule on their maps, and a Boe-Bot that passes them by its sonars."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot_apps.vehicles.boebot import maze_run
from virtualrobot_apps.vehicles.boebot.cockpit import Cockpit
from virtualrobot_apps.vehicles.boebot.maze import Maze, generated, right_hand
from virtualrobot_apps.vehicles.boebot.wall_follower import Distances, Steering, remaining_of, turn_of
from virtualrobot_apps.vehicles.boebot.worlds import ROBOT, WALL, maze_world

from tests.kernels import KernelProcess


@pytest.mark.parametrize("size", [2, 3, 5, 9])
def test_a_maze_has_one_way_between_any_two_cells(size: int, seed: int) -> None:
    """A tree: cells less one passages, all cells reached; the exit is the only gap in the outer wall."""
    maze = generated(size, seed % 1000)
    inside = ~maze.walls[1:-1, 1:-1]
    assert inside.sum() == 2 * size**2 - 1
    border = np.concatenate([maze.walls[0], maze.walls[-1], maze.walls[1:-1, 0], maze.walls[1:-1, -1]])
    assert (~border).sum() == 1
    reached, waiting = {maze.start}, [maze.start]
    while waiting:
        row, column = waiting.pop()
        for beside in ((row, column + 1), (row + 1, column), (row, column - 1), (row - 1, column)):
            if not maze.walls[beside] and beside not in reached and max(beside) < 2 * size:
                reached.add(beside)
                waiting.append(beside)
    assert len(reached) == inside.sum()
    assert (generated(size, seed % 1000).walls == maze.walls).all()


@pytest.mark.parametrize("loops", [0, 3])
def test_the_rule_finds_the_exit_of_each(loops: int, seed: int) -> None:
    for number in range(20):
        maze = generated(3 + number % 6, seed % 1000 + number, loops)
        path = right_hand(maze)
        assert path[-1] == maze.exit
        assert len(path) - 1 >= maze.shortest()
        steps = np.abs(np.diff(np.array(path), axis=0)).sum(axis=1)
        assert (steps == 1).all()
        assert not maze.walls[tuple(np.array(path).T)].any()


def test_walls_are_covered_once(seed: int) -> None:
    for size in (2, 4, 7):
        maze = generated(size, seed % 1000)
        covered = np.zeros(maze.walls.shape, dtype=int)
        for bottom, top, left, right in maze.blocks():
            covered[bottom:top, left:right] += 1
        assert (covered == maze.walls).all()


def test_what_is_no_maze_is_refused() -> None:
    with pytest.raises(ValueError, match="a maze has 2 to 50 cells along a side, not 1"):
        generated(1)
    with pytest.raises(ValueError, match="a maze of 3 x 3 cells has 0 to 4 loops, not 5"):
        generated(3, loops=5)
    closed = generated(3)
    walls = closed.walls.copy()
    walls[closed.exit] = True
    shut = Maze(walls, closed.start, closed.exit, 0)
    with pytest.raises(ValueError, match="goes round in this maze"):
        right_hand(shut)
    with pytest.raises(ValueError, match="no way to its exit"):
        shut.shortest()


def test_the_rule_is_that_of_the_document() -> None:
    """Table 5.1: no wall at right: turn right; else no wall at straight: keep straight; else turn left."""
    far, near = 0.7, 0.2
    assert turn_of(Distances(near, near, far)) == turn_of(Distances(far, far, math.inf)) == -1
    assert turn_of(Distances(near, far, near)) == turn_of(Distances(far, math.inf, near)) == 0
    assert turn_of(Distances(far, near, near)) == turn_of(Distances(near, near, near)) == 1
    assert remaining_of(0.31) == pytest.approx(0.1)
    assert remaining_of(0.7) is None


def test_steering_keeps_the_middle_of_a_passage_though_a_wheel_is_larger(rng: np.random.Generator) -> None:
    """A right wheel 0.5% larger turns it by 43 mrad a metre; sonars tell with a deviation of 2 mm, in steps of 3 mm."""
    steering, off, heading, rate, offs = Steering(), 0.02, 0.05, 0.0, []
    for _ in range(600):
        way, turn = 0.015, 0.1 * rate
        heading += turn + way * 0.005 / 0.116
        off += way * math.sin(heading)
        told = np.round((np.array([0.21 - off, 0.21 + off]) + rng.normal(0.0, 0.002, 2)) / 0.003) * 0.003
        steering.rolled(way, turn)
        steering.seen(way, Distances(float(told[0]), math.inf, float(told[1])))
        rate = steering.rate()
        offs.append(off)
    assert np.abs(offs).max() < 0.06
    assert np.abs(offs[200:]).max() < 0.02


def test_what_was_ahead_is_beside_after_a_turn() -> None:
    steering = Steering()
    steering.off = 0.01
    assert steering.turned(1, 0.02) == pytest.approx(0.01)
    assert steering.off == pytest.approx(-0.02)
    assert steering.turned(-1, 0.01) == pytest.approx(0.02)
    assert steering.off == pytest.approx(0.01)


@pytest.mark.long
def test_a_right_angle_takes_1309_ticks(steps: virtualrobot.Client) -> None:
    """90 degrees at 0.3 rad/s are 5.236 s, 1309 ticks of 4 ms; what it lacks at the beginning it has at the end."""
    maze_run.build(steps, generated(2))
    with Cockpit(steps) as cockpit:
        assert cockpit.ticks_of(maze_run.RIGHT_ANGLE) == 1309
        cockpit.drive(0.0, maze_run.TURNING, 1309)
        cockpit.drive(0.0, 0.0, cockpit.ticks_of(maze_run.REST))
        assert cockpit.pose[2] == pytest.approx(math.pi / 2.0, abs=1e-4)


@pytest.mark.long
def test_a_maze_is_passed_as_the_map_says(steps: virtualrobot.Client) -> None:
    maze = generated(2, 1)
    run = maze_run.passed(steps, maze)
    assert run.passed, run.reason
    assert run.squares == right_hand(maze)
    assert np.abs(run.turned) == pytest.approx(math.pi / 2.0, abs=1e-3)


@pytest.mark.long
def test_the_bundled_scene_is_what_its_maze_makes(steps: virtualrobot.Client) -> None:
    file = Path(maze_run.__file__).parent / "maze.yaml"
    assert file.read_text("utf-8") == maze_world(generated(4, seed=1))
    assert {"walls", ROBOT} <= set(steps.scene.load_scene(file))
    walls = steps.scene.node("walls").figures
    heights = {figure._message.box.size.z for figure in walls}
    assert heights == {WALL}


@pytest.mark.long
def test_a_larger_maze_is_passed_with_a_wheel_that_is_larger_than_it_knows(
    steps: virtualrobot.Client, seed: int
) -> None:
    maze = generated(5, seed % 100, 4)
    maze_run.build(steps, maze)
    settings = {"track_meters": 0.116, "wheel_radius_meters": 0.0325, "right_wheel_radius_meters": 1.005 * 0.0325}
    steps.scene.set_craft(ROBOT, "differential", settings)
    run = maze_run.drive(steps, maze)
    assert run.passed, run.reason
    assert run.squares == right_hand(maze)


@pytest.mark.long
def test_the_demo_counts_what_was_passed(stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    plot = tmp_path / "maze.svg"
    arguments = ["demo", "maze", "--size", "2", "--mazes", "2", "--address", stepped_kernel.address, "--headless"]
    result = CliRunner().invoke(cli, [*arguments, "--plot", str(plot)])
    assert result.exit_code == 0, result.output
    assert "passed 2 of 2" in result.output
    assert "1309 ticks, 5.236 s" in result.output
    assert "<polygon" in plot.read_text("utf-8")


def test_a_maze_that_is_too_large_is_refused() -> None:
    result = CliRunner().invoke(cli, ["demo", "maze", "--size", "50", "--mazes", "2"])
    assert result.exit_code == 2
    assert "the largest maze has 50 cells along a side" in result.output


def test_a_study_counts_the_mazes_of_each_size() -> None:
    """Of each size those that were passed; squares, turns and times are of these, and a way's against the shortest.

    From (1, 1) to the exit above the upper right cell it is as far as the map says: 5 squares of the smallest mazes.
    """
    small = [generated(2, seed) for seed in (1, 2, 3)]
    least = [maze.shortest() for maze in small]
    assert least[0] == 5

    def run(maze: Maze, passed: bool, seconds: float, squares: int, turns: int) -> maze_run.Run:
        way = [(1, 1)] * (squares + 1)
        return maze_run.Run(maze, passed, "", seconds, 0, way, np.zeros(turns), np.zeros((1, 2)))

    rows = maze_run.size_rows(
        [
            run(small[0], True, 20.0, least[0], 1),
            run(small[1], True, 40.0, 2 * least[1], 3),
            run(small[2], False, 99.0, 7, 9),
            run(generated(3, 1), False, 9.0, 4, 2),
        ]
    )
    most, each = 2 * least[1], 60.0 / (least[0] + 2 * least[1])
    cells = f"2 x 2 2 of 3 67% 5 to {most} 1.00 to 2.00 1 to 3 20.0 to 40.0 s {each:.2f} s"
    assert [row.split() for row in rows[1:]] == [cells.split(), "3 x 3 0 of 1 0%".split()]


@pytest.mark.long
def test_two_mazes_of_a_size_are_passed(stepped_kernel: KernelProcess) -> None:
    arguments = ["demo", "maze", "--size", "2", "--seeds", "2", "--address", stepped_kernel.address, "--headless"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    assert "passed 2 of 2" in result.output
    assert "2 x 2     2 of 2  100%" in result.output
