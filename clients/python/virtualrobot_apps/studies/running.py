"""Running of a study: its folder is made or found again, what is missing is done, and what kills workers is named."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from virtualrobot.errors import MalformedFileError, WrongStateError

from virtualrobot_apps.studies import functions
from virtualrobot_apps.studies.engines import Engine, Lost
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.plans import plan_of
from virtualrobot_apps.studies.stores import Store, store_of
from virtualrobot_apps.studies.study_file import Study
from virtualrobot_apps.studies.work import KILLED, Block, Done, Job, prepare, row, source_of

ATTEMPTS = 3
"""Deaths of workers in one cell after which it is named as the cause."""
_MOST_DEATHS = 40
"""Deaths of workers without a single block that was done, or in a row before a cell, after which it isn't cells."""
_LEAST_BLOCKS = 3
STAMP, PROGRESS, CANCEL = "study.json", "progress.json", "cancel"
"""Files beside the cells: what they have in common, what is left, and that somebody wants it to end."""
_TOLD_SECONDS = 1.0


@dataclass(frozen=True)
class Progress:
    """Cells of a study that are done, and what is left.

    Attributes:
        cells: number of all cells.
        done: how many of these are done, with those that failed.
        failed: how many have raised an error.
        killed: how many have killed their workers.
        left: time (s) until it is done, from and to; None as long as nothing can be said.
        failure: the first error of this run, in a line.
        unasked: parameters that no cell of this run has asked for, in the order of the file; none where all failed.
    """

    cells: int
    done: int
    failed: int
    killed: int
    left: tuple[float, float] | None = None
    failure: str = ""
    unasked: tuple[str, ...] = ()


class Pace:
    """Remaining time, by the blocks that this run has done: they are drawn from all, so they speak for the rest."""

    def __init__(self, workers: int) -> None:
        """Begin; `workers` is how many blocks are done at once."""
        self._workers = workers
        self._cells: list[int] = []
        self._seconds: list[float] = []

    def add(self, cells: int, seconds: float) -> None:
        """Count a block: its cells, and the time (s) that it took."""
        self._cells.append(cells)
        self._seconds.append(seconds)

    @property
    def blocks(self) -> int:
        """Number of blocks that were counted."""
        return len(self._cells)

    def left(self, cells: int) -> tuple[float, float] | None:
        """Return the time (s) for so many cells, from and to; None before three blocks are done.

        It is the prediction interval, of two standard deviations, for a sum of n blocks by the mean of k others:
        n m +- 2 s sqrt(n + n^2/k).
        """
        k = self.blocks
        if cells == 0:
            return 0.0, 0.0
        if k < _LEAST_BLOCKS:
            return None
        each = [seconds / count for seconds, count in zip(self._seconds, self._cells, strict=True)]
        mean = sum(self._seconds) / sum(self._cells)
        deviation = math.sqrt(sum((one - mean) ** 2 for one in each) / (k - 1))
        size = sum(self._cells) / k
        n = cells / size
        off = 2.0 * deviation * size * math.sqrt(n + n * n / k)
        at_once = min(self._workers, max(n, 1.0))
        return max(0.0, cells * mean - off) / at_once, (cells * mean + off) / at_once


def has_begun(place: Path | str) -> bool:
    """Return whether a folder (a path or `s3://BUCKET/FOLDER`) has results of a study.

    Raises:
        WrongStateError: when it can't be read.
    """
    try:
        return store_of(place).has(STAMP)
    except OSError as error:
        raise WrongStateError(f"{place} cannot be read: {error.strerror or error}") from error


def open_job(study: Study, folder: Path | str, resume: bool) -> Job:
    """Return the job of a study whose folder (a path or `s3://BUCKET/FOLDER`) is made, or found again as this study's.

    Raises:
        WrongStateError: when the folder can't be written, has results already (run) or none (resume), or those of
            another study, function, scene or version.
        VirtualRobotError: when the function isn't there, or fails as it is imported.
    """
    parts = Parts(folder, study)
    job = Job(study, folder, source_of(study), functions.versions())
    begun = has_begun(folder)
    if resume and not begun:
        raise WrongStateError(f"{folder} has no results to go on from: 'virtualrobot study run' begins them")
    if begun and not resume:
        done = parts.counts().done
        raise WrongStateError(
            f"{folder} has {done} of {study.cells.count} cells already: 'virtualrobot study resume' goes on with them, "
            "--folder begins elsewhere"
        )
    if begun:
        _check_same(_marks(job), parts.store, folder)
    try:
        parts.make()
        if not begun:
            parts.store.write(STAMP, _written(_marks(job)))
        parts.store.remove(CANCEL)
    except OSError as error:
        raise WrongStateError(f"{folder} cannot be written: {error.strerror or error}") from error
    return job


def forget(job: Job) -> None:
    """Take back what `open_job` has begun, unless cells are done: what was wrong may be mended, and it begins anew."""
    parts = Parts(job.folder, job.study)
    with suppress(OSError):  # which the run has told of
        if not parts.counts().done:
            parts.store.remove(STAMP)


