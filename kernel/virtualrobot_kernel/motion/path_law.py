"""Time law along any path: at rest at both ends, every limit kept all the way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.rates import Rate, joint_rates, nodes_of, table, tcp_rate
from virtualrobot_kernel.motion.time_optimal import time_optimal_law
from virtualrobot_kernel.numeric.laws import fastest_law


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
    if law is TimeLaw.TIME_OPTIMAL:
        return time_optimal_law(rates)
    return PiecewisePolynomial(*fastest_law(*table(rates), nodes_of(rates)))
