"""Orientations of floating joints that follow setpoints.

In the columns of a quaternion a motion by setpoints reckons with quasi-coordinates, the integrals of the angular
velocity (`motion.orientation`), and 0. What leads from one orientation to another is a turn from where it is now.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.orientation import turn_between, turned, unit
from virtualrobot_kernel.motion.polynomial import Array


class Turning(NamedTuple):
    """Orientation of a floating joint, and that of its newest setpoint, as quaternions (4,) of these columns."""

    columns: list[int]
    now: Array
    newest: Array


def begun(limits: JointLimits, q: Array) -> tuple[tuple[Turning, ...], Array]:
    """Return orientations at joint positions q (k,), and q with the quasi-coordinates 0 in their columns."""
    found, q = [], q.copy()
    for columns in map(list, limits.quaternions):
        now = unit(q[columns], "the start")
        found.append(Turning(columns, now, now))
        q[columns] = 0.0
    return tuple(found), q


def led_to(
    turning: Sequence[Turning], now: Sequence[float], wanted: Sequence[float]
) -> tuple[tuple[Turning, ...], tuple[float, ...]]:
    """Return orientations with a newest setpoint, and this (k,) with quasi-coordinates, where `now` (k,) is."""
    found, values = [], list(wanted)
    for columns, here, _ in turning:
        newest = unit(np.array([wanted[column] for column in columns]), "a setpoint")
        found.append(Turning(columns, here, newest))
        for column, way in zip(columns, [*turn_between(here, newest).tolist(), 0.0], strict=True):
            values[column] = now[column] + way
    return tuple(found), tuple(values)


def check_rates(limits: JointLimits, wanted: Sequence[float]) -> None:
    """Raise KernelError where a velocity is wanted of the fourth component of a quaternion."""
    for *_, last in limits.quaternions:
        if wanted[last]:
            raise KernelError(
                f"a setpoint is refused: the velocity of {limits.names[last]!r} is 0, not {wanted[last]:.6g}; those of "
                "the other three components are the angular velocity",
                joint=limits.names[last],
                value=wanted[last],
            )


def gone_on(turning: Sequence[Turning], before: Sequence[float], now: Sequence[float]) -> tuple[Turning, ...]:
    """Return orientations after the quasi-coordinates (k,) have gone from `before` to `now` within a tick."""
    ways = (np.array([now[column] - before[column] for column in columns[:3]]) for columns, _, _ in turning)
    return tuple(
        one._replace(now=turned(one.now, way)) if way.any() else one for one, way in zip(turning, ways, strict=True)
    )


def correction(
    turning: Sequence[Turning], now: Sequence[float], counted: Sequence[float], least: float
) -> tuple[float, ...]:
    """Return what is to be added to setpoints (k,) as seen before, to be seen from where `now` (k,) is.

    Turns about different axes don't add up, so there is something to add, where it is above `least`.
    """
    found = [0.0] * len(counted)
    for columns, here, newest in turning:
        for column, way in zip(columns, turn_between(here, newest).tolist(), strict=False):
            off = now[column] + way - counted[column]
            found[column] = off if abs(off) > least else 0.0
    return tuple(found)


def positions(turning: Sequence[Turning], now: Sequence[float], states: Array) -> Array:
    """Return joint positions (m, k) where columns are at `states` (m, k) in the next m ticks, one after the other."""
    found = states.copy()
    for columns, here, _ in turning:
        own = columns[:3]
        steps = np.diff(states[:, own], axis=0, prepend=np.array([[now[column] for column in own]]))
        found[:, columns] = list(accumulate(steps, turned, initial=here))[1:]
    return found
