"""Choice of a quintic ramp of a motion's rate on which joints keep their limits, compiled."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from virtualrobot_sdk.compiled.cache import inlined

from virtualrobot_kernel.numeric.polynomials import write_all

Floats = np.ndarray[Any, np.dtype[np.float64]]

SLACK = 0.005
"""Share of a limit by which a ramp or a brake may exceed it, in the samples that it is checked at."""

#: Lengths that are tried, in units of the plan's stop time: 0.11 to 5.2, each 1.2 times the one before; the first
#: ones, up to 1.44, stop about as fast as is possible from top speed.
_LENGTHS = 1.2 ** np.arange(-12.0, 10.0)
_PROMPT = 15
_SHORTEST = 1e-3
_ROUNDING = 1e-12
_BEYOND_ALL = 1e300
_COARSE, _FINE = 32, 480


class Limited(NamedTuple):
    """Joints on a plan, as in its `Braking`, and their limits; `columns` says how many of its columns count."""

    table: Floats
    beyond: Floats
    most_acceleration: Floats
    most_jerk: Floats
    columns: int
    stop_time: float
    begin: float
    duration: float


@inlined
def ramp_state(goal: float, length: float, c: Floats, t: float) -> tuple[float, float, float, float]:
    """Return rate, its first two derivatives (1/s, 1/s²) and the nominal time gone by (s), t s after a ramp began.

    c (6,): coefficients of x^0 ... x^5, x = t / length; `RateRamp.state` is the same.
    """
    if t >= length:
        gone = length * (c[0] + c[1] / 2.0 + c[2] / 3.0 + c[3] / 4.0 + c[4] / 5.0 + c[5] / 6.0)
        return goal, 0.0, 0.0, gone + goal * (t - length)
    x = t / length
    rate = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))))
    slope = (c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * (4.0 * c[4] + x * 5.0 * c[5])))) / length
    curvature = (2.0 * c[2] + x * (6.0 * c[3] + x * (12.0 * c[4] + x * 20.0 * c[5]))) / (length * length)
    gone = t * (c[0] + x * (c[1] / 2.0 + x * (c[2] / 3.0 + x * (c[3] / 4.0 + x * (c[4] / 5.0 + x * c[5] / 6.0)))))
    return rate, slope, curvature, gone


@inlined
def time_when(goal: float, length: float, c: Floats, gone: float) -> float:
    """Return the time (s) at which the nominal time `gone` (s) has gone by; inf when the rate falls to 0 before."""
    at_end = ramp_state(goal, length, c, length)[3]
    if at_end < gone:
        return length + (gone - at_end) / goal if goal > 0.0 else math.inf
    low = 0.0
    high = length
    for _ in range(50):
        middle = 0.5 * (low + high)
        if ramp_state(goal, length, c, middle)[3] < gone:
            low = middle
        else:
            high = middle
    return high


@inlined
def _greatest_excess(
    joints: Limited, tau: float, goal: float, length: float, c: Floats, samples: int, first: int, enough: float
) -> tuple[float, int]:
    """Return by what share joints exceed a limit most at even places of a ramp, and which place has it.

    inf where the rate leaves [0, 1]; one above `enough` need not be the greatest. They are looked at from the place
    `first` on, those before it last. Both rows beside the time count and what is beyond them in between, since
    acceleration and jerk may jump there; past the end of the plan the joints stand still, which is the last row.
    Velocity needs no check: a rate of at most 1 never exceeds the plan's own.
    """
    table, beyond = joints.table, joints.beyond
    most_acceleration, most_jerk = joints.most_acceleration, joints.most_jerk
    last = table.shape[0] - 1
    rows = (last - 1) / (joints.duration - joints.begin)
    most = 0.0
    place = first
    at = first
    for _ in range(samples + 1):
        r, r1, r2, gone = ramp_state(goal, length, c, at / samples * length)
        worst = 0.0
        if r < -_ROUNDING or r > 1.0 + _ROUNDING:
            worst = math.inf
        else:
            before = int((tau + gone - joints.begin) * rows)
            row = min(max(before, 0), last)
            other = min(max(before + 1, 0), last)
            squared = r * r
            cubed = squared * r
            mixed = 3.0 * r * r1
            for j in range(joints.columns):
                a = abs(table[row, 1, j] * squared + table[row, 0, j] * r1)
                b = abs(table[other, 1, j] * squared + table[other, 0, j] * r1)
                more = beyond[row, 0, j]
                worst = max(worst, (max(a, b) + more * squared) / most_acceleration[j])
                a = abs(table[row, 2, j] * cubed + table[row, 1, j] * mixed + table[row, 0, j] * r2)
                b = abs(table[other, 2, j] * cubed + table[other, 1, j] * mixed + table[other, 0, j] * r2)
                more = beyond[row, 1, j] * cubed + more * abs(mixed)
                worst = max(worst, (max(a, b) + more) / most_jerk[j])
        if worst > most:
            most = worst
            place = at
            if most - 1.0 > enough:
                break
        at += 1
        if at > samples:
            at = 0
    return most - 1.0, place


@inlined
def _stays_in_range(c: Floats) -> bool:
    """Return True if the rate stays in [0, 1], also between samples: a ramp that reverses another one may overshoot.

    Its first two derivatives are 0 at x = 1, so its derivative is (1 - x)² times a quadratic, whose roots are turns.
    """
    if c[1] == 0.0 and c[2] == 0.0:
        return True  # from a constant rate it is monotone
    a = 5.0 * c[5]
    b = 2.0 * (c[2] + c[1])
    square = b * b - 4.0 * a * c[1]
    if square < 0.0:
        return True
    q = -0.5 * (b + math.copysign(math.sqrt(square), b))
    for over, under in ((q, a), (c[1], q)):
        if under != 0.0:
            x = over / under
            if 0.0 < x < 1.0:
                rate = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))))
                if rate < -_ROUNDING or rate > 1.0 + _ROUNDING:
                    return False
    return True


@inlined
def choose_ramp(
    joints: Limited,
    tau: float,
    state: tuple[float, float, float, float],
    goal: float,
    prompt: bool,
    chosen: Floats,
) -> float:
    """Write the shortest of a fixed list of ramps to `goal` on which the joints keep the limits; return its length (s).

    The coefficients of x^0 ... x^5 are written to `chosen` (6,). Where none fits it is the one least beyond the limits,
    and 0 where that leaves [0, 1]. `prompt` leaves out the ramps that are much longer than a stop from top speed, and
    all that do not fit. A ramp is tried from nominal time `tau` (s) at the given rate with its derivatives. With s(tau)
    the joints at nominal time and r the rate, it is checked that acceleration s'' r² + s' r' and jerk
    s''' r³ + 3 s'' r r' + s' r'' keep their limits.
    """
    rate, slope, curvature, _ = state
    c = np.empty(6)
    least = math.inf
    least_length = 0.0
    place = 0
    enough = SLACK if prompt else _BEYOND_ALL
    for which in range(_PROMPT if prompt else _LENGTHS.shape[0]):
        length = max(joints.stop_time * _LENGTHS[which], _SHORTEST)
        rise = goal - rate
        c1 = slope * length
        c2 = curvature * length * length
        c[0] = rate
        c[1] = c1
        c[2] = 0.5 * c2
        c[3] = 10.0 * rise - 6.0 * c1 - 1.5 * c2
        c[4] = -15.0 * rise + 8.0 * c1 + 1.5 * c2
        c[5] = 6.0 * rise - 3.0 * c1 - 0.5 * c2
        # Where the one before was worst this one is likely beyond, too.
        excess, place = _greatest_excess(joints, tau, goal, length, c, _COARSE, place, enough)
        if excess <= SLACK and _stays_in_range(c):
            excess, _ = _greatest_excess(joints, tau, goal, length, c, _FINE, 0, enough)
            if excess <= SLACK:
                write_all(c, chosen)
                return length
        if excess < least and not prompt:
            least = excess
            least_length = length
            write_all(c, chosen)
    return least_length if least_length > 0.0 and _stays_in_range(chosen) else 0.0
