"""Exploration: the vehicle drives to the edges of what it knows until there are none left.

B. Yamauchi, A Frontier-Based Approach for Autonomous Exploration, IEEE CIRA 1997.
"""

from __future__ import annotations

import numpy as np

from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator
from virtualrobot_apps.seeing.navigation.planning import Costmap, NoWayError, Planner
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.regions import parts, widened

SMALLEST = 0.35
"""Length (m) from which on an edge of the known is driven to."""
SIGHT = 0.6
"""Distance (m) from an edge at which it is seen well."""


class Explorer:
    """Chooses where to look next, and leaves out what was tried."""

    def __init__(self, navigator: Navigator) -> None:
        """Explore with a navigator that maps."""
        self.navigator = navigator
        self._tried: list[Floats] = []

    def next(self) -> Goal | None:
        """Return where to drive next; None where nothing is left that can be reached."""
        grid = self.navigator.where.grid
        if not grid.log_odds.size:
            return Goal(*self.navigator.pose[:2])
        planner = Planner(Costmap.of(grid, self.navigator.footprint, np.zeros((0, 2))))
        free, unknown = grid.free, ~(grid.free | grid.occupied)
        edges = free & widened(unknown)
        labels, count = parts(edges)
        try:
            reached = planner.reached(self.navigator.pose)
        except NoWayError:
            return None
        places = grid.middles(*np.nonzero(reached))
        if not len(places):
            return None
        # It turns there: what is nearer to something than its outer radius is left to the last.
        roomy = planner.clearance[np.nonzero(reached)] > self.navigator.footprint.outer
        best, goal = np.inf, None
        here = self.navigator.pose[:2]
        for number in range(1, count + 1):
            cells = grid.middles(*np.nonzero(labels == number))
            if len(cells) * grid.resolution < SMALLEST:
                continue
            middle = cells[np.argmin(np.hypot(*(cells - cells.mean(axis=0)).T))]
            if any(np.hypot(*(middle - one)) < 0.3 for one in self._tried):
                continue
            away = np.hypot(*(places - middle).T) + np.where(roomy, 0.0, 0.5)
            at = int(np.argmin(away))
            if away[at] > SIGHT + 0.6:
                continue
            near = np.hypot(*(places[at] - here))
            score = near - 0.5 * len(cells) * grid.resolution
            if score < best:
                best, goal, edge = score, Goal(float(places[at, 0]), float(places[at, 1])), middle
        if goal is not None:
            self._tried.append(edge)
        return goal
