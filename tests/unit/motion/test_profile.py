"""The jerk-limited profile: the analytic duration, its limits, rest at both ends, no network."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import virtualrobot_kernel
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.profile import jerk_limited_profile


def double_s_duration(length: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Return the duration of the double S profile from rest to rest.

    Biagiotti, Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), section 3.4.2, equations
    (3.19) to (3.30) for zero end velocities.
    """
    if velocity * jerk >= acceleration**2:
        ramp = acceleration / jerk + velocity / acceleration
    else:
        ramp = 2.0 * math.sqrt(velocity / jerk)
    cruise = length / velocity - ramp
    if cruise >= 0.0:
        return 2.0 * ramp + cruise
    if length >= 2.0 * acceleration**3 / jerk**2:  # the acceleration limit is reached
        half = acceleration / (2.0 * jerk)
        return 2.0 * (half + math.sqrt(half**2 + length / acceleration))
    return 4.0 * math.cbrt(length / (2.0 * jerk))


def test_the_duration_is_the_analytic_one_and_the_limits_hold(rng: np.random.Generator) -> None:
    for _ in range(300):
        length = 10.0 ** rng.uniform(-5.0, 1.0)
        velocity = rng.uniform(0.05, 5.0)
        acceleration = velocity / rng.uniform(0.03, 1.0)
        jerk = acceleration / rng.uniform(0.02, 1.0)
        law = jerk_limited_profile(length, velocity, acceleration, jerk)
        assert law.end == pytest.approx(double_s_duration(length, velocity, acceleration, jerk), rel=1e-9)
        u, v, a, j = law.states(np.linspace(0.0, law.end, 500), 3)[:, :, 0]
        assert np.all(np.diff(u) >= -1e-15 * length)
        for values, limit in ((v, velocity), (a, acceleration), (j, jerk)):
            assert np.abs(values).max() <= limit * (1.0 + 1e-9)
        assert (u[0], v[0], a[0]) == (0.0, 0.0, 0.0)
        assert u[-1] == pytest.approx(length, rel=1e-12)
        assert abs(v[-1]) <= 1e-12 * velocity
        assert abs(a[-1]) <= 1e-9 * acceleration


@pytest.mark.parametrize(
    ("length", "velocity", "acceleration", "jerk"),
    [(0.16, 2.0, 8.0, 80.0), (0.2, 2.0, 10.0, 100.0), (0.1, 1.0, 5.0, 50.0), (0.01, 0.25, 0.5, 5.0)],
)
def test_a_length_that_just_reaches_the_acceleration_limit_has_a_profile(
    length: float, velocity: float, acceleration: float, jerk: float
) -> None:
    # length = 2 a³ / j²: the phase of constant acceleration lasts 0 s.
    law = jerk_limited_profile(length, velocity, acceleration, jerk)
    assert law.end == pytest.approx(double_s_duration(length, velocity, acceleration, jerk), rel=1e-9)
    assert law.evaluate(law.end)[0] == pytest.approx(length, rel=1e-12)


def test_random_lengths_that_just_reach_the_acceleration_limit_have_profiles(rng: np.random.Generator) -> None:
    for _ in range(500):
        acceleration = rng.uniform(1.0, 30.0)
        jerk = acceleration * rng.uniform(5.0, 30.0)
        length = 2.0 * acceleration**3 / jerk**2
        velocity = acceleration**2 / jerk * float(rng.choice([1.0, 1.5]))
        law = jerk_limited_profile(length, velocity, acceleration, jerk)
        assert law.end == pytest.approx(double_s_duration(length, velocity, acceleration, jerk), rel=1e-9)


def test_value_velocity_and_acceleration_are_continuous(rng: np.random.Generator) -> None:
    length, velocity, acceleration = rng.uniform(0.5, 5.0, 3)
    law = jerk_limited_profile(length, velocity, acceleration, rng.uniform(5.0, 50.0))
    inner = law.breaks[1:-1]
    before, after = law.states(np.nextafter(inner, 0.0), 2), law.states(inner, 2)
    np.testing.assert_allclose(before, after, atol=1e-12)


def test_a_length_of_zero_takes_no_time() -> None:
    law = jerk_limited_profile(0.0, 1.0, 1.0, 1.0)
    assert law.end == 0.0
    assert law.evaluate(0.0) == [0.0]


@pytest.mark.parametrize("bad", [(-1.0, 1, 1, 1), (1, 0.0, 1, 1), (1, 1, math.inf, 1), (1, 1, 1, math.nan)])
def test_impossible_limits_are_refused(bad: tuple[float, float, float, float]) -> None:
    with pytest.raises(KernelError, match="must be finite"):
        jerk_limited_profile(*bad)


def test_equal_profiles_are_bit_equal() -> None:
    first, second = (jerk_limited_profile(0.7, 1.3, 5.0, 60.0) for _ in range(2))
    assert first.coefficients.tobytes() == second.coefficients.tobytes()


WITHOUT_DESCRIPTORS = """
import os, resource
import ruckig
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.plan import plan_ptp
ones = [1.0] * 7
limits = JointLimits(tuple("abcdefg"), [-3.0] * 7, [3.0] * 7, ones, ones, ones)
plan_ptp([0.0] * 7, [0.5] * 7, limits)  # loads what is loaded when it is first used, compiled code among it
# From here on no file and no socket can be opened, by Python or by native code.
free = os.dup(0)
os.close(free)
resource.setrlimit(resource.RLIMIT_NOFILE, (free, free))
print(plan_ptp([0.0] * 7, ones, limits).duration, flush=True)
given = ruckig.InputParameter(1)
given.intermediate_positions = [[0.5]]
given.target_position, given.max_velocity, given.max_acceleration, given.max_jerk = [1.0], [1.0], [1.0], [1.0]
try:
    print(ruckig.Ruckig(1, 0.01, 1).calculate(given, ruckig.Trajectory(1, 1)))
except ruckig.RuckigError as error:
    print("waypoints need the network:", type(error).__name__)
"""


def test_planning_opens_no_socket() -> None:
    # ruckig sends intermediate waypoints to a cloud service; the second half shows that this would be noticed here.
    result = subprocess.run(
        [sys.executable, "-c", WITHOUT_DESCRIPTORS],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "PYTHONPATH": str(Path(virtualrobot_kernel.__file__).parents[1])},
        check=False,
    )
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    planned, waypoints = next(line for line in lines if line[0].isdigit()), lines[-1]
    assert float(planned) == pytest.approx(double_s_duration(1.0, 1.0, 1.0, 1.0), rel=1e-9)
    assert waypoints == "waypoints need the network: RuckigError"


@pytest.mark.parametrize(("length", "limit"), [(1e308, 2.0), (1.0, 1e-300), (1.0, 5e-324)])
def test_a_motion_of_years_is_refused_instead_of_overflowing(length: float, limit: float) -> None:
    with pytest.raises(KernelError, match="the motion would take") as refused:
        jerk_limited_profile(length, limit, 8.0, 80.0)
    assert refused.value.reason is Reason.LIMIT_EXCEEDED
