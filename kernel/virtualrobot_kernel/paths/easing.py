"""Free values of a tool path by which joints accelerate less: where frames kink, the tool turns evenly.

Values that are smooth themselves leave the kinks of the frames, such as where a way goes onto a bent surface, to the
joints. So the joints are what is looked at here: the least squares are solved of how far values are off those found,
and of the joints' accelerations in parts of their limits, again and again about what they gave (Gauss-Newton), with
values beyond a bound held there, and with greater and greater weight of the accelerations until they are low enough.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.free_path import within_hull
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.paths.tool_query import Tolerances

Floats = NDArray[np.float64]
Postures = Callable[[Floats, Floats], Floats]
"""Joints (n, k) for free values (n, f) at parameters (n,), NaN where there is no posture."""

WEIGHTS = 0.01, 0.1, 1.0, 10.0, 100.0, 1e4
"""Weights of the accelerations against the distances from the values found, one after the other until they will do."""
KEPT = 0.8
"""Part of its greatest acceleration that a joint may need at the places: between them it may need more."""
SOLVED, HELD = 3, 12
"""Number of Gauss-Newton's steps at each weight, and how often values beyond bounds are held in each."""
ASIDE, DIFFERENCE = 1e-5, 1e-5
"""Differences of the parameter, and of free values (rad or m), by which derivatives are told."""
WIDEST = 0.3
"""Distance of a free value that counts as an acceleration at its limit does; half of its width where that is less."""


def eased(
    places: Floats, values: Floats, tolerances: Tolerances, postures: Postures, most: Floats
) -> tuple[Floats, float]:
    """Return free values (n + 2, f) that joints follow more easily than others (n, f); and the share that they need.

    That is the greatest acceleration at the places in parts of what joints may have; inf where no posture is.

    Args:
        places: (n,) parameters of the path, so near to each other that what is free and what is asked of the tool have
            second derivatives that go straight between them.
        values: the values found, those without end as they go on beyond a turn.
        tolerances: bounds (2, f) and which are without end (f,).
        postures: the joints for other values, at or beside the places.
        most: (k,) the greatest second derivatives of the joints by the parameter.
    """
    width = tolerances.bounds[1] - tolerances.bounds[0]
    free = np.flatnonzero(tolerances.endless | (width > 0.0))
    unit = np.where(tolerances.endless, WIDEST, np.minimum(WIDEST, 0.5 * width))[free]
    lower, upper = np.where(tolerances.endless, [[-np.inf], [np.inf]], tolerances.bounds)

    def spline(control: Floats) -> PiecewisePolynomial:
        return within_hull(places, np.clip(_with_ends(control), lower, upper))

    bends = _bends(places)
    control, best, least = values.copy(), values, np.inf
    for weight in WEIGHTS:
        for _ in range(SOLVED):
            function = spline(control)
            before, here, after = (
                postures(places + aside, function.evaluate(places + aside)) for aside in (-ASIDE, 0.0, ASIDE)
            )
            needed = (after - 2.0 * here + before) / ASIDE**2 / most
            if np.isnan(needed).any():
                break
            share = float(np.abs(needed).max())
            if share < least:
                best, least = control.copy(), share
            if share <= KEPT:
                return np.clip(_with_ends(best), lower, upper), least
            at = function.evaluate(places)
            columns = [_slopes(postures, places, at, axis, lower, upper) for axis in free.tolist()]
            slopes = np.stack(columns, axis=1) / most
            if np.isnan(slopes).any():
                break
            rest = needed - np.einsum("nfk,nf->nk", slopes, bends @ control[:, free])
            near = values[:, free]
            control[:, free] = _solved(bends, slopes, rest, near, weight, unit, (lower[free], upper[free]))
    return np.clip(_with_ends(best), lower, upper), least


def _solved(
    bends: Floats, slopes: Floats, rest: Floats, near: Floats, weight: float, unit: Floats, ends: tuple[Floats, Floats]
) -> Floats:
    """Return control values (n, f) within ends, by the squares of their distances from `near` and of accelerations.

    These are slopes (n, f, k) @ (bends (n, n) @ control) + rest (n, k).
    """
    n, f, _ = slopes.shape
    matrix, right = np.zeros((f, n, f, n)), near.T / unit[:, None] ** 2
    # Controls beyond the third beside one have no part in its bend.
    begin = np.clip(np.arange(n) - 1, 0, max(n - 3, 0))
    columns = begin[:, None] + np.arange(min(3, n))
    own = np.take_along_axis(bends, columns, axis=1)
    for a in range(f):
        matrix[a, :, a] += np.eye(n) / unit[a] ** 2
        right[a] -= weight * bends.T @ np.einsum("nk,nk->n", slopes[:, a], rest)
        for b in range(f):
            share = weight * np.einsum("nk,nk->n", slopes[:, a], slopes[:, b])
            parts = share[:, None, None] * own[:, :, None] * own[:, None, :]
            np.add.at(matrix[a, :, b], (columns[:, :, None], columns[:, None, :]), parts)
    square, found = matrix.reshape(f * n, f * n), np.zeros(f * n)
    lower, upper = (np.repeat(end, n) for end in ends)
    held = np.zeros(f * n, np.bool_)
    for _ in range(HELD):
        loose = ~held
        wanted = right.ravel()[loose] - square[np.ix_(loose, held)] @ found[held]
        found[loose] = np.linalg.solve(square[np.ix_(loose, loose)], wanted)
        beyond = (found < lower) | (found > upper)
        found = np.clip(found, lower, upper)
        if not beyond.any():
            break
        held |= beyond
    return found.reshape(f, n).T


def _slopes(postures: Postures, places: Floats, values: Floats, axis: int, lower: Floats, upper: Floats) -> Floats:
    """Return the derivatives (n, k) of joints by a free value; NaN where there is no posture."""
    ahead, back = values.copy(), values.copy()
    ahead[:, axis] = np.minimum(values[:, axis] + DIFFERENCE, upper[axis])
    back[:, axis] = np.maximum(values[:, axis] - DIFFERENCE, lower[axis])
    return (postures(places, ahead) - postures(places, back)) / (ahead - back)[:, axis, None]


def _bends(places: Floats) -> Floats:
    """Return the second derivatives (n, n) at places (n,) by control values there: of three in a row, at each.

    Every third value is 1 in each of three functions, so that each tells what one value does.
    """
    n, rows = len(places), np.arange(len(places))
    told = within_hull(places, (np.arange(n + 2)[:, None] % 3 == np.arange(3)).astype(float)).evaluate(places, 2)
    found = np.zeros((n, n + 2))
    for aside in range(3):
        found[rows, rows + aside] = told[rows, (rows + aside) % 3]
    return found @ _with_ends(np.eye(n))


def _with_ends(values: Floats) -> Floats:
    """Return values (n + 2, f): (n, f), and one more at either end, as they go on there."""
    return np.concatenate([2.0 * values[:1] - values[1:2], values, 2.0 * values[-1:] - values[-2:-1]])
