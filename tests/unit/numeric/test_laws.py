"""Laws along paths: what limits need of them against NumPy's derivatives, and a peak between the places looked at."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.motion.planned import Track, peaks
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.rates import Rate, greatest_stretch, stretch_needed


@pytest.mark.parametrize("terms", [2, 4, 6])
def test_limits_need_of_a_law_what_the_derivatives_by_time_say(rng: np.random.Generator, terms: int) -> None:
    """Two rates, vectors of three on a part of the path and single joints on all of it; places and times beyond, too.

    Path and law jump between their pieces, which is nothing to those who look at them.
    """
    path = PiecewisePolynomial(np.sort(rng.uniform(0.0, 1.0, 5)), rng.normal(size=(4, 6, 6)))
    part = path.between(path.start + 0.2 * (path.end - path.start), path.end)
    along = 0.3 * rng.normal(size=(3, terms, 1))
    along[:, 0] += 0.5
    law = PiecewisePolynomial(np.sort(rng.uniform(0.0, 3.0, 4)), along)
    limits = rng.uniform(0.5, 2.0, (3, 6)), rng.uniform(0.5, 2.0, (3, 2))
    rates = [Rate(path.derivative(), 1, limits[0]), Rate(part.derivative(), 3, limits[1])]
    taus = np.sort(rng.uniform(law.start - 0.1, law.end + 0.1, 300))
    u = law.states(taus, 0)[0, :, 0]
    x = Track(path, law).derivatives(taus)[1:]
    single = np.abs(x) / limits[0][:, None] * ((u >= path.start) & (u <= path.end))[:, None]
    vectors = np.linalg.norm(x.reshape(3, -1, 2, 3), axis=3) / limits[1][:, None]
    vectors *= ((u >= part.start) & (u <= part.end))[:, None]
    wanted = np.concatenate([single, vectors], axis=2).max(axis=2) ** np.array([[1.0], [1.0 / 2.0], [1.0 / 3.0]])
    np.testing.assert_allclose(stretch_needed(rates, law, taus), wanted, rtol=1e-9, atol=1e-12)
    assert greatest_stretch(rates, law, taus, 2) >= wanted[:2].max() * (1.0 - 1e-9)
    every = Track(path, law).derivatives(Track(path, law).grid(2000))
    np.testing.assert_allclose(peaks(Track(path, law)), np.abs(every[1:]).max(axis=1), rtol=1e-9)


def test_without_rates_a_law_needs_nothing() -> None:
    law = PiecewisePolynomial(np.array([0.0, 1.0]), np.array([[[0.0], [1.0]]]))
    assert not stretch_needed([], law, np.linspace(0.0, 1.0, 5)).any()


def test_a_peak_between_the_places_is_looked_at_closely() -> None:
    """The velocity 1 - (s - 0.47)^2 of a joint is 1 at s = 0.47; a law that goes evenly is looked at 12 times."""
    rate = PiecewisePolynomial(np.array([0.0, 1.0]), np.array([[[1.0 - 0.47**2], [0.94], [-1.0]]]))
    law = PiecewisePolynomial(np.array([0.0, 1.0]), np.array([[[0.0], [1.0]]]))
    taus, limits = np.linspace(0.0, 1.0, 12), np.array([[1.0], [1e9], [1e9]])
    assert stretch_needed([Rate(rate, 1, limits)], law, taus).max() < 1.0 - 1e-4
    assert 1.0 - 1e-5 < greatest_stretch([Rate(rate, 1, limits)], law, taus, 1) <= 1.0
