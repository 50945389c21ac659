"""Piecewise polynomials: the plain arrays that every path and every time law is made of."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import comb, factorial, perm

import numpy as np
from numpy.typing import ArrayLike, NDArray

from virtualrobot_kernel.errors import KernelError

Array = NDArray[np.float64]

#: Breaks nearer to each other than this share of the whole are one.
_SHORTEST = 1e-12


@dataclass(frozen=True)
class Excursion:
    """First place where a piecewise polynomial leaves its bounds.

    `entered` is the parameter where component `component` crosses the bound; `parameter` and `value` are the worst
    point of the same polynomial piece.
    """

    entered: float
    parameter: float
    component: int
    value: float


@dataclass(frozen=True, eq=False)
class PiecewisePolynomial:
    """Vector function of one parameter, polynomial between breaks; constant (clamped) outside them.

    breaks: (K + 1,), strictly increasing (one piece of length zero is allowed: a function at one point).
    coefficients: (K, degree + 1, n), ascending powers of `x - breaks[k]`.
    """

    breaks: Array
    coefficients: Array
    _breaks: list[float] = field(init=False, repr=False)
    _scalar: list[list[float]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Freeze the arrays; raise KernelError when shapes, order or values are impossible."""
        breaks = np.array(self.breaks, dtype=np.float64)
        coefficients = np.array(self.coefficients, dtype=np.float64)
        if breaks.ndim != 1 or coefficients.ndim != 3 or len(breaks) != len(coefficients) + 1 or not len(coefficients):
            raise KernelError(
                f"a piecewise polynomial needs breaks (K + 1,) and coefficients (K, degree + 1, n), "
                f"not {breaks.shape} and {coefficients.shape}"
            )
        if not (np.isfinite(breaks).all() and np.isfinite(coefficients).all()):
            raise KernelError("a piecewise polynomial needs finite breaks and coefficients")
        steps = breaks[1:] - breaks[:-1]
        if not ((steps > 0.0).all() or (len(steps) == 1 and steps[0] == 0.0)):
            raise KernelError(
                f"breaks of a piecewise polynomial must increase; breaks[{int(np.argmin(steps))}] does not"
            )
        breaks.setflags(write=False)
        coefficients.setflags(write=False)
        object.__setattr__(self, "breaks", breaks)
        object.__setattr__(self, "coefficients", coefficients)
        object.__setattr__(self, "_breaks", breaks.tolist())
        # Plain floats make one evaluation of a scalar law five times as fast as arrays of one element.
        scalar = coefficients[:, :, 0].tolist() if coefficients.shape[2] == 1 else []
        object.__setattr__(self, "_scalar", scalar)

    @property
    def start(self) -> float:
        """First break."""
        return self._breaks[0]

    @property
    def end(self) -> float:
        """Last break."""
        return self._breaks[-1]

    @property
    def dimension(self) -> int:
        """Number n of components."""
        return self.coefficients.shape[2]

    def evaluate(self, x: ArrayLike, derivative: int = 0) -> Array:
        """Return the value or a derivative at `x`: shape (n,) for a scalar, (m, n) for m parameters."""
        points = np.asarray(x, dtype=np.float64)
        if points.ndim == 0:
            return self.state(float(points), derivative)[derivative]
        return self.states(points, derivative)[derivative]

    def state(self, x: float, order: int) -> Array:
        """Return value and derivatives up to `order` at one parameter, shape (order + 1, n)."""
        piece, local, inside = self._locate(x)
        return np.array(_basis(local, self.coefficients.shape[1], order, inside)) @ self.coefficients[piece]

    def states(self, x: Array, order: int) -> Array:
        """Return values and derivatives up to `order` at m parameters, shape (order + 1, m, n)."""
        within = np.minimum(np.maximum(x, self.breaks[0]), self.breaks[-1])
        piece = np.minimum(self.breaks[1:-1].searchsorted(within, side="right"), len(self.coefficients) - 1)
        local = within - self.breaks[piece]
        found = np.zeros((order + 1, len(x), self.dimension))
        local = local[:, None]
        # Horner's scheme for a polynomial and its derivatives over k!, a term at a time for all parameters.
        for terms in self.coefficients.transpose(1, 0, 2)[::-1]:
            for k in range(order, 0, -1):
                found[k] *= local
                found[k] += found[k - 1]
            found[0] *= local
            found[0] += terms.take(piece, axis=0)
        for k in range(2, order + 1):
            found[k] *= factorial(k)
        if order:
            found[1:, within != x] = 0.0
        return found

    def scalar_state(self, x: float) -> tuple[float, float, float]:
        """Return value, first and second derivative of a function with one component, as plain floats."""
        piece, local, inside = self._locate(x)
        value = first = second = 0.0
        for coefficient in reversed(self._scalar[piece]):
            second = second * local + 2.0 * first
            first = first * local + value
            value = value * local + coefficient
        return (value, first, second) if inside else (value, 0.0, 0.0)

    def derivative(self) -> PiecewisePolynomial:
        """Return the derivative as a piecewise polynomial of one degree less (at least 0)."""
        powers = np.arange(1, self.coefficients.shape[1])
        if not len(powers):
            return PiecewisePolynomial(self.breaks, np.zeros_like(self.coefficients))
        return PiecewisePolynomial(self.breaks, self.coefficients[:, 1:, :] * powers[None, :, None])

    def stretched(self, end: float) -> PiecewisePolynomial:
        """Return the same function with its parameter scaled uniformly from [0, self.end] to [0, end].

        The k-th derivative is divided by (end / self.end) ** k. A function at one point becomes constant.
        """
        if self.end == 0.0:
            return PiecewisePolynomial(np.array([0.0, end]), self.coefficients)
        factor = end / self.end
        breaks = self.breaks * factor
        breaks[-1] = end
        scale = factor ** -np.arange(self.coefficients.shape[1], dtype=np.float64)
        return PiecewisePolynomial(breaks, self.coefficients * scale[None, :, None])

    def between(self, begin: float, end: float) -> PiecewisePolynomial:
        """Return the same function on [begin, end] alone, start <= begin < end <= self.end."""
        shortest = _SHORTEST * (self.end - self.start)
        inside = self.breaks[(self.breaks > begin + shortest) & (self.breaks < end - shortest)]
        return self._with_breaks(np.concatenate([[begin], inside, [end]]))

    def onto(self, begin: float, end: float) -> PiecewisePolynomial:
        """Return the same function with its parameter mapped from [start, end] to these, begin < end."""
        factor = (end - begin) / (self.end - self.start)
        breaks = begin + (self.breaks - self.start) * factor
        breaks[-1] = end
        scale = factor ** -np.arange(self.coefficients.shape[1], dtype=np.float64)
        return PiecewisePolynomial(breaks, self.coefficients * scale[None, :, None])

    def first_excursion(self, lower: Array, upper: Array, tolerance: float) -> Excursion | None:
        """Return the first place where the function leaves [lower - tolerance, upper + tolerance] (n,), or None.

        Exact also between breaks: pieces whose Bernstein coefficients lie within the bounds do too (convex hull
        property, Farin, Curves and Surfaces for CAGD, 5th ed., ch. 5); the others are decided by polynomial roots.
        """
        low, high = lower - tolerance, upper + tolerance
        bernstein = self._bernstein()
        suspicious = np.any((bernstein < low) | (bernstein > high), axis=1)
        for piece in np.flatnonzero(suspicious.any(axis=1)):
            found = [
                excursion
                for component in np.flatnonzero(suspicious[piece])
                if (excursion := self._piece_excursion(int(piece), int(component), low[component], high[component]))
            ]
            if found:
                return min(found, key=lambda excursion: excursion.entered)
        return None

    def hull(self) -> tuple[Array, Array]:
        """Return bounds (n,) that the function keeps: exact for pieces of the first degree, else a little wider."""
        bernstein = self._bernstein()
        return bernstein.min(axis=(0, 1)), bernstein.max(axis=(0, 1))

    def slope_bounds(self, parts: int) -> tuple[Array, Array]:
        """Return breaks (m + 1,) that cut each piece into `parts`, and bounds (m, n) of |derivative| between them.

        Exact for pieces up to the second degree, else a little above the greatest value.
        """
        shares = np.arange(parts) / parts
        cuts = (self.breaks[:-1, None] + np.diff(self.breaks)[:, None] * shares).ravel()
        slopes = self.derivative()._with_breaks(np.append(cuts, self.breaks[-1]))
        return slopes.breaks, np.abs(slopes._bernstein()).max(axis=1)

    def _bernstein(self) -> Array:
        """Return the Bernstein coefficients (pieces, degree + 1, n): each piece is in their hull."""
        degree = self.coefficients.shape[1] - 1
        width = np.diff(self.breaks)
        scaled = self.coefficients * (width[:, None] ** np.arange(degree + 1))[:, :, None]
        to_bernstein = np.array([[comb(k, i) / comb(degree, i) for i in range(degree + 1)] for k in range(degree + 1)])
        return np.einsum("ki,pin->pkn", to_bernstein, scaled)

    def _piece_excursion(self, piece: int, component: int, low: float, high: float) -> Excursion | None:
        polynomial = np.polynomial.Polynomial(self.coefficients[piece, :, component])
        width = self._breaks[piece + 1] - self._breaks[piece]
        candidates = np.concatenate(([0.0, width], _roots_within(polynomial.deriv(), width)))
        values = polynomial(candidates)
        excess = np.maximum(values - high, low - values)
        worst = int(np.argmax(excess))
        if not excess[worst] > 0.0:
            return None
        if excess[0] > 0.0:
            entered = 0.0
        else:
            bound = high if values[worst] > high else low
            entered = min([*_roots_within(polynomial - bound, width).tolist(), float(candidates[worst])])
        origin = self._breaks[piece]
        return Excursion(origin + entered, origin + float(candidates[worst]), component, float(values[worst]))

    def _with_breaks(self, breaks: Array) -> PiecewisePolynomial:
        """Return the same function with other breaks, of which each old one that lies inside is one."""
        middles = 0.5 * (breaks[:-1] + breaks[1:])
        piece = np.clip(np.searchsorted(self.breaks, middles, side="right") - 1, 0, len(self.coefficients) - 1)
        shift = (breaks[:-1] - self.breaks[piece])[:, None]
        # Powers of x - new break instead of x - old break, by repeated synthetic division (Horner).
        coefficients = self.coefficients[piece]
        for k in range(coefficients.shape[1] - 1):
            for i in range(coefficients.shape[1] - 2, k - 1, -1):
                coefficients[:, i] += shift * coefficients[:, i + 1]
        return PiecewisePolynomial(breaks, coefficients)

    def _locate(self, x: float) -> tuple[int, float, bool]:
        breaks = self._breaks
        if x >= breaks[-1]:
            return len(breaks) - 2, breaks[-1] - breaks[-2], x == breaks[-1]
        if x < breaks[0]:
            return 0, 0.0, False
        piece = bisect_right(breaks, x) - 1
        return piece, x - breaks[piece], True


