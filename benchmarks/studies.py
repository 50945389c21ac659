"""Studies beside a bare pool that does the same cells and keeps nothing; and what a cell costs beside its function."""

from __future__ import annotations

import tempfile
import time
from concurrent.futures import wait
from pathlib import Path

import numpy as np
from loky import ProcessPoolExecutor
from virtualrobot_apps.studies.engines import Engine, Here, Local
from virtualrobot_apps.studies.running import open_job
from virtualrobot_apps.studies.running import run as run_job
from virtualrobot_apps.studies.study_file import read_study

from benchmarks.rows import Row, row

WORKERS, ROUNDS = 2, 3
CELLS, BLOCK, CELL_SECONDS = 1000, 50, 0.01
EMPTY_CELLS = 20_000
FUNCTIONS = """
from benchmarks.studies import spin

def spun(cell):
    spin()
    return {"y": cell.rng.normal()}

def empty(cell):
    return {"y": cell.rng.normal()}
"""
STUDY = """
schema_version: 1
function: cells:{function}
block: {block}
draws: {cells}
parameters: {{x: {{range: [0, 1]}}, u: {{law: norm}}}}
results: {{y: number}}
"""


def run() -> list[Row]:
    """Measure and return the rows."""
    ours, bare = [], []
    for _ in range(ROUNDS):
        bare.append(_bare())
        ours.append(_study("spun", CELLS, BLOCK, Local(WORKERS)))
    each = 1e3 * _study("empty", EMPTY_CELLS, 1000, Here()) / EMPTY_CELLS
    what = f"{CELLS} cells of 10 ms by {WORKERS} workers, which start for it"
    return [
        # At least 0.9 of what the pool does.
        row(what, float(np.median(ours)), float(np.median(bare)), "bare pool of loky", "s", 1.0 / 0.9),
        row("a cell beside its function, two parameters drawn", each, 1.0, "1 ms", "ms", 1.0),
    ]


def spin() -> None:
    """Compute for as long as a cell takes."""
    end = time.process_time() + CELL_SECONDS
    while time.process_time() < end:
        pass


def _block(count: int) -> None:
    for _ in range(count):
        spin()


def _bare() -> float:
    start = time.perf_counter()
    with ProcessPoolExecutor(WORKERS) as pool:
        wait([pool.submit(_block, BLOCK) for _ in range(CELLS // BLOCK)])
        return time.perf_counter() - start


def _study(function: str, cells: int, block: int, engine: Engine) -> float:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "cells.py").write_text(FUNCTIONS)
        (folder / "study.yaml").write_text(STUDY.format(function=function, cells=cells, block=block))
        start = time.perf_counter()
        progress = run_job(open_job(read_study(folder / "study.yaml"), folder / "out", False), engine)
        assert progress.done == cells
        return time.perf_counter() - start


if __name__ == "__main__":
    for result in run():
        print(result)
