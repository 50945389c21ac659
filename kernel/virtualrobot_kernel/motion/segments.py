"""Joint trajectories whose segments are given by their ends, as ros2_control's joint_trajectory_controller runs them.

Source of the formulas: ros2_controllers, joint_trajectory_controller/src/trajectory.cpp,
`Trajectory::interpolate_between_points` (Apache-2.0).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.planned import Plan, Track, peaks
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial, joined
from virtualrobot_kernel.motion.trajectory_checks import check_limits, check_rows

PASSED = 1e-9
"""Time (s) by which a point that is due now may be past by rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class TrajectoryPoints:
    """Points of a trajectory of k joints, and the way from the first to the last.

    times (m,): s since its begin, not negative, strictly growing. positions (m, k): rad or m. velocities, accelerations
    (m, k): per s and s², None where none are given. path: from the first point on, by time since its begin, to the last
    one and, where that has a velocity, on until it stands; None where there is one point, at rest. most (3, k): largest
    |velocity|, |acceleration| and |jerk| on it. goal (k,): where it stands in the end.
    """

    times: Array
    positions: Array
    velocities: Array | None
    accelerations: Array | None
    path: PiecewisePolynomial | None
    most: Array
    goal: Array


@dataclass(frozen=True, slots=True, eq=False)
class JointMotion:
    """Positions, velocities and accelerations (k,) of joints at one moment: rad or m, per s, per s²."""

    positions: Array
    velocities: Array
    accelerations: Array


def points(
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike | None,
    accelerations: ArrayLike | None,
    limits: JointLimits,
) -> TrajectoryPoints:
    """Return the points of a trajectory.

    Raises KernelError for times that are negative or don't increase strictly, for shapes that don't fit, for what is
    not finite, for accelerations without velocities, and for joints with a quaternion; LimitError naming joint, time,
    value and limit where position or velocity leaves its limits, also between the points.
    """
    t, q = np.array(times, dtype=np.float64), np.array(positions, dtype=np.float64)
    v, a = (None if given is None else np.array(given, dtype=np.float64) for given in (velocities, accelerations))
    check_rows(t, q, {"velocity": v, "acceleration": a}, limits.names, fewest=1)
    if t[0] < 0.0:
        raise KernelError(f"the times of a trajectory are 0 or later, not {t[0]:.6g} s", time=t[0])
    if a is not None and v is None:
        raise KernelError("a trajectory with accelerations needs velocities, too")
    if limits.quaternions:
        joint = limits.names[limits.quaternions[0][0]].removesuffix("/qx")
        raise KernelError(f"the joint {joint!r} has a quaternion, which segments can't turn; leave it out", joint=joint)
    limits.check(q[0], f"the trajectory at {t[0]:.6g} s")
    parts = [segments(t, q, v, a)] if len(t) > 1 else []
    goal = q[-1]
    if v is not None and v[-1].any():
        seconds = float((np.abs(v[-1]) / limits.acceleration).max())
        terms = np.stack([q[-1], v[-1], -v[-1] / (2.0 * seconds)])
        parts.append(PiecewisePolynomial(np.array([t[-1], t[-1] + seconds]), terms[None]))
        goal = q[-1] + v[-1] * seconds / 2.0
    if not parts:
        return TrajectoryPoints(t, q, v, a, None, np.zeros((3, len(goal))), goal)
    path = joined(parts)
    check_limits(path, path, limits)
    return TrajectoryPoints(t, q, v, a, path, peaks(Track(path, _evenly(path))), goal)


