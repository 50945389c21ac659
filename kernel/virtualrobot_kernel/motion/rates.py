"""Rates of limited quantities along a path, by the path parameter s: each a vector with limits of its length.

With f(s) = dx/ds of a quantity x and the law s(t), x has the velocity f s', the acceleration f s'' + f' s'^2 and the
jerk f s''' + 3 f' s' s'' + f'' s'^3. A joint is a quantity of one component; the position and the rotation of a TCP
have three.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.bounds import JointBound, TcpBound
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial, flattened, merged
from virtualrobot_kernel.numeric import laws

#: Nodes of the polynomial that stands for a rate on one piece, and how exactly it has to: a share of the rate, or of
#: this many m or rad for one of the parameter where the rate is smaller, as that of a TCP which is to stand still.
_NODES, _EXACT, _SMALL = 9, 1e-6, 1e-2
_SMALLEST_PIECE = 1e-4
#: Cells of a path: at least, and on each piece at least.
_CELLS, _CELLS_PER_PIECE = 200, 6
_ONCE = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 12))
_ONCE_COEFFICIENTS = np.linalg.inv(np.vander(_ONCE, increasing=True))


@dataclass(frozen=True, eq=False)
class Rate:
    """Rate f(s) of quantities, `size` components of it for each, on the range of `polynomial`.

    limits (3, n / size): the greatest velocity, acceleration and jerk of each quantity.
    """

    polynomial: PiecewisePolynomial
    size: int
    limits: Array

    @property
    def begin(self) -> float:
        """Path parameter at which its range begins."""
        return self.polynomial.start

    @property
    def end(self) -> float:
        """Path parameter at which its range ends."""
        return self.polynomial.end

    def lengths(self, vectors: Array) -> Array:
        """Return the lengths (m, n / size) of the quantities' vectors (m, n)."""
        if self.size == 1:
            return np.abs(vectors)
        # Column by column: numpy is slow along an axis of three.
        return np.sqrt(sum(vectors[:, first :: self.size] ** 2 for first in range(self.size)))


def joint_rates(path: PiecewisePolynomial, limits: JointLimits, bounds: Sequence[JointBound]) -> list[Rate]:
    """Return the rates of the joints on the whole path, and on the ranges where they have to be slower."""
    whole = path.derivative()
    rows = np.stack([limits.velocity, limits.acceleration, limits.jerk])
    rates = _with_vectors(whole, rows, limits)
    for bound in bounds:
        share = np.atleast_2d(bound.share)
        if bound.end > bound.begin and np.any(share < 1.0):
            slow = np.concatenate([rows[: len(share)] * share, rows[len(share) :]])
            rates += _with_vectors(_within(whole, bound), slow, limits)
    return rates


def _with_vectors(function: PiecewisePolynomial, rows: Array, limits: JointLimits) -> list[Rate]:
    """Return the rates of joints with limits (3, k), and those of vectors among them."""
    rates = [Rate(function, 1, rows)]
    for columns in map(list, limits.vectors):
        part = PiecewisePolynomial(function.breaks, function.coefficients[:, :, columns])
        rates.append(Rate(part, len(columns), rows[:, columns[:1]]))
    return rates


def tcp_rate(path: PiecewisePolynomial, bound: TcpBound) -> Rate:
    """Return the rates of a TCP's position and rotation on the range of `bound`: J(q(s)) q'(s)."""
    part = _within(path, bound)

    def twist(s: float) -> Array:
        q, rate = part.state(s, 1)[:, bound.columns]
        return bound.tcp.jacobian(q) @ rate

    return Rate(fitted(twist, part.breaks), 3, _rows(bound.limits))


def tcp_rate_once(path: PiecewisePolynomial, bound: TcpBound) -> Rate:
    """Return as `tcp_rate` the rates along a path of one short piece, by one polynomial and without a check of it."""
    width = path.end - path.start
    states = path.states(path.start + width * _ONCE, 1)[:, :, bound.columns]
    twists = np.array([bound.tcp.jacobian(q) @ rate for q, rate in zip(states[0], states[1], strict=True)])
    coefficients = _ONCE_COEFFICIENTS @ twists / (width ** np.arange(len(_ONCE)))[:, None]
    return Rate(PiecewisePolynomial(np.array([path.start, path.end]), coefficients[None]), 3, _rows(bound.limits))


