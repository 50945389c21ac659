"""Pose graph: the poses that fit all measured relations between them best.

F. Lu, E. Milios, Globally Consistent Range Scan Alignment for Environment Mapping, Autonomous Robots 4, 1997; relations
that contradict the others draw less. Gauss and Newton's steps, each solved sparsely.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, identity
from scipy.sparse.linalg import spsolve

from virtualrobot_apps.seeing.navigation.poses import Floats, between, wrapped

HUBER = 1.345
"""Deviations from which on a relation draws no harder."""
_STEPS, _STILL = 20, 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Relation:
    """Measured pose (3,) of one pose in the frame of another, by their numbers, and its deviations (m, rad)."""

    first: int
    second: int
    pose: Floats
    meters: float
    radians: float


def optimised(poses: Floats, relations: list[Relation]) -> Floats:
    """Return the poses (n, 3) that fit relations best, from these on; the first one stays."""
    first = np.array([one.first for one in relations])
    second = np.array([one.second for one in relations])
    told = np.array([one.pose for one in relations])
    weights = 1.0 / np.array([(one.meters, one.meters, one.radians) for one in relations])

    now, known = np.array(poses, np.float64), 3 * (len(poses) - 1)
    rows = np.arange(3 * len(relations)).reshape(-1, 3)
    for _ in range(_STEPS):
        off = between(now[first], now[second]) - told
        off[:, 2] = wrapped(off[:, 2])
        off *= weights
        # P. J. Huber's loss, by weights that follow: a relation far from the others draws no harder.
        trust = np.sqrt(np.minimum(1.0, HUBER / np.maximum(np.linalg.norm(off, axis=1), 1e-12)))[:, None]
        values, lines, columns = [], [], []
        for part, numbers in zip(_by_poses(now[first], now[second]), (first, second), strict=True):
            free = numbers > 0
            values.append((part[free] * (trust * weights)[free][:, :, None]).ravel())
            lines.append(np.repeat(rows[free], 3, axis=1).ravel())
            columns.append(np.tile(3 * (numbers[free] - 1)[:, None] + np.arange(3), (1, 3)).ravel())
        places = np.concatenate(lines), np.concatenate(columns)
        slope = csc_matrix((np.concatenate(values), places), shape=(rows.size, known))
        step = np.asarray(
            spsolve((slope.T @ slope + 1e-9 * identity(known)).tocsc(), -slope.T @ (off * trust).ravel()), np.float64
        )
        now[1:] += step.reshape(-1, 3)
        if float(np.abs(step).max()) < _STILL:
            break
    now[:, 2] = wrapped(now[:, 2])
    return now


def _by_poses(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Return the derivatives (n, 3, 3) of `between(a, b)` by each of both poses (n, 3)."""
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    dx, dy = b[:, 0] - a[:, 0], b[:, 1] - a[:, 1]
    by_first, by_second = np.zeros((2, len(a), 3, 3))
    by_first[:, 0, 0], by_first[:, 0, 1], by_first[:, 0, 2] = -c, -s, -s * dx + c * dy
    by_first[:, 1, 0], by_first[:, 1, 1], by_first[:, 1, 2] = s, -c, -c * dx - s * dy
    by_second[:, 0, 0], by_second[:, 0, 1] = c, s
    by_second[:, 1, 0], by_second[:, 1, 1] = -s, c
    by_first[:, 2, 2], by_second[:, 2, 2] = -1.0, 1.0
    return by_first, by_second
