"""Heat maps and fronts of reports: each field of a grid, and fronts by comparing each point with each other one."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import MalformedFileError
from virtualrobot_apps.studies.charts import color, colors, is_on_front
from virtualrobot_apps.studies.report import report

from tests.apps.studies import done, written

GRID = """
schema_version: 1
function: cells:f
parameters:
  z: {list: [1, 2]}
  y: {grid: {from: 0, to: 2, count: 3}}
  x: {list: [0, 1, 2, 5]}
  kind: {list: [<a>]}
results: {sum: number}
"""
SUM = """
def f(cell):
    x, y, z = (cell.parameters[name] for name in "xyz")
    return {"sum": None if x == y == 2 else x + 10.0 * y + 100.0 * z}
"""


def test_a_grid_has_a_map_for_each_combination_of_what_is_neither_across_nor_up(tmp_path: Path) -> None:
    study = written(tmp_path / "in", GRID, SUM)
    text = report(study, done(study, tmp_path / "out")[1])
    captions = re.findall(r"<figcaption>(.*?)</figcaption>(.*?)</figure>", text)
    assert [head for head, _ in captions] == ["z 1", "z 2"]
    for z, (_, chart) in enumerate(captions, 1):
        said = re.findall(r'<rect x="([\d.]+)" y="([\d.]+)"[^>]*style="fill:(#\w+)"><title>(.*?)</title>', chart)
        assert len(said) == 12
        expected = [
            f"x {x}, y {y}: " + ("none" if x == y == 2 else f"{x + 10 * y + 100 * z}")
            for y in range(3)
            for x in (0, 1, 2, 5)
        ]
        assert [one[3] for one in said] == expected
        # The first row is at the bottom, the first column at the left.
        assert float(said[0][1]) > float(said[4][1]) and float(said[0][0]) < float(said[1][0])
        assert said[10][2] == "#dddddd"
    # One scale for both: the least of the first map and the greatest of the second have its ends.
    assert "fill:#440154" in captions[0][1] and 'fill:#fde725"><title>x 5, y 2: 225' in captions[1][1]


def test_what_is_drawn_counts_by_its_mean(tmp_path: Path) -> None:
    text = GRID.replace("  kind: {list: [<a>]}\n", "").replace("schema_version: 1", "schema_version: 1\ndraws: 2")
    function = "def f(cell):\n    return {'sum': cell.parameters['x'] + cell.number % 2}\n"
    study = written(tmp_path / "in", text, function)
    found = report(study, done(study, tmp_path / "out")[1])
    assert "<title>x 5, y 0: 5.5</title>" in found


def test_what_is_the_same_in_all_cells_is_told_once(tmp_path: Path) -> None:
    study = written(tmp_path / "in", GRID, SUM)
    text = report(study, done(study, tmp_path / "out")[1])
    assert text.count("&lt;a&gt;") == 1 and "<td>kind</td><td>&lt;a&gt;</td>" in text
    # Without draws, each cell is a row of one table, which opens when it is clicked: it is long.
    cells = text[text.index("<h2>Cells") :]
    assert "<details><summary>24 rows</summary>" in cells
    assert re.findall("<th>(.*?)</th>", cells) == ["cell", "z", "y", "x", "sum"]
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall("<tr>(<td.*?)</tr>", cells)]
    assert rows[6] == ["6", "1", "1", "2", "112"] and rows[10] == ["10", "1", "2", "2", ""] and len(rows) == 24


def test_one_parameter_has_a_curve(tmp_path: Path) -> None:
    text = GRID.replace("{from: 0, to: 2, count: 3}", "{from: 0, to: 2, count: 4}").replace("[1, 2]", "[7]")
    text = text.replace("{list: [0, 1, 2, 5]}", "{list: [0]}")
    function = "def f(cell):\n    return {'sum': None if cell.number == 2 else cell.number}\n"
    study = written(tmp_path / "in", text, function)
    found = report(study, done(study, tmp_path / "out")[1])
    assert re.findall(r"<circle[^>]*><title>(.*?)</title>", found) == ["y 0: 0", "y 0.66667: 1", "y 2: 3"]
    (way,) = re.findall('<polyline points="(.*?)"', found)
    (left, low), _, (right, high) = ([float(one) for one in at.split(",")] for at in way.split())
    assert left < right and low > high


def test_colours_are_those_of_viridis() -> None:
    """Its first, middle and last entries: Matplotlib's `_cm_listed.py`."""
    assert [color(value, (2.0, 4.0)) for value in (2.0, 3.0, 4.0)] == ["#440154", "#21918c", "#fde725"]
    assert color(9.0, (2.0, 4.0)) == "#fde725" and color(float("nan"), (2.0, 4.0)) == "#dddddd"
    assert color(1.0, (1.0, 1.0)) == "#21918c"
    assert colors([3.0, 2.0, 4.0]).tolist() == [[0x21, 0x91, 0x8C], [0x44, 0x01, 0x54], [0xFD, 0xE7, 0x25]]


