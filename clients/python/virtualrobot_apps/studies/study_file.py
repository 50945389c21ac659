"""Study files: which function, over which parameters, with which results, in YAML."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from virtualrobot_apps.cell_io.yaml_file import Item, read_file
from virtualrobot_apps.studies.parameters import (
    MOST_CELLS,
    RANDOM,
    SENSITIVITY,
    SOBOL,
    Cells,
    Choice,
    Law,
    Parameter,
    Values,
    check_law,
)

NUMBER, TEXT = "number", "text"
RESERVED = ("cell", "status", "error", "seconds", "worker")
"""Columns of every table of results."""
_FIELDS = (
    *("schema_version", "function", "setup", "scene", "seed", "draws", "sampling", "block", "cell_seconds"),
    *("parameters", "results", "search", "goals"),
)
_KINDS = ("list", "grid", "range", "law")
_MOST_VALUES = 1_000_000


@dataclass(frozen=True)
class Goal:
    """Result that shall be little, with the sign 1, or great, with -1."""

    result: str
    sign: int

    @property
    def said(self) -> str:
        """Return its name, and which way is better."""
        return f"{self.result} ({'less' if self.sign > 0 else 'more'} is better)"


@dataclass(frozen=True)
class SearchFor:
    """Search for the parameters at which a result is best, or for the front of several.

    Attributes:
        goals: the results that are meant.
        population: cells of a generation, which are done at once.
        generations: their number.
    """

    goals: tuple[Goal, ...]
    population: int
    generations: int


@dataclass(frozen=True)
class Study:
    """A study as its file says it.

    Attributes:
        file: the study file; modules and the scene are looked for beside it.
        function: `module:function`, called once for each cell.
        setup: `module:function` that makes what cells share, once in each process; empty for none.
        scene: file that the setup and the cells are told.
        block: number of cells that a worker is given at once.
        cell_seconds: time (s) after which a cell that hasn't ended is killed.
        cells: what is done.
        results: kind of each result, by name.
        search: the search that chooses the parameters; None where they are all known.
        goals: two or more of which the report tells the front; empty for none.
    """

    file: Path
    function: str
    setup: str
    scene: Path | None
    block: int
    cell_seconds: float | None
    cells: Cells
    results: tuple[tuple[str, str], ...]
    search: SearchFor | None = None
    goals: tuple[Goal, ...] = ()


def read_study(file: Path) -> Study:
    """Return the study of a file.

    Raises:
        MissingFileError: when it, or its scene, is not there.
        MalformedFileError: when it says something impossible; with file, line and what would be right.
    """
    root = read_file(file)
    fields = root.fields(_FIELDS, needed=("function", "parameters", "results"))

    def whole(name: str, default: int, least: int, most: int) -> int:
        return fields[name].whole(least, most) if name in fields else default

    parameters = tuple(_parameter(name, item) for name, item in _names(fields["parameters"]).items())
    results = {name: item.one_of((NUMBER, TEXT)) for name, item in _names(fields["results"]).items()}
    for name in results:
        if name in {one.name for one in parameters}:
            raise fields["results"].error(f"{name!r} is a parameter, too; give the result another name")
    sampling = fields["sampling"].one_of((RANDOM, SOBOL, SENSITIVITY)) if "sampling" in fields else RANDOM
    goals = _goals(fields["goals"], results) if "goals" in fields else ()
    search = _search(fields["search"], parameters, results, goals) if "search" in fields else None
    if search is not None and ("draws" in fields or "sampling" in fields):
        raise fields["search"].error("a search draws by itself: leave 'draws' and 'sampling' out")
    draws = whole("draws", 1, 1, MOST_CELLS) if search is None else search.population * search.generations
    chosen = parameters if search is None else _choices(parameters)
    cells = Cells(chosen, draws, sampling, whole("seed", 0, 0, 2**64 - 1))
    if sampling != RANDOM:
        _check_sobol(cells, fields["sampling"])
    if cells.count > MOST_CELLS:
        raise root.error(f"these are {cells.count} cells, of which a study has at most {MOST_CELLS}")
    return Study(
        file=file.absolute(),
        function=_reference(fields["function"]),
        setup=_reference(fields["setup"]) if "setup" in fields else "",
        scene=_scene(file, fields["scene"]) if "scene" in fields else None,
        block=whole("block", 100, 1, 1_000_000),
        cell_seconds=fields["cell_seconds"].number(0.001, 1e6) if "cell_seconds" in fields else None,
        cells=cells,
        results=tuple(results.items()),
        search=search,
        goals=goals,
    )


def _reference(item: Item) -> str:
    text = item.text()
    if not re.fullmatch(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*", text):
        raise item.error(f"module:function belongs here, such as pick:pick, not {text!r}")
    return text


def _scene(file: Path, item: Item) -> Path:
    scene = file.absolute().parent / item.text()
    if not scene.is_file():
        raise item.error(f"there is no file {scene}")
    return scene


def _names(item: Item) -> dict[str, Item]:
    found = item.mapping("names")
    if not found:
        raise item.error("at least one belongs here")
    for name, one in found.items():
        if not re.fullmatch(r"[A-Za-z]\w*", name):
            raise one.error(f"{name!r} is no name: letters, digits and _")
        if name in RESERVED:
            raise one.error(f"{name!r} is a column that every study has; these are {', '.join(RESERVED)}")
    return found


def _parameter(name: str, item: Item) -> Parameter:
    fields = item.mapping("fields")
    kinds = [kind for kind in _KINDS if kind in fields]
    if len(kinds) != 1:
        raise item.error(f"one of {', '.join(_KINDS)} belongs here, such as {{range: [0, 1]}}")
    kind = fields[kinds[0]]
    if kinds[0] == "law":
        settings = {one: value.number() for one, value in fields.items() if one != "law"}
        try:
            check_law(kind.text(), settings)
        except ValueError as error:
            raise item.error(str(error)) from error
        return Law(name, kind.text(), tuple(settings.items()))
    item.fields(kinds)
    if kinds[0] == "range":
        ends = [one.number() for one in kind.items()]
        if len(ends) != 2 or not ends[0] < ends[1]:
            raise kind.error("two numbers belong here, the lower one first")
        return Law(name, "uniform", (("loc", ends[0]), ("scale", ends[1] - ends[0])))
    if kinds[0] == "grid":
        grid = kind.fields(("from", "to", "count"), needed=("from", "to", "count"))
        count = grid["count"].whole(2, _MOST_VALUES)
        return Values(name, tuple(map(float, np.linspace(grid["from"].number(), grid["to"].number(), count))))
    return _listed(name, kind)


def _listed(name: str, item: Item) -> Values:
    values = [one.scalar() for one in item.items()]
    texts = [isinstance(value, str) for value in values]
    if not values or any(texts) != all(texts):
        raise item.error("one or more numbers belong here, or one or more texts")
    for value, one in zip(values, item.items(), strict=True):
        if isinstance(value, bool) or not (isinstance(value, str) or math.isfinite(value)):
            raise one.error(f"a finite number or a text belongs here, not {value}")
    return Values(name, tuple(values))


def _search(
    item: Item, parameters: tuple[Parameter, ...], results: dict[str, str], goals: tuple[Goal, ...]
) -> SearchFor:
    fields = item.fields(("minimize", "maximize", "population", "generations"), needed=("generations",))
    named = [name for name in ("minimize", "maximize") if name in fields]
    if len(named) != (0 if goals else 1):
        raise item.error("'minimize' or 'maximize' belongs here, and the result that is meant; or 'goals' in the study")
    for name in named:
        result = fields[name].one_of([result for result, kind in results.items() if kind == NUMBER])
        goals = (Goal(result, 1 if name == "minimize" else -1),)
    laws = [one for one in parameters if isinstance(one, Law)]
    if any(one.law != "uniform" for one in laws):
        raise item.error("a search has ranges and lists, no laws: what is left to chance, the function draws")
    if len(parameters) == len(goals) == 1:
        raise item.error("a search has two parameters or more; one alone is a grid's")
    by_evolution = len(goals) == 1 and len(laws) == len(parameters)
    usual = 4 + int(3 * math.log(len(parameters))) if by_evolution else 40
    population = fields["population"].whole(4, 100_000) if "population" in fields else usual
    return SearchFor(goals, population, fields["generations"].whole(1, 1_000_000))


def _choices(parameters: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
    """Return the parameters of a search, which chooses among the values of lists."""
    return tuple(Choice(one.name, one.values) if isinstance(one, Values) else one for one in parameters)


def _goals(item: Item, results: dict[str, str]) -> tuple[Goal, ...]:
    found = []
    for name, one in item.mapping("results").items():
        if results.get(name) != NUMBER:
            known = ", ".join(result for result, kind in results.items() if kind == NUMBER) or "none"
            raise one.error(f"{name!r} is no result that is a number; these are {known}")
        found.append(Goal(name, 1 if one.one_of(("minimize", "maximize")) == "minimize" else -1))
    if len(found) < 2:
        raise item.error("two goals or more belong here, such as {cost: minimize, throughput: maximize}")
    return tuple(found)


def _check_sobol(cells: Cells, item: Item) -> None:
    if not cells.laws:
        raise item.error("a Sobol sequence draws parameters, and none is a range or a law")
    if cells.sampling == SENSITIVITY and len(cells.laws) < 2:
        raise item.error("of one parameter there is no share: two or more are ranges or laws")
    if cells.draws & (cells.draws - 1) or not 1 < cells.draws <= 2**30:
        near = 2 ** min(max(round(math.log2(cells.draws)), 1), 30)
        raise item.error(f"a Sobol sequence is even over a power of two: draws {near}, not {cells.draws}")
