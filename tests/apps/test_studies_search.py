"""Searches of studies: they find a known optimum, and come to the same when they are resumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import WrongStateError
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
    assert first.startswith(f"<td>{best['cell']}</td>")
    assert "95% interval</th>" in text and " to " not in text[text.index("<h2>cost") :].partition("<svg")[0]


def test_a_search_that_is_resumed_comes_to_the_same(tmp_path: Path) -> None:
    """Cancelled in the middle of a generation, in other blocks, and with what functions draw by NumPy left as it is."""
    function = VALLEY.replace("SIGN", "1.0")
    study = written(tmp_path / "in", STUDY, function)
    np.random.seed(1)
    _, whole = done(study, tmp_path / "whole")
    assert np.random.random() == np.random.RandomState(1).random()
    folder = tmp_path / "cancelled"
    run(open_job(study, folder, False), Here(), lambda told: told.done < 100 or (folder / "cancel").touch())
    assert Parts(folder, study).counts()["done"] == 100
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