def segments(t: Array, q: Array, v: Array | None, a: Array | None) -> PiecewisePolynomial:
    """Return the way through positions q (m, k) at times t (m,): between two of them of degree 1, 3 or 5.

    The degree is that by which also the velocities v (m, k), and the accelerations a (m, k), are those given, if they
    are.
    """
    seconds = np.diff(t)[:, None]
    step = np.diff(q, axis=0)
    if v is None:
        return PiecewisePolynomial(t, np.stack([q[:-1], step / seconds], axis=1))
    v0, v1 = v[:-1] * seconds, v[1:] * seconds
    if a is None:
        terms = [q[:-1], v0, 3.0 * step - 2.0 * v0 - v1, -2.0 * step + v0 + v1]
    else:
        a0, a1 = a[:-1] * seconds**2, a[1:] * seconds**2
        terms = [
            *(q[:-1], v0, a0 / 2.0),
            (20.0 * step - 3.0 * a0 + a1 - 12.0 * v0 - 8.0 * v1) / 2.0,
            (-30.0 * step + 3.0 * a0 - 2.0 * a1 + 16.0 * v0 + 14.0 * v1) / 2.0,
            (12.0 * step - a0 + a1 - 6.0 * v0 - 6.0 * v1) / 2.0,
        ]
    return PiecewisePolynomial(t, np.stack([term / seconds**power for power, term in enumerate(terms)], axis=1))


def plan_points(given: TrajectoryPoints, here: JointMotion, elapsed: float, limits: JointLimits) -> Plan:
    """Return the motion from where joints are, and as fast as they are, through the points that are not past.

    elapsed: how long ago (s) the trajectory began; negative where it begins later. Its nominal time begins with 0 now.
    Raises KernelError where all points are past, and where the first one is due now and the joints are elsewhere (to
    1e-6); LimitError as `points` does, of the way to the first point.
    """
    left = int(np.searchsorted(given.times, elapsed - PASSED))
    if left == len(given.times):
        raise KernelError(
            f"the trajectory's last point was due {elapsed - given.times[-1]:.6g} s ago; give a later start time",
            time=given.times[-1],
        )
    due, parts, most = float(given.times[left]), [], given.most
    if due - elapsed > PASSED:
        first = segments(np.array([elapsed, due]), *_to_point(given, here, left))
        check_limits(first, first, limits, since=elapsed)
        parts.append(first)
        most = np.maximum(most, peaks(Track(first, _evenly(first))))
    else:
        _check_start(given.positions[left], here.positions, limits.names)
    if given.path is not None and due < given.path.end:
        parts.append(given.path if left == 0 else given.path.between(due, given.path.end))
    if not parts:
        parts = [PiecewisePolynomial(np.array([due, due]), given.goal[None, None])]
    path = joined(parts)
    path = PiecewisePolynomial(path.breaks - path.start, path.coefficients)
    own = np.stack([limits.velocity, limits.acceleration, limits.jerk])
    track = Track(path, _evenly(path))
    return Plan("trajectory", limits.names, (track,), path.evaluate(path.start), given.goal, *np.maximum(own, most))


def _to_point(given: TrajectoryPoints, here: JointMotion, left: int) -> tuple[Array, Array | None, Array | None]:
    """Return positions, velocities and accelerations (2, k), here and at a point, where that gives them."""
    v, a = given.velocities, given.accelerations
    return (
        np.stack([here.positions, given.positions[left]]),
        None if v is None else np.stack([here.velocities, v[left]]),
        None if a is None else np.stack([here.accelerations, a[left]]),
    )


def _evenly(path: PiecewisePolynomial) -> PiecewisePolynomial:
    """Return the law that goes along a path by its own time."""
    return PiecewisePolynomial(path.breaks[[0, -1]], np.array([[[path.start], [1.0]]]))


def _check_start(first: Array, here: Array, names: tuple[str, ...]) -> None:
    for index in np.flatnonzero(np.abs(first - here) > TOLERANCE):
        raise KernelError(
            f"the trajectory starts with joint {names[index]!r} at {first[index]:.9g}, but the joint is at "
            f"{here[index]:.9g}; they must agree to {TOLERANCE}, or the first point be later",
            joint=names[index],
            value=first[index],
            current=here[index],
        )
