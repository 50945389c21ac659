"""Studies: the same results whatever happens on the way, and refusals in words."""

from __future__ import annotations

import json
import math
import os
import re
import resource
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from click.testing import CliRunner
from virtualrobot.cli import run as command_line
from virtualrobot.errors import VirtualRobotError, WrongStateError
from virtualrobot_apps.studies import summary
from virtualrobot_apps.studies.command import study as command
from virtualrobot_apps.studies.engines import Here, Local
from virtualrobot_apps.studies.parts import Parts, column
from virtualrobot_apps.studies.running import Pace, open_job, run
from virtualrobot_apps.studies.study_file import read_study
from virtualrobot_apps.studies.threads import ONE_THREAD

from tests.apps.studies import CELLS, FAILED, FUNCTION, STUDY, done, written


@pytest.fixture(autouse=True)
def _modules_are_looked_for_where_they_were(monkeypatch: pytest.MonkeyPatch) -> None:
    """A study that runs in this process has its folder looked through first, and one of these has a `random.py`."""
    monkeypatch.setattr(sys, "path", list(sys.path))


def test_a_monte_carlo_meets_its_law(tmp_path: Path) -> None:
    """The picks of the example: P(r <= 2 sigma) = 1 - exp(-2), and the mean of r is sigma sqrt(pi / 2) (Rayleigh)."""
    assert CliRunner().invoke(command, ["new", str(tmp_path / "pick")]).exit_code == 0
    study = read_study(tmp_path / "pick" / "pick.yaml")
    progress, parts = done(study, tmp_path / "results")
    assert (progress.done, progress.failed, progress.left) == (3072, 0, (0.0, 0.0))
    points = list(summary.by_point(study, parts.table()))
    assert [at["sigma"] for at, _ in points] == [0.0005, 0.001, 0.002]
    for at, found in points:
        low, high = found["got"].interval or (0.0, 0.0)
        assert low < 1.0 - math.exp(-2.0) < high
        expected = float(at["sigma"]) * math.sqrt(math.pi / 2.0)
        # Four deviations of a mean of 1024, of a law whose deviation is sigma sqrt(2 - pi / 2).
        assert abs(found["off"].mean - expected) < 4.0 * float(at["sigma"]) * math.sqrt(2.0 - math.pi / 2.0) / 32.0


def test_a_worker_loads_what_its_function_needs_and_no_more(tmp_path: Path) -> None:
    """Laws are drawn before, and rows are written without pandas: either takes longer to load than all else."""
    function = (
        "import sys\ndef spin(cell):\n    return {'y': 'scipy' in sys.modules, 'odd': str('pandas' in sys.modules)}\n"
    )
    study = written(tmp_path / "in", STUDY.replace("block: 7", "block: 20"), function)
    _, parts = done(study, tmp_path / "out", Local(1))
    rows = parts.table().to_pylist()
    assert {(row["status"], row["y"], row["odd"]) for row in rows} == {("ok", 0.0, "False")}
    assert [row["u"] for row in rows] == [one["u"] for one in study.cells.between(0, CELLS)]


def test_what_has_done_nothing_may_begin_anew(tmp_path: Path) -> None:
    """A setup that fails, and is mended: what `run` has made of the folder is no study's."""
    setup = "def begin(scene):\n    raise OSError('no camera')\n"
    study = written(tmp_path / "in", STUDY.replace("function: cells:spin", "function: cells:spin\nsetup: cells:begin"))
    (tmp_path / "in" / "cells.py").write_text(FUNCTION + setup)
    asked = ["run", str(study.file), "--folder", str(tmp_path / "out"), "--workers", "0"]
    failed = CliRunner().invoke(command, asked)
    told = f"the setup cells:begin fails: OSError: no camera ({tmp_path}/in/cells.py:7)"
    assert failed.exit_code == 1 and told == str(failed.exception)
    (tmp_path / "in" / "cells.py").write_text(FUNCTION + setup.replace("raise", "return"))
    mended = CliRunner().invoke(command, asked)
    assert mended.exit_code == 0 and f"{CELLS} of {CELLS} cells, {FAILED} failed" in mended.output
    # What has done something is kept.
    again = CliRunner().invoke(command, asked)
    assert again.exit_code == 1 and "200 of 200 cells already" in str(again.exception)


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ([1, None, -(2**62)], pyarrow.int64()),
        ([1.5, None, True, np.float64(0.1)], pyarrow.float64()),
        (["a", None, "h\u00f6her", ""], pyarrow.string()),
        ([None] * 17, pyarrow.string()),
        ([None] * 17, pyarrow.float64()),
    ],
)
def test_columns_are_those_of_arrow(values: list[float | str | None], kind: pyarrow.DataType) -> None:
    made = column(values, kind)
    made.validate(full=True)
    assert made.equals(pyarrow.array(values, kind))


