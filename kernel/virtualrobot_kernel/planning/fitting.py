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
