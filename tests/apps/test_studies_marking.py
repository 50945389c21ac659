"""Marks for exercises: points for what a scene or a line reaches, and none where something else has changed."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray
from virtualrobot.errors import MalformedFileError, UnknownNameError
from virtualrobot_apps.studies.command import study as command
from virtualrobot_apps.studies.marking import Exercise

Floats = NDArray[np.float64]

LAYOUT = """
schema_version: 1
task: Put the base so that both places are reached.
given: cell.yaml
layout: {robot: arm, targets: [feeder, machine], stays: [post]}
goals:
  reached: {points: 4}
  free: {points: 4, least: 1}
  margin: {points: 2, least: 0.5}
"""


class Rail:
    """World of an arm that slides 0 to 2 m along x from its base, and of nodes that lie on its way.

    A file says where all are: `arm 0.0` and so on, each in a line; who is at 0.9 to 1.1 m touches a post.
    """

    def __init__(self, file: Path) -> None:
        """Read it."""
        lines = (line.split() for line in file.read_text().splitlines() if line and not line.startswith("schema"))
        self.places = {name: float(place) for name, place in lines}
        self.is_closed = False

    def pose(self, node: str) -> Floats:
        if node not in self.places:
            raise UnknownNameError(f"there is no node {node!r}")
        found = np.eye(4)
        found[0, 3] = self.places[node]
        return found

    def joint_limits(self, robot: str) -> Floats:
        return np.array([[0.0, 2.0]])

    def contacts(self, robot: str) -> list[tuple[str, str]]:
        return [("arm", "floor")] if self.places[robot] < -1.0 else []

    def postures(self, robot: str, poses: Floats) -> SimpleNamespace:
        slides = poses[:, 0, 3] - self.places[robot]
        target = np.flatnonzero((slides >= 0.0) & (slides <= 2.0))
        free = np.abs(poses[target, 0, 3] - 1.0) > 0.1
        return SimpleNamespace(target=target, positions=slides[target, None], free=free, touching=())

    def close(self) -> None:
        self.is_closed = True


def laid_out(folder: Path, text: str, exercise: str = LAYOUT) -> list[tuple[str, float]]:
    """Return what is found, and earned, for a scene."""
    (folder / "exercise.yaml").write_text(exercise)
    (folder / "cell.yaml").write_text("arm 0\nfeeder 1.5\nmachine 2.5\npost 1")
    (folder / "mine.yaml").write_text(text)
    opened: list[Rail] = []

    def opening(file: Path) -> Rail:
        opened.append(Rail(file))
        return opened[-1]

    marks = Exercise(folder / "exercise.yaml").marks(folder / "mine.yaml", opening)  # pyright: ignore[reportArgumentType]
    assert all(one.is_closed for one in opened) and len(opened) == 2
    assert [one.points for one in marks] == [4.0, 4.0, 2.0]
    return [(one.found, one.earned) for one in marks]


def test_a_layout_earns_what_it_reaches(tmp_path: Path) -> None:
    """Slides of 1.5 and 2.5 m: one of two. From 1 m on 0.5 and 1.5 m, each half of half the range off the limits."""
    assert laid_out(tmp_path, "arm 0\nfeeder 1.5\nmachine 2.5\npost 1") == [("0.5", 2.0), ("0.5", 0.0), ("none", 0.0)]
    assert laid_out(tmp_path, "arm 1\nfeeder 1.5\nmachine 2.5\npost 1") == [("1", 4.0), ("1", 4.0), ("0.5", 2.0)]
    assert laid_out(tmp_path, "arm 0.6\nfeeder 1.5\nmachine 2.5\npost 1")[2] == ("0.1", 0.0)
    # A base that touches something leaves nothing free.
    assert laid_out(tmp_path, "arm -1.5\nfeeder 1.5\nmachine 2.5\npost 1")[1] == ("0", 0.0)


def test_what_has_to_stay_stays(tmp_path: Path) -> None:
    """Targets always, and what the exercise names."""
    for text, said in (
        ("arm 1\nfeeder 1.5\nmachine 2.5\npost 7", "'post' has moved, and has to stay"),
        ("arm 1\nfeeder 1.4\nmachine 2.5\npost 1", "'feeder' has moved, and has to stay"),
        ("arm 1\nfeeder 1.5\npost 1", "'machine' is not there: there is no node 'machine'"),
    ):
        assert laid_out(tmp_path, text) == [(said, 0.0)] * 3


GIVEN = """
schema_version: 1
stations:
- {name: saw, cycle: 40, price: 10000}
- {name: weld, cycle: {law: lognorm, s: 0.2, scale: 60}, price: 50000}
money: {hours: 2000, running: 40, revenue: 3, years: 5}
"""
LINE = """
schema_version: 1
task: Finish 80 an hour for at most 130,000.
given: given.yaml
line: {hours: 20, runs: 3, stays: [money, saw.cycle, weld.cycle, weld.price, saw.price]}
goals:
  throughput: {points: 6, least: 80}
  investment: {points: 3, most: 130000}
  payback: {points: 1, most: 2}
