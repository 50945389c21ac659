"""`virtualrobot study`: thousands of cells of a function, run, watched, resumed and reported."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.new.writing import Folder, write
from virtualrobot_apps.studies.threads import ONE_THREAD

if TYPE_CHECKING:
    from virtualrobot_apps.studies.engines import Engine
    from virtualrobot_apps.studies.running import Progress
    from virtualrobot_apps.studies.study_file import Study

EXAMPLES = Path(__file__).parent / "examples"
_PACKAGES = ("cma", "loky", "optuna", "pyarrow", "scipy")
_TOLD_SECONDS = 0.5
_BEGIN = "\r\x1b[K"
_EXAMPLES = """
\b
Examples:
  virtualrobot study new my-study
  virtualrobot study run my-study/pick.yaml
  virtualrobot study report my-study/pick.yaml
"""
FILE = click.argument("file", type=click.Path(path_type=Path, dir_okay=False), metavar="STUDY.yaml")
FOLDER = click.option(
    "--folder",
    metavar="FOLDER",
    help="Where results are [STUDY, beside the file], such as 's3://BUCKET/FOLDER' of a bucket.",
)
WORKERS = click.option(
    "--workers", type=click.IntRange(0, 1024), help="Worker processes [one for each core]; 0 is this process."
)

ON = click.option(
    "--on",
    metavar="PLACE",
    default="local",
    show_default=True,
    help="Where cells are done: 'local', worker processes of this machine; 'ray', a Ray cluster of its own here; "
    "'ray://HOST:PORT', a Ray cluster, from anywhere; 'HOST:PORT', from one of its nodes.",
)


@click.group(epilog=_EXAMPLES, short_help="Run a function over thousands of cells, and go on after whatever dies.")
def study() -> None:
    """Run a function over thousands of cells, each with its own parameters and random numbers.

    STUDY.yaml names the function, its parameters and its results. These go into a folder as Parquet files; whatever
    dies meanwhile, 'resume' goes on. No kernel is needed, unless the function wants one.
    """


@study.command()
@click.argument("folder", type=Folder(), required=False)
def new(folder: Path | None) -> None:
    """Write a study that runs as it is into FOLDER [pick], as a start for your own."""
    files = write([EXAMPLES / "pick"], folder or Path("pick"))
    where = files[0].parent
    click.echo(f"written: {', '.join(file.name for file in files)} in {where}")
    click.echo(f"Run it:  virtualrobot study run {where / 'pick.yaml'}")


@study.command()
@FILE
@FOLDER
@WORKERS
@ON
def run(file: Path, folder: str | None, workers: int | None, on: str) -> None:
    """Begin a study and do all its cells; Ctrl-C ends it at once, 'study cancel' after the running blocks.

    The exit code is 1 when it is cancelled. Cells that fail are results.
    """
    _do(file, folder, workers, on, resume=False)


@study.command()
@FILE
@FOLDER
@WORKERS
@ON
def resume(file: Path, folder: str | None, workers: int | None, on: str) -> None:
    """Do the cells that are missing, with the same results as if nothing had happened.

    Refused when function, scene, parameters or versions have changed since.
    """
    _do(file, folder, workers, on, resume=True)


@study.command()
@FILE
@FOLDER
@click.option("--json", "as_json", is_flag=True, help="Write it as JSON, with the SHA-256 of the results.")
def status(file: Path, folder: str | None, as_json: bool) -> None:
    """Tell how many cells are done and how many have failed, and how long a run that goes on will take."""
    from virtualrobot_apps.studies.parts import Parts
    from virtualrobot_apps.studies.running import PROGRESS, Progress

    found, where = _found(file, folder)
    parts = Parts(where, found)
    counts = parts.counts()
    if as_json:
        click.echo(json.dumps({"cells": found.cells.count, **counts._asdict(), "sha256": parts.digest()}))
        return
    ago, left = 0.0, None
    if counts.done < found.cells.count and parts.store.has(PROGRESS):
        document = json.loads(parts.store.read(PROGRESS))
        ago, left = time.time() - document["at"], document["left"]
    progress = Progress(found.cells.count, *counts, left=left)
    click.echo(_line(progress) + (f", as of {_time(ago)} ago" if left is not None else ""))


@study.command()
@FILE
@FOLDER
def cancel(file: Path, folder: str | None) -> None:
    """End the run of a study after the blocks that are running; it may be resumed."""
    from virtualrobot_apps.studies.parts import Parts
    from virtualrobot_apps.studies.running import CANCEL
    from virtualrobot_apps.studies.stores import store_of

    found, where = _found(file, folder)
    if (done := Parts(where, found).counts().done) == found.cells.count:
        click.echo(f"all {done} cells are done: there is nothing to end")
        return
    try:
        store_of(where).write(CANCEL, b"")
    except OSError as error:
        raise WrongStateError(f"{where} cannot be written: {error.strerror or error}") from error
    click.echo("its run ends after the blocks that it is at")


@study.command()
@FILE
@FOLDER
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="File to write [report.html in the folder; beside the study file for one in a bucket].",
)
def report(file: Path, folder: str | None, output: Path | None) -> None:
    """Write tables, heat maps, histograms and failures of the cells that are done as one HTML file."""
    from virtualrobot_apps.studies import report as reports
    from virtualrobot_apps.studies.parts import Parts

    found, where = _found(file, folder)
    text = reports.report(found, Parts(where, found))
    if output is None:
        output = where / "report.html" if isinstance(where, Path) else file.with_name(f"{file.stem}-report.html")
    try:
        output.write_text(text, "utf-8")
    except OSError as error:
        raise WrongStateError(f"{output} cannot be written: {error.strerror or error}") from error
    click.echo(output)


@study.command()
@FILE
@FOLDER
@click.option("--by", "result", required=True, metavar="RESULT", help="Result that is greatest in the best cells.")
@click.option("--least", "is_least", is_flag=True, help="The best cells are those in which it is least.")
@click.option("--count", type=click.IntRange(1, 1000), default=5, show_default=True, help="Number of cells.")
@click.option(
    "--scenes",
    "with_scenes",
    is_flag=True,
    help="Write a scene file for each, beside the study's, in which the robot stands as in the cell.",
)
def best(file: Path, folder: str | None, result: str, is_least: bool, count: int, with_scenes: bool) -> None:
    """Tell the best cells by one of the results, and write the scenes of them."""
    from virtualrobot_apps.studies.best import best_cells, scene_of
    from virtualrobot_apps.studies.parts import Parts

    found, where = _found(file, folder)
    parameters = [one.name for one in found.cells.parameters]
    for row in best_cells(found, Parts(where, found).table(), result, is_least, count):
        names = [result, *parameters, *(name for name, _ in found.results if name != result)]
        click.echo(f"cell {row['cell']}: " + ", ".join(f"{name} {_said(row[name])}" for name in names))
        if with_scenes:
            if found.scene is None:
                raise WrongStateError(f"{file} has no scene of which others could be made")
            output = found.scene.with_name(f"{found.scene.stem}-{row['cell']}.yaml")
            text = scene_of(found.scene, {name: row[name] for name in parameters})
            try:
                output.write_text(text, "utf-8")
            except OSError as error:
                raise WrongStateError(f"{output} cannot be written: {error.strerror or error}") from error
            click.echo(output)


@study.command()
@click.argument("exercise", type=click.Path(path_type=Path, dir_okay=False), metavar="EXERCISE.yaml")
@click.argument("handed_in", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE")
@click.option("--json", "as_json", is_flag=True, help="Write it as JSON.")
def mark(exercise: Path, handed_in: Path, as_json: bool) -> None:
    """Mark a scene or a line that a student hands in, by the goals of an exercise."""
    from virtualrobot_apps.studies.marking import Exercise

    marks = Exercise(exercise).marks(handed_in)
    earned, points = sum(one.earned for one in marks), sum(one.points for one in marks)
    if as_json:
        click.echo(json.dumps({"earned": earned, "points": points, "goals": [vars(one) for one in marks]}))
        return
    for one in marks:
        click.echo(f"{one.result}: {one.found} ({one.wanted}): {one.earned:.3g} of {one.points:g}")
    click.echo(f"{earned:.3g} of {points:g} points")


def check_packages() -> None:
    """Raise WrongStateError, which says how to install them, where packages are missing."""
    if missing := [name for name in _PACKAGES if importlib.util.find_spec(name) is None]:
        raise WrongStateError(f"studies need {' and '.join(missing)}: pip install 'virtualrobot[studies]'")


def _read(file: Path, folder: str | None) -> tuple[Study, Path | str]:
    check_packages()
    from virtualrobot_apps.studies.stores import SCHEME
    from virtualrobot_apps.studies.study_file import read_study

    if folder is None:
        return read_study(file), file.with_suffix("")
    return read_study(file), folder if folder.startswith(SCHEME) else Path(folder)


def _found(file: Path, folder: str | None) -> tuple[Study, Path | str]:
    study, where = _read(file, folder)
    from virtualrobot_apps.studies.running import has_begun

    if not has_begun(where):
        raise WrongStateError(f"{where} has no results yet: 'virtualrobot study run {file}' begins them")
    return study, where


def _engine(workers: int | None, on: str) -> Engine:
    """Return where cells are done; raise WrongStateError where there is no such place."""
    from virtualrobot_apps.studies.engines import Here, Local

    if on == "local":
        return Here() if workers == 0 else Local(workers)
    if on != "ray" and not re.fullmatch(r"(ray://)?[^/:]+:\d+", on):
        raise click.BadParameter(
            f"local, ray, ray://HOST:PORT or HOST:PORT belongs here, not {on!r}", param_hint="'--on'"
        )
    if workers == 0:
        raise click.BadParameter("0 workers are this process: leave '--on' out", param_hint="'--workers'")
    from virtualrobot_apps.studies.ray_engine import OWN, Ray

    return Ray(OWN if on == "ray" else on, workers)


def _do(file: Path, folder: str | None, workers: int | None, on: str, resume: bool) -> None:
    if workers == 0 and "numpy" not in sys.modules:
        os.environ.update(ONE_THREAD)
    study, where = _read(file, folder)
    from virtualrobot_apps.studies.running import forget, open_job
    from virtualrobot_apps.studies.running import run as run_job
    from virtualrobot_apps.studies.stores import store_of

    job = open_job(study, where, resume)
    try:
        progress = run_job(job, _engine(workers, on), _teller())
    except KeyboardInterrupt:
        click.echo(f"ended: what is done stays; 'virtualrobot study resume {file}' goes on", err=True)
        raise
    except Exception:
        if not resume:
            forget(job)
        raise
    click.echo(f"{_BEGIN if sys.stdout.isatty() else ''}{_line(progress)}; results in {store_of(where).where('cells')}")
    if progress.unasked:
        names = " or ".join(map(repr, progress.unasked))
        click.echo(f"no cell has asked for the parameter {names}: does the function know it by this name?", err=True)
    if progress.done < progress.cells:
        click.echo(f"cancelled: 'virtualrobot study resume {file}' goes on", err=True)
        raise SystemExit(1)


def _teller() -> Callable[[Progress], None]:
    """Return what tells the progress, in one line where a terminal has it, and the first failure once."""
    last, failure = 0.0, ""

    def tell(progress: Progress) -> None:
        nonlocal last, failure
        if progress.failure and not failure:
            failure = progress.failure
            click.echo(f"first failure: {failure}", err=True)
        if sys.stdout.isatty() and time.monotonic() - last >= _TOLD_SECONDS:
            last = time.monotonic()
            click.echo(f"{_BEGIN}{_line(progress)}", nl=False)

    return tell


def _line(progress: Progress) -> str:
    said = f"{progress.done} of {progress.cells} cells, {progress.failed} failed, {progress.killed} killed"
    if progress.done == progress.cells or progress.left is None:
        return said
    low, high = map(_time, progress.left)
    return f"{said}, {low if low == high else f'{low} to {high}'} left"


def _said(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)


def _time(seconds: float) -> str:
    """Return a time for people: 40 s, 3 min, 2.5 h."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"