def run(job: Job, engine: Engine, tell: Callable[[Progress], None] = lambda progress: None) -> Progress:
    """Do all cells that are missing, unless somebody cancels it, and return how far it is then.

    Blocks go in an order that is drawn, so that the first results, and their times, speak for all. A block whose worker
    dies is halved until one cell is left; one in which ATTEMPTS workers die is kept as killed, with how. A worker that
    dies before it comes to a cell, as on a node that lacks something, is none of the cells' fault.

    Raises:
        WrongStateError: when results can't be written, a worker has other versions, or all workers die; what is done
            stays.
        VirtualRobotError: when the function or its setup is at fault.
    """
    study, parts = job.study, Parts(job.folder, job.study)
    plan = plan_of(study, parts)
    pace, deaths, lost, idle, told = Pace(engine.workers), Counter[int](), 0, 0, 0.0
    progress, names = Progress(study.cells.count, *parts.counts()), [one.name for one in study.cells.parameters]
    unasked: list[str] | None = None

    def following() -> Block | None:
        return None if parts.store.has(CANCEL) else plan.following()

    try:
        if progress.done < progress.cells:
            _check_function(job)
        with closing(engine.run(job, following)) as ended:
            for block, answer in ended:
                count = block.last - block.first
                has_begun = _has_begun(job, parts, block)
                if isinstance(answer, Lost):
                    lost, idle = lost + 1, 0 if has_begun else idle + 1
                    if idle >= _MOST_DEATHS:
                        raise WrongStateError(f"{idle} workers in a row died before they came to a cell: {answer.how}")
                    if lost >= _MOST_DEATHS and not pace.blocks:
                        raise WrongStateError(f"{lost} workers died, and none has done anything: {answer.how}")
                if isinstance(answer, Done):
                    idle = 0
                    pace.add(count, answer.seconds)
                    plan.ended(block)
                    if answer.failed < count:  # the others have asked for what they need
                        unasked = [name for name in (names if unasked is None else unasked) if name in answer.unasked]
                    progress = replace(
                        progress,
                        done=progress.done + count,
                        failed=progress.failed + answer.failed,
                        failure=progress.failure or answer.failure,
                    )
                elif not has_begun:
                    plan.again(block)
                elif count > 1:
                    plan.again(*block.halves())
                else:
                    deaths[block.first] += 1
                    if deaths[block.first] < ATTEMPTS:
                        parts.trace(block.first, block.last).unlink(missing_ok=True)
                        plan.again(block)
                    else:
                        parts.write([_killed(job, parts, block, answer)])
                        plan.ended(block)
                        failure = (
                            progress.failure or f"cell {block.first} killed its worker {ATTEMPTS} times: {answer.how}"
                        )
                        progress = replace(
                            progress, done=progress.done + 1, killed=progress.killed + 1, failure=failure
                        )
                progress = replace(progress, left=pace.left(progress.cells - progress.done))
                if time.monotonic() - told >= _TOLD_SECONDS:
                    told = time.monotonic()
                    parts.store.write(PROGRESS, _written({"at": time.time(), "left": progress.left}))
                tell(progress)
    except OSError as error:
        said = error.strerror or error
        raise WrongStateError(
            f"{job.folder} cannot be written: {said}; what is done stays, and 'virtualrobot study resume' goes on"
        ) from error
    return replace(progress, unasked=tuple(unasked or ()))


def _check_function(job: Job) -> None:
    """Look for the function before workers start: what is wrong is told at once. The setup is theirs to call."""
    prepare(replace(job, study=replace(job.study, setup=""), source=source_of(replace(job.study, setup=""))))


def _has_begun(job: Job, parts: Parts, block: Block) -> bool:
    """Return whether a worker that died has come to a cell of a block: who did left a trace, here or beside a bucket.

    Of what is in a bucket the trace may be on another machine: there it is taken for granted.
    """
    return not isinstance(job.folder, Path) or parts.trace(block.first, block.last).is_file()


def _killed(job: Job, parts: Parts, block: Block, lost: Lost) -> dict[str, Any]:
    trace = parts.trace(block.first, block.last)
    where = trace.read_text("utf-8", "replace") if trace.is_file() else ""
    limit = job.study.cell_seconds
    limited = f", or took longer than {limit:g} s" if limit is not None else ""
    error = f"the cell killed its worker {ATTEMPTS} times{limited}: {lost.how}\n{where}".strip()
    (parameters,) = block.parameters(job.study)
    return row(block.first, parameters, {}, KILLED, error, 0.0)


def _marks(job: Job) -> dict[str, Any]:
    """Return what all cells of a folder have in common; the block and the time of a cell may change."""
    study = job.study
    scene = hashlib.sha256(study.scene.read_bytes()).hexdigest() if study.scene is not None else ""
    marks = {
        "function": study.function,
        "setup": study.setup,
        "source": job.source,
        "scene": scene,
        "seed": study.cells.seed,
        "draws": study.cells.draws,
        "sampling": study.cells.sampling,
        "search": None if study.search is None else asdict(study.search),
        "parameters": [asdict(one) for one in study.cells.parameters],
        "results": study.results,
        "versions": dict(job.versions),
    }
    return json.loads(json.dumps(marks))


def _check_same(marks: dict[str, Any], store: Store, folder: Path | str) -> None:
    try:
        begun = json.loads(store.read(STAMP))
        changed = [name for name in marks if begun[name] != marks[name]]
    except (ValueError, KeyError, TypeError) as error:
        raise MalformedFileError(f"{store.where(STAMP)} is damaged: {error!r}") from error
    if not changed:
        return
    name = changed[0]
    what = {
        "source": f"the source of {marks['function']} has changed",
        "scene": "the scene file has changed",
        "parameters": "the parameters of the study file have changed",
        "results": "the results of the study file have changed",
        "search": "the search of the study file has changed",
    }.get(name, f"{name} was {_worded(begun[name])} and is {_worded(marks[name])}")
    raise WrongStateError(
        f"{what} since the first cells in {folder}, which new ones would not fit; undo that, or take another --folder"
    )


def _worded(value: object) -> str:
    return ", ".join(f"{name} {one}" for name, one in value.items()) if isinstance(value, dict) else repr(value)


def _written(document: object) -> bytes:
    return json.dumps(document, indent=1).encode()
