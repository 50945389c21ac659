"""Free values that joints follow easily, against a linear program that knows the least that any could need."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog
from virtualrobot_kernel.motion.free_path import within_hull
from virtualrobot_kernel.paths.easing import KEPT, eased
from virtualrobot_kernel.paths.tool_query import Tolerances

from tests.tiers import Draws

Floats = NDArray[np.float64]

PLACES = np.linspace(0.0, 1.0, 81)


def bend(at: Floats, where: Floats, sharp: float) -> Floats:
    """Return what is asked of two joints (n, 2): each stands, and from a place on goes, as smoothly as `sharp` says."""
    return np.logaddexp(0.0, sharp * (at[:, None] - where)) / sharp


def least(where: Floats, sharp: float, mix: Floats, bounds: Floats) -> float:
    """Return the least greatest second derivative at the places that control values within bounds leave."""
    n, f = len(PLACES), bounds.shape[1]
    unit = np.eye(n)
    ends = np.concatenate([2.0 * unit[:1] - unit[1:2], unit, 2.0 * unit[-1:] - unit[-2:-1]])
    bends = within_hull(PLACES, ends).evaluate(PLACES, 2)
    after, here, before = (bend(PLACES + aside, where, sharp) for aside in (1e-4, 0.0, -1e-4))
    asked = (after - 2.0 * here + before) / 1e-8
    # Unknowns are the control values, and the greatest one: +- (asked + bends @ control @ mix) - greatest <= 0.
    joints = [np.concatenate([mix[axis, joint] * bends for axis in range(f)], axis=1) for joint in range(2)]
    over = np.concatenate([sign * one for one in joints for sign in (1.0, -1.0)])
    right = np.concatenate([-sign * asked[:, joint] for joint in range(2) for sign in (1.0, -1.0)])
    table = np.concatenate([over, -np.ones((len(over), 1))], axis=1)
    limits = [(low, high) for low, high in bounds.T.tolist() for _ in range(n)] + [(0.0, None)]
    found = linprog(np.append(np.zeros(f * n), 1.0), table, right, bounds=limits, method="highs")
    assert found.success
    return float(found.fun)


def test_joints_are_eased_wherever_a_third_of_that_would_do(draws: Draws, rng: np.random.Generator) -> None:
    """Bends that alone need twice to five times the limit, at random places, by values within random bounds.

    Least squares are not the least greatest one: they come to within three times of it.
    """
    possible = 0
    for _ in range(draws(40)):
        where, sharp = rng.uniform(0.2, 0.8, 2), rng.uniform(40.0, 120.0)
        mix, bounds = rng.normal(0.0, 1.0, (2, 2)), np.outer([-1.0, 1.0], rng.uniform(0.01, 0.15, 2))
        most = np.full(2, 0.25 * sharp / rng.uniform(2.0, 5.0))

        def postures(at: Floats, values: Floats) -> Floats:
            return bend(at, where, sharp) + values @ mix  # noqa: B023 called before the next draw

        tolerances = Tolerances(bounds, np.zeros(2, np.bool_))
        control, share = eased(PLACES, np.zeros((81, 2)), tolerances, postures, most)
        assert ((bounds[0] <= control) & (control <= bounds[1])).all()
        function = within_hull(PLACES, control)
        before, here, after = (
            postures(PLACES + aside, function.evaluate(PLACES + aside)) for aside in (-1e-5, 0.0, 1e-5)
        )
        assert np.abs((after - 2.0 * here + before) / 1e-10 / most).max() == pytest.approx(share, rel=1e-3)
        best = least(where, sharp, mix, bounds) / most[0]
        assert share >= best - 1e-3
        if best <= KEPT / 3.0:
            possible += 1
            assert share < 1.0
    assert possible


def test_without_a_posture_nothing_is_eased() -> None:
    tolerances = Tolerances(np.array([[-0.1], [0.1]]), np.zeros(1, np.bool_))
    control, share = eased(
        PLACES, np.full((81, 1), 0.05), tolerances, lambda at, _: np.full((len(at), 2), np.nan), np.ones(2)
    )
    assert share == np.inf and (control == 0.05).all()