def joined(parts: Sequence[PiecewisePolynomial]) -> PiecewisePolynomial:
    """Return one function made of functions of n components each, of which each begins where the last one ends."""
    terms = max(part.coefficients.shape[1] for part in parts)
    breaks = [parts[0].breaks, *(part.breaks[1:] for part in parts[1:])]
    return PiecewisePolynomial(np.concatenate(breaks), np.concatenate([_padded(part, terms) for part in parts]))


def stacked(parts: Sequence[PiecewisePolynomial]) -> PiecewisePolynomial:
    """Return one function whose components are those of functions on the same range, one after the other."""
    breaks = merged([part.breaks for part in parts])
    parts = [part._with_breaks(breaks) for part in parts]
    terms = max(part.coefficients.shape[1] for part in parts)
    return PiecewisePolynomial(parts[0].breaks, np.concatenate([_padded(part, terms) for part in parts], axis=2))


def with_columns(path: PiecewisePolynomial, columns: Sequence[int], part: PiecewisePolynomial) -> PiecewisePolynomial:
    """Return a function with some components in place of its own, on the same range."""
    whole, order = stacked([path, part]), np.arange(path.dimension)
    order[columns] = path.dimension + np.arange(part.dimension)
    return PiecewisePolynomial(whole.breaks, whole.coefficients[:, :, order])


