"""Plans of studies: blocks of cells that are all known, or of a search, whose cells follow from results."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Protocol

import numpy as np

from virtualrobot_apps.studies.parameters import generator
from virtualrobot_apps.studies.parts import Parts
from virtualrobot_apps.studies.searching import strategy_of
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
        self._cells = study.cells
        blocks = [Block(*one) for one in _cut(parts.missing(), study.block)]
        order = generator(study.cells.seed, _ORDER).permutation(len(blocks))
        self._blocks = deque(blocks[one] for one in order)

    def following(self) -> Block | None:
        """Return the next block; None when all are given away."""
        if not self._blocks:
            return None
        block = self._blocks.popleft()
        if block.drawn or not self._cells.laws:
            return block
        return block._replace(drawn=tuple(self._cells.between(block.first, block.last)))

    def again(self, *blocks: Block) -> None:
        """Put blocks first."""
        self._blocks.extendleft(reversed(blocks))

    def ended(self, block: Block) -> None:
        """Do nothing: no block waits for another one."""


class Search:
    """Blocks of a search, a generation after the other; each follows from the results of those before.

    So a study that is resumed asks and tells all anew, and comes to the same.
    """

    def __init__(self, study: Study, parts: Parts) -> None:
        """Ask for the first generation."""
        assert study.search is not None
        self._study, self._parts, self._search = study, parts, study.search
        self._strategy = strategy_of(study.search, study.cells.laws, generator(study.cells.seed, _SEARCH))
        self._blocks: deque[Block] = deque()
        self._first, self._last, self._open = 0, 0, 0
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

    def _ask(self) -> None:
        """Ask for a generation, and make blocks of its cells that are missing."""
        rows = self._strategy.ask()
        self._last = self._first + len(rows)
        missing = [(max(one, self._first), min(end, self._last)) for one, end in self._parts.missing()]
        for first, end in _cut([one for one in missing if one[0] < one[1]], self._study.block):
            self._blocks.append(Block(first, end, tuple(rows[first - self._first : end - self._first])))
            self._open += end - first

    def _tell(self) -> None:
        """Tell the results of a generation, and ask for the next one."""
        goals = self._search.goals
        costs = np.stack(
            [goal.sign * self._parts.numbers(goal.result, self._first, self._last) for goal in goals], axis=1
        )
        # A cell without a result is worse than any that has one.
        worst = np.where(np.isnan(costs), -np.inf, costs).max(axis=0)
        without = np.isnan(costs).any(axis=1, keepdims=True)
        self._strategy.tell(np.where(without, np.where(np.isinf(worst), 0.0, worst) + 1.0, costs))
        self._first = self._last
        if self._first < self._study.cells.count:
            self._ask()


def _cut(missing: list[tuple[int, int]], size: int) -> Iterator[tuple[int, int]]:
    """Yield what is missing in blocks; their ends are multiples of the size."""
    for first, last in missing:
        while first < last:
            end = min(last, (first // size + 1) * size)
            yield first, end
            first = end
