"""Ways on meshes made fair: what triangles make of a smooth surface, a curvature that goes up and down, is left out.

A way over a mesh crosses its edges where they are on the surface and inside it in turns. Within a chord that is
nothing, but a tool that is held against it at an even speed would be turned to and fro at each triangle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded

from virtualrobot_apps.curves.way import Floats, Way, units

FAIR = 0.5
"""Part of a chord by which ways may be off a mesh to be fair; the rest is for lines between their points."""
TURN = np.radians(2.0)
"""Angle (rad) by which normals may be off those that were given."""
STIFFEST, SOFTEST = 1e6, 1e-2
"""Weights of squared third differences against squared distances, first and last, by tenths: the first one that will do
is taken. It halves waves of 60 points, the last one leaves all but what goes to and fro from point to point."""
FEWEST = 5
"""Number of points from which on a way has third differences that are looked at."""
AROUND = 200
"""Number of points of a loop by which it goes on beyond its ends."""


def fair(way: Way, chord: float, step: float, turn: float = TURN) -> Way:
    """Return a smoother way within a chord (m) of another, with smoother normals, its points evenly a step (m) apart.

    Or a little less. A weight for the points is chosen, the greatest that leaves them within the chord, and one for the
    normals, within `turn` (rad). What would be off by more than that, such as at a corner, stays as it was.
    """
    if len(way.points) < FEWEST:
        return way
    rows = np.arange(len(way.points))
    if way.closed:
        rows = np.arange(-AROUND, len(rows) + AROUND) % (len(rows) - 1)
    inner = slice(AROUND, -AROUND) if way.closed else slice(None)
    points, normals = way.points[rows], way.normals[rows]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    thirds = _thirds(np.concatenate([[0.0], np.cumsum(steps)]))
    moved = _softened(thirds, points, chord, lambda one: np.linalg.norm(one - points, axis=1))
    flat = normals.reshape(len(rows), -1)
    turned = _softened(thirds, flat, turn, lambda one: _angles(units(one.reshape(normals.shape)), normals))
    moved, turned = moved[inner], turned[inner]
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(moved, axis=0), axis=1))])
    if way.closed:
        moved[-1], turned[-1] = moved[0], turned[0]
    even = np.linspace(0.0, at[-1], max(2, int(np.ceil(at[-1] / step - 1e-9)) + 1))
    ends = "periodic" if way.closed else "natural"
    points, flat = (CubicSpline(at, one, bc_type=ends)(even) for one in (moved, turned))
    return replace(way, points=points, normals=units(flat.reshape(len(even), *normals.shape[1:])))


def _softened(thirds: Floats, values: Floats, most: float, off: Callable[[Floats], Floats]) -> Floats:
    """Return values (n, c) by the greatest weight with which none is off by more than `most`; themselves where none."""
    # Bands of the squares of third differences: row d is the d-th diagonal, from its first element on.
    squares = np.zeros((4, len(values)))
    for d in range(4):
        for a in range(4 - d):
            squares[d, a : a + len(thirds)] += thirds[:, a] * thirds[:, a + d]
    weight = STIFFEST
    while weight >= SOFTEST:
        bands = weight * squares
        bands[0] += 1.0
        # From the first one on, so that what is the same all along stays exactly so.
        found = values[:1] + solveh_banded(bands, values - values[:1], lower=True)
        if off(found).max() <= most:
            return found
        weight *= 0.1
    return values


def _thirds(at: Floats) -> Floats:
    """Return what third differences (n - 3, 4) take of values at four places (n,) in a row, as if these were even."""
    four = np.stack([at[i : len(at) - 3 + i] for i in range(4)], axis=1)
    gaps = four[:, :, None] - four[:, None, :] + np.eye(4)
    return 6.0 * (np.diff(at).mean() ** 3) / gaps.prod(axis=2)


def _angles(found: Floats, given: Floats) -> Floats:
    """Return the greatest angles (n,) between unit vectors (n, k, 3); 0 where there are none."""
    if not given.shape[1]:
        return np.zeros(len(given))
    return 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(found - given, axis=2), 0.0, 1.0)).max(axis=1)
