"""Paths that go over into each other: the corner between two moves is rounded off by one quintic piece in joint space.

The parameter s runs from 0 on each path. How far it runs on one compared with the next is free, and says at which
speeds a corner is entered and left when s grows evenly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial, joined


@dataclass(frozen=True, eq=False)
class Corner:
    """Rounded corner: the parameter lengths (above 0) that it replaces, and the one piece in their place, from 0 on.

    left: of the end of the path before it; right: of the beginning of the path after it.
    """

    left: float
    right: float
    piece: PiecewisePolynomial


@dataclass(frozen=True, eq=False)
class Rounded:
    """m paths made one, with m - 1 rounded corners: where each begins and ends on its parameter.

    moves: the m parts that are left of the paths, in which they are what they were; they may have no length. corners:
    the m - 1 ranges between them.
    """

    path: PiecewisePolynomial
    moves: tuple[tuple[float, float], ...]
    corners: tuple[tuple[float, float], ...]


def round_corner(before: PiecewisePolynomial, after: PiecewisePolynomial, left: float, right: float) -> Corner:
    """Return the quintic from where `before` is `left` ahead of its end to where `after` is at `right`.

    It has their values and first two derivatives there, so tangent and curvature are continuous. Its length is
    2 min(left, right): the control points of a quintic Hermite piece of length h are, at each end, the value and that
    moved on by 1/5 and 2/5 of h times the derivative (and h²/20 times the second). So with straight paths all of
    them, hence the whole piece (Farin, Curves and Surfaces for CAGD, 5th ed., ch. 5), stay between the corner and the
    borders, which those of a longer one need not do.
    """
    length = 2.0 * min(left, right)
    values, rates, curvatures = (
        np.array(rows) for rows in zip(before.state(before.end - left, 2), after.state(right, 2), strict=True)
    )
    piece = quintic_hermite(np.array([0.0, length]), values, rates, curvatures)
    return Corner(left, right, piece)


def rounded(paths: Sequence[PiecewisePolynomial], corners: Sequence[Corner]) -> Rounded:
    """Return paths q(s), s from 0 on, made one path, with a corner between each two of them."""
    parts: list[PiecewisePolynomial] = []
    moves: list[tuple[float, float]] = []
    turns: list[tuple[float, float]] = []
    here = 0.0
    for place, path in enumerate(paths):
        begin = corners[place - 1].right if place else 0.0
        end = path.end - (corners[place].left if place < len(corners) else 0.0)
        first = here
        # Two corners that meet in the middle of a move leave at most rounding of it.
        if end - begin > 1e-9 * path.end:
            here = first + (end - begin)
            parts.append(path.between(begin, end).onto(first, here))
        moves.append((first, here))
        if place < len(corners):
            piece = corners[place].piece
            turns.append((here, here + piece.end))
            parts.append(piece.onto(here, here + piece.end))
            here += piece.end
    return Rounded(joined(parts), tuple(moves), tuple(turns))
