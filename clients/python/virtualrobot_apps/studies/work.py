"""Work of a study: a block of cells, done in some process, whose results become one part of the study's folder.

Nothing here knows which engine runs it. A block that is done twice is there once.
"""

from __future__ import annotations

import faulthandler
import math
import numbers
import os
import platform
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from virtualrobot._wire.names import did_you_mean
from virtualrobot.errors import InvalidArgumentError, WrongStateError

from virtualrobot_apps.studies import functions
from virtualrobot_apps.studies.parameters import Value, generator
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.study_file import TEXT, Study

OK, FAILED, KILLED = "ok", "failed", "killed"
_LONGEST_ERROR = 4000


class Block(NamedTuple):
    """Cells from `first` up to but not with `last`; where these are drawn they bring their parameters, a row each.

    So no worker has to load SciPy, which takes longer than many a block.
    """

    first: int
    last: int
    drawn: tuple[Mapping[str, Value], ...] = ()

    def parameters(self, study: Study) -> Sequence[Mapping[str, Value]]:
        """Return the parameters of its cells, by name."""
        return self.drawn or study.cells.between(self.first, self.last)

    def halves(self) -> tuple[Block, Block]:
        """Return two blocks of these cells."""
        middle = (self.first + self.last) // 2
        count = middle - self.first
        return Block(self.first, middle, self.drawn[:count]), Block(middle, self.last, self.drawn[count:])


@dataclass(frozen=True)
class Job:
    """All that a worker needs to know of a study, wherever it is.

    Attributes:
        study: as its file says it.
        folder: where its results go, a path or `s3://BUCKET/FOLDER`.
        source: digest of its functions, which a worker's own must have.
        versions: of packages; the same.
    """

    study: Study
    folder: Path | str
    source: str
    versions: Mapping[str, str]


@dataclass(frozen=True)
class Done:
    """End of a block.

    Attributes:
        seconds: the time that it took.
        failed: how many cells failed.
        failure: how the first of these did.
        unasked: names of parameters that no cell has asked for.
    """

    seconds: float
    failed: int = 0
    failure: str = ""
    unasked: frozenset[str] = frozenset()


class Asked(Mapping[str, Value]):
    """Parameters of a cell by name, which note in a set those that are asked for."""

    def __init__(self, values: Mapping[str, Value], noted: set[str]) -> None:
        """Take the parameters, and where it is noted."""
        self._values, self._noted = values, noted

    def __getitem__(self, name: str) -> Value:
        """Return a parameter; raise KeyError, in words, where the study file has none of that name."""
        self._noted.add(name)
        if name not in self._values:
            raise KeyError(f"the study file has no parameter {name!r}")
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        """Return an iterator over all names."""
        return iter(self._values)

    def __len__(self) -> int:
        """Return the number of parameters."""
        return len(self._values)

    def __or__(self, other: Mapping[str, object]) -> dict[str, object]:
        """Return these with others in their place or besides."""
        return {**self, **other}


@dataclass(frozen=True)
class Cell:
    """Cell, as its function is told it.

    Attributes:
        number: from 0.
        parameters: by name, numbers or texts as the study file says.
        rng: random numbers, which depend on the study's seed and the cell's number alone.
        shared: what the study's setup has returned in this process; None without one.
        scene: the study's scene file; None without one.
    """

    number: int
    parameters: Mapping[str, Any]
    rng: np.random.Generator
    shared: Any
    scene: Path | None


def source_of(study: Study) -> str:
    """Return the digest of a study's functions; raise UnknownNameError or InvalidArgumentError as `functions` does."""
    folder = study.file.parent
    return " ".join(functions.digest(one, folder) for one in (study.function, study.setup) if one)


def prepare(job: Job) -> tuple[Callable[..., Any], Any]:
    """Return a study's function, and what its setup makes.

    Raises:
        UnknownNameError: when there is no such function.
        InvalidArgumentError: when its module, or its setup, fails.
        WrongStateError: when the function or a package is another one here than where the study was begun.
    """
    study, folder = job.study, job.study.file.parent
    if source_of(study) != job.source:
        raise WrongStateError(f"{study.function} of this worker is not that which the study was begun with")
    if (here := functions.versions()) != job.versions:
        raise WrongStateError(f"this worker has {_told(here)}, and the study was begun with {_told(job.versions)}")
    function = functions.load(study.function, folder)
    if not study.setup:
        return function, None
    setup = functions.load(study.setup, folder)
    try:
        return function, setup(study.scene)
    except Exception as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        said = f"{type(error).__name__}: {error} ({at.filename}:{at.lineno})"
        raise InvalidArgumentError(f"the setup {study.setup} fails: {said}") from error