@pytest.mark.long
def test_a_sobol_sequence_comes_nearer(tmp_path: Path) -> None:
    """Random draws have a deviation of sqrt(p (1 - p) / 1024) = 0.0107; these are within a third of it."""
    CliRunner().invoke(command, ["new", str(tmp_path / "pick")])
    file = tmp_path / "pick" / "pick.yaml"
    file.write_text(file.read_text() + "sampling: sobol\n")
    study = read_study(file)
    _, parts = done(study, tmp_path / "results")
    for _, found in summary.by_point(study, parts.table()):
        assert abs(found["got"].mean - (1.0 - math.exp(-2.0))) < 0.0107 / 3.0
        assert found["got"].interval is None


def test_every_cell_is_there_once_whatever_the_block_and_whoever_cancels(tmp_path: Path) -> None:
    study = written(tmp_path / "in")
    progress, parts = done(study, tmp_path / "whole")
    assert (progress.done, progress.failed) == (CELLS, FAILED)
    assert parts.table().column("cell").to_pylist() == list(range(CELLS))
    others = written(tmp_path / "in", STUDY.replace("block: 7", "block: 23"))
    assert done(others, tmp_path / "others")[1].digest() == parts.digest()
    # Cancelled when it has done some blocks; resumed in other blocks, over the first ones that are cut through.
    folder = tmp_path / "cancelled"
    told = run(open_job(study, folder, False), Here(), lambda progress: (folder / "cancel").touch())
    assert told.done < CELLS
    assert done(others, folder, resume=True)[0].done == CELLS
    assert Parts(folder, study).digest() == parts.digest()
    # Another seed is another study.
    other = written(tmp_path / "in", STUDY.replace("seed: 3", "seed: 4"))
    assert done(other, tmp_path / "seed")[1].digest() != parts.digest()


def test_cells_that_were_done_twice_count_once(tmp_path: Path) -> None:
    """Two runs at once, in other blocks, may both have done them."""
    study = written(tmp_path / "in")
    _, parts = done(study, tmp_path / "one")
    _, twice = done(written(tmp_path / "in", STUDY.replace("block: 7", "block: 30")), tmp_path / "two")
    for file in (tmp_path / "one" / "cells").iterdir():
        (tmp_path / "two" / "cells" / file.name).write_bytes(file.read_bytes())
    assert twice.table().column("cell").to_pylist() == list(range(CELLS))
    assert twice.digest() == parts.digest()


def test_a_cell_that_fails_keeps_its_traceback(tmp_path: Path) -> None:
    _, parts = done(written(tmp_path / "in"), tmp_path / "out")
    row = parts.table().slice(50, 1).to_pylist()[0]
    assert (row["status"], row["x"], row["y"]) == ("failed", 5.0, None)
    assert row["error"].endswith("ValueError: no <solution> for 5.0\n")
    assert 'raise ValueError(f"no <solution>' in row["error"]


