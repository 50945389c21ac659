"""Mazes on a map of squares, by a seed, and the right-hand rule on the map.

A maze of n x n cells is a map of (2n + 1) x (2n + 1) squares: cells at odd places, between them passages, and walls
that are as thick as cells are wide. Row 0 is at the bottom, column 0 on the left.
"""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Square = tuple[int, int]
"""Row and column."""

DIRECTIONS: tuple[Square, ...] = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""East, north, west, south: each is the one before, turned to the left."""
LARGEST = 50
"""Most cells along a side."""


@dataclass(frozen=True, eq=False)
class Maze:
    """A maze: `walls` (rows, columns) is true where a wall is; the exit is a gap in the outer wall, the last square."""

    walls: NDArray[np.bool_]
    start: Square
    exit: Square
    seed: int

    @property
    def size(self) -> int:
        """Return the number of cells along a side."""
        return (len(self.walls) - 1) // 2

    def is_free(self, square: Square) -> bool:
        """Return whether a square is no wall; what is outside of the map is free."""
        return not (self._is_inside(square) and self.walls[square])

    def blocks(self) -> Iterator[tuple[int, int, int, int]]:
        """Yield boxes of walls that cover each wall square once: bottom, top, left and right, the ends not included."""
        left = self.walls.copy()
        for row, column in np.argwhere(self.walls).tolist():
            if not left[row, column]:
                continue
            right = column
            while right < left.shape[1] and left[row, right]:
                right += 1
            top = row + 1
            # A wall that goes on upwards alone is one box, too.
            while right == column + 1 and top < left.shape[0] and left[top, column] and not _beside(left, top, column):
                top += 1
            left[row:top, column:right] = False
            yield row, top, column, right

    def shortest(self) -> int:
        """Return how many squares it is to the exit at least."""
        ways, waiting = {self.start: 0}, deque([self.start])
        while waiting:
            square = waiting.popleft()
            if square == self.exit:
                return ways[square]
            for step in DIRECTIONS:
                beside = (square[0] + step[0], square[1] + step[1])
                if self._is_inside(beside) and self.is_free(beside) and beside not in ways:
                    ways[beside] = ways[square] + 1
                    waiting.append(beside)
        raise ValueError("the maze has no way to its exit")

    def _is_inside(self, square: Square) -> bool:
        return 0 <= square[0] < self.walls.shape[0] and 0 <= square[1] < self.walls.shape[1]


def _beside(walls: NDArray[np.bool_], row: int, column: int) -> bool:
    return bool(walls[row, max(0, column - 1) : column + 2].sum() > 1)


def generated(size: int, seed: int = 0, loops: int = 0) -> Maze:
    """Return a maze of size x size cells, by depth-first search: one way between any two cells, and `loops` ways more.

    It starts at the lower left cell; the exit is above the upper right one. Raises ValueError for a size or a number of
    loops that there is not.
    """
    if not 2 <= size <= LARGEST:
        raise ValueError(f"a maze has 2 to {LARGEST} cells along a side, not {size}")
    if not 0 <= loops <= (size - 1) ** 2:
        raise ValueError(f"a maze of {size} x {size} cells has 0 to {(size - 1) ** 2} loops, not {loops}")
    drawn = random.Random(seed)
    walls = np.ones((2 * size + 1, 2 * size + 1), dtype=np.bool_)
    walls[1, 1] = False
    way: list[Square] = [(1, 1)]
    while way:
        row, column = way[-1]
        closed = [
            (row + step[0], column + step[1])
            for step in DIRECTIONS
            if 0 < row + 2 * step[0] < 2 * size
            and 0 < column + 2 * step[1] < 2 * size
            and walls[row + 2 * step[0], column + 2 * step[1]]
        ]
        if not closed:
            way.pop()
            continue
        between = closed[drawn.randrange(len(closed))]
        cell = (2 * between[0] - row, 2 * between[1] - column)
        walls[between] = walls[cell] = False
        way.append(cell)
    inner = [(r, c) for r in range(1, 2 * size) for c in range(1, 2 * size) if (r + c) % 2 and walls[r, c]]
    for _ in range(loops):
        walls[inner.pop(drawn.randrange(len(inner)))] = False
    walls[2 * size, 2 * size - 1] = False
    return Maze(walls, (1, 1), (2 * size, 2 * size - 1), seed)


def right_hand(maze: Maze) -> list[Square]:
    """Return the squares that the right-hand rule passes from the start, headed east, to the exit, both among them.

    Raises ValueError where it comes back to where it began, headed as it was then: it would go on so for ever.
    """
    square, heading = maze.start, 0
    path, seen = [square], set()
    while square != maze.exit:
        if (square, heading) in seen:
            raise ValueError("the right-hand rule goes round in this maze")
        seen.add((square, heading))
        for turn in (-1, 0, 1, 2):
            step = DIRECTIONS[(heading + turn) % 4]
            ahead = (square[0] + step[0], square[1] + step[1])
            if maze.is_free(ahead):
                heading = (heading + turn) % 4
                square = ahead
                break
        path.append(square)
    return path
