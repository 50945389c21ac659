"""Searches and sensitivities of studies: known optima and shares, and the same when they are resumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.studies import summary
from virtualrobot_apps.studies.engines import Here
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.report import report
from virtualrobot_apps.studies.running import open_job, run

from tests.apps.studies import done, written

pytestmark = pytest.mark.long

STUDY = """
schema_version: 1
function: cells:f
seed: 5
block: 4
parameters: {x: {range: [-2, 2]}, y: {range: [0, 10]}}
results: {cost: number}
search: {minimize: cost, population: 8, generations: 40}
"""
VALLEY = """
def f(cell):
    x, y = cell.parameters["x"], cell.parameters["y"]
    if y > 9.0:
        raise ValueError("out of reach")
    return {"cost": SIGN * ((x - 0.7) ** 2 + 4.0 * (y - 3.0) ** 2 + (x - 0.7) * (y - 3.0))}
"""
"""A tilted quadratic valley: least, 0, at (0.7, 3)."""


@pytest.mark.parametrize(("goal", "sign"), [("minimize", "1.0"), ("maximize", "-1.0")])
def test_a_search_finds_the_lowest_place_of_a_valley(tmp_path: Path, goal: str, sign: str) -> None:
    study = written(tmp_path / "in", STUDY.replace("minimize", goal), VALLEY.replace("SIGN", sign))
    progress, parts = done(study, tmp_path / "out")
    assert (progress.cells, progress.done) == (320, 320)
    rows = [row for row in parts.table().to_pylist() if row["status"] == "ok"]
    best = min(rows, key=lambda row: abs(row["cost"]))
    assert (best["x"], best["y"]) == pytest.approx((0.7, 3.0), abs=1e-3)
    text = report(study, parts)
    first = text[text.index("Best cells") :].partition("</tr><tr>")[2]
    assert first.startswith(f'<td class="number">{best["cell"]}</td>')
    assert "95% interval</th>" in text and " to " not in text[text.index("<h2>cost") :].partition("<svg")[0]


def test_a_search_that_is_resumed_comes_to_the_same(tmp_path: Path) -> None:
    """Cancelled in the middle of a generation, in other blocks, and with what functions draw by NumPy left as it is."""
    function = VALLEY.replace("SIGN", "1.0")
    study = written(tmp_path / "in", STUDY, function)
    np.random.seed(1)
    _, whole = done(study, tmp_path / "whole")
    assert np.random.random() == np.random.RandomState(1).random()
    folder = tmp_path / "cancelled"
    run(open_job(study, folder, False), Here(), lambda told: (folder / "cancel").touch() if told.done >= 100 else None)
    assert Parts(folder, study).counts().done == 100
    others = written(tmp_path / "in", STUDY.replace("block: 4", "block: 3"), function)
    assert done(others, folder, resume=True)[1].digest() == whole.digest()
    other = written(tmp_path / "in", STUDY.replace("seed: 5", "seed: 6"), function)
    assert done(other, tmp_path / "other")[1].digest() != whole.digest()
    longer = written(tmp_path / "in", STUDY.replace("generations: 40", "generations: 41"), function)
    with pytest.raises(WrongStateError, match="draws was 320 and is 328"):
        open_job(longer, folder, True)


def test_a_search_that_has_converged_begins_elsewhere(tmp_path: Path) -> None:
    """Of a flat cost all places are the same: CMA-ES gives that up, again and again, and does all generations."""
    study = written(tmp_path / "in", STUDY, "def f(cell):\n    return {'cost': 1.0}\n")
    progress, parts = done(study, tmp_path / "out")
    assert progress.done == 320
    assert len({row["x"] for row in parts.table().to_pylist()}) == 320


GOALS = """
schema_version: 1
function: cells:f
seed: 5
block: 7
parameters: {x: {range: [-10, 10]}, kind: {list: [dear, cheap, broken]}, y: {list: [0, 1]}}
results: {near: number, far: number}
goals: {near: minimize, far: maximize}
search: {population: 20, generations: 20}
"""
SCHAFFER = """
def f(cell):
    x, kind, y = (cell.parameters[name] for name in ("x", "kind", "y"))
    if kind == "broken":
        raise ValueError("it is broken")
    more = (5.0 if kind == "dear" else 0.0) + y
    return {"near": x**2 + more, "far": -(x - 2.0) ** 2 - more}