def _told(versions: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in versions.items())


_prepared: dict[tuple[Study, Path | str, str], tuple[Callable[..., Any], Any]] = {}
"""The last study's function in this process, and what its setup has made."""


def work(job: Job, block: Block, in_worker: bool = False) -> Done:
    """Do a block and leave its part in the folder.

    Args:
        job: of which study.
        block: its cells.
        in_worker: this process may be killed: cells that take too long end it, and leave where they were.

    Raises:
        OSError: when the part can't be written.
        VirtualRobotError: as `prepare`.
    """
    study, parts = job.study, Parts(job.folder, job.study)
    key = (study, job.folder, job.source)
    if key not in _prepared:
        _prepared.clear()
        _prepared[key] = prepare(job)
    function, shared = _prepared[key]
    begin, rows, failure, asked = time.perf_counter(), [], "", set[str]()
    with _watched(parts.trace(block.first, block.last), study.cell_seconds if in_worker else None, in_worker) as watch:
        for number, parameters in zip(range(block.first, block.last), block.parameters(study), strict=True):
            cell = Cell(number, Asked(parameters, asked), generator(study.cells.seed, number), shared, study.scene)
            watch()
            begun = time.perf_counter()
            try:
                results, status, error = _checked(function(cell), study), OK, ""
            except (Exception, SystemExit) as raised:
                if not study.setup and "NoneType" in str(raised):
                    raised.add_note("perhaps for want of a setup: without one in the study file, cell.shared is None")
                results, status, error = {}, FAILED, _trace(raised)
                failure = failure or f"cell {number}: {error.strip().splitlines()[-1]}"
            seconds = time.perf_counter() - begun
            rows.append(row(number, parameters, results, status, error, seconds))
    failed = sum(one["status"] != OK for one in rows)
    parts.write(rows)
    unasked = frozenset(one.name for one in study.cells.parameters) - asked
    return Done(time.perf_counter() - begin, failed, failure, unasked)


def row(
    number: int,
    parameters: Mapping[str, Value],
    results: Mapping[str, float | str | None],
    status: str,
    error: str,
    seconds: float,
) -> dict[str, Any]:
    """Return the row of a cell in the table of results."""
    worker = f"{platform.node()}:{os.getpid()}"
    about = {"cell": number, "status": status, "error": error, "seconds": seconds, "worker": worker}
    return about | dict(parameters) | dict(results)


@contextmanager
def _watched(trace: Path, seconds: float | None, in_worker: bool) -> Iterator[Callable[[], None]]:
    """Give a function to call as a cell begins: a process that crashes or hangs in it leaves where it was."""
    if not in_worker:
        yield lambda: None
        return
    with trace.open("w") as file:
        faulthandler.enable(file)
        try:
            if seconds is None:
                yield lambda: None
            else:
                limit = seconds
                yield lambda: faulthandler.dump_traceback_later(limit, file=file, exit=True)
        finally:
            faulthandler.cancel_dump_traceback_later()
            faulthandler.disable()
    trace.unlink(missing_ok=True)


def _checked(results: object, study: Study) -> dict[str, float | str | None]:
    """Return a cell's results; raise ValueError, in words, for what the study file doesn't say."""
    kinds = dict(study.results)
    if not isinstance(results, Mapping):
        raise ValueError(f"the function returns a mapping of results ({', '.join(kinds)}), not {results!r}")
    for name in results:
        if name not in kinds:
            raise ValueError(f"the study file has no result {name!r}{did_you_mean(str(name), kinds)}")
    return {name: _value(name, kind, results) for name, kind in kinds.items()}


def _value(name: str, kind: str, results: Mapping[str, Any]) -> float | str | None:
    if name not in results:
        raise ValueError(f"the result {name!r} is missing; None stands for one that there is not")
    value = results[name]
    if value is None:
        return None
    if kind == TEXT:
        if not isinstance(value, str):
            raise ValueError(f"the result {name!r} is a text, not {value!r}")
        return value
    if not isinstance(value, numbers.Real | np.bool_):
        raise ValueError(f"the result {name!r} is a number, not {value!r}")
    if not math.isfinite(number := float(value)):
        raise ValueError(f"the result {name!r} is {number}: a finite number belongs there, or None")
    return number


def _trace(error: BaseException) -> str:
    return "".join(traceback.format_exception(error))[-_LONGEST_ERROR:]
