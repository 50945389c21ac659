"""Joint paths: the straight line, quintic Hermite pieces, and the smooth path through timed samples."""

from __future__ import annotations

import numpy as np

from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.numeric.tridiagonal import eliminate


def joint_line(q_start: Array, q_goal: Array) -> PiecewisePolynomial:
    """Return q(u) = q_start + u (q_goal - q_start) for u in [0, 1]; joints (k,)."""
    return PiecewisePolynomial(np.array([0.0, 1.0]), np.stack([q_start, q_goal - q_start])[None])


def quintic_hermite(
    parameters: Array, positions: Array, velocities: Array, accelerations: Array
) -> PiecewisePolynomial:
    """Return the quintic pieces through values (m, k) with the given first and second derivatives (m, k) at m knots.

    Source: Biagiotti, Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), section 2.1.4.
    """
    first, second = (velocities[:-1], velocities[1:]), (accelerations[:-1], accelerations[1:])
    pieces = hermite_pieces(np.diff(parameters)[:, None], np.diff(positions, axis=0), first, second)
    pieces[:, 0] = positions[:-1]
    return PiecewisePolynomial(parameters, pieces)


def hermite_pieces(h: Array, rise: Array, velocities: tuple[Array, Array], accelerations: tuple[Array, Array]) -> Array:
    """Return the coefficients (n, 6, k) of quintics from 0, h (n, 1) wide, that rise by (n, k); see `quintic_hermite`.

    velocities and accelerations are those at their beginnings and ends, (n, k) each.
    """
    v0, v1 = (one * h for one in velocities)
    a0, a1 = (one * h**2 for one in accelerations)
    coefficients = [
        np.zeros_like(rise),
        velocities[0],
        accelerations[0] / 2.0,
        (20.0 * rise - 12.0 * v0 - 8.0 * v1 - 3.0 * a0 + a1) / (2.0 * h**3),
        (-30.0 * rise + 16.0 * v0 + 14.0 * v1 + 3.0 * a0 - 2.0 * a1) / (2.0 * h**4),
        (12.0 * rise - 6.0 * v0 - 6.0 * v1 - a0 + a1) / (2.0 * h**5),
    ]
    return np.stack(coefficients, axis=1)


def smooth_path(times: Array, positions: Array, velocities: Array | None) -> PiecewisePolynomial:
    """Return a quintic spline, three times continuously differentiable, through timed samples, at rest at both ends.

    times (m,) increasing, m >= 2; positions (m, k); velocities (m, k) or None, which takes those of the cubic spline
    with zero end velocities. The accelerations at the knots follow from the continuity of the jerk, zero at the ends.
    """
    h = np.diff(times)[:, None]
    slope = np.diff(positions, axis=0) / h
    if velocities is None:
        velocities = np.zeros_like(positions)
        velocities[1:-1] = solve_tridiagonal(
            (1.0 / h[:-1, 0])[1:],
            (2.0 / h[:-1] + 2.0 / h[1:])[:, 0],
            (1.0 / h[1:, 0])[:-1],
            3.0 * (slope[:-1] / h[:-1] + slope[1:] / h[1:]),
        )
    accelerations = np.zeros_like(positions)
    # Third derivative of the piece before a knot = that of the piece after it, for the quintics of quintic_hermite.
    before = (60.0 * slope[:-1] - 36.0 * velocities[1:-1] - 24.0 * velocities[:-2]) / h[:-1] ** 2
    after = (60.0 * slope[1:] - 36.0 * velocities[1:-1] - 24.0 * velocities[2:]) / h[1:] ** 2
    accelerations[1:-1] = solve_tridiagonal(
        (-3.0 / h[:-1, 0])[1:], (9.0 / h[:-1] + 9.0 / h[1:])[:, 0], (-3.0 / h[1:, 0])[:-1], after - before
    )
    return quintic_hermite(times, positions, velocities, accelerations)


def solve_tridiagonal(below: Array, diagonal: Array, above: Array, right: Array) -> Array:
    """Return the solutions (m, k) of a diagonally dominant tridiagonal system (m,) for right sides (m, k)."""
    solution = np.empty(right.shape)
    eliminate(*map(np.ascontiguousarray, (below, diagonal, above, right)), solution)
    return solution