@pytest.mark.parametrize(
    ("asks", "unasked"),
    [
        ("p['x']", ("u", "v")),
        ("p.get('u', 0) if 'x' in p else 0", ("v",)),
        ("p['v'] if cell.number == 11 else p['u']", ("x",)),
        ("len({**p})", ()),
        ("len(dict(p))", ()),
        ("len(list(p.items()))", ()),
        ("len(list(p.values()))", ()),
        ("len(p | {'w': 1})", ()),
        ("p.get('w', 3)", ("x", "u", "v")),
        ("1 // (cell.number // 6) * p['x']", ("u", "v")),
        ("1 // 0", ()),
    ],
)
def test_parameters_that_no_cell_asks_for_are_told(tmp_path: Path, asks: str, unasked: tuple[str, ...]) -> None:
    text = "schema_version: 1\nfunction: cells:f\nblock: 5\nparameters:\n  x: {list: [1, 2, 3]}\n"
    text += "  u: {list: [4, 5]}\n  v: {list: [6, 7]}\nresults: {y: number}\n"
    function = f"def f(cell):\n    p = cell.parameters\n    return {{'y': {asks}}}\n"
    progress, _ = done(written(tmp_path / "in", text, function), tmp_path / "out")
    assert progress.done == 12 and progress.unasked == unasked


def test_a_parameter_that_is_missing_is_named(tmp_path: Path) -> None:
    text = "schema_version: 1\nfunction: cells:f\nparameters: {turn: {list: [1]}}\nresults: {y: number}\n"
    function = "def f(cell):\n    return {'y': cell.parameters['turns']}\n"
    progress, _ = done(written(tmp_path / "in", text, function), tmp_path / "out")
    assert "the study file has no parameter 'turns'" in progress.failure


def test_a_function_that_wants_a_setup_is_told_that_there_is_none(tmp_path: Path) -> None:
    text = "schema_version: 1\nfunction: cells:f\nparameters: {x: {list: [1]}}\nresults: {y: number}\n"
    study = written(tmp_path / "in", text, "def f(cell):\n    return {'y': cell.shared.pose('arm')}\n")
    progress, parts = done(study, tmp_path / "out")
    assert progress.failure == (
        "cell 0: perhaps for want of a setup: without one in the study file, cell.shared is None"
    )
    assert "'NoneType' object has no attribute 'pose'" in parts.table().column("error").to_pylist()[0]


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        ("float('nan')", "the result 'y' is nan: a finite number belongs there, or None"),
        ("float('inf')", "the result 'y' is inf"),
        ("'high'", "the result 'y' is a number, not 'high'"),
        ("None}, {'y': 1", "a mapping of results (y), not ({'y': None}, {'y': 1})"),
        ("1, 'z': 2", "the study file has no result 'z'"),
        ("exit(3)", "SystemExit: 3"),
    ],
)
def test_results_that_are_none_are_failures_in_words(tmp_path: Path, returned: str, said: str) -> None:
    text = "schema_version: 1\nfunction: cells:f\nparameters: {x: {list: [1]}}\nresults: {y: number}\n"
    function = f"from sys import exit\ndef f(cell):\n    return {{'y': {returned}}}\n"
    progress, parts = done(written(tmp_path / "in", text, function), tmp_path / "out")
    assert progress.failed == 1
    assert said in parts.table().column("error").to_pylist()[0]
    assert progress.failure.startswith("cell 0: ")


def test_the_process_of_the_command_takes_one_thread_as_workers_do(tmp_path: Path) -> None:
    """It is told before NumPy is loaded, which looks for it then."""
    function = "import os\ndef f(cell):\n    return {'y': int(os.environ['OPENBLAS_NUM_THREADS']), 'odd': None}\n"
    study = written(tmp_path / "in", STUDY.replace("cells:spin", "cells:f"), function)
    program = "import sys\nfrom virtualrobot_apps.studies.command import study\nassert 'numpy' not in sys.modules\n"
    words = ["run", str(study.file), "--workers", "0"]
    environment = {name: value for name, value in os.environ.items() if name not in ONE_THREAD}
    subprocess.run([sys.executable, "-c", f"{program}study({words})"], check=True, env=environment)
    assert set(Parts(tmp_path / "in" / "study", study).table().column("y").to_pylist()) == {1.0}


