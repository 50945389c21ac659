"""Ways over a map: the cheapest one for a footprint, cost rising towards obstacles, by A* (pyastar2d).

P. E. Hart, N. J. Nilsson, B. Raphael, A Formal Basis for the Heuristic Determination of Minimum Cost Paths, 1968.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pyastar2d
from numpy.typing import NDArray

from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.regions import Distances, parts, ways_from

SHY, STEEPNESS = 20.0, 0.12
"""Cost of a cell beside an obstacle above that of a free one, and the distance (m) over which it falls by e."""
MARGIN = 0.03
"""Distance (m) that a way keeps from obstacles beside the footprint's inner radius."""
TURNING, FREELY = 0.06, 0.15
"""Distances (m) beyond its outer radius at which a vehicle can turn, and at which it does so freely."""
SPACING = 0.05
"""Distance (m) between points of a way."""
STRIDE, SPAN, SAMPLES = 3, 30, 128
"""Cells from one point to the next of those that lines are laid between, their most, and places looked at on each.

The longest line goes across 90 cells, so that it passes 127.
"""


class NoWayError(ValueError):
    """Raised where there is no way, with what stands against it."""


class GoalTakenError(NoWayError):
    """Raised where something stands on the goal, or too near to it."""


@dataclass(frozen=True, slots=True, eq=False)
class Costmap:
    """Map for a footprint: `grid` with obstacles besides, `blocked` and `known` (rows, columns).

    clearance: (rows, columns) distance of each cell's middle to the edge of what is blocked or unknown (m).
    """

    grid: Grid
    footprint: Footprint
    blocked: NDArray[np.bool_]
    known: NDArray[np.bool_]
    clearance: NDArray[np.float32]

    @classmethod
    def of(cls, grid: Grid, footprint: Footprint, seen: Floats, distances: Distances | None = None) -> Costmap:
        """Return the costmap of a grid with points (n, 2) besides that were seen (m).

        `distances` keeps those to what the grid has from one costmap to the next.
        """
        blocked, free = grid.occupied, grid.free
        rows, columns = grid.cells(seen[grid.has(seen)])
        blocked[rows, columns] = True
        away = (distances or Distances()).of(~free, rows, columns)
        away *= grid.resolution
        away -= 0.5 * grid.resolution
        return cls(grid, footprint, blocked, free | blocked, np.maximum(away, 0.0, out=away))


