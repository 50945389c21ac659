"""Jerk-limited time law of a scalar, from rest to rest (library ruckig, one degree of freedom)."""

from __future__ import annotations

import math

import numpy as np
import ruckig

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial

#: The longest motion (s): three years.
_LONGEST = 1e8


def jerk_limited_profile(
    length: float, max_velocity: float, max_acceleration: float, max_jerk: float
) -> PiecewisePolynomial:
    """Return the fastest law u(tau), u(0) = 0, u(end) = length, at rest at both ends, as exact cubic pieces.

    Source: Berscheid, Kröger, Jerk-limited Real-time Trajectory Generation with Arbitrary Target States (RSS 2021),
    which for rest to rest is the double S profile of Biagiotti, Melchiorri, Trajectory Planning for Automatic
    Machines and Robots (2008), section 3.4. Waypoints are never given to ruckig: they would go to a cloud service.
    A length of 0 gives a law of duration 0. Raises KernelError when a value is not finite, a limit not positive, or the
    law longer than three years.
    """
    if not (math.isfinite(length) and length >= 0.0):
        raise KernelError(f"the length of a profile must be finite and not negative, not {length}", length=length)
    for name, limit in (("velocity", max_velocity), ("acceleration", max_acceleration), ("jerk", max_jerk)):
        if not (math.isfinite(limit) and limit > 0.0):
            raise KernelError(f"the {name} limit of a profile must be finite and above 0, not {limit}", limit=limit)
    if length == 0.0:
        return PiecewisePolynomial(np.zeros(2), np.zeros((1, 4, 1)))
    # In units of the length and of the shortest conceivable time, ruckig sees numbers near 1 whatever the robot is.
    unit = max(length / max_velocity, math.sqrt(length / max_acceleration), math.cbrt(length / max_jerk))
    if unit > _LONGEST:
        raise KernelError(
            f"the motion would take {unit:.3g} s or more; the longest that is planned takes {_LONGEST:g} s",
            reason=Reason.LIMIT_EXCEEDED,
        )
    times, jerks = _unit_profile(
        max_velocity * unit / length, max_acceleration * unit**2 / length, max_jerk * unit**3 / length
    )
    breaks, pieces = [0.0], []
    position = velocity = acceleration = 0.0
    for time, jerk in zip(times, jerks, strict=True):
        if time <= 1e-12:
            continue
        pieces.append([position, velocity, acceleration / 2.0, jerk / 6.0])
        position += time * (velocity + time * (acceleration / 2.0 + time * jerk / 6.0))
        velocity += time * (acceleration + time * jerk / 2.0)
        acceleration += time * jerk
        breaks.append(breaks[-1] + time)
    scale = np.array([length / unit**power for power in range(4)])
    return PiecewisePolynomial(np.array(breaks) * unit, (np.array(pieces) * scale)[:, :, None])


def _unit_profile(max_velocity: float, max_acceleration: float, max_jerk: float) -> tuple[list[float], list[float]]:
    """Return durations and jerks of the seven phases from 0 to 1."""
    given = ruckig.InputParameter(1)
    given.target_position = [1.0]
    # Above these ruckig's root finding fails; no law from 0 to 1 in a time of 1 or more reaches the first, and the
    # others cost it less than a ten-thousandth of its time.
    given.max_velocity = [min(max_velocity, 10.0)]
    given.max_acceleration = [min(max_acceleration, 1e4)]
    given.max_jerk = [min(max_jerk, 1e8)]
    trajectory = ruckig.Trajectory(1)
    try:
        result = ruckig.Ruckig(1).calculate(given, trajectory)
    except ruckig.RuckigError:
        # Where the acceleration limit is reached for one moment only, as on 0.2 rad at 10 rad/s² and 100 rad/s³,
        # rounding makes ruckig miss the root. It does so within a few units in the last place of that jerk.
        given.max_jerk = [given.max_jerk[0] * (1.0 - 1e-10)]
        result = ruckig.Ruckig(1).calculate(given, trajectory)
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise KernelError(
            f"ruckig found no profile for velocity {max_velocity}, acceleration {max_acceleration}, jerk {max_jerk} "
            f"over length 1: {result}",
            reason=Reason.INTERNAL,
        )
    profile = trajectory.profiles[0][0]
    return list(profile.t), list(profile.j)