"""
"""x^2 and (x - 2)^2, both to be little: 0 <= x <= 2; David Schaffer, "Multiple objective optimization", 1985."""


def test_a_search_for_several_goals_finds_their_front(tmp_path: Path) -> None:
    """Among choices, of which one is better in all goals, and another one always fails."""
    study = written(tmp_path / "in", GOALS, SCHAFFER)
    progress, parts = done(study, tmp_path / "out")
    assert progress.done == 400 and progress.failed > 0
    rows = [row for row in parts.table().to_pylist() if row["status"] == "ok"]
    front = [row for row in rows if not any(one["near"] < row["near"] and one["far"] > row["far"] for one in rows)]
    assert {(row["kind"], row["y"]) for row in front} == {("cheap", 0.0)}
    places = sorted(row["x"] for row in front)
    assert -0.1 < places[0] < 0.3 and 1.7 < places[-1] < 2.1
    assert len(set(places)) >= 15 and max(np.diff(places)) < 0.5
    text = report(study, parts)
    assert f"<p>{len(front)} that no other one is better than" in text and "Best cells" not in text


def test_a_search_for_several_goals_that_is_resumed_comes_to_the_same(tmp_path: Path) -> None:
    study = written(tmp_path / "in", GOALS.replace("generations: 20", "generations: 5"), SCHAFFER)
    _, whole = done(study, tmp_path / "whole")
    folder = tmp_path / "cancelled"
    run(open_job(study, folder, False), Here(), lambda told: (folder / "cancel").touch() if told.done >= 48 else None)
    assert 0 < Parts(folder, study).counts().done < 100
    assert done(study, folder, resume=True)[1].digest() == whole.digest()


def test_a_search_chooses_among_values_for_one_goal(tmp_path: Path) -> None:
    text = STUDY.replace("y: {range: [0, 10]}", "y: {list: [1, 2, 3, 4, 9.5]}").replace(
        "population: 8", "population: 16"
    )
    study = written(tmp_path / "in", text, VALLEY.replace("SIGN", "1.0"))
    _, parts = done(study, tmp_path / "out")
    rows = [row for row in parts.table().to_pylist() if row["status"] == "ok"]
    best = min(rows, key=lambda row: row["cost"])
    assert best["y"] == 3.0 and best["x"] == pytest.approx(0.7, abs=0.1)


def test_shares_of_a_known_function_are_found(tmp_path: Path) -> None:
    """Ishigami and Homma, "An importance quantification technique in uncertainty analysis for computer models", 1990.

    f = sin x + 7 sin^2 y + 0.1 z^4 sin x over (-pi, pi): D = a^2/8 + b pi^4/5 + b^2 pi^8/18 + 1/2 with a = 7, b = 0.1.
    """
    ishigami = """
from math import sin
def f(cell):
    x, y, z = (cell.parameters[name] for name in "xyz")
    return {"cost": sin(x) + 7.0 * sin(y) ** 2 + 0.1 * z**4 * sin(x)}
"""
    sides = ", ".join(f"{name}: {{range: [-3.141592653589793, 3.141592653589793]}}" for name in "xyz")
    text = f"schema_version: 1\nfunction: cells:f\nresults: {{cost: number}}\nparameters: {{{sides}}}\n"
    study = written(tmp_path / "in", f"{text}sampling: sensitivity\ndraws: 4096\nblock: 4096\n", ishigami)
    progress, parts = done(study, tmp_path / "out")
    assert progress.done == 5 * 4096
    found = summary.sensitivities(study, summary.numbers(study, parts.table())["cost"])
    a, b = 7.0, 0.1
    whole = a**2 / 8.0 + b * np.pi**4 / 5.0 + b**2 * np.pi**8 / 18.0 + 0.5
    x, y, xz = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2, a**2 / 8.0, b**2 * np.pi**8 * 8.0 / 225.0
    assert found is not None
    assert [one.first_order for one in found.values()] == pytest.approx([x / whole, y / whole, 0.0], abs=0.02)
    assert [one.total_order for one in found.values()] == pytest.approx(
        [(x + xz) / whole, y / whole, xz / whole], abs=0.02
    )
    assert f'<td>y</td><td class="number">{found["y"].first_order:.3f}</td>' in report(study, parts)
    assert summary.sensitivities(study, np.full(study.cells.count, np.nan)) is None
