"""Laws of brakes: the time-optimal stop of one coordinate, compiled.

A brake is a law u(t) of up to three pieces, (3, 5): the time (s) at which each begins, inf for one that is not there,
and the coefficients of t^0 ... t^3 from then on.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from virtualrobot_sdk.compiled.cache import inlined

Floats = np.ndarray[Any, np.dtype[np.float64]]

#: Phases shorter than this (s) are left out.
SHORTEST = 1e-12


@inlined
def brake_phases(speed: float, slope: float, acceleration: float, jerk: float) -> tuple[float, float, float]:
    """Return the durations (s) of the time-optimal stop from u' = speed >= 0, u'' = slope; inf when there is none.

    Jerk -J until u'' = -a_p, jerk 0, jerk +J until u'' = 0. The first and last phase change u' by (u''² - a_p²) / 2J
    and -a_p² / 2J, so without the middle one a_p² = J u' + u''² / 2; where that exceeds A², a_p = A and the middle one
    lasts (u' + u''² / 2J - A² / J) / A. Source: the end of the double S profile, Biagiotti, Melchiorri, Trajectory
    Planning for Automatic Machines and Robots (2008), section 3.4. A is `acceleration` (1/s²), or the deceleration
    -u'' when that is larger already; J is `jerk` (1/s³). There is none where the deceleration is so large that even
    jerk +J would end it with u' < 0.
    """
    peak = math.sqrt(jerk * max(speed, 0.0) + 0.5 * slope * slope)
    if peak < -slope:
        return math.inf, math.inf, math.inf
    return phases_with_peak(peak, speed, slope, acceleration, jerk)


@inlined
def phases_with_peak(
    peak: float, speed: float, slope: float, acceleration: float, jerk: float
) -> tuple[float, float, float]:
    """Return the durations (s) of the phases of a stop whose greatest deceleration would be `peak` (1/s²)."""
    acceleration = max(acceleration, -slope)
    if peak <= acceleration:
        return (slope + peak) / jerk, 0.0, peak / jerk
    peak = acceleration
    hold = (speed + (0.5 * slope * slope - peak * peak) / jerk) / peak
    return (slope + peak) / jerk, hold, peak / jerk


@inlined
def write_brake(
    u: float, speed: float, slope: float, jerk: float, phases: tuple[float, float, float], brake: Floats
) -> tuple[float, float]:
    """Write the brake with these phases; return its duration (s) and where it ends."""
    brake[:, 0] = math.inf
    brake[0] = 0.0
    brake[0, 1] = u
    piece = 0
    end = 0.0
    signs = (-1.0, 0.0, 1.0)
    for phase in range(3):
        time = phases[phase]
        if time <= SHORTEST:
            continue
        j = signs[phase] * jerk
        brake[piece, 0] = end
        brake[piece, 1] = u
        brake[piece, 2] = speed
        brake[piece, 3] = slope / 2.0
        brake[piece, 4] = j / 6.0
        u += time * (speed + time * (slope / 2.0 + time * j / 6.0))
        speed += time * (slope + time * j / 2.0)
        slope += time * j
        end += time
        piece += 1
    return end, u


@inlined
def brake_at(brake: Floats, t: float) -> tuple[float, float, float, float]:
    """Return the state of a brake and its third derivative, t seconds after it began and not beyond its end."""
    piece = 0
    while piece < 2 and brake[piece + 1, 0] <= t:
        piece += 1
    x = t - brake[piece, 0]
    c1 = brake[piece, 2]
    c2 = brake[piece, 3]
    c3 = brake[piece, 4]
    u = brake[piece, 1] + x * (c1 + x * (c2 + x * c3))
    return u, c1 + x * (2.0 * c2 + 3.0 * c3 * x), 2.0 * c2 + 6.0 * c3 * x, 6.0 * c3


@inlined
def total(phases: tuple[float, float, float]) -> float:
    """Return the duration (s) of a stop by those of its phases; inf when there is none."""
    return phases[0] + phases[1] + phases[2]