def test_a_setup_is_made_once(tmp_path: Path) -> None:
    function = (
        "made = []\ndef setup(scene):\n    made.append(scene.read_text())\n    return made\n"
        "def f(cell):\n    return {'y': len(cell.shared), 'odd': cell.shared[0]}\n"
    )
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "cell.yaml").write_text("a cell")
    text = STUDY.replace("cells:spin", "cells:f\nsetup: cells:setup\nscene: cell.yaml")
    _, parts = done(written(tmp_path / "in", text, function), tmp_path / "out")
    assert set(parts.table().column("y").to_pylist()) == {1.0}
    assert set(parts.table().column("odd").to_pylist()) == {"a cell"}


def changed_study(old: str, new: str) -> Callable[[Path, Path], object]:
    return lambda source, _: (source / "study.yaml").write_text(STUDY.replace(old, new))


def changed_function(old: str, new: str) -> Callable[[Path, Path], object]:
    return lambda source, _: (source / "cells.py").write_text(FUNCTION.replace(old, new))


def other_version(_: Path, folder: Path) -> None:
    stamp = folder / "study.json"
    document = json.loads(stamp.read_text())
    stamp.write_text(json.dumps(document | {"versions": document["versions"] | {"numpy": "1.0"}}))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (changed_function("% 10", "% 11"), "the source of cells:spin has changed since the first cells in"),
        (changed_study("seed: 3", "seed: 4"), "seed was 3 and is 4 since"),
        (changed_study("to: 19", "to: 18"), "the parameters of the study file have changed"),
        (changed_study("odd: text", "odd: number"), "the results of the study file have changed"),
        (changed_study("draws: 10", "draws: 11"), "draws was 10 and is 11"),
        (other_version, "numpy 1.0"),
        (lambda _, folder: (folder / "study.json").write_text("{"), "study.json is damaged"),
    ],
)
def test_what_has_changed_is_not_gone_on_with(
    tmp_path: Path, change: Callable[[Path, Path], object], said: str
) -> None:
    study, folder = written(tmp_path / "in"), tmp_path / "out"
    open_job(study, folder, False)
    change(tmp_path / "in", folder)
    with pytest.raises(VirtualRobotError) as error:
        open_job(read_study(study.file), folder, resume=True)
    assert said in str(error.value)


def test_a_comment_changes_nothing_and_a_helper_does(tmp_path: Path) -> None:
    function = "import helper\ndef spin(cell):\n    return {'y': helper.value(), 'odd': None}\n"
    (tmp_path / "in").mkdir()
    helper = tmp_path / "in" / "helper.py"
    helper.write_text("def value():\n    return 1\n")
    study, folder = written(tmp_path / "in", function=function), tmp_path / "out"
    job = open_job(study, folder, False)
    helper.write_text("# One.\ndef value():\n    return 1\n")
    assert open_job(study, folder, True) == job
    helper.write_text("def value():\n    return 2\n")
    with pytest.raises(WrongStateError, match="the source of cells:spin has changed"):
        open_job(study, folder, True)
    # A worker that finds another function than the run has begun with does nothing.
    with pytest.raises(WrongStateError, match="is not that which the study was begun with"):
        run(job, Here())
    with pytest.raises(WrongStateError, match=r"this worker has python .*, and the study was begun with numpy 1.0"):
        run(replace(open_job(study, tmp_path / "third", False), versions={"numpy": "1.0"}), Here())
    # Begun anew, it is the new one that counts, though this process has imported the old one.
    assert set(done(study, tmp_path / "new")[1].table().column("y").to_pylist()) == {2.0}


