"""Plans of studies: blocks of cells that are all known, or of a search, whose cells follow from results."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Protocol

import numpy as np

from virtualrobot_apps.studies.parameters import Floats, Law, Value, generator
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.study_file import Study
from virtualrobot_apps.studies.work import Block

_ORDER = 2**64 - 1
"""Number in the place of a cell's, by which the order of blocks is drawn; no cell has it."""
_SEARCH = 2**64 - 2
"""The same for a search."""


class Plan(Protocol):
    """Blocks that are left."""

    def following(self) -> Block | None:
        """Return the next block; None while there is none."""
        ...

    def again(self, *blocks: Block) -> None:
        """Put blocks first."""
        ...

    def ended(self, block: Block) -> None:
        """Note that the cells of a block are in the study's parts."""
        ...


def plan_of(study: Study, parts: Parts) -> Plan:
    """Return the plan of what a study has not done yet."""
    return Known(study, parts) if study.search is None else Search(study, parts)


class Known:
    """All blocks that are missing, in an order that is drawn: the first ones speak for all."""

    def __init__(self, study: Study, parts: Parts) -> None:
        """Look for what is missing."""
        blocks = [Block(*one) for one in _cut(parts.missing(), study.block)]
        order = generator(study.cells.seed, _ORDER).permutation(len(blocks))
        self._blocks = deque(blocks[one] for one in order)

    def following(self) -> Block | None:
        """Return the next block; None when all are given away."""
        return self._blocks.popleft() if self._blocks else None

    def again(self, *blocks: Block) -> None:
        """Put blocks first."""
        self._blocks.extendleft(reversed(blocks))

    def ended(self, block: Block) -> None:
        """Do nothing: no block waits for another one."""


class Search:
    """Blocks of a search by CMA-ES, a generation after the other; each follows from the results of those before.

    So a study that is resumed asks and tells all anew, and comes to the same. What it draws is a point of the unit
    cube, whose sides are the parameters' ranges. A search that has converged begins again at a place that is drawn.
    Nikolaus Hansen, "The CMA evolution strategy: a tutorial", 2016.
    """

    def __init__(self, study: Study, parts: Parts) -> None:
        """Ask for the first generation."""
        assert study.search is not None
        self._study, self._parts, self._search = study, parts, study.search
        self._rng = generator(study.cells.seed, _SEARCH)
        self._strategy = self._begun(np.full(len(study.cells.laws), 0.5))
        self._blocks: deque[Block] = deque()
        self._first, self._open, self._points = 0, 0, list[Floats]()
        self._ask()

    def following(self) -> Block | None:
        """Return the next block; None while the generation isn't complete, and after the last."""
        while not self._blocks and not self._open and self._first < self._study.cells.count:
            self._tell()
        return self._blocks.popleft() if self._blocks else None

    def again(self, *blocks: Block) -> None:
        """Put blocks first."""
        self._blocks.extendleft(reversed(blocks))

    def ended(self, block: Block) -> None:
        """Note that cells are done: when those of a generation are, the next one is asked for."""
        self._open -= block.last - block.first

    def _begun(self, start: Floats):  # noqa: ANN202 (cma has no types)
        import cma

        options = {"bounds": [0.0, 1.0], "popsize": self._search.population, "verbose": -9, "seed": np.nan}
        # Its own random numbers, so that those of NumPy stay as functions find them.
        options["randn"] = lambda *shape: self._rng.standard_normal(shape)
        return cma.CMAEvolutionStrategy(start, 0.25, options)

    def _ask(self) -> None:
        """Draw a generation, and make blocks of its cells that are missing."""
        self._points = [np.clip(point, 0.0, 1.0) for point in self._strategy.ask()]
        rows = [_parameters(self._study.cells.laws, point) for point in self._points]
        last = self._first + len(rows)
        missing = [(max(one, self._first), min(end, last)) for one, end in self._parts.missing()]
        for first, end in _cut([one for one in missing if one[0] < one[1]], self._study.block):
            self._blocks.append(Block(first, end, tuple(rows[first - self._first : end - self._first])))
            self._open += end - first

    def _tell(self) -> None:
        """Tell the results of a generation, and ask for the next one."""
        last = self._first + len(self._points)
        costs = self._search.sign * self._parts.numbers(self._search.result, self._first, last)
        there = costs[~np.isnan(costs)]
        # A cell without a result is worse than any that has one.
        costs = np.where(np.isnan(costs), (there.max() if len(there) else 0.0) + 1.0, costs)
        self._strategy.tell(self._points, list(costs))
        if self._strategy.stop():
            self._strategy = self._begun(self._rng.uniform(size=len(self._study.cells.laws)))
        self._first = last
        if self._first < self._study.cells.count:
            self._ask()


def _parameters(laws: list[Law], point: Floats) -> dict[str, Value]:
    return {law.name: law.quantiles(point[one : one + 1])[0] for one, law in enumerate(laws)}


def _cut(missing: list[tuple[int, int]], size: int) -> Iterator[tuple[int, int]]:
    """Yield what is missing in blocks; their ends are multiples of the size."""
    for first, last in missing:
        while first < last:
            end = min(last, (first // size + 1) * size)
            yield first, end
            first = end
