"""The way between ticks: where it truly goes is within what is said of it, with limits of the jerk and without."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.collision.brake_check import _curve

FINE = 7
"""Into how many parts a tick is cut."""


@pytest.mark.parametrize("dt", [0.001, 0.004, 0.02])
def test_a_way_whose_acceleration_jumps_is_within_its_wobble(dt: float, rng: np.random.Generator) -> None:
    """Five stretches of constant acceleration, at any times, one after the other: as laws without a jerk limit go."""
    ends = np.cumsum(rng.uniform(5.0, 20.0, 5)) * dt
    accelerations = rng.uniform(-10.0, 10.0, 5)

    def place(time: float) -> float:
        x = v = begin = 0.0
        for end, a in zip(ends.tolist(), accelerations.tolist(), strict=True):
            h = min(max(time - begin, 0.0), end - begin)
            x, v, begin = x + v * h + 0.5 * a * h * h, v + a * h, end
        return x

    ticks = int(ends[-1] / dt)
    path = _curve(np.array([[place(tick * dt)] for tick in range(ticks + 1)]), 0.0, dt, np.array([0.0]))
    assert path.wobble is not None
    wobble = float(path.wobble[0])
    assert wobble < 60.0 * dt**2 / 8.0, "no more than three of the greatest jumps"
    times = np.linspace(0.0, ticks * dt, FINE * ticks + 1).tolist()
    assert max(abs(float(path.at(time)[0]) - place(time)) for time in times) <= wobble + 1e-12
    for one, other in pairwise(times):
        assert abs(place(other) - place(one)) <= float(path.travel(one, other)[0]) + 2.0 * wobble + 1e-12
