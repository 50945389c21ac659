"""Curves as rational Bézier pieces: what splines, polynomials, circles and polylines of all formats are exactly."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot.errors import InvalidArgumentError

Floats = NDArray[np.float64]

SAME = 1e-9
"""Distance (m) up to which points are the same."""
NUDGE = 1e-4
"""Part of a piece whose chord tells its direction where its derivative is zero."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Curve of a CAD file, in meters.

    Attributes:
        name: its name in the file; one made of its place there where it has none.
        pieces: rational Bézier curves, one after the other, each by (k, 4) control points w x, w y, w z, w; where two
            pieces meet the curve may have a corner.
        normals: (len(pieces) + 1, 3) the surface's normal at the end points of the pieces, where the file tells it.
    """

    name: str
    pieces: tuple[Floats, ...]
    normals: Floats | None = None

    @property
    def ends(self) -> Floats:
        """The points (2, 3) at which it begins and ends."""
        first, last = self.pieces[0][0], self.pieces[-1][-1]
        return np.stack([first[:3] / first[3], last[:3] / last[3]])

    @property
    def length(self) -> float:
        """Its length (m), by Gauss' rule of 32 points in each piece."""
        places, weights = np.polynomial.legendre.leggauss(32)
        speeds = [np.linalg.norm(points_on(piece, 0.5 * places + 0.5)[1], axis=1) for piece in self.pieces]
        return float(0.5 * np.sum(speeds @ weights))

    def reversed(self) -> Curve:
        """Return the curve the other way round."""
        normals = None if self.normals is None else self.normals[::-1]
        return Curve(self.name, tuple(piece[::-1] for piece in reversed(self.pieces)), normals)


def points_on(piece: Floats, parameters: ArrayLike) -> tuple[Floats, Floats]:
    """Return points and derivatives (n, 3) of a rational Bézier curve at parameters (n,) from 0 to 1.

    Source: G. Farin, *Curves and Surfaces for CAGD*, 5th edition, 4.2 (de Casteljau), 13.4 (derivative).
    """
    t = np.asarray(parameters, dtype=np.float64)[:, None, None]
    row = np.broadcast_to(piece, (len(t), *piece.shape))
    while row.shape[1] > 2:
        row = (1.0 - t) * row[:, :-1] + t * row[:, 1:]
    t = t[:, 0]
    at, slope = (1.0 - t) * row[:, 0] + t * row[:, 1], (len(piece) - 1) * (row[:, 1] - row[:, 0])
    points = at[:, :3] / at[:, 3:]
    return points, (slope[:, :3] - slope[:, 3:] * points) / at[:, 3:]


def directions(piece: Floats, parameters: ArrayLike) -> Floats:
    """Return the unit directions (n, 3) of a piece at parameters (n,); where it stands still, of what comes next."""
    at = np.asarray(parameters, dtype=np.float64)
    _, slopes = points_on(piece, at)
    flat = np.linalg.norm(slopes, axis=1) <= 1e-6 * np.ptp(piece[:, :3] / piece[:, 3:], axis=0).max()
    if flat.any():
        begin = np.minimum(at[flat], 1.0 - NUDGE)
        slopes[flat] = points_on(piece, begin + NUDGE)[0] - points_on(piece, begin)[0]
    return slopes / np.linalg.norm(slopes, axis=1)[:, None]


def polynomial(coefficients: Floats) -> Floats:
    """Return a piece of the sum of coefficients (k, 3) times powers of a parameter from 0 to 1.

    Source: Farin, *Curves and Surfaces for CAGD*, 5th edition, 6.6.
    """
    degree = max(len(coefficients) - 1, 1)
    points = np.zeros((degree + 1, 3))
    for i in range(degree + 1):
        for j in range(min(i + 1, len(coefficients))):
            points[i] += comb(i, j) / comb(degree, j) * coefficients[j]
    return np.hstack([points, np.ones((degree + 1, 1))])


def polyline(points: Floats) -> tuple[Floats, ...]:
    """Return straight pieces between points (n, 3)."""
    rows = np.hstack([points, np.ones((len(points), 1))])
    return tuple(np.stack(pair) for pair in pairwise(rows))


def arc(center: Floats, to_start: Floats, across: Floats, begin: float, end: float) -> tuple[Floats, ...]:
    """Return pieces of at most a quarter turn: center + cos a `to_start` + sin a `across`, a from begin to end (rad).

    Source: L. Piegl and W. Tiller, *The NURBS Book*, 2nd edition, 7.3.
    """
    count = max(1, int(np.ceil(abs(end - begin) / (0.5 * np.pi) - 1e-9)))
    half = 0.5 * (end - begin) / count
    found = []
    for middle in begin + half * (2.0 * np.arange(count) + 1.0):
        corners = [(middle - half, 1.0, 1.0), (middle, 1.0 / np.cos(half), np.cos(half)), (middle + half, 1.0, 1.0)]
        rows = [
            [*(weight * (center + far * (np.cos(a) * to_start + np.sin(a) * across))), weight]
            for a, far, weight in corners
        ]
        found.append(np.array(rows))
    return tuple(found)


def with_length(curve: Curve) -> Curve:
    """Return a curve without the pieces that have no length; raises InvalidArgumentError where nothing is left."""
    sizes = [np.ptp(piece[:, :3] / piece[:, 3:], axis=0).max() for piece in curve.pieces]
    kept = [place for place, size in enumerate(sizes) if size > SAME]
    if not kept:
        raise InvalidArgumentError(f"the curve {curve.name!r} has no length")
    if len(kept) == len(curve.pieces):
        return curve
    normals = None if curve.normals is None else curve.normals[[*kept, kept[-1] + 1]]
    return Curve(curve.name, tuple(curve.pieces[place] for place in kept), normals)