@pytest.mark.parametrize("goals", [2, 3])
def test_fronts_are_those_of_comparing_all(rng: np.random.Generator, goals: int) -> None:
    """Whole numbers, so that some are equal."""
    costs = rng.integers(0, 12, (200, goals)).astype(float)
    expected = [not any((other <= one).all() and (other < one).any() for other in costs) for one in costs]
    assert is_on_front(costs).tolist() == expected
    assert is_on_front(np.empty((0, goals))).tolist() == []


def test_cells_of_a_search_are_points_in_their_colours(tmp_path: Path) -> None:
    text = (
        "schema_version: 1\nfunction: cells:f\nsearch: {minimize: cost, population: 4, generations: 3}\n"
        "parameters: {x: {range: [0, 1]}, y: {range: [0, 1]}}\nresults: {cost: number}\n"
    )
    function = "def f(cell):\n    x = cell.parameters['x']\n    return {'cost': None if cell.number == 5 else x}\n"
    study = written(tmp_path / "in", text, function)
    _, parts = done(study, tmp_path / "out")
    found = re.findall(r'cx="([\d.]+)"[^>]*fill:(#\w+)"><title>cell (\d+), y ([-\d.e]+), x', report(study, parts))
    rows = {row["cell"]: row for row in parts.table().to_pylist()}
    assert [int(one[2]) for one in found] == [number for number in range(12) if number != 5]
    costs = [row["cost"] for row in rows.values() if row["cost"] is not None]
    for _, fill, number, y in found:
        assert fill == color(rows[int(number)]["cost"], (min(costs), max(costs)))
        assert float(y) == pytest.approx(rows[int(number)]["y"], rel=1e-4)


SCHAFFER = """
schema_version: 1
function: cells:f
parameters: {x: {grid: {from: -2, to: 4, count: 61}}}
results: {near: number, far: number, odd: text}
goals: {near: minimize, far: minimize}
"""


def test_the_front_of_a_known_function_is_found(tmp_path: Path) -> None:
    """x^2 and (x - 2)^2: 0 <= x <= 2.

    David Schaffer, "Multiple objective optimization with vector evaluated genetic algorithms", 1985.
    """
    function = (
        "def f(cell):\n    x = round(cell.parameters['x'], 9)\n"
        "    if x == 1:\n        raise ValueError('not here')\n"
        "    return {'near': x**2, 'far': (x - 2)**2, 'odd': None}\n"
    )
    study = written(tmp_path / "in", SCHAFFER, function)
    _, parts = done(study, tmp_path / "out")
    text = report(study, parts)
    table = text[text.index("<h2>Goals") : text.index("<h2>near")]
    assert "<p>20 that no other one is better than in all of them:" in table
    assert "<th>near (less is better)</th>" in table
    rows = re.findall(r"<tr><td[^>]*>(\d+)</td><td[^>]*>([-\d.e]+)</td>", table)
    assert [float(x) for _, x in rows] == pytest.approx([0.1 * one for one in range(21) if one != 10], abs=1e-9)
    circles = re.findall(r'r="(\d)" style="fill:(#\w+)"><title>cell \d+, x ([-\d.e]+)</title>', table)
    assert len(circles) == 60
    assert all((radius == "5") is (-1e-9 <= float(x) <= 2.0 + 1e-9) for radius, _, x in circles)
    # The other way round the ends are best, as far as the grid goes.
    study = written(tmp_path / "in", SCHAFFER.replace("minimize", "maximize"), function)
    again = report(study, parts)
    assert "<p>2 that no other one is better than" in again and "near (more is better)" in again


@pytest.mark.parametrize(
    ("goals", "said"),
    [
        ("{near: minimize}", "two goals or more belong here"),
        ("{near: minimize, odd: minimize}", "'odd' is no result that is a number; these are near, far"),
        ("{near: minimize, nearer: minimize}", "'nearer' is no result that is a number"),
        ("{near: minimize, far: least}", "'least' is not known; it is one of minimize, maximize"),
    ],
)
def test_goals_that_are_none_are_refused(tmp_path: Path, goals: str, said: str) -> None:
    with pytest.raises(MalformedFileError, match=said):
        written(tmp_path / "in", SCHAFFER.replace("{near: minimize, far: minimize}", goals))
