"""Ways of points, split at corners, made smooth, and as dense as a chord asks."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Floats, Way, above_zero, slopes, units

CORNER = np.radians(30.0)
"""Turn (rad) of a way from which on it is a corner."""
CHORD = 1e-4
"""Distance (m) that a way may be beside the line between two of its points."""
STEP = 5e-3
"""The longest distance (m) of two points of a way."""
MOST_POINTS = 100_000
"""Points of a way at most: more is a mistaken unit."""


def ways_of(points: Floats, faces: Floats, closed: bool, corner: float = CORNER) -> list[Way]:
    """Return ways along lines between points (n, 3), split at corners.

    Args:
        points: those of a loop end where they begin.
        faces: (n - 1, k, 3) unit normals of the faces beside each line. They count in the middle of the line, and at
            the points what is between.
        closed: true for a loop, which begins anew at its first corner if it has one.
        corner: the turn (rad) from which on the way is split.
    """
    lines = units(np.diff(points, axis=0))
    turns = np.arccos(np.clip(np.einsum("ij,ij->i", lines, np.roll(lines, -1, axis=0)), -1.0, 1.0))
    cuts = np.flatnonzero(turns[: len(lines) if closed else -1] > corner) + 1
    if closed and len(cuts):
        shift = int(cuts[0]) % len(lines)
        points = np.concatenate([points[shift:-1], points[: shift + 1]])
        faces = np.roll(faces, -shift, axis=0)
        cuts, closed = (cuts[1:] - cuts[0]), False
    bounds = [0, *cuts.tolist(), len(points) - 1]
    found = []
    for begin, end in pairwise(bounds):
        part = points[begin : end + 1]
        found.append(Way(part, _at_points(part, faces[begin:end], closed), closed))
    return found


def _at_points(points: Floats, faces: Floats, closed: bool) -> Floats:
    """Return unit normals (n, k, 3) at points (n, 3) of those (n - 1, k, 3) in the middle of the lines between them."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)[:, None, None]
    if closed:
        steps, faces = (np.concatenate([one[-1:], one, one[:1]]) for one in (steps, faces))
    if len(faces) == 1:
        return faces.repeat(2, axis=0)
    inner = (faces[:-1] * steps[1:] + faces[1:] * steps[:-1]) / (steps[:-1] + steps[1:])
    if not closed:
        inner = np.concatenate([faces[:1], inner, faces[-1:]])
    return units(inner)


def sampled(way: Way, chord: float = CHORD, step: float = STEP, corner: float = CORNER) -> Way:
    """Return a way on the smooth curve through the points of another, as dense as asked, with corners kept.

    Between two points the curve is a cubic with the directions of the parabolas through each point and its neighbours
    (Bessel's tangents; C. de Boor, *A Practical Guide to Splines*, IV); at corners it is one on either side. Where it
    would leave the line to a neighbour by more than `chord`, the point is a corner, too: beside what is straight for
    long, and on polygons that are no curves. So it stays by the lines that were given.

    Args:
        way: points that are closer to each other than a tenth of `chord` count as one.
        chord: how far the curve may be beside the lines between the points (m), those given and those returned.
        step: the longest distance of two points (m).
        corner: the turn (rad) from which on a point is a corner.

    Raises:
        InvalidArgumentError: for a chord or step that is not above 0, where over 100,000 points would be needed, and
            for a loop that is smaller than the chord.
    """
    check_density(way.length, chord, step)
    thin = _thinned(way, 0.1 * chord)
    if not thin.length:
        raise InvalidArgumentError(f"a way of {1e3 * way.length:.6g} mm is shorter than its chord lets it be")
    corners = _corners(thin, chord, corner)
    bounds = [0, *(np.flatnonzero(corners[1:-1]) + 1).tolist(), len(thin.points) - 1]
    round_it = thin.closed and not corners.any()
    points, normals = [thin.points[:1]], [thin.normals[:1]]
    for begin, end in pairwise(bounds):
        part = thin.points[begin : end + 1]
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(part, axis=0), axis=1))])
        curve = CubicHermiteSpline(lengths, part, slopes(part, round_it))
        at = dense(curve, lengths, chord, step)[1:]
        points.append(np.concatenate([curve(at[:-1]), part[-1:]]))
        normals.append(between(lengths, thin.normals[begin : end + 1], at))
    return Way(np.concatenate(points), np.concatenate(normals), thin.closed)