"""


def marked(folder: Path, line: str) -> dict:
    (folder / "exercise.yaml").write_text(LINE)
    (folder / "given.yaml").write_text(GIVEN)
    (folder / "mine.yaml").write_text(line)
    words = ["mark", str(folder / "exercise.yaml"), str(folder / "mine.yaml")]
    plain = CliRunner().invoke(command, words, catch_exceptions=False).output
    found = json.loads(CliRunner().invoke(command, [*words, "--json"], catch_exceptions=False).output)
    assert plain.endswith(f"{found['earned']:.3g} of {found['points']:g} points\n")
    return found


def test_a_line_earns_what_it_does(tmp_path: Path) -> None:
    """One welder does less than 60 an hour; two with places before them as much as the saw, 90."""
    given = marked(tmp_path, GIVEN)
    assert (given["earned"], given["points"]) == (4.0, 10.0)
    better = marked(tmp_path, GIVEN.replace("scale: 60}", "scale: 60}, machines: 2, buffer: 3"))
    assert [goal["earned"] for goal in better["goals"]] == [6.0, 3.0, 1.0]
    assert float(better["goals"][0]["found"]) == pytest.approx(88.0, abs=3.0)
    assert (better["goals"][1]["found"], better["goals"][1]["wanted"]) == ("110000", "at most 130000")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("cycle: 40", "cycle: 20", "'cycle' of 'saw' has changed, and has to stay"),
        ("scale: 60", "scale: 50", "'cycle' of 'weld' has changed, and has to stay"),
        ("name: weld", "name: glue", "'cycle' of 'weld' has changed, and has to stay"),
        ("price: 50000", "price: 5", "'price' of 'weld' has changed, and has to stay"),
        ("revenue: 3", "revenue: 30", "'money' has changed, and has to stay"),
    ],
)
def test_conditions_of_a_line_stay(tmp_path: Path, old: str, new: str, said: str) -> None:
    found = marked(tmp_path, GIVEN.replace(old, new))
    assert found["earned"] == 0.0 and {goal["found"] for goal in found["goals"]} == {said}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("given: given.yaml", "given: none.yaml", "exercise.yaml:4: given: there is no file"),
        ("throughput:", "throughputs:", "there is no goal 'throughputs'; these are throughput"),
        ("{points: 6, least: 80}", "{points: 6}", "'least' or 'most' belongs here"),
        ("{points: 6, least: 80}", "{least: 80}", "the field 'points' is missing"),
        ("saw.cycle", "saw.cycles", "source, money or STATION.FIELD belongs here"),
        ("line: {", "layout: {robot: a, targets: [b]}\nline: {", "either 'layout' or 'line' belongs here"),
        ("runs: 3", "runs: 0", "a number of at least 1 belongs here"),
    ],
)
def test_exercises_that_are_none_are_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    (tmp_path / "given.yaml").write_text(GIVEN)
    (tmp_path / "exercise.yaml").write_text(LINE.replace(old, new))
    with pytest.raises(MalformedFileError, match=re.escape(said)):
        Exercise(tmp_path / "exercise.yaml").marks(tmp_path / "given.yaml")
