"""Checks of joint trajectories: their samples, and the limits of position and velocity on their whole way."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial


def check_rows(t: Array, q: Array, more: Mapping[str, Array | None], names: tuple[str, ...], fewest: int) -> None:
    """Raise KernelError unless positions q (m, k), and what more is given of each joint, have finite rows at times t.

    t (m,): at least `fewest` times that increase strictly.
    """
    if t.ndim != 1 or len(t) < fewest:
        count = f"{fewest} times" if fewest > 1 else "1 time"
        raise KernelError(f"a trajectory needs at least {count}, not an array of shape {t.shape}")
    if q.shape != (len(t), len(names)):
        raise KernelError(f"{len(t)} times and {len(names)} joints need positions of shape {(len(t), len(names))}, "
                          f"not {q.shape}")  # fmt: skip
    plurals = {"velocity": "velocities", "acceleration": "accelerations"}
    for what, values in more.items():
        if values is not None and values.shape != q.shape:
            raise KernelError(f"the {plurals[what]} of a trajectory have shape {values.shape}, the positions {q.shape}")
    if not np.all(np.isfinite(t)):
        raise KernelError(f"times[{int(np.flatnonzero(~np.isfinite(t))[0])}] is not finite")
    for row in np.flatnonzero(np.diff(t) <= 0.0):
        raise KernelError(
            f"the times of a trajectory must increase strictly: times[{row}] is {t[row]:.9g} s, times[{row + 1}] is "
            f"{t[row + 1]:.9g} s",
            time=t[row + 1],
        )
    for what, values in {"position": q, **more}.items():
        if values is None:
            continue
        for row, joint in np.argwhere(~np.isfinite(values)):
            raise KernelError(
                f"the {what} of joint {names[joint]!r} at {t[row]:.6g} s is {values[row, joint]}; it must be finite",
                joint=names[joint],
                time=t[row],
                value=values[row, joint],
            )


def check_limits(
    path: PiecewisePolynomial, rated: PiecewisePolynomial, limits: JointLimits, since: float = 0.0
) -> None:
    """Raise LimitError naming joint, time, value and limit where a way leaves the limits of position or velocity.

    path: positions by time (s), rated: what their velocities are the derivatives of; since: what is told as time 0.
    """
    excursion = path.first_excursion(limits.lower, limits.upper, TOLERANCE)
    if excursion is not None:
        entered, at = excursion.entered - since, excursion.parameter - since
        what = f"the trajectory leaves the joint limits at {entered:.6g} s, at {at:.6g} s"
        raise limits.error(excursion.component, excursion.value, what, time=entered)
    excursion = rated.derivative().first_excursion(-limits.velocity, limits.velocity, TOLERANCE)
    if excursion is not None:
        name, limit = limits.names[excursion.component], float(limits.velocity[excursion.component])
        entered, at = excursion.entered - since, excursion.parameter - since
        raise LimitError(
            f"the trajectory is too fast from {entered:.6g} s on: at {at:.6g} s joint {name!r} has velocity "
            f"{excursion.value:.6g}, its limit is {limit:.6g} per second",
            joint=name,
            time=entered,
            value=excursion.value,
            limit=limit,
        )
