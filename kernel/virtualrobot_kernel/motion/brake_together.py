"""Brake of joints that keep the ratios of their velocities, so that what they move slows down on its way. Pure.

Joints that brake each on their own stop at different times, and a tool that was slow because their velocities cancelled
becomes fast meanwhile. Here they brake in the plane that their velocities (k,) and accelerations (k,) span: along the
velocities, and along what the accelerations have beside them, each as fast as its share of the limits allows.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from virtualrobot_kernel.motion import online
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.online import Bounds, JointState, StoppableTrajectory
from virtualrobot_kernel.motion.polynomial import Array

SHARE = 0.8
"""Share of the limits that the brake along the velocities gets where there is another one, which has the rest."""

SAMPLE_TICKS = 4
"""Number of ticks between the places at which a brake is looked at."""

_INSIDE = 1.0 - 1e-6
"""Share of the limits that both brakes take together, so that rounding leads past none."""

_ROUNDING, _NOTHING = 1e-9, 1e-12


def plane(*vectors: Array) -> Array:
    """Return orthonormal vectors (m, n), the first along the first of some vectors (n,), that span them all."""
    found: list[Array] = []
    for vector in vectors:
        rest = vector
        for axis in found:
            rest = rest - (axis @ rest) * axis
        length = float(np.linalg.norm(rest))
        if length > 1e-9 * (1.0 + float(np.linalg.norm(vector))) or (not found and length > 0.0):
            found.append(rest / length)
    return np.array(found).reshape(len(found), len(vectors[0]))


def plane_of(now: JointState) -> Array:
    """Return the axes (m, k) of a brake that begins in a state; none at rest."""
    return plane(np.array(now.v), np.array(now.a))


def brake(now: JointState, axes: Array, limits: JointLimits, bounds: Bounds, dt: float) -> JointState:
    """Return the joints `dt` seconds later on a brake along axes (m, k); each on its own where limits ask for that."""
    if not len(axes):
        return online.brake(now, bounds, dt)[1]
    then = _at(now, axes, _way(now, axes, bounds), dt)
    if keeps(now, then, limits, dt) and online.can_stop(now, then, bounds, dt):
        return then
    return online.brake(now, bounds, dt)[1]


def is_kept(
    now: JointState,
    axes: Array,
    limits: JointLimits,
    bounds: Bounds,
    dt: float,
    fits: Callable[[Array, Array], bool] | None = None,
) -> bool:
    """Return whether joints keep their limits on a brake along axes (m, k), and fit with positions and velocities (k,).

    It is looked at in places `SAMPLE_TICKS` apart.
    """
    if not len(axes):
        return not any(now.v) and not any(now.a)
    way = _way(now, axes, bounds)
    if not keeps(now, _at(now, axes, way, dt), limits, dt):
        return False
    ticks = math.ceil(way.duration / dt)
    for tick in (*range(0, ticks, SAMPLE_TICKS), ticks):
        q, v, a = map(np.array, _at(now, axes, way, tick * dt))
        if not (
            ((limits.lower <= q) & (q <= limits.upper)).all()
            and (np.abs(v) <= limits.velocity * (1.0 + _ROUNDING)).all()
            and (np.abs(a) <= limits.acceleration).all()
            and (fits is None or fits(q, v))
        ):
            return False
    return True


def positions(now: JointState, axes: Array, bounds: Bounds, dt: float, most: int) -> Array:
    """Return the joint positions (m, k) on a brake along axes (m, k): now and at each tick, at most so many."""
    if not len(axes):
        return np.array([now.q])
    way = _way(now, axes, bounds)
    ticks = min(max(1, math.ceil(way.duration / dt)), most)
    return np.array([now.q, *(_at(now, axes, way, tick * dt).q for tick in range(1, ticks + 1))])


def keeps(now: JointState, then: JointState, limits: JointLimits, dt: float) -> bool:
    """Return whether joints keep their limits of velocity, acceleration and jerk when they get from a state to another.

    Velocities count as they are once the acceleration has come to 0. What positions and velocities say must agree as it
    does under such a jerk, by the error of the trapezoidal rule.
    """
    (q, v, a), (joints, speeds, slopes) = (map(np.array, one) for one in (now, then))
    fastest = np.maximum(np.abs(speeds), np.abs(speeds + slopes * np.abs(slopes) / (2.0 * limits.jerk)))
    return bool(
        (fastest <= limits.velocity * (1.0 + _ROUNDING)).all()
        and (np.abs(slopes) <= limits.acceleration).all()
        and (np.abs(slopes - a) <= limits.jerk * dt).all()
        and (np.abs(joints - q - 0.5 * dt * (v + speeds)) <= limits.jerk * dt**3 / 6.0 + _ROUNDING).all()
    )


def _way(now: JointState, axes: Array, bounds: Bounds) -> StoppableTrajectory:
    """Return the brake along axes (m, k), as the way from 0 along each."""
    count = len(axes)
    shares = _INSIDE * np.array([1.0] if count == 1 else [SHARE, 1.0 - SHARE])
    rates = np.maximum(np.abs(axes), _NOTHING)
    most = [(shares * (np.array(limit) / rates).min(axis=1)).tolist() for limit in (bounds.acceleration, bounds.jerk)]
    along = [tuple((axes @ np.array(one)).tolist()) for one in (now.v, now.a)]
    free = Bounds([-math.inf] * count, [math.inf] * count, *most, couplings=())
    return online.brake(JointState((0.0,) * count, *along), free, 0.0)[0]


def _at(now: JointState, axes: Array, way: StoppableTrajectory, time: float) -> JointState:
    shift, speed, slope = (np.array(one) @ axes for one in way.at(time))
    return JointState(tuple((np.array(now.q) + shift).tolist()), tuple(speed.tolist()), tuple(slope.tolist()))
