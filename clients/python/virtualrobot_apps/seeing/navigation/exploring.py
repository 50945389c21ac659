"""Exploration: the vehicle looks at the edges of what it knows until all are seen, or left for a reason that it says.

B. Yamauchi, A Frontier-Based Approach for Autonomous Exploration, IEEE CIRA 1997; an edge is judged from places that
see it and that can be come to, and the way to these is measured around walls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.mapping import Mapper
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator
from virtualrobot_apps.seeing.navigation.planning import FREELY, TURNING, Costmap, NoWayError, Planner
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.regions import Mask, parts, ways_from, widened
from virtualrobot_apps.seeing.navigation.sight import SILENT_SECONDS

SMALLEST = 0.35
"""Length (m) from which on an edge of the known is looked at."""
PIECE, LEAST_PIECE = 1.0, 0.15
"""Edge (m) of the squares into which long edges fall, and length of a piece from which on it is looked at."""
SIGHT = 0.85
"""Part of the lidar's reach from which an edge is looked at."""
LOOKS, OTHER_PLACE = 3, 0.3
"""Number of looks at one edge that change nothing after which it is left, and how far apart their places are (m)."""
GAIN, AWAY = 0.5, 0.3
"""Meters of way that a meter of an edge makes up for, and those that a meter from a place to the edge counts for."""
TIGHT = 0.5
"""Meters of way that a place counts for where it can just turn."""
CHECKED = 10
"""Periods from one check to the next of how much of an edge is seen."""
_TARGETS, _RAYS = 12, 240


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """Edge of the known: middles (n, 2) of its free cells and, beside these, of unknown ones (m, 2), in meters."""

    cells: Floats
    beyond: Floats
    length: float

    def __str__(self) -> str:
        """Return it in words."""
        middle = self.cells[np.argmin(np.hypot(*(self.cells - self.cells.mean(axis=0)).T))]
        return f"an edge of {self.length:.1f} m at ({middle[0]:.2f}, {middle[1]:.2f})"


@dataclass(frozen=True, slots=True, eq=False)
class Unseen:
    """Edge that stays unseen, and why."""

    edge: Edge
    why: str

    def __str__(self) -> str:
        """Return it in words."""
        return f"leaves {self.edge} unseen: {self.why}"


@dataclass(frozen=True, slots=True, eq=False)
class _Look:
    """Look at an edge from a place (2,); `end` is what the way there came to, None where it has led there."""

    edge: Edge
    place: Floats
    end: str | None


