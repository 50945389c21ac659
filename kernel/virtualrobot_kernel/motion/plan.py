"""Planners: PTP, LIN, CIRC, splines and joint trajectories become plans, or are refused with the place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.cartesian_plan import plan_circ, plan_lin, plan_spline
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits, checked_joints
from virtualrobot_kernel.motion.orientation import unit
from virtualrobot_kernel.motion.path import joint_line, smooth_path
from virtualrobot_kernel.motion.planned import Plan, plan_together, planned
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.motion.time_optimal import trapezoid
from virtualrobot_kernel.motion.trajectory_checks import check_limits, check_rows
from virtualrobot_kernel.motion.turning_path import turning_line, turning_path

__all__ = ["Plan", "plan_circ", "plan_lin", "plan_ptp", "plan_spline", "plan_together", "plan_trajectory"]


def plan_ptp(
    q_start: Sequence[float] | Array,
    q_goal: Sequence[float] | Array,
    limits: JointLimits,
    velocity_scale: float = 1.0,
    time_law: TimeLaw = TimeLaw.JERK_LIMITED,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> Plan:
    """Return the point-to-point motion: the straight line between two joint positions (k,), phase-synchronised.

    All joints share one law, the fastest that keeps every joint's velocity (times `velocity_scale` in (0, 1]),
    acceleration and, unless it is time-optimal, jerk. Continuous joints move by the plain difference, and quaternions
    turn evenly the shorter way. gentle: shares in (0, 1] of acceleration and jerk that are used.
    Raises LimitError naming a joint whose start or goal is outside its limits.
    """
    q_start = checked_joints(q_start, len(limits.names), "the start of a PTP motion")
    q_goal = checked_joints(q_goal, len(limits.names), "the goal of a PTP motion")
    limits.check(q_start, "the start of the PTP motion")
    limits.check(q_goal, "the goal of the PTP motion")
    path, quasi, way = joint_line(q_start, q_goal), None, q_goal - q_start
    if limits.quaternions:
        path, quasi = turning_line(q_start, q_goal, limits.quaternions)
        q_goal, way = path.evaluate(path.end), quasi.evaluate(quasi.start, 1)
    limits = limits.along(way)
    slow, travel = limits.scaled(velocity_scale, *gentle), np.abs(way)
    moving = travel > 0.0
    if moving.any():
        bounds = [
            float((values[moving] / travel[moving]).min()) for values in (slow.velocity, slow.acceleration, slow.jerk)
        ]
        law = jerk_limited_profile(1.0, *bounds) if time_law is TimeLaw.JERK_LIMITED else trapezoid(1.0, *bounds[:2])
    else:
        law = jerk_limited_profile(0.0, 1.0, 1.0, 1.0)
    return planned("ptp", path, law, limits, q_goal, quasi=quasi)


def plan_trajectory(
    q_start: Sequence[float] | Array,
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike | None,
    limits: JointLimits,
) -> Plan:
    """Return the motion through joint positions (m, k) at times (m,) in s, m >= 2, at rest at start and end.

    The path is `smooth_path`, with quaternions `turning_path`: it passes every sample at its time, with the given
    velocities (m, k) or its own.
    Raises KernelError when the times do not increase strictly from 0, something is not finite, the first sample is
    not at `q_start` (the current joints, to 1e-6), or an end velocity is not 0; LimitError naming joint, time, value
    and limit where position or velocity leaves its limits, also between the samples.
    """
    names = limits.names
    t, q = np.array(times, dtype=np.float64), np.array(positions, dtype=np.float64)
    v = None if velocities is None else np.array(velocities, dtype=np.float64)
    current = checked_joints(q_start, len(names), "the start of a trajectory")
    _check_samples(t, q, v, names)
    for columns in map(list, limits.quaternions):
        q[:, columns] = _continued(t, q[:, columns], current[columns], names[columns[0]].removesuffix("/qx"))
    for index in np.flatnonzero(np.abs(q[0] - current) > TOLERANCE):
        raise KernelError(
            f"the trajectory starts with joint {names[index]!r} at {q[0, index]:.9g}, but the joint is at "
            f"{current[index]:.9g}; they must agree to {TOLERANCE}",
            joint=names[index],
            value=q[0, index],
            current=current[index],
        )
    q[0] = current
    path, quasi = smooth_path(t, q, v), None
    if limits.quaternions:
        path, quasi = turning_path(t, q, v, limits.quaternions)
    check_limits(path, quasi or path, limits)
    law = PiecewisePolynomial(t[[0, -1]], np.array([[[0.0], [1.0]]]))
    return planned("trajectory", path, law, limits, q[-1], quasi=quasi)


def _continued(t: Array, quaternions: Array, current: Array, joint: str) -> Array:
    """Return unit quaternions (m, 4), each of two that are the same orientation the nearer one to that before it."""
    found = [current]
    for time, quaternion in zip(t, quaternions, strict=True):
        one = unit(quaternion, f"the joint {joint!r} of a trajectory at {time:.6g} s")
        found.append(one if one @ found[-1] >= 0.0 else -one)
    return np.array(found[1:])


def _check_samples(t: Array, q: Array, v: Array | None, names: tuple[str, ...]) -> None:
    check_rows(t, q, {"velocity": v}, names, fewest=2)
    if t[0] != 0.0:
        raise KernelError(f"the times of a trajectory start at 0, not {t[0]:.6g} s", time=t[0])
    if v is not None:
        for row in (0, -1):
            for joint in np.flatnonzero(v[row]):
                raise KernelError(
                    f"a trajectory starts and ends at rest, but joint {names[joint]!r} has velocity "
                    f"{v[row, joint]:.6g} at {t[row]:.6g} s",
                    joint=names[joint],
                    time=t[row],
                    value=v[row, joint],
                )
