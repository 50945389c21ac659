"""Samples of motions on plans: where the joints of all of them are, in one compiled pass."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined

from virtualrobot_kernel.numeric.polynomials import one_of, piece_at, scalar_state, write_derivatives

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]


@inlined
def _write_at(breaks: Floats, terms: Floats, u: float, rows: Floats) -> None:
    """Write value and first two derivatives at u, which are 0 beyond the ends."""
    piece = piece_at(breaks, u)
    inside = min(max(u, breaks[0]), breaks[terms.shape[0]])
    write_derivatives(terms, piece, inside - breaks[piece], rows)
    if u != inside:
        for component in range(terms.shape[2]):
            rows[1, component], rows[2, component] = 0.0, 0.0


@compiled(
    *(array_of(int64, 3), array_of(float64, 1), array_of(float64, 1), array_of(int64, 1), array_of(float64, 1)),
    *(array_of(float64, 1), array_of(float64, 2), array_of(float64, 2)),
)
def sample_plans(
    shapes: Integers,
    breaks: Floats,
    terms: Floats,
    tracks: Integers,
    goal: Floats,
    durations: Floats,
    states: Floats,
    along: Floats,
) -> Floats:
    """Return positions, velocities and accelerations (3, n) of the joints of m plans, one plan after another.

    Args:
        shapes: (t, 3, 5) of the path, of what rates it and of the law of t tracks, as in `one_of`.
        breaks: (b,) all their breaks.
        terms: (c,) all their terms.
        tracks: (m + 1,) the tracks of plan i are tracks[i] to tracks[i + 1].
        goal: (n,) where the joints are at the end of the plans.
        durations: (m,) s.
        states: (m, 4) nominal time (s), its rate and the rate's slope (1/s), and 1 where the plan's tracks brake.
        along: (t, 3) the path parameter and its first two derivatives by time, of tracks that brake.
    """
    found = np.zeros((3, goal.shape[0]))
    first = 0
    for plan in range(durations.shape[0]):
        tau, rate, rate_slope, brakes = states[plan, 0], states[plan, 1], states[plan, 2], states[plan, 3] > 0.0
        for track in range(tracks[plan], tracks[plan + 1]):
            path_breaks, path = one_of(breaks, terms, shapes[track, 0])
            count = path.shape[2]
            if tau >= durations[plan] and not brakes:
                for c in range(first, first + count):
                    found[0, c] = goal[c]
                first += count
                continue
            u, speed, slope = along[track, 0], along[track, 1], along[track, 2]
            if not brakes:
                law_breaks, law = one_of(breaks, terms, shapes[track, 2])
                u, u1, u2 = scalar_state(law_breaks, law, tau)
                speed, slope = u1 * rate, u2 * rate * rate + u1 * rate_slope
            rows = np.empty((3, count))
            _write_at(path_breaks, path, u, rows)
            for c in range(count):
                found[0, first + c] = rows[0, c]
            if shapes[track, 1, 1] != shapes[track, 0, 1]:
                rated_breaks, rated = one_of(breaks, terms, shapes[track, 1])
                _write_at(rated_breaks, rated, u, rows)
            for c in range(count):
                found[1, first + c] = rows[1, c] * speed
                found[2, first + c] = rows[2, c] * (speed * speed) + rows[1, c] * slope
            first += count
    return found