class Explorer:
    """Chooses where to look next, and tells what is left unseen."""

    def __init__(self, navigator: Navigator, mapper: Mapper, reach: float) -> None:
        """Explore with a navigator whose places a mapper tells, by a lidar that sees so far (m)."""
        self.navigator, self._mapper, self._sight = navigator, mapper, SIGHT * reach
        self.unseen: list[Unseen] = []
        """Edges that stay, once there is no place left to look from."""
        self._looks: list[_Look] = []
        self._edge: Edge | None = None

    def run(self, period: Callable[[], object], longest: float) -> None:
        """Drive by periods until no edge is left that can be seen, or for a time (s)."""
        navigator, mapper = self.navigator, self._mapper
        over = navigator.last_time + longest
        while (goal := self.next()) is not None:
            navigator.go(goal)
            periods = 0
            while navigator.end is None and not (periods % CHECKED == 0 and self._sees()):
                if navigator.last_time >= over:
                    why = f"{longest:g} s are over"
                    self.unseen = [Unseen(edge, why) for edge in _edges(mapper.grid, mapper.grid.free)]
                    return
                period()
                periods += 1
            # What it sees from there is to be on the map before that is judged.
            mapper.keep_next = True
            waited = navigator.last_time + SILENT_SECONDS
            while navigator.end is not None and mapper.keep_next and navigator.last_time < waited:
                period()
            self._looked()

    def next(self) -> Goal | None:
        """Return where to drive next; None where no edge is left that can be seen: `unseen` tells the others."""
        grid, footprint = self._mapper.grid, self.navigator.footprint
        self.unseen, self._edge = [], None
        planner = Planner(Costmap.of(grid, footprint, np.zeros((0, 2))))
        try:
            reached = planner.reached(self.navigator.pose)
        except NoWayError as error:
            self.unseen = [Unseen(edge, str(error)) for edge in _edges(grid, grid.free)]
            return None
        roomy = reached & (planner.clearance > footprint.outer + TURNING)
        rows, columns = grid.cells(self.navigator.pose[None, :2])
        ways = ways_from(reached, int(rows[0]), int(columns[0])) * grid.resolution
        tight = np.where(planner.clearance > footprint.outer + FREELY, 0.0, TIGHT)
        best, goal = np.inf, None
        for edge in _edges(grid, reached):
            found = self._place(grid, edge, ways + tight, roomy, reached)
            if isinstance(found, str):
                self.unseen.append(Unseen(edge, found))
            elif found[0] < best:
                best, goal, self._edge = found[0], Goal(*found[1].tolist()), edge
        if goal is not None:
            self.unseen = []
        return goal

    def _place(self, grid: Grid, edge: Edge, ways: Floats, roomy: Mask, reached: Mask) -> tuple[float, Floats] | str:
        """Return the place (2,) to look at an edge from, behind its cost (m), or why there is none."""
        looks = [look for look in self._looks if _same(look.edge, edge, 2.1 * grid.resolution)]
        ends = [look.end for look in looks if look.end is not None]
        in_vain = f"on its way there it {ends[-1]}" if ends else f"looks from {_places(len(looks))} nothing more of it"
        if len(looks) >= LOOKS:
            return in_vain
        seen = _seeing(grid, edge.beyond, self._sight)
        places = np.nonzero((seen > 0) & roomy)
        middles = grid.middles(*places)
        kept = np.ones(len(middles), bool)
        for look in looks:
            kept &= np.hypot(*(middles - look.place).T) > OTHER_PLACE
        if not kept.any():
            if looks:
                return f"{in_vain}, and no other place sees it"
            return f"no place that it can come to {'and turn at ' if (reached & (seen > 0)).any() else ''}sees it"
        middles, count, far = middles[kept], seen[places][kept], ways[places][kept]
        share = count / min(len(edge.beyond), _TARGETS)
        off = np.hypot(*(middles[:, None] - edge.beyond[:: 1 + len(edge.beyond) // _TARGETS]).transpose(2, 0, 1))
        cost = far - GAIN * share * edge.length + AWAY * off.min(axis=1)
        cost[count < 0.5 * count.max()] = np.inf
        at = int(np.argmin(cost))
        return float(cost[at]), middles[at]

    def _sees(self) -> bool:
        """Return whether most of the edge that it is on its way to is seen by now."""
        assert self._edge is not None
        grid = self._mapper.grid
        return bool(_frontier(grid)[grid.cells(self._edge.cells)].mean() < 0.5)

    def _looked(self) -> None:
        """Keep in mind a look that has changed nothing."""
        navigator, edge = self.navigator, self._edge
        if edge is None or navigator.goal is None or self._sees():
            return
        place = np.array([navigator.goal.x, navigator.goal.y])
        self._looks.append(_Look(edge, place, None if navigator.reached else navigator.end))


def _places(count: int) -> str:
    return "one place show" if count == 1 else f"{count} places show"


def _frontier(grid: Grid) -> Mask:
    """Return which free cells are beside unknown ones, (rows, columns)."""
    return grid.free & widened(~(grid.free | grid.occupied))


def _edges(grid: Grid, reached: Mask) -> list[Edge]:
    """Return the edges of the known that hang together, through free cells, with those that are reached."""
    labels, _ = parts(grid.free)
    inside = np.isin(labels, np.unique(labels[reached & grid.free]))
    unknown = ~(grid.free | grid.occupied)
    labels, count = parts(_frontier(grid) & inside)
    edges = []
    for number in range(1, count + 1):
        rows, columns = np.nonzero(labels == number)
        if len(rows) * grid.resolution < SMALLEST:
            continue
        cells = grid.middles(rows, columns)
        # A long one is looked at piece by piece, each where the map is then, however it goes on beyond.
        long = np.ptp(cells, axis=0).max() > 1.5 * PIECE
        tiles = np.floor(cells / PIECE).astype(np.int64) if long else np.zeros((len(cells), 2), np.int64)
        _, piece = np.unique(tiles, axis=0, return_inverse=True)
        for one in range(int(piece.max()) + 1):
            mine = piece.ravel() == one
            length = int(mine.sum()) * grid.resolution
            if long and length < LEAST_PIECE:
                continue
            own = np.zeros(labels.shape, bool)
            own[rows[mine], columns[mine]] = True
            edges.append(Edge(cells[mine], grid.middles(*np.nonzero(unknown & widened(own))), length))
    return edges


def _seeing(grid: Grid, targets: Floats, sight: float) -> NDArray[np.int32]:
    """Return of how many targets (n, 2), of at most some of them, each cell sees, (rows, columns).

    A ray from each goes through free cells, but for its first ones, which are as unknown as the target.
    """
    free, occupied, step = grid.free, grid.occupied, 0.7 * grid.resolution
    seeing = np.zeros(free.shape, np.int32)
    marks = np.arange(step, sight, step)
    angles = np.linspace(0.0, 2.0 * np.pi, _RAYS, endpoint=False)
    along = np.column_stack([np.cos(angles), np.sin(angles)])[:, None] * marks[:, None]
    begins = marks < 2.0 * grid.resolution
    chosen = targets[np.linspace(0, len(targets) - 1, min(len(targets), _TARGETS)).astype(int)]
    for target in chosen:
        places = target + along
        inside = grid.has(places)
        rows, columns = grid.cells(places)
        rows, columns = np.where(inside, rows, 0), np.where(inside, columns, 0)
        passes = inside & np.where(begins, ~occupied[rows, columns], free[rows, columns])
        passes = np.logical_and.accumulate(passes, axis=1)
        seen = np.zeros(free.shape, bool)
        seen[rows[passes], columns[passes]] = True
        seeing += seen
    return seeing


def _same(one: Edge, other: Edge, near: float) -> bool:
    """Return whether most of each of two edges lies within a distance (m) of the other one."""
    away = np.hypot(*(one.cells[:, None] - other.cells).transpose(2, 0, 1))
    return bool((away.min(axis=0) < near).mean() > 0.5 and (away.min(axis=1) < near).mean() > 0.5)