class Planner:
    """Plans on one costmap."""

    def __init__(self, costmap: Costmap) -> None:
        """Plan ways over a costmap."""
        self.costmap = costmap
        self.clearance = costmap.clearance
        self._least = costmap.footprint.inner + MARGIN

    @cached_property
    def _costs(self) -> NDArray[np.float32]:
        away = self.clearance - self._least
        costs = 1.0 + SHY * np.exp(-np.maximum(away, 0.0) / STEEPNESS)
        return np.where(away < 0.0, np.inf, costs).astype(np.float32)

    def way(self, start: Floats, goal: Floats) -> Floats:
        """Return the cheapest way (n, 2) from a place to another (2,), points SPACING apart.

        Raises:
            NoWayError: when the goal is off the map, unknown, too near an obstacle or cut off, with numbers.
        """
        where = self.check_goal(goal)
        first, last = self._cell(start), self._cell(goal)
        costs = self._costs
        if not math.isfinite(costs[first]):  # it stands nearer to something than ways go: out of it by the nearest cell
            first = self._nearest_free(first)
        cells = pyastar2d.astar_path(costs, first, last, allow_diagonal=True)
        if cells is None:
            raise NoWayError(self._too_narrow(first, last, where))
        points = self.costmap.grid.middles(cells[:, 0], cells[:, 1])
        points = np.vstack(
            [np.asarray(start, np.float64)[None, :2], points[1:-1], np.asarray(goal, np.float64)[None, :2]]
        )
        return spaced(smooth(spaced(self._pulled(points))))

    def cost(self, way: Floats) -> float:
        """Return the cost of a way (n, 2), in meters of one far from obstacles; inf where it leads through some."""
        rows, columns = self.costmap.grid.cells(way[1:])
        height, width = self.clearance.shape
        costs = self._costs[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
        return float(np.hypot(*np.diff(way, axis=0).T) @ costs)

    def check_goal(self, goal: Floats) -> str:
        """Return a goal (2,) in words; raise NoWayError where it is off the map, unknown, or too near an obstacle."""
        need, where = self._least, f"({goal[0]:.2f}, {goal[1]:.2f})"
        if not self.costmap.grid.has(np.asarray(goal)[None])[0]:
            raise NoWayError(f"the goal {where} is off the map")
        cell = self._cell(goal)
        if self.costmap.blocked[cell]:
            raise GoalTakenError(f"the goal {where} is inside an obstacle")
        if not self.costmap.known[cell]:
            raise NoWayError(f"the goal {where} is where nothing has been seen")
        if self.clearance[cell] < need:
            raise GoalTakenError(
                f"the goal {where} is {self.clearance[cell]:.2f} m from an obstacle, and the footprint needs "
                f"{need:.2f} m"
            )
        return where

    def reached(self, start: Floats) -> NDArray[np.bool_]:
        """Return which cells a way from a place (2,) can lead to, (rows, columns)."""
        labels, _ = parts(np.isfinite(self._costs))
        first = self._cell(start)
        if not labels[first]:
            first = self._nearest_free(first)
        return labels == labels[first] if labels[first] else np.zeros_like(labels, bool)

    def out(self, start: Floats) -> Floats | None:
        """Return the way (n, 2) from a place (2,) to the nearest other one where the footprint can turn, if any."""
        try:
            reached = self.reached(start)
        except NoWayError:
            return None
        row, column = self._cell(start)
        ways = ways_from(reached, row, column) * self.costmap.grid.resolution
        for room in (FREELY, TURNING):
            roomy = (self.clearance > self.costmap.footprint.outer + room) & (ways > 2.0 * SPACING)
            away = np.where(roomy, ways, np.inf)
            at = np.unravel_index(int(np.argmin(away)), away.shape)
            if np.isfinite(away[at]):
                return self.way(start, self.costmap.grid.middles(np.array(at[0]), np.array(at[1])))
        return None

    def _pulled(self, points: Floats) -> Floats:
        """Return those points of a way between which straight lines cost least: A* counts a diagonal step as one."""
        points = np.vstack([points[:-1:STRIDE], points[-1:]])
        grid, count = self.costmap.grid, len(points)
        best, before = np.full(count, np.inf), np.zeros(count, int)
        best[0] = 0.0
        marks = np.linspace(0.0, 1.0, SAMPLES)[:, None]
        x, y = np.ascontiguousarray(((points - grid.origin) / grid.resolution).T)  # in cells
        by_place, width = self._costs.ravel(), np.int32(self._costs.shape[1])
        for first in range(count - 1):
            at = slice(first + 1, first + 1 + SPAN)
            cells = (y[first] + marks * (y[at] - y[first])).astype(np.int32) * width
            cells += (x[first] + marks * (x[at] - x[first])).astype(np.int32)
            costs = by_place.take(cells)
            # What begins or ends nearer to something than ways go is as dear as can be, and no bar.
            costs[0] = np.minimum(costs[0], 1.0 + SHY)
            lengths = np.hypot(*(points[at] - points[first]).T)
            total = best[first] + lengths * costs.mean(axis=0)
            if not math.isfinite(total[0]):
                total[0] = best[first] + lengths[0] * (1.0 + SHY)
            before[at] = np.where(total < best[at], first, before[at])
            best[at] = np.minimum(best[at], total)
        chosen = [count - 1]
        while chosen[-1]:
            chosen.append(int(before[chosen[-1]]))
        return points[chosen[::-1]]

    def _cell(self, place: Floats) -> tuple[int, int]:
        rows, columns = self.costmap.grid.cells(np.asarray(place, np.float64)[None, :2])
        height, width = self.clearance.shape
        return min(max(int(rows[0]), 0), height - 1), min(max(int(columns[0]), 0), width - 1)

    def _nearest_free(self, cell: tuple[int, int]) -> tuple[int, int]:
        rows, columns = np.nonzero(np.isfinite(self._costs))
        if not len(rows):
            raise NoWayError("there is no free place on the map for this footprint")
        nearest = np.argmin((rows - cell[0]) ** 2 + (columns - cell[1]) ** 2)
        return int(rows[nearest]), int(columns[nearest])

    def _too_narrow(self, first: tuple[int, int], last: tuple[int, int], where: str) -> str:
        """Return in words how wide the widest way to a place is."""
        low, high = 0.0, min(float(self.clearance[first]), float(self.clearance[last]))
        if not self._joined(first, last, 1e-6):
            return f"nothing that was seen as free leads to the goal {where}"
        for _ in range(12):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._joined(first, last, middle) else (low, middle)
        return (
            f"the widest passage to the goal {where} is {2.0 * low:.2f} m, and the footprint needs "
            f"{2.0 * self._least:.2f} m"
        )

    def _joined(self, first: tuple[int, int], last: tuple[int, int], radius: float) -> bool:
        labels, _ = parts(self.clearance >= radius)
        return bool(labels[first] and labels[first] == labels[last])


def smooth(points: Floats, rounds: int = 4) -> Floats:
    """Return a way (n, 2) whose inner points lie between their neighbours: the stairs of cells are gone."""
    points = points.copy()
    for _ in range(rounds):
        points[1:-1] = 0.25 * points[:-2] + 0.5 * points[1:-1] + 0.25 * points[2:]
    return points


def spaced(points: Floats) -> Floats:
    """Return points of a way (n, 2) SPACING apart, with its ends."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(2, int(np.ceil(along[-1] / SPACING)) + 1)
    marks = np.linspace(0.0, along[-1], count)
    return np.column_stack([np.interp(marks, along, points[:, column]) for column in (0, 1)])


def length(way: Floats) -> float:
    """Return the length (m) of a way (n, 2)."""
    return float(np.hypot(*np.diff(way, axis=0).T).sum())