@pytest.mark.parametrize(
    ("function", "text", "said"),
    [
        (FUNCTION, "cells:spinn", "cells has no function 'spinn'; did you mean 'spin'?"),
        (FUNCTION, "cell:spin", "there is no module 'cell', neither in"),
        (FUNCTION, "random:spin", "random.py is called as a module of Python's own"),
        ("spin = 3", "cells:spin", "cells:spin is no function but 3"),
        ("def spin(:", "cells:spin", "is not Python: invalid syntax"),
        ("import no_such_library", "cells:spin", "ModuleNotFoundError: No module named 'no_such_library'"),
        ("def spin(cell): 0\ndef setup(_): 1 / 0", "cells:spin\nsetup: cells:setup", "the setup cells:setup fails"),
    ],
)
def test_functions_that_are_none_are_refused(tmp_path: Path, function: str, text: str, said: str) -> None:
    study = written(tmp_path / "in", STUDY.replace("cells:spin", text), function)
    (tmp_path / "in" / "random.py").write_text(function)
    with pytest.raises(VirtualRobotError) as error:
        done(study, tmp_path / "out")
    assert said in str(error.value)


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(WrongStateError, match="out cannot be written: Not a directory"):
        done(written(tmp_path / "in"), tmp_path / "file" / "out")
    # Nobody makes folders there, whatever rights he has.
    with pytest.raises(
        WrongStateError, match=r"/sys/kernel/out cannot be written: .*(not permitted|denied|[Rr]ead-only)"
    ):
        done(written(tmp_path / "in"), Path("/sys/kernel/out"))


def test_a_full_disk_ends_the_run_and_loses_nothing(tmp_path: Path) -> None:
    """Files of this process may have 1 kB for a while: less than a part has, and more than the study's own files."""
    study = written(tmp_path / "in", STUDY.replace("block: 7", "block: 100"))
    job = open_job(study, tmp_path / "full", False)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1024, limits[1]))
    try:
        with pytest.raises(WrongStateError, match="File too large; what is done stays"):
            run(job, Here())
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert list((tmp_path / "full" / "cells").iterdir()) == []
    assert done(study, tmp_path / "full", resume=True)[1].digest() == done(study, tmp_path / "out")[1].digest()


def test_a_damaged_part_is_named(tmp_path: Path) -> None:
    study = written(tmp_path / "in")
    _, parts = done(study, tmp_path / "out")
    file = tmp_path / "out" / "cells" / "0000000007-0000000013.parquet"
    before = parts.digest()
    file.write_bytes(b"PAR1")
    with pytest.raises(VirtualRobotError, match=r"0000000007-0000000013.parquet is damaged .*: delete it and resume"):
        parts.digest()
    file.unlink()
    assert done(study, tmp_path / "out", resume=True)[1].digest() == before


def test_what_was_left_unwritten_goes_when_nobody_can_be_at_it_any_more(tmp_path: Path) -> None:
    study, folder = written(tmp_path / "in"), tmp_path / "out"
    open_job(study, folder, False)
    old, young, said = folder / "cells" / ".0-1.7.8.tmp", folder / "cells" / ".0-1.9.8.tmp", folder / "lost" / "0-1.txt"
    for file in (old, young, said):
        file.write_text("part")
    for file in (old, said):
        os.utime(file, (0, 0))
    open_job(study, folder, True)
    assert [file.exists() for file in (old, young, said)] == [False, True, True]


def test_a_time_for_cells_needs_workers(tmp_path: Path) -> None:
    with pytest.raises(WrongStateError, match="cell_seconds needs worker processes"):
        done(written(tmp_path / "in", STUDY + "cell_seconds: 1\n"), tmp_path / "out")


def test_the_remaining_time_is_a_prediction_interval() -> None:
    """Of n blocks by k others: n m +- 2 s sqrt(n + n^2 / k), here with m = 2, s = 1, k = 3, n = 4, for one worker."""
    pace = Pace(1)
    for seconds in (1.0, 2.0):
        pace.add(10, seconds)
    assert pace.left(40) is None
    pace.add(10, 3.0)
    off = 2.0 * math.sqrt(4.0 + 16.0 / 3.0)
    assert pace.left(40) == pytest.approx((8.0 - off, 8.0 + off))
    two = Pace(2)
    for _ in range(3):
        two.add(10, 2.0)
    assert two.left(40) == pytest.approx((4.0, 4.0))


