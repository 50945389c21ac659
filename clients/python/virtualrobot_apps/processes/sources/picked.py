"""Splines through points that somebody picked."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from virtualrobot_apps.curves.way import Way, checked_way
from virtualrobot_apps.processes.sources.sampling import CHORD, STEP, between, check_density, dense


def spline(
    points: ArrayLike, normals: ArrayLike, *, closed: bool = False, chord: float = CHORD, step: float = STEP
) -> Way:
    """Return a way on the cubic spline through picked points, with normals between theirs.

    Its parameter goes by the square root of the distance of points (E. Lee, *Choosing nodes in parametric curve
    interpolation*, 1989), which keeps loops out where far and near points are neighbours.

    Args:
        points: (n, 3) in m; a loop goes from the last one to the first.
        normals: (3,) or (n, 3) out of the surface, of any length above 0.
        closed: makes it a loop.
        chord: how far it may be beside the lines between the points of the way (m).
        step: the longest distance of two points of the way (m).

    Raises:
        InvalidArgumentError: for what `checked_way` refuses, and for a chord or step that is not above 0.
    """
    if closed:
        places, given = np.array(points, dtype=np.float64), np.array(normals, dtype=np.float64)
        if places.ndim == 2 and len(places) and not np.array_equal(places[0], places[-1]):
            points = np.concatenate([places, places[:1]])
            normals = given if given.ndim == 1 else np.concatenate([given, given[:1]])
    picked = checked_way(points, normals, closed)
    check_density(picked.length, chord, step)
    distances = np.linalg.norm(np.diff(picked.points, axis=0), axis=1)
    knots = np.concatenate([[0.0], np.cumsum(np.sqrt(distances))])
    curve = CubicSpline(knots, picked.points, bc_type="periodic" if closed else "not-a-knot")
    at = dense(curve, knots, chord, step)
    on = curve(at)
    on[[0, -1]] = picked.points[[0, -1]]
    return Way(on, np.concatenate([picked.normals[:1], between(knots, picked.normals, at[1:])]), closed)
