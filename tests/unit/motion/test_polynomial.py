"""Piecewise polynomials: derivatives, clamping, stretching and exact bounds."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial, joined, stacked


def random_polynomial(rng: np.random.Generator, pieces: int = 5, degree: int = 5, n: int = 3) -> PiecewisePolynomial:
    breaks = np.cumsum(rng.uniform(0.2, 1.0, pieces + 1))
    return PiecewisePolynomial(breaks, rng.normal(size=(pieces, degree + 1, n)))


def test_values_and_derivatives_are_those_of_numpy_polynomials(rng: np.random.Generator) -> None:
    function = random_polynomial(rng)
    x = rng.uniform(function.start, function.end, 200)
    states = function.states(x, 3)
    for i, point in enumerate(x):
        piece = int(np.searchsorted(function.breaks, point, side="right")) - 1
        for component in range(3):
            polynomial = np.polynomial.Polynomial(function.coefficients[piece, :, component])
            expected = [polynomial.deriv(k)(point - function.breaks[piece]) for k in range(4)]
            np.testing.assert_allclose(states[:, i, component], expected, rtol=1e-12, atol=1e-11)
    for order in range(4):
        np.testing.assert_allclose(function.evaluate(x, order), states[order], rtol=1e-13, atol=1e-12)
        np.testing.assert_allclose(function.evaluate(x[0], order), states[order, 0], rtol=1e-13, atol=1e-12)
    np.testing.assert_allclose(function.derivative().evaluate(x), states[1], rtol=1e-12, atol=1e-12)


def test_one_component_is_evaluated_in_plain_floats(rng: np.random.Generator) -> None:
    function = random_polynomial(rng, n=1)
    for x in rng.uniform(function.start - 1.0, function.end + 1.0, 100):
        np.testing.assert_allclose(function.scalar_state(x), function.state(x, 2)[:, 0], rtol=1e-12, atol=1e-12)


def test_outside_the_breaks_the_ends_are_kept(rng: np.random.Generator) -> None:
    function = random_polynomial(rng)
    for outside, end in ((function.start - 0.5, function.start), (function.end + 0.5, function.end)):
        np.testing.assert_array_equal(function.evaluate(outside), function.evaluate(end))
        np.testing.assert_array_equal(function.state(outside, 3)[1:], 0.0)
        np.testing.assert_array_equal(function.states(np.array([outside]), 3)[1:], 0.0)


def test_stretching_scales_time_and_divides_derivatives(rng: np.random.Generator) -> None:
    function = random_polynomial(rng)
    function = PiecewisePolynomial(function.breaks - function.start, function.coefficients)
    factor = rng.uniform(1.5, 4.0)
    slow = function.stretched(function.end * factor)
    x = rng.uniform(0.0, function.end, 50)
    for order in range(4):
        expected = function.evaluate(x, order) / factor**order
        np.testing.assert_allclose(slow.evaluate(x * factor, order), expected, rtol=1e-9, atol=1e-9)


def test_a_part_is_the_same_function_there(rng: np.random.Generator) -> None:
    function = random_polynomial(rng)
    begin, end = np.sort(rng.uniform(function.start, function.end, 2))
    part = function.between(begin, end)
    assert (part.start, part.end) == (begin, end)
    x = np.linspace(begin, end, 100)
    assert np.allclose(part.states(x, 3), function.states(x, 3), rtol=1e-10, atol=1e-10)
    whole = function.between(function.start, function.end)
    assert np.array_equal(whole.breaks, function.breaks) and np.array_equal(whole.coefficients, function.coefficients)


def test_another_range_has_the_same_values_and_scaled_derivatives(rng: np.random.Generator) -> None:
    function = random_polynomial(rng)
    begin, length = rng.uniform(-2.0, 2.0), rng.uniform(0.1, 5.0)
    moved = function.onto(begin, begin + length)
    share = rng.random(100)
    factor = length / (function.end - function.start)
    x = function.start + share * (function.end - function.start)
    for k in range(4):
        values = moved.evaluate(begin + share * length, k) * factor**k
        assert np.allclose(values, function.evaluate(x, k), rtol=1e-9, atol=1e-9)


def test_functions_are_joined_and_stacked(rng: np.random.Generator) -> None:
    function = random_polynomial(rng)
    line = PiecewisePolynomial(function.breaks[[0, -1]], rng.normal(size=(1, 2, 2)))
    cuts = np.sort(rng.uniform(function.start, function.end, 2))
    ends = [function.start, *cuts, function.end]
    again = joined([function.between(a, b) for a, b in pairwise(ends)])
    both = stacked([line, function])
    x = rng.uniform(function.start, function.end, 200)
    assert np.allclose(again.states(x, 3), function.states(x, 3), rtol=1e-10, atol=1e-10)
    assert np.allclose(both.states(x, 3)[:, :, :2], line.states(x, 3), rtol=1e-10, atol=1e-10)
    assert np.allclose(both.states(x, 3)[:, :, 2:], function.states(x, 3), rtol=1e-10, atol=1e-10)


def test_breaks_that_differ_by_rounding_are_one_when_stacked(rng: np.random.Generator) -> None:
    function = random_polynomial(rng)
    close = PiecewisePolynomial(function.breaks * (1.0 + 1e-15), function.coefficients)
    assert len(stacked([function, close.onto(function.start, function.end)]).breaks) == len(function.breaks)


def test_the_first_excursion_is_found_between_the_breaks(rng: np.random.Generator) -> None:
    for _ in range(50):
        knots = np.cumsum(rng.uniform(0.2, 1.0, 6))
        function = quintic_hermite(knots, *rng.normal(size=(3, 6, 2)))
        dense = function.evaluate(np.linspace(function.start, function.end, 20001))
        lower, upper = dense.min(axis=0), dense.max(axis=0)
        # The dense grid misses a peak by less than 1e-4 of the range, so just outside it nothing is found ...
        assert function.first_excursion(lower - 1e-3, upper + 1e-3, 0.0) is None
        # ... and a bound below the peak is crossed no later than by the dense values, which miss what peaks just above.
        upper[1] -= 0.05 * (upper[1] - lower[1])
        excursion = function.first_excursion(lower - 1e-3, upper + np.array([1e-3, 0.0]), 0.0)
        assert excursion is not None
        assert excursion.component == 1
        first = float(np.linspace(function.start, function.end, 20001)[int(np.argmax(dense[:, 1] > upper[1]))])
        assert excursion.entered <= first
        there = function.evaluate(excursion.entered)[1]
        assert there == pytest.approx(upper[1], abs=1e-6) if excursion.entered > function.start else there > upper[1]
        assert function.evaluate(excursion.parameter)[1] == pytest.approx(excursion.value, abs=1e-9)
        assert excursion.value > upper[1]


@pytest.mark.parametrize(
    ("breaks", "coefficients", "message"),
    [
        ([0.0, 1.0], np.zeros((2, 4, 1)), "needs breaks"),
        ([0.0, 1.0, 1.0], np.zeros((2, 4, 1)), r"breaks\[1\]"),
        ([0.0, np.nan], np.zeros((1, 4, 1)), "finite"),
    ],
)
def test_impossible_arrays_are_refused(breaks: list[float], coefficients: np.ndarray, message: str) -> None:
    with pytest.raises(KernelError, match=message):
        PiecewisePolynomial(np.array(breaks), coefficients)


def test_arrays_are_frozen(rng: np.random.Generator) -> None:
    with pytest.raises(ValueError, match="read-only"):
        random_polynomial(rng).coefficients[0, 0, 0] = 1.0
