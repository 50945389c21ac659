"""What planning costs by motion type and time law: arc, spline and jog against a line of the same length."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import pi

import numpy as np
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.circle import Center
from virtualrobot_kernel.motion.jog import plan_cartesian_jog
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.plan import Plan, plan_circ, plan_lin, plan_ptp, plan_spline
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.poses import rotation_matrix

from benchmarks import time_laws
from benchmarks.kinematics import ARMS, chain_of
from benchmarks.rows import Row, row

LENGTH = 0.3
"""Meters, of line and arc alike."""

REPEATS = 15
BUDGET = 2.0
"""An arc may cost twice a line: its joint path bends more, so it has more pieces."""

LINE_BUDGET = 2.0
"""A line may cost twice what toppra takes for a spline of 20 pieces."""

POSES = 12
"""Through how many poses a spline goes along the same arc."""

OPTIMAL = TimeLaw.TIME_OPTIMAL

READY = {
    "iiwa 14": (0.3, 0.6, -0.2, -1.4, 0.1, 0.9, 0.2),
    "Panda": (0.0, -0.4, 0.0, -2.0, 0.0, 1.6, 0.8),
    "xArm6": (0.0, -0.4, -1.0, 0.0, 1.4, 0.0),
    "Puma 560": (0.1, -0.7, -0.5, 0.2, 0.9, 0.3),
}


def milliseconds(*plans: Callable[[], Plan]) -> list[float]:
    """Return the time of planning each, the least of several in turn: what else the machine does hits all alike."""
    best = [np.inf] * len(plans)
    for _ in range(REPEATS):
        for k, plan in enumerate(plans):
            start = time.perf_counter()
            plan()
            best[k] = min(best[k], (time.perf_counter() - start) * 1e3)
    return best


def arc_pose(here: Array, center: Center, angle: float) -> Array:
    """Return the pose (4, 4) on the half circle about `center` that is `angle` on from `here`, not turned."""
    pose = here.copy()
    assert center.axis is not None
    pose[:3, 3] = center.point + rotation_matrix(angle * center.axis) @ (here[:3, 3] - center.point)
    return pose


def jogged(kinematics: ChainKinematics, ready: Array, limits: JointLimits) -> Plan:
    """Return a jog to the side as far as the arm can go, at most 2 m."""
    way, still = np.array([0.0, -2.0, 0.0]), np.zeros(3)
    return plan_cartesian_jog(kinematics, ready, way, still, limits, CartesianLimits())[0]


def run() -> list[Row]:
    """Return rows for each arm: half a circle, a spline and a jog against a line; and the line against a PTP."""
    rows = []
    _, bare = time_laws.splined(np.random.default_rng(), 20)
    for arm in ARMS:
        kinematics = ChainKinematics(chain_of(arm))
        count = arm.axes
        rates = (np.full(count, value) for value in (2.0, 10.0, 100.0))
        limits = JointLimits(kinematics.joint_names, kinematics.lower, kinematics.upper, *rates)
        ready = np.array(READY[arm.name])
        here = kinematics.forward(ready)[-1]
        goal = here.copy()
        goal[1, 3] -= LENGTH
        center = Center(here[:3, 3] - (0.0, LENGTH / pi, 0.0), np.array([1.0, 0.0, 0.0]), pi)
        line = plan_lin(kinematics, ready, goal, limits)
        arc = plan_circ(kinematics, ready, center, None, limits)
        goals = [arc_pose(here, center, angle) for angle in np.linspace(0.0, pi, POSES + 1)[1:]]
        curve = plan_spline(kinematics, ready, goals, limits)
        ptp, lin, circ, spline, jog = milliseconds(
            lambda q=ready, p=line, m=limits: plan_ptp(q, p.goal, m),
            lambda k=kinematics, q=ready, g=goal, m=limits: plan_lin(k, q, g, m),
            lambda k=kinematics, q=ready, c=center, m=limits: plan_circ(k, q, c, None, m),
            lambda k=kinematics, q=ready, g=goals, m=limits: plan_spline(k, q, g, m),
            lambda k=kinematics, q=ready, m=limits: jogged(k, q, m),
        )
        pieces = [len(plan.tracks[0].path.coefficients) for plan in (arc, line, curve)]
        title = f"planning a CIRC of 0.3 m, {arm.name}"
        rows.append(row(title, circ, lin, "LIN of 0.3 m", "ms", BUDGET, f"{pieces[0]} pieces against {pieces[1]}"))
        title = f"planning a spline of 0.3 m through {POSES} poses, {arm.name}"
        rows.append(row(title, spline, lin, "LIN of 0.3 m", "ms", None, f"{pieces[2]} pieces against {pieces[1]}"))
        title = f"planning a jog as far as it goes, {arm.name}"
        rows.append(row(title, jog, lin, "LIN of 0.3 m", "ms", None))
        title = f"planning a LIN of 0.3 m, {arm.name}"
        rows.append(row(title, lin, ptp, "PTP to its end", "ms", None))
        rows.append(row(title, lin, time_laws.best_milliseconds(bare), "bare toppra on 20 pieces", "ms", LINE_BUDGET))
        fast_lin, fast_circ = milliseconds(
            lambda k=kinematics, q=ready, g=goal, m=limits: plan_lin(k, q, g, m, time_law=OPTIMAL),
            lambda k=kinematics, q=ready, c=center, m=limits: plan_circ(k, q, c, None, m, time_law=OPTIMAL),
        )
        rows.append(row(f"planning a time-optimal LIN, {arm.name}", fast_lin, lin, "jerk-limited LIN", "ms", None))
        rows.append(row(f"planning a time-optimal CIRC, {arm.name}", fast_circ, circ, "jerk-limited CIRC", "ms", None))
    return [*rows, *time_laws.run()]


if __name__ == "__main__":
    for result in run():
        print(result)
