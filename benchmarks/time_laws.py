"""Time laws against bare toppra and bare ruckig: what planning them costs, and how long the motions take."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import ruckig
from toppra import SplineInterpolator
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.path_law import path_law
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial

from benchmarks.rows import Row, row

JOINTS = 7
REPEATS = 15
PIECES = (20, 200)
BUDGETS = {20: 1.5}
"""By pieces: how many times as long as bare toppra, which knows no jerk, planning a jerk-limited law may take."""

SAME = 1.03
"""Both sides look for the shortest duration under the same limits; the grids differ."""


def best_milliseconds(call: Callable[[], object]) -> float:
    """Return the least time of several calls."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times) * 1e3


def limits() -> JointLimits:
    """Return the limits of an arm of middle size: 2 rad/s, 10 rad/s², 100 rad/s³."""
    rates = (np.full(JOINTS, value) for value in (2.0, 10.0, 100.0))
    wide = np.full(JOINTS, 1e3)
    return JointLimits(tuple(f"joint {i}" for i in range(JOINTS)), -wide, wide, *rates)


def splined(rng: np.random.Generator, pieces: int) -> tuple[PiecewisePolynomial, Callable[[], float]]:
    """Return a cubic spline through random postures, and what solves it by bare toppra and returns the duration (s)."""
    bound = limits()
    constraints = [JointVelocityConstraint(bound.velocity), JointAccelerationConstraint(bound.acceleration)]
    postures = np.cumsum(rng.normal(size=(pieces + 1, JOINTS)) * 0.3, axis=0)
    spline = SplineInterpolator(np.arange(pieces + 1.0), postures)
    grid = np.linspace(0.0, pieces, max(200, 6 * pieces) + 1)

    def bare() -> float:
        solver = TOPPRA(constraints, spline, gridpoints=grid, solver_wrapper="seidel")
        speeds = solver.compute_parameterization(0.0, 0.0)[1]
        assert speeds is not None
        return float((2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1])).sum())

    return PiecewisePolynomial(spline.cspl.x, spline.cspl.c[::-1].transpose(1, 0, 2)), bare


def along_splines(rng: np.random.Generator) -> list[Row]:
    """Return rows for cubic splines through random postures, which both sides take as they are."""
    bound, rows = limits(), []
    for pieces in PIECES:
        path, bare = splined(rng, pieces)
        laws = {law: path_law(path, bound, (), (), law).end for law in TimeLaw}
        peer = best_milliseconds(bare)
        for law in TimeLaw:
            name = law.value.lower().replace("_", "-")
            spent = best_milliseconds(lambda law=law, path=path: path_law(path, bound, (), (), law))
            what = f"{name} law along a spline of {pieces} pieces, 7 joints"
            budget = BUDGETS.get(pieces) if law is TimeLaw.JERK_LIMITED else None
            rows.append(row(f"planning the {what}", spent, peer, "bare toppra, unverified", "ms", budget))
            budget = SAME if law is TimeLaw.TIME_OPTIMAL else None
            rows.append(row(f"duration of the {what}", laws[law], bare(), "bare toppra, unverified", "s", budget))
    return rows


def point_to_point(rng: np.random.Generator) -> list[Row]:
    """Return rows for a straight line in joint space by either law, against ruckig for seven joints in phase."""
    bound = limits()
    start, goal = rng.uniform(-1.5, 1.5, (2, JOINTS))
    asked = ruckig.InputParameter(JOINTS)
    asked.current_position, asked.target_position = start.tolist(), goal.tolist()
    asked.max_velocity, asked.max_acceleration = bound.velocity.tolist(), bound.acceleration.tolist()
    asked.max_jerk = bound.jerk.tolist()
    asked.synchronization = ruckig.Synchronization.Phase
    found = ruckig.Trajectory(JOINTS)

    def bare() -> float:
        ruckig.Ruckig(JOINTS).calculate(asked, found)
        return found.duration

    rows = []
    for law in TimeLaw:
        name = f"{law.value.lower().replace('_', '-')} PTP, 7 joints"
        spent = best_milliseconds(lambda law=law: plan_ptp(start, goal, bound, 1.0, law))
        duration = plan_ptp(start, goal, bound, 1.0, law).duration
        rows.append(row(f"planning a {name}", spent, best_milliseconds(bare), "bare ruckig, jerk-limited", "ms", None))
        budget = SAME if law is TimeLaw.JERK_LIMITED else None
        rows.append(row(f"duration of the {name}", duration, bare(), "bare ruckig, jerk-limited", "s", budget))
    return rows


def run() -> list[Row]:
    """Measure and return the rows."""
    rng = np.random.default_rng()
    return [*point_to_point(rng), *along_splines(rng)]


if __name__ == "__main__":
    for result in run():
        print(result)
