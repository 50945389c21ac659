"""Time law along any path: at rest at both ends, every limit kept all the way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.law_search import cells_of, longest_window, search, spend
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.rates import Rate, greatest_stretch, joint_rates, stretch_needed, tcp_rate
from virtualrobot_kernel.motion.time_optimal import time_optimal_law

#: By how much slower than by its fine grid a law is.
_MARGIN = 1.0002
#: The windows that are tried: each this much shorter than the one before, so many at most, and how often each of the
#: best is tried with another budget.
_SHORTER, _WINDOWS, _BUDGETS = 0.7, 8, 3
_COARSE, _FINE = 500, 5000


def path_law(
    path: PiecewisePolynomial,
    limits: JointLimits,
    joints: Sequence[JointBound],
    tcps: Sequence[TcpBound],
    law: TimeLaw,
) -> PiecewisePolynomial:
    """Return the law u(tau) over the whole path q(u), at rest at both ends, that keeps every limit.

    path: twice continuously differentiable. What is kept: the velocity, acceleration and jerk of the joints, where
    `joints` says so only a share of their velocity, and where `tcps` says so the limits of a tool centre point. A
    time-optimal law has no limit of jerk.
    """
    return law_along([*joint_rates(path, limits, joints), *(tcp_rate(path, bound) for bound in tcps)], law)


def law_along(rates: Sequence[Rate], law: TimeLaw) -> PiecewisePolynomial:
    """Return the law of this kind over the range of the first rate that keeps the limits of all."""
    if not any(np.any(rate.polynomial.coefficients) for rate in rates):
        raise KernelError("a time law needs a path along which something moves; this one stands still")
    return time_optimal_law(rates) if law is TimeLaw.TIME_OPTIMAL else _jerk_limited(rates)


def _jerk_limited(rates: Sequence[Rate]) -> PiecewisePolynomial:
    cells = cells_of(rates)
    usual = np.ones(cells.count)
    found: dict[float, PiecewisePolynomial] = {}
    window = longest_window(cells) / _SHORTER
    for _ in range(_WINDOWS):
        law = search(cells, window, usual)
        if law is not None:
            found[window] = _stretched(law, rates, _COARSE)
            ends = [one.end for one in found.values()]
            if len(ends) > 2 and ends[-1] > ends[-2] > ends[-3]:
                break
        window *= _SHORTER
    best = min(found, key=lambda one: found[one].end)
    tried = [found[best]]
    for window in (best, best * _SHORTER):
        budget = usual
        for _ in range(_BUDGETS):
            law = search(cells, window, budget)
            if law is None:
                break
            taus = _grid(law, rates, _COARSE)
            needed = stretch_needed(rates, law, taus)
            tried.append(law.stretched(law.end * float(needed.max())))
            budget = spend(cells, budget, law, taus, needed[2], window)
    return _kept(min(tried, key=lambda one: one.end), rates)


def _kept(law: PiecewisePolynomial, rates: Sequence[Rate]) -> PiecewisePolynomial:
    """Return the law as fast as the limits of the rates allow, by a fine grid and a margin for what lies between."""
    need = greatest_stretch(rates, law, _fine_grid(law, rates))
    return law.stretched(law.end * need * _MARGIN)


def _stretched(law: PiecewisePolynomial, rates: Sequence[Rate], points: int) -> PiecewisePolynomial:
    return law.stretched(law.end * float(stretch_needed(rates, law, _grid(law, rates, points)).max()))


def _fine_grid(law: PiecewisePolynomial, rates: Sequence[Rate]) -> Array:
    return np.sort(np.concatenate([np.linspace(law.start, law.end, _FINE), _grid(law, rates, _FINE)]))


def _grid(law: PiecewisePolynomial, rates: Sequence[Rate], points: int) -> Array:
    """Return increasing nominal times: both sides of each break of the law, and places all along the path."""
    breaks, edges = law.breaks, rates[0].polynomial.breaks
    each = max(4, points // len(edges))
    places = (edges[:-1, None] + np.diff(edges)[:, None] * (np.arange(each) / each)).ravel()
    taus = np.interp(places, law.evaluate(breaks)[:, 0], breaks)
    return np.sort(np.concatenate([taus, breaks, np.nextafter(breaks, -np.inf)]))
