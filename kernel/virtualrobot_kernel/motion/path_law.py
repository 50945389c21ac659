"""The time law along any path: at rest at both ends, every limit kept all the way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.motion.rates import Rate, joint_rates, stretch_needed, tcp_rate

#: A law that has to be slower becomes so by this much more.
_MARGIN = 1.0005


def path_law(
    path: PiecewisePolynomial,
    limits: JointLimits,
    joints: Sequence[JointBound],
    tcps: Sequence[TcpBound],
    law: TimeLaw,
) -> PiecewisePolynomial:
    """Return the law u(tau) over the whole path q(u), at rest at both ends, that keeps every limit.

    path: twice continuously differentiable. What is kept: the velocity, acceleration and jerk of the joints, where
    `joints` says so only a share of their velocity, and where `tcps` says so the limits of a tool centre point.
    """
    del law
    rates = [*joint_rates(path, limits, joints), *(tcp_rate(path, bound) for bound in tcps)]
    return _uniform(path, rates)


def _uniform(path: PiecewisePolynomial, rates: Sequence[Rate]) -> PiecewisePolynomial:
    """Return the double S from end to end, stretched until every limit is kept."""
    unit = jerk_limited_profile(path.end - path.start, 1.0, 1.0, 1.0)
    profile = PiecewisePolynomial(unit.breaks, unit.coefficients + _offset(path.start, unit.coefficients))
    return _kept(profile, rates)


def _offset(start: float, coefficients: Array) -> Array:
    return np.array([start] + [0.0] * (coefficients.shape[1] - 1))[None, :, None]


def _kept(law: PiecewisePolynomial, rates: Sequence[Rate]) -> PiecewisePolynomial:
    """Return the law as fast or as slow as the limits want it to be, verified on a second, finer grid."""
    law = law.stretched(law.end * float(stretch_needed(rates, law, _grid(law, rates, 2000)).max()))
    while (need := float(stretch_needed(rates, law, _grid(law, rates, 7001)).max())) > 1.0:
        law = law.stretched(law.end * need * _MARGIN)
    return law


def _grid(law: PiecewisePolynomial, rates: Sequence[Rate], points: int) -> Array:
    """Return nominal times that cover the law, both sides of each of its breaks included."""
    breaks = law.breaks
    points = max(points, 8 * sum(len(rate.polynomial.coefficients) for rate in rates))
    return np.concatenate([np.linspace(breaks[0], breaks[-1], points), breaks, np.nextafter(breaks, -np.inf)])
