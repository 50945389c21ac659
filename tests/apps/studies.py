"""Studies that tests run: files in a folder, and what becomes of them."""

from __future__ import annotations

from pathlib import Path

from virtualrobot_apps.studies.engines import Engine, Here
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.running import Progress, open_job, run
from virtualrobot_apps.studies.study_file import Study, read_study

FUNCTION = """
def spin(cell):
    if cell.parameters["x"] % 10 == 5:
        raise ValueError(f"no <solution> for {cell.parameters['x']}")
    return {"y": cell.rng.normal() + cell.parameters["x"], "odd": "odd" if cell.number % 2 else None}
"""
STUDY = """
schema_version: 1
function: cells:spin
seed: 3
draws: 10
block: 7
parameters: {x: {grid: {from: 0, to: 19, count: 20}}, u: {law: norm}}
results: {y: number, odd: text}
"""
CELLS, FAILED = 200, 20
"""Numbers of cells of the study, and of those that fail: x of 5 and 15, ten draws each."""


def written(folder: Path, study: str = STUDY, function: str = FUNCTION) -> Study:
    """Return a study whose file and function are written into a folder."""
    folder.mkdir(exist_ok=True)
    (folder / "cells.py").write_text(function)
    (folder / "study.yaml").write_text(study)
    return read_study(folder / "study.yaml")


def done(study: Study, folder: Path, engine: Engine | None = None, resume: bool = False) -> tuple[Progress, Parts]:
    """Run or resume a study, in this process where no engine is given; return how far it is, and its parts."""
    return run(open_job(study, folder, resume), engine or Here()), Parts(folder, study)
