"""Spots: places that a tool goes to along their normals, such as welds and holes, in an order that is short."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Floats, Way, units

CLEAR = 0.01
"""Default distance (m) before a spot at which its way begins."""


def spots(
    points: ArrayLike, normals: ArrayLike, *, depth: float = 0.0, clear: float = CLEAR, pecks: int = 1
) -> list[Way]:
    """Return the ways to spots, straight against their normals; of each spot one, or one for each peck, ever deeper.

    Args:
        points: (n, 3) on the surface (m).
        normals: (n, 3) out of it, of any length above 0.
        depth: how deep below it a way ends (m).
        clear: how far above it each begins (m).
        pecks: the number of ways that are gone for one spot, each as much deeper.

    Raises:
        InvalidArgumentError: for no spots, for values that are not finite, and where a way has no length.
    """
    places, out = np.array(points, np.float64).reshape(-1, 3), np.array(normals, np.float64).reshape(-1, 3)
    if not len(places) or len(out) != len(places):
        raise InvalidArgumentError(f"spots have places and normals, at least one each, not {len(places)}, {len(out)}")
    if not (np.isfinite(places).all() and np.isfinite(out).all() and np.linalg.norm(out, axis=1).all()):
        raise InvalidArgumentError("places of spots must be finite, and normals, which have a length")
    if not (clear > 0.0 and depth >= 0.0 and pecks >= 1 and np.isfinite(clear + depth)):
        raise InvalidArgumentError(
            f"spots are gone to from {clear:g} m above them to {depth:g} m below in {pecks} pecks; these must be above "
            "0, at least 0, and at least 1"
        )
    if pecks > 1 and depth == 0.0:
        raise InvalidArgumentError("pecks go deeper and deeper: give a depth above 0")
    found = []
    for place, normal in zip(places, units(out), strict=True):
        for peck in range(1, pecks + 1):
            ends = np.stack([place + clear * normal, place - depth * peck / pecks * normal])
            found.append(Way(ends, np.tile(normal, (2, 1, 1))))
    return found


def shortest_order(points: ArrayLike) -> list[int]:
    """Return an order (n,) in which a way from the first of points (n, 3) through all others is short.

    From each to the nearest that is left, then stretches are turned round as long as that makes it shorter (2-opt:
    G. Croes, A method for solving traveling-salesman problems, 1958).
    """
    places = np.array(points, np.float64).reshape(-1, 3)
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    order, left = [0], set(range(1, len(places)))
    while left:
        order.append(min(sorted(left), key=lambda other: float(apart[order[-1], other])))
        left.remove(order[-1])
    better = True
    while better:
        better = False
        for first in range(1, len(order) - 1):
            for last in range(first + 1, len(order)):
                if _saved(apart, order, first, last) > 1e-12:
                    order[first : last + 1] = order[first : last + 1][::-1]
                    better = True
    return order


def _saved(apart: Floats, order: list[int], first: int, last: int) -> float:
    """Return by how much a way becomes shorter where it is turned round from one place in the order to another."""
    before, begin, end = order[first - 1], order[first], order[last]
    saved = apart[before, begin] - apart[before, end]
    if last + 1 < len(order):
        saved += apart[end, order[last + 1]] - apart[begin, order[last + 1]]
    return float(saved)
