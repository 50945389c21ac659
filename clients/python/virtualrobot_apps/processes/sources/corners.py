"""Corners of ways: rounded within a distance, gone round outside by a loop, or ways that end there."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Floats, Way, above_zero, place, units
from virtualrobot_apps.processes.sources.sampling import CORNER, between

SHARPEST = np.radians(150.0)
"""The greatest turn (rad) that is rounded or gone round: beyond it a way goes back on itself."""
ROUND_IT = np.linspace(-1.0, 1.0, 9)
"""Places of points on a rounded corner, in parts of its reach on either side."""
NEARING = 2.0
"""Factor by which points are farther from each other, from a rounded corner on, so that a spline through them keeps to
the lines."""
LOOP_POINTS = 24
"""Points of a whole turn of a loop."""


def corners(way: Way, corner: float = CORNER) -> tuple[NDArray[np.int64], Floats]:
    """Return the rows (m,) of a way's points between its ends at which it turns by more than an angle, and turns (m,).

    Args:
        way: as `sampling.sampled` makes it, with corners kept.
        corner: the turn (rad) from which on a point is a corner.
    """
    lines = units(np.diff(way.points, axis=0))
    turns = np.arccos(np.clip(np.einsum("ij,ij->i", lines[:-1], lines[1:]), -1.0, 1.0))
    rows = np.flatnonzero(turns > corner)
    return rows + 1, turns[rows]


def parted(way: Way) -> list[Way]:
    """Return a way in parts that end at its corners; a loop begins where it did."""
    rows, _ = corners(way)
    if not len(rows):
        return [way]
    bounds = [0, *rows.tolist(), len(way.points) - 1]
    return [Way(way.points[i : k + 1], way.normals[i : k + 1]) for i, k in pairwise(bounds)]


def rounded(way: Way, most: float) -> Way:
    """Return a way whose corners are rounded inside, at most a distance (m) from them, and never outside.

    What was a kink of the two lines is a uniform cubic B-spline (C. de Boor, *A Practical Guide to Splines*, IX), whose
    curvature has no jump. At its reach r on either side the way is on its lines again; at the corner it is
    r / 6 |t2 - t1| within, t1 and t2 being the directions before and behind.

    Raises InvalidArgumentError for a distance that is not above 0, and where the way goes back on itself.
    """
    above_zero("distance of a rounded corner", most)
    rows, turns = corners(way)
    if not len(rows):
        return way
    at = _places(way)
    _check_turns(way, rows, turns)
    room = 0.5 * np.diff(np.concatenate([at[:1], at[rows], at[-1:]]))
    # Half of the way to another corner is for that one; an end of the way has none.
    room[[0, -1]] *= 2.0
    reaches = np.minimum(3.0 * most / np.sin(0.5 * turns), 0.9 * np.minimum(room[:-1], room[1:]))
    kept = [at]
    for centre, reach in zip(at[rows].tolist(), reaches.tolist(), strict=True):
        apart = reach * np.cumsum(NEARING ** np.arange(12) * (ROUND_IT[1] - ROUND_IT[0])) + reach
        step = max(float(np.diff(at).max()), reach)
        near = apart[np.append(True, np.diff(apart) < step)]
        kept = [one[np.abs(one - centre) > near[-1] + 0.5 * reach] for one in kept]
        kept += [centre + reach * ROUND_IT, centre - near, centre + near]
    found = np.unique(np.concatenate([at[:1], *kept, at[-1:]]))
    found = found[(found >= at[0]) & (found <= at[-1])]
    found = found[np.append(True, np.diff(found) > 1e-9)]
    points = _at(way, at, found)
    for row, centre, reach in zip(rows.tolist(), at[rows].tolist(), reaches.tolist(), strict=True):
        here = np.abs(found - centre) < reach
        s = (found[here] - centre) / reach
        before, behind = _at(way, at, centre - reach * _ramp(-s)), _at(way, at, centre + reach * _ramp(s))
        points[here] = before + behind - way.points[row]
    return Way(points, between(at, way.normals, found), way.closed)


def looped(way: Way, radius: float) -> Way:
    """Return a way that goes straight on at each corner, round a loop outside, and straight through the corner again.

    Raises InvalidArgumentError for a radius (m) that is not above 0, and where the way goes back on itself.
    """
    above_zero("radius of a loop", radius)
    rows, turns = corners(way)
    _check_turns(way, rows, turns)
    points, normals, begin = list[Floats](), list[Floats](), 0
    for row, turn in zip(rows.tolist(), turns.tolist(), strict=True):
        corner = way.points[row]
        there, behind = units(np.array([corner - way.points[row - 1], way.points[row + 1] - corner]))
        aside = units((there * np.cos(turn) - behind)[None])[0]  # across `there`, away from where the way goes
        straight = radius * np.tan(0.5 * turn)
        on = np.linspace(0.0, 1.0, int(np.ceil(LOOP_POINTS * straight / (2.0 * np.pi * radius))) + 1)[1:-1, None]
        angles = np.linspace(0.0, 2.0 * np.pi - turn, max(8, int(LOOP_POINTS * (1.0 - turn / (2.0 * np.pi)))))
        round_it = np.sin(angles)[:, None] * there + (1.0 - np.cos(angles))[:, None] * aside
        loop = corner + np.concatenate(
            [straight * on * there, straight * there + radius * round_it, -straight * on[::-1] * behind]
        )
        points += [way.points[begin : row + 1], loop]
        normals += [way.normals[begin : row + 1], np.repeat(way.normals[row : row + 1], len(loop), axis=0)]
        begin = row
    points.append(way.points[begin:])
    normals.append(way.normals[begin:])
    return Way(np.concatenate(points), np.concatenate(normals), way.closed)


def _ramp(s: Floats) -> Floats:
    """Return max(0, s) as a cubic B-spline has it, which is that beyond -1 and 1."""
    s = np.clip(s, -1.0, 1.0)
    return np.where(s < 0.0, (s + 1.0) ** 3 / 6.0, s + (1.0 - s) ** 3 / 6.0)


def _places(way: Way) -> Floats:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way.points, axis=0), axis=1))])


def _at(way: Way, at: Floats, places: Floats) -> Floats:
    """Return points (m, 3) of a way at lengths (m,) from its beginning."""
    return np.stack([np.interp(places, at, column) for column in way.points.T], axis=1)


def _check_turns(way: Way, rows: NDArray[np.int64], turns: Floats) -> None:
    if (turns > SHARPEST).any():
        row = int(rows[(turns > SHARPEST).argmax()])
        raise InvalidArgumentError(
            f"{place(way, row)} the way turns by {np.degrees(turns.max()):.4g} degrees, nearly back: lift the tool "
            "there"
        )
