"""Studies whose workers, or whose own process, are killed: every cell once, and equal results."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.studies.engines import Ends, Local, Lost
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.running import Progress, open_job, run
from virtualrobot_apps.studies.study_file import read_study
from virtualrobot_apps.studies.work import Block, Job, work

from tests.apps.studies import done, written
from tests.waiting import until

STUDY = """
schema_version: 1
function: cells:spin
seed: 3
block: 4
parameters: {{x: {{grid: {{from: 0, to: 1, count: {count}}}}}}}
results: {{y: number}}
"""
FUNCTION = """
import ctypes, os, signal, time
from pathlib import Path

def spin(cell):
    {fault}
    return {{"y": cell.rng.normal()}}
"""
HARMLESS = FUNCTION.format(fault="pass")


class Dying:
    """Engine of one worker, which dies in each block that has one of the cells `deadly`; it notes what it was given.

    Before so many blocks as `sick` says it dies at first without a trace, as on a node that lacks something.
    """

    workers = 1

    def __init__(self, *deadly: int, sick: int = 0) -> None:
        """Choose the cells."""
        self.deadly, self.sick = deadly, sick
        self.given: list[Block] = []

    def run(self, job: Job, following: Callable[[], Block | None]) -> Ends:
        """Do blocks one after the other."""
        while (block := following()) is not None:
            self.given.append(block)
            if self.sick:
                self.sick -= 1
                yield block, Lost("it has no memory")
            elif set(range(block.first, block.last)) & set(self.deadly):
                Parts(job.folder, job.study).trace(block.first, block.last).touch()
                yield block, Lost("it died")
            else:
                yield block, work(job, block)


def test_a_block_that_kills_its_worker_is_halved_until_the_cell_is_named(tmp_path: Path) -> None:
    engine = Dying(13)
    progress, parts = done(written(tmp_path / "in", STUDY.format(count=16), HARMLESS), tmp_path / "out", engine)
    assert (progress.done, progress.killed) == (16, 1)
    assert progress.failure == "cell 13 killed its worker 3 times: it died"
    deadly = [block[:2] for block in engine.given if block.first <= 13 < block.last]
    assert deadly == [(12, 16), (12, 14), (13, 14), (13, 14), (13, 14)]
    assert parts.table().column("cell").to_pylist() == list(range(16))
    assert parts.table().slice(13, 1).to_pylist()[0]["error"] == "the cell killed its worker 3 times: it died"


def test_where_all_workers_die_it_is_not_the_cells(tmp_path: Path) -> None:
    study = written(tmp_path / "in", STUDY.format(count=200), HARMLESS)
    with pytest.raises(WrongStateError, match="40 workers died, and none has done anything: it died"):
        done(study, tmp_path / "out", Dying(*range(200)))


def test_a_worker_that_dies_before_a_cell_is_none_of_the_cells_fault(tmp_path: Path) -> None:
    text = STUDY.format(count=16)
    _, expected = done(written(tmp_path / "in", text, HARMLESS), tmp_path / "expected")
    engine = Dying(sick=39)
    progress, parts = done(read_study(tmp_path / "in" / "study.yaml"), tmp_path / "out", engine)
    assert (progress.done, progress.killed) == (16, 0) and parts.digest() == expected.digest()
    assert [block[:2] for block in engine.given[:40]] == 40 * [engine.given[0][:2]]
    with pytest.raises(WrongStateError, match="40 workers in a row died before they came to a cell: it has no memory"):
        done(read_study(tmp_path / "in" / "study.yaml"), tmp_path / "again", Dying(sick=40))


@pytest.mark.long
def test_a_worker_that_dies_costs_nothing_and_a_cell_that_kills_each_is_named(tmp_path: Path) -> None:
    """Cell 2 kills its worker the first time alone, as somebody else might; cell 13 crashes each."""
    marker = tmp_path / "killed"
    fault = f"""
    if cell.number == 2 and not Path({str(marker)!r}).exists():
        Path({str(marker)!r}).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if cell.number == 13:
        ctypes.string_at(0)
    """
    text = STUDY.format(count=16)
    _, expected = done(written(tmp_path / "harmless", text, HARMLESS), tmp_path / "expected")
    study = written(tmp_path / "deadly", text, FUNCTION.format(fault=fault))
    progress, parts = done(study, tmp_path / "out", Local(2))
    assert marker.exists()
    assert (progress.done, progress.failed, progress.killed) == (16, 0, 1)
    table = parts.table()
    wanted = expected.table().column("y").to_pylist()
    assert table.column("y").to_pylist() == [*wanted[:13], None, *wanted[14:]]
    row = table.slice(13, 1).to_pylist()[0]
    assert row["status"] == "killed"
    # How it died, as loky says it, and where, as Python's own handler of faults has left it.
    assert "killed its worker 3 times" in row["error"] and "SIGSEGV" in row["error"]
    assert "Fatal Python error: Segmentation fault" in row["error"] and "in spin" in row["error"]
    assert parts.counts() == (16, 0, 1)


@pytest.mark.parametrize("kills", [pytest.param(1, marks=pytest.mark.long), pytest.param(50, marks=pytest.mark.hunted)])
def test_a_study_that_is_killed_is_resumed_with_the_same_results(
    tmp_path: Path, kills: int, rng: np.random.Generator
) -> None:
    """Killed when it has left some number of parts; its workers end by themselves."""
    text, function = STUDY.format(count=200), FUNCTION.format(fault="time.sleep(0.002)")
    study = written(tmp_path / "in", text, function)
    _, expected = done(written(tmp_path / "quick", text, HARMLESS), tmp_path / "expected")
    for number in range(kills):
        folder, wanted = tmp_path / str(number), int(rng.integers(0, 40))
        words = ["study", "run", str(study.file), "--folder", str(folder), "--workers", "2"]
        process = subprocess.Popen([sys.executable, "-m", "virtualrobot", *words], stdout=subprocess.DEVNULL)
        try:
            until(lambda folder=folder, wanted=wanted: len(list((folder / "cells").glob("*.parquet"))) >= wanted)
        finally:
            process.kill()
            process.wait()
        workers = {int(one.rpartition(":")[2]) for one in Parts(folder, study).table().column("worker").to_pylist()}
        until(lambda workers=workers: not any(map(alive, workers)))
        progress, parts = done(study, folder, resume=(folder / "study.json").exists())
        assert progress.done == 200
        assert parts.table().column("cell").to_pylist() == list(range(200))
        assert parts.digest() == expected.digest()


def alive(number: int) -> bool:
    """Return whether there is a process of this number."""
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.long
def test_workers_that_are_killed_from_outside_cost_nothing(tmp_path: Path, rng: np.random.Generator) -> None:
    """Twice, each when some more parts are there: any worker that has begun a cell and lives."""
    text, alive_here = STUDY.format(count=200), tmp_path / "alive"
    alive_here.mkdir()
    fault = f"Path({str(alive_here)!r}, str(os.getpid())).touch(); time.sleep(0.002)"
    study = written(tmp_path / "in", text, FUNCTION.format(fault=fault))
    _, expected = done(written(tmp_path / "quick", text, HARMLESS), tmp_path / "expected")
    killed: list[int] = []

    def tell(progress: Progress) -> None:
        if len(killed) < 2 and progress.done >= 50 * (len(killed) + 1):
            workers = [int(file.name) for file in sorted(alive_here.iterdir()) if int(file.name) not in killed]
            killed.append(workers[int(rng.integers(len(workers)))])
            os.kill(killed[-1], signal.SIGKILL)

    progress = run(open_job(study, tmp_path / "out", False), Local(2), tell)
    assert (progress.done, progress.failed, progress.killed, len(killed)) == (200, 0, 0, 2)
    assert Parts(tmp_path / "out", study).digest() == expected.digest()


@pytest.mark.long
def test_a_cell_that_hangs_is_named_with_the_line_where_it_does(tmp_path: Path) -> None:
    fault = "time.sleep(600 if cell.number == 5 else 0)"
    study = written(tmp_path / "in", STUDY.format(count=8) + "cell_seconds: 1\n", FUNCTION.format(fault=fault))
    progress, parts = done(study, tmp_path / "out", Local(2))
    assert (progress.done, progress.killed) == (8, 1)
    row = parts.table().slice(5, 1).to_pylist()[0]
    assert "or took longer than 1 s" in row["error"]
    assert "Timeout (0:00:01)!" in row["error"] and 'cells.py", line 6 in spin' in row["error"]


@pytest.mark.long
def test_ctrl_c_ends_it_at_once_in_one_line(tmp_path: Path) -> None:
    """The terminal tells all processes in front; workers leave it to the command."""
    study = written(tmp_path / "in", STUDY.format(count=100), FUNCTION.format(fault="time.sleep(0.02)"))
    words = ["study", "run", str(study.file), "--folder", str(tmp_path / "out"), "--workers", "2"]
    command = [sys.executable, "-m", "virtualrobot", *words]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    try:
        until(lambda: any((tmp_path / "out" / "cells").glob("*.parquet")))
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    assert errors.strip() == f"ended: what is done stays; 'virtualrobot study resume {study.file}' goes on"
    assert process.returncode == 130
    workers = Parts(tmp_path / "out", study).table().column("worker").to_pylist()
    until(lambda: not any(alive(int(one.rpartition(":")[2])) for one in set(workers)))
    assert done(study, tmp_path / "out", resume=True)[0].done == 100


@pytest.mark.long
def test_whoever_asks_may_cancel_it_and_resume_with_other_workers(tmp_path: Path) -> None:
    text, function = STUDY.format(count=100), FUNCTION.format(fault="time.sleep(0.002)")
    study = written(tmp_path / "in", text, function)
    folder = tmp_path / "out"
    words = ["study", "run", str(study.file), "--folder", str(folder), "--workers", "1"]
    process = subprocess.Popen([sys.executable, "-m", "virtualrobot", *words], stderr=subprocess.PIPE, text=True)
    try:
        until(lambda: len(list((folder / "cells").glob("*.parquet"))) >= 3)
        cancel = ["study", "cancel", str(study.file), "--folder", str(folder)]
        subprocess.run([sys.executable, "-m", "virtualrobot", *cancel], check=True)
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    if process.returncode == 0:  # it was quicker
        assert Parts(folder, study).counts().done == 100
    else:
        assert process.returncode == 1 and "cancelled: 'virtualrobot study resume" in errors
    _, parts = done(study, folder, Local(2), resume=True)
    assert parts.counts().done == 100
    _, expected = done(written(tmp_path / "quick", text, HARMLESS), tmp_path / "expected")
    assert parts.digest() == expected.digest()
