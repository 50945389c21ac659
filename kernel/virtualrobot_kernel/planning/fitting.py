"""Fits of poses and parameters to measured points, by least squares, with what the measurements can't tell apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError

Floats = NDArray[np.float64]

LEAST_SHARE = 1e-3
"""Share of the best determined direction of parameters from which one is determined at all: below it, a millimetre of
what was measured may be a metre of the result."""

MOST_STEPS = 100
"""Greatest number of steps of a fit that isn't linear."""

_TOLD = 1e-7
"""Share of the best determined direction below which rounding alone tells one."""

SETTLED = 1e-12
"""Length of a step (rad, m) from which a fit has come to its end."""


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Parameters (k,) that fit best, their standard errors (k,), and how far each of n points is off then (n,), in m.

    The errors are those of measurements that are independent and equally good; NaN where there are no more measured
    numbers than parameters.
    """

    parameters: Floats
    errors: Floats
    residuals: Floats


def rigid_fit(points: Floats, targets: Floats) -> Floats:
    """Return the pose (4, 4) that takes points (n, 3) nearest to targets (n, 3), in the sum of squares.

    By the singular value decomposition of Arun, Huang and Blostein (1987), with Umeyama's (1991) care for mirrors.
    Raises KernelError for fewer than three points, and for those that lie on a line.
    """
    if len(points) < 3:
        raise KernelError(f"{len(points)} points don't determine a pose; give at least 3", field="points")
    middle, center = points.mean(axis=0), targets.mean(axis=0)
    for name, spread in (("points", points - middle), ("postures", targets - center)):
        widths = np.linalg.svd(spread, compute_uv=False)
        if widths[1] <= LEAST_SHARE * widths[0] or widths[0] == 0.0:
            raise KernelError(
                f"the {name} lie on a line, about which the base may turn; give one that is off it", field=name
            )
    left, _, right = np.linalg.svd((targets - center).T @ (points - middle))
    pose = np.eye(4)
    pose[:3, :3] = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    pose[:3, 3] = center - pose[:3, :3] @ middle
    return pose


def pivot_fit(flanges: Floats) -> Fit:
    """Return the point in the flange's frame, then in the world's, (6,), that poses of the flange (n, 4, 4) share best.

    Each pose says that `rotation @ tip + position = point`: linear least squares, as for a pivoted pointer. Raises
    KernelError where the poses don't tell where along an axis the tip is.
    """
    count = len(flanges)
    matrix = np.concatenate([flanges[:, :3, :3], np.broadcast_to(-np.eye(3), (count, 3, 3))], axis=2).reshape(-1, 6)
    wanted = -flanges[:, :3, 3].reshape(-1)
    determined(matrix, ("tip x", "tip y", "tip z", "point x", "point y", "point z"))
    found = np.asarray(np.linalg.lstsq(matrix, wanted, rcond=None)[0], dtype=np.float64)
    return _fit(matrix, found, matrix @ found - wanted)


def fit(residuals: Callable[[Floats], tuple[Floats, Floats]], start: Floats, names: Sequence[str]) -> Fit:
    """Return the parameters (k,) whose residuals are smallest in the sum of squares, by Levenberg and Marquardt.

    Args:
        residuals: returns for parameters (k,) how far n points are off (n, 3) and the derivatives (n, 3, k).
        start: where to begin (k,).
        names: of the parameters, for people.

    Raises KernelError where the measurements can't tell some of them apart, with their names.
    """
    at, damping = start.copy(), 1e-6
    off, slopes = residuals(at)
    determined(slopes.reshape(-1, len(at)), names)
    for _ in range(MOST_STEPS):
        matrix, rest = slopes.reshape(-1, len(at)), off.reshape(-1)
        normal = matrix.T @ matrix
        step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), matrix.T @ rest)
        there, slopes_there = residuals(at + step)
        if np.sum(there**2) <= np.sum(off**2):
            at, off, slopes, damping = at + step, there, slopes_there, damping / 10.0
        else:
            damping *= 10.0
        if np.abs(step).max(initial=0.0) < SETTLED:
            break
    determined(slopes.reshape(-1, len(at)), names)
    return _fit(slopes.reshape(-1, len(at)), at, off.reshape(-1))


def determined(matrix: Floats, names: Sequence[str]) -> None:
    """Raise KernelError when equations (m, k) leave parameters undetermined, and name them."""
    width = np.linalg.norm(matrix, axis=0)
    flat = [name for name, size in zip(names, width, strict=True) if size <= LEAST_SHARE * width.max()]
    if not flat:
        _, sizes, directions = np.linalg.svd(matrix / width, full_matrices=True)
        rank = int(np.sum(sizes > LEAST_SHARE * sizes[0]))
        loose = np.abs(directions[rank:]).max(axis=0, initial=0.0)
        flat = [name for name, share in zip(names, loose, strict=True) if share > 0.1]
    if flat:
        raise KernelError(
            f"what was measured doesn't determine {', '.join(flat)}; measure in postures that differ more, turned "
            "about all axes, or leave some of them out of the fit",
            field="postures",
            undetermined=",".join(flat),
        )


def _fit(matrix: Floats, found: Floats, off: Floats) -> Fit:
    """Return a fit with the errors that follow from equations (3n, k) and what is left over (3n,)."""
    spare = len(off) - len(found)
    if spare > 0:
        variance = off @ off / spare
        errors = np.sqrt(variance * np.diag(np.linalg.inv(matrix.T @ matrix)))
    else:
        errors = np.full(len(found), np.nan)
    return Fit(found, errors, np.linalg.norm(off.reshape(-1, 3), axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class LeastFit:
    """Parameters (k,) that fit best, where some can't be told apart.

    Attributes:
        parameters: the changes (k,); what the measurements don't tell is 0 in them.
        rank: how many directions of them the measurements tell.
        condition: the best determined of these over the worst one.
        covariance: (k, k) of the parameters, by what is left over; NaN where nothing is to spare.
        deviation: of one measured number, sqrt(SSR / (3 n - rank)); NaN likewise.
        residuals: (n,) how far each point is off, m.
    """

    parameters: Floats
    rank: int
    condition: float
    covariance: Floats
    deviation: float
    residuals: Floats


def least_fit(residuals: Callable[[Floats], tuple[Floats, Floats]], count: int) -> LeastFit:
    """Return the parameters (count,) whose residuals, as `fit` has them, are smallest, of those that are told at 0.

    By Gauss and Newton, for parameters that are small, such as a robot's errors. What tells of a direction at 0 no more
    than rounding does, stays 0: away from there something may, but by far too little beside noise.
    """
    off, slopes = residuals(np.zeros(count))
    _, sizes, directions = np.linalg.svd(slopes.reshape(-1, count), full_matrices=False)
    rank = _rank(sizes)
    basis, at = directions[:rank].T, np.zeros(rank)
    for _ in range(MOST_STEPS):
        step = -np.linalg.lstsq(slopes.reshape(-1, count) @ basis, off.reshape(-1), rcond=None)[0]
        at = at + step
        off, slopes = residuals(basis @ at)
        if np.abs(step).max(initial=0.0) < SETTLED:
            break
    matrix, spare = slopes.reshape(-1, count) @ basis, off.size - rank
    sizes = np.linalg.svd(matrix, compute_uv=False)
    deviation = float(np.sqrt(np.sum(off**2) / spare)) if spare > 0 else np.nan
    covariance = deviation**2 * basis @ np.linalg.inv(matrix.T @ matrix) @ basis.T
    lengths = np.linalg.norm(off, axis=1)
    return LeastFit(basis @ at, rank, float(sizes[0] / sizes[-1]), covariance, deviation, lengths)


def told(matrix: Floats) -> int:
    """Return how many directions of parameters equations (m, k) tell, by more than rounding."""
    return _rank(np.asarray(np.linalg.svd(matrix, compute_uv=False), dtype=np.float64))


def _rank(sizes: Floats) -> int:
    return int(np.sum(sizes > _TOLD * sizes[0]))
