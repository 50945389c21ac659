"""Shortcuts of a path: what a search finds makes detours that no line of it needs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LineIsFree = Callable[[Floats, Floats], bool]

TRIES = 60
"""Number of random shortcuts tried."""

WORTH = 0.02
"""Least share of a path's length that a shortcut saves; less is not worth a look, and another corner."""

NEAR = 1e-6
"""Greatest difference of waypoints that count as one, in rad or m."""


def length_of(waypoints: Floats) -> float:
    """Return the length of a polyline (n, k) in the space of the joints."""
    return float(np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum())


def shortened(waypoints: Floats, free: LineIsFree, rng: np.random.Generator, go_on: Callable[[], bool]) -> Floats:
    """Return a path (m, k) with the ends of `waypoints` (n, k), all of whose new lines are `free`.

    First each waypoint goes on to the farthest one that it sees; then two random places of the path are joined by a
    line where that is free (R. Geraerts, M. Overmars, Creating high-quality paths for motion planning, International
    Journal of Robotics Research 26(8), 2007), and waypoints that this makes needless are left out.

    Args:
        waypoints: a free path.
        free: whether the line between two configurations (k,) is.
        rng: what places are drawn from.
        go_on: whether there is time for another try.
    """
    path = straightened(waypoints, free, go_on)
    for _ in range(TRIES):
        if len(path) < 3 or not go_on():
            break
        gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        first, last = np.sort(rng.uniform(0.0, gone[-1], 2))
        rows = np.searchsorted(gone, [first, last], side="right") - 1
        if rows[0] == rows[1]:
            continue
        begin, end = (_at(path, gone, place, row) for place, row in zip((first, last), rows.tolist(), strict=True))
        saved = last - first - float(np.linalg.norm(end - begin))
        if saved > WORTH * gone[-1] and free(begin, end):
            path = distinct(np.concatenate([path[: rows[0] + 1], [begin, end], path[rows[1] + 1 :]]))
    return straightened(path, free, go_on)


def distinct(waypoints: Floats) -> Floats:
    """Return a path (m, k) without waypoints that are where the one before them is."""
    kept = [0]
    for row in range(1, len(waypoints)):
        if np.abs(waypoints[row] - waypoints[kept[-1]]).max() > NEAR:
            kept.append(row)
    if kept[-1] != len(waypoints) - 1 and len(kept) > 1:
        kept[-1] = len(waypoints) - 1
    return waypoints[kept]


def straightened(path: Floats, free: LineIsFree, go_on: Callable[[], bool]) -> Floats:
    """Return a path in which each waypoint is followed by the farthest one that a free line leads to."""
    kept, row = [0], 0
    while row < len(path) - 1:
        following = len(path) - 1
        while following > row + 1 and not (go_on() and free(path[row], path[following])):
            following -= 1
        kept.append(following)
        row = following
    return path[kept]


def _at(path: Floats, gone: Floats, place: float, row: int) -> Floats:
    row = min(row, len(path) - 2)
    share = (place - gone[row]) / (gone[row + 1] - gone[row])
    return path[row] + share * (path[row + 1] - path[row])