def _corners(way: Way, chord: float, corner: float) -> NDArray[np.bool_]:
    """Return which points (n,) of a way are corners; its ends are only where it is a loop.

    A cubic over a length L whose direction at one end is off by a small angle a is up to 4/27 L sin a beside its line.
    Each end may take half of the chord.
    """
    points = np.concatenate([way.points[-2:-1], way.points, way.points[1:2]]) if way.closed else way.points
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    lines = np.diff(points, axis=0) / steps[:, None]
    turns = np.arccos(np.clip(np.einsum("ij,ij->i", lines[:-1], lines[1:]), -1.0, 1.0))
    way_there = slopes(points, False)[1:-1]
    sizes = np.maximum(np.linalg.norm(way_there, axis=1), 1e-12)
    aside = [np.linalg.norm(np.cross(way_there, one), axis=1) / sizes for one in (lines[:-1], lines[1:])]
    leaves = 8.0 / 27.0 * np.maximum(steps[:-1] * aside[0], steps[1:] * aside[1]) > chord
    found = (turns > corner) | leaves
    return found if way.closed else np.concatenate([[False], found, [False]])


def check_density(length: float, chord: float, step: float) -> None:
    """Raise InvalidArgumentError for a chord or step that is not above 0, or too short a step for a length (m)."""
    for what, value in (("chord", chord), ("step", step)):
        above_zero(what, value)
    if length / step > MOST_POINTS:
        raise InvalidArgumentError(
            f"a way of {length:.6g} m in steps of {step:g} m has over {MOST_POINTS:,} points; is its unit m?"
        )


def dense(curve: Callable[[Floats], Floats], knots: Floats, chord: float, step: float) -> Floats:
    """Return parameters at which a curve is so dense, its knots among them: halved until it is."""
    at = knots
    while True:
        quarters = at[:-1, None] + np.diff(at)[:, None] * np.array([0.25, 0.5, 0.75])
        ends = curve(at)
        across = ends[1:] - ends[:-1]
        sizes = np.linalg.norm(across, axis=1)
        beside = np.linalg.norm(np.cross(curve(quarters) - ends[:-1, None], across[:, None]), axis=2)
        wide = (beside.max(axis=1) > chord * sizes) | (sizes > step)
        if not wide.any():
            return at
        if len(at) > MOST_POINTS:
            raise InvalidArgumentError(
                f"a curve within {chord:g} m of the lines between its points has over {MOST_POINTS:,} of them"
            )
        at = np.sort(np.concatenate([at, quarters[wide, 1]]))


def _thinned(way: Way, least: float) -> Way:
    """Return a way without points that are nearer than `least` (m) to the one before; its ends stay."""
    kept = [0]
    for row in range(1, len(way.points) - 1):
        if np.linalg.norm(way.points[row] - way.points[kept[-1]]) > least:
            kept.append(row)
    if len(kept) > 1 and np.linalg.norm(way.points[-1] - way.points[kept[-1]]) <= least:
        kept.pop()
    kept.append(len(way.points) - 1)
    return Way(way.points[kept], way.normals[kept], way.closed)


def between(knots: Floats, normals: Floats, at: Floats) -> Floats:
    """Return unit normals (m, k, 3) at places between those (n, k, 3) at knots (n,)."""
    row = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    part = ((at - knots[row]) / (knots[row + 1] - knots[row]))[:, None, None]
    return units((1.0 - part) * normals[row] + part * normals[row + 1])