def test_the_remaining_time_is_mostly_right(rng: np.random.Generator) -> None:
    """Sixty blocks whose times differ by a half; after ten of them the rest is foretold.

    Two deviations are 95% of a normal law, and 92% of Student's with nine degrees of freedom.
    """
    right = 0
    for _ in range(400):
        seconds, pace = rng.lognormal(0.0, 0.5, 60), Pace(1)
        for one in seconds[:10]:
            pace.add(5, float(one))
        low, high = pace.left(250) or (0.0, 0.0)
        right += low < seconds[10:].sum() < high
    assert right > 0.85 * 400


def test_shares_have_the_interval_of_wilson() -> None:
    """Brown, Cai, DasGupta, "Interval estimation for a binomial proportion", 2001: z = 1.96, here 8 of 10."""
    assert summary.wilson(8.0, 10) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    found = summary.summarize(np.array([1.0] * 8 + [0.0] * 2))
    assert found.interval == pytest.approx(summary.wilson(8.0, 10))
    # Student's t for three degrees of freedom at 97.5%: 3.182 (any table of it).
    four = summary.summarize(np.array([1.0, 2.0, 3.0, 4.0]))
    assert four.interval == pytest.approx((2.5 - 3.182 * 1.29099 / 2.0, 2.5 + 3.182 * 1.29099 / 2.0), abs=1e-3)


class Tags(HTMLParser):
    """Tags that are open, and the text of cells of tables."""

    def __init__(self) -> None:
        """Begin with none."""
        super().__init__()
        self.open: list[str] = []
        self.texts: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.extend([data] if data.strip() else [])


def test_the_command_line_runs_resumes_and_reports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    written(tmp_path)
    monkeypatch.chdir(tmp_path)

    def said(*words: str) -> tuple[int, str, str]:
        code = command.main(list(words), standalone_mode=False)
        found = capsys.readouterr()
        return code or 0, found.out, found.err

    with pytest.raises(WrongStateError, match=r"study has no results yet: 'virtualrobot study run study.yaml' begins"):
        said("status", "study.yaml")
    with pytest.raises(WrongStateError, match="study has no results to go on from"):
        said("resume", "study.yaml")
    _, output, errors = said("run", "study.yaml", "--workers", "0")
    assert output == "200 of 200 cells, 20 failed, 0 killed; results in study/cells\n"
    failure, unasked = errors.splitlines()
    assert re.fullmatch(r"first failure: cell (5|15)\d: ValueError: no <solution> for \1.0", failure)
    assert unasked == "no cell has asked for the parameter 'u': does the function know it by this name?"
    with pytest.raises(WrongStateError, match="study has 200 of 200 cells already"):
        said("run", "study.yaml")
    assert said("status", "study.yaml")[1] == "200 of 200 cells, 20 failed, 0 killed\n"
    assert said("cancel", "study.yaml")[1] == "all 200 cells are done: there is nothing to end\n"
    assert not Path("study/cancel").exists()
    told = json.loads(said("status", "study.yaml", "--json")[1])
    digest = Parts(Path("study"), read_study(Path("study.yaml"))).digest()
    assert told == {"cells": 200, "done": 200, "failed": 20, "killed": 0, "sha256": digest}
    assert said("report", "study.yaml")[1] == "study/report.html\n"
    tags = Tags()
    tags.feed(Path("study/report.html").read_text())
    assert tags.open == []
    assert told["sha256"] in tags.texts
    assert tags.texts[tags.texts.index("odd") + 1 :][:4] == ["cells", "odd", "90", "Cells that failed"]
    assert "10 failed, first cell 50: ValueError: no <solution> for 5.0" in tags.texts
    next((tmp_path / "study" / "cells").iterdir()).unlink()
    assert said("resume", "study.yaml", "--workers", "0")[1].startswith("200 of 200 cells")


def test_what_is_missing_is_told_with_the_line_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("virtualrobot_apps.studies.command._PACKAGES", ("no_such_package",))
    assert command_line(["study", "run", str(tmp_path / "study.yaml")]) == 1
    assert "studies need no_such_package: pip install 'virtualrobot[studies]'" in capsys.readouterr().err
