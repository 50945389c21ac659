"""Joint paths with quaternions among their columns: from a goal and through timed samples, with quasi-coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from virtualrobot_kernel.motion.orientation import product, slerp
from virtualrobot_kernel.motion.path import joint_line, smooth_path
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial, with_columns
from virtualrobot_kernel.motion.rates import fitted

Turn = tuple[PiecewisePolynomial, PiecewisePolynomial]
"""Path, and the quasi-coordinates whose derivatives are its velocities."""


def turning_line(q_start: Array, q_goal: Array, quaternions: Sequence[Sequence[int]]) -> Turn:
    """Return `joint_line` with quaternions (columns) turned evenly the shorter way."""
    path = quasi = joint_line(q_start, q_goal)
    for columns in map(list, quaternions):
        turn, rates = slerp(q_start[columns], q_goal[columns])
        path, quasi = with_columns(path, columns, turn), with_columns(quasi, columns, rates)
    return path, quasi


def turning_path(
    times: Array, positions: Array, velocities: Array | None, quaternions: Sequence[Sequence[int]]
) -> Turn:
    """Return `smooth_path` with quaternions (columns), which it leads as `smooth_turn` does."""
    path = quasi = smooth_path(times, positions, velocities)
    for columns in map(list, quaternions):
        rates = None if velocities is None else velocities[:, columns]
        turn, integrals = smooth_turn(times, positions[:, columns], rates)
        path, quasi = with_columns(path, columns, turn), with_columns(quasi, columns, integrals)
    return path, quasi


def smooth_turn(times: Array, quaternions: Array, rates: Array | None) -> Turn:
    """Return the smooth turn through unit quaternions (m, 4), each at most half a turn from the one before it.

    It is the smooth path through them among all quaternions, at each place brought to length 1. rates (m, 4): angular
    velocities in the axes of what turns, and 0; None: those of the smooth path.
    """
    velocities = None
    if rates is not None:
        velocities = np.array([0.5 * product(q, rate) for q, rate in zip(quaternions, rates, strict=True)])
    free = smooth_path(times, quaternions, velocities)

    def state(time: float) -> Array:
        """Return the quaternion (4,) and the angular velocity (3,)."""
        place, rate = free.state(time, 1)
        length = float(np.linalg.norm(place))
        here = place / length
        return np.concatenate([here, 2.0 * product(here * [-1.0, -1.0, -1.0, 1.0], rate / length)[:3]])

    found = fitted(state, times)
    powers, widths = np.arange(1, found.coefficients.shape[1] + 1), np.diff(found.breaks)
    integrals = np.zeros((len(widths), len(powers) + 1, 4))
    integrals[:, 1:, :3] = found.coefficients[:, :, 4:] / powers[:, None]
    gone = (integrals * (widths[:, None] ** np.append(0, powers))[:, :, None]).sum(axis=1)
    integrals[1:, 0] = np.cumsum(gone, axis=0)[:-1]
    return PiecewisePolynomial(found.breaks, found.coefficients[:, :, :4]), PiecewisePolynomial(found.breaks, integrals)