def merged(breaks: Sequence[ArrayLike]) -> Array:
    """Return all breaks in increasing order, the first and the last exactly; those apart by rounding are one."""
    ordered = np.unique(np.concatenate(breaks))
    apart = np.diff(ordered, append=np.inf) > _SHORTEST * (ordered[-1] - ordered[0])
    kept = ordered[apart]
    kept[0] = ordered[0]
    return kept


def flattened(functions: Sequence[PiecewisePolynomial]) -> tuple[NDArray[np.int64], Array, Array]:
    """Return f functions as compiled code takes them (`numeric.polynomials.one_of`): shapes (f, 5), breaks, terms.

    One that comes twice is there once.
    """
    shapes: dict[PiecewisePolynomial, tuple[int, ...]] = {}
    breaks = terms = 0
    for one in functions:
        if one not in shapes:
            shapes[one] = (breaks, terms, *one.coefficients.shape)
            breaks, terms = breaks + len(one.breaks), terms + one.coefficients.size
    return (
        np.array([shapes[one] for one in functions], np.int64),
        np.concatenate([one.breaks for one in shapes]),
        np.concatenate([one.coefficients.ravel() for one in shapes]),
    )


def _padded(part: PiecewisePolynomial, terms: int) -> Array:
    return np.pad(part.coefficients, ((0, 0), (0, terms - part.coefficients.shape[1]), (0, 0)))


def _basis(local: float, terms: int, order: int, inside: bool) -> list[list[float]]:
    """Return rows of derivative k of (1, x, x², ...) at `local`, for k = 0 ... order."""
    powers = [1.0]
    for _ in range(terms - 1):
        powers.append(powers[-1] * local)
    rows = [powers]
    for k in range(1, order + 1):
        if inside:
            rows.append([_PERMUTATIONS[k][i] * powers[i - k] if i >= k else 0.0 for i in range(terms)])
        else:
            rows.append([0.0] * terms)
    return rows


_PERMUTATIONS = [[float(perm(i, k)) for i in range(16)] for k in range(5)]


def _roots_within(polynomial: np.polynomial.Polynomial, width: float) -> Array:
    roots = polynomial.trim().roots()
    real = np.asarray(roots.real, dtype=np.float64)[np.abs(roots.imag) <= 1e-9 * max(width, 1e-12)]
    return np.sort(real[(real >= 0.0) & (real <= width)])