def _within(function: PiecewisePolynomial, bound: JointBound | TcpBound) -> PiecewisePolynomial:
    return function.between(max(bound.begin, function.start), min(bound.end, function.end))


def cartesian_rate(tcp_path: CartesianPath, path: PiecewisePolynomial, limits: CartesianLimits) -> Rate:
    """Return the rates of position and rotation along the Cartesian path that a joint path on [0, 1] follows."""
    return Rate(fitted(tcp_path.twist, np.unique([path.start, *tcp_path.knots, path.end])), 3, _rows(limits))


def _rows(limits: CartesianLimits) -> Array:
    return np.array(
        [
            [limits.velocity, limits.rotation_velocity],
            [limits.acceleration, limits.rotation_acceleration],
            [limits.jerk, limits.rotation_jerk],
        ]
    )


def fitted(function: Callable[[float], Array], breaks: Array) -> PiecewisePolynomial:
    """Return polynomials through Chebyshev points of a function that is smooth between `breaks`, halved where need be.

    function: from a parameter to (n,).
    """
    nodes = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, _NODES))
    to_coefficients = np.linalg.inv(np.vander(nodes, increasing=True))
    found: list[tuple[float, Array]] = []
    waiting = list(pairwise(breaks.tolist()))[::-1]
    shortest = _SMALLEST_PIECE * float(breaks[-1] - breaks[0])
    while waiting:
        begin, end = waiting.pop()
        width = end - begin
        inside = np.nextafter(end, begin)
        values = np.array([function(min(begin + width * float(x), inside)) for x in nodes])
        coefficients = to_coefficients @ values
        # The size of the highest terms is that of what is missing beyond them.
        if np.abs(coefficients[-2:]).max() > _EXACT * max(float(np.abs(values).max()), _SMALL) and width > shortest:
            waiting += [(0.5 * (begin + end), end), (begin, 0.5 * (begin + end))]
            continue
        found.append((begin, coefficients / (width ** np.arange(_NODES))[:, None]))
    return PiecewisePolynomial(
        np.array([*(begin for begin, _ in found), breaks[-1]]), np.stack([coefficients for _, coefficients in found])
    )


def nodes_of(rates: Sequence[Rate]) -> Array:
    """Return the nodes (N + 1,) of the path of the first rate: its breaks, where ranges end, and points between."""
    edges = merged([rates[0].polynomial.breaks, *([rate.begin, rate.end] for rate in rates)])
    each = max(_CELLS_PER_PIECE, -(-_CELLS // (len(edges) - 1)))
    steps = np.arange(each) / each
    return np.append((edges[:-1, None] + np.diff(edges)[:, None] * steps).ravel(), edges[-1])


def table(rates: Sequence[Rate], *others: PiecewisePolynomial) -> tuple[NDArray[Any], ...]:
    """Return rates, and other functions after them, as `numeric.laws` takes them."""
    limits = np.concatenate([np.empty((3, 0)), *(rate.limits for rate in rates)], axis=1)
    sizes = np.array([rate.size for rate in rates], np.int64)
    return *flattened([*(rate.polynomial for rate in rates), *others]), sizes, np.ascontiguousarray(limits)


def stretch_needed(rates: Sequence[Rate], law: PiecewisePolynomial, taus: Array) -> Array:
    """Return by how much the law has to be slower at each nominal time (m,), for each limit to be kept there: (3, m).

    Rows: velocity, acceleration, jerk. A stretch by c divides velocities by c, accelerations by c², jerks by c³.
    """
    needed = np.empty((3, len(taus)))
    laws.stretch_needed(*table(rates, law), taus, needed)
    return needed


def greatest_stretch(rates: Sequence[Rate], law: PiecewisePolynomial, taus: Array, rows: int = 3) -> float:
    """Return the greatest of `stretch_needed`, of its first `rows`; peaks are looked at closely.

    taus (m,): increasing nominal times.
    """
    return laws.greatest_stretch(*table(rates, law), taus, rows)
