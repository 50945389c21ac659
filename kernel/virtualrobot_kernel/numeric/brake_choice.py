"""Choice of the soonest brake of one track that keeps the limits of its joints, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from virtualrobot_sdk.compiled.cache import inlined

from virtualrobot_kernel.numeric.brake_laws import SHORTEST, brake_phases, total, write_brake
from virtualrobot_kernel.numeric.polynomials import piece_at
from virtualrobot_kernel.numeric.ramps import SLACK

Floats = np.ndarray[Any, np.dtype[np.float64]]

GOES_ON, WAITS, NEEDS_TABLE, RAMPS, BRAKES, AT_GOAL, STANDS = range(7)
"""Outcomes of a motion: it goes on as it does; it waits for a change, since none fits now; it can't be told without a
braking table; it follows another ramp; it brakes; it is at its goal; it stands at the end of its ramp."""

#: Shares of what the joints allow on a straight path that are tried, for acceleration and jerk each; the path's
#: curvature takes the rest.
_SHARES = np.array([1.0, 0.8, 0.64, 0.5, 0.4, 0.3, 0.2, 0.1])
#: By how much a brake must stop sooner than the motion does anyway (s): above rounding, far below a tick.
SOONER = 1e-6
_COARSE, _FINE, _SIDES = 32, 480, 8
_ROUNDING = 1e-9
#: Distance from a break at which its sides are looked at, as a share of the whole law: far above rounding.
_ASIDE = 1e-9


@inlined
def _beyond(
    breaks: Floats,
    terms: Floats,
    bounds: Floats,
    along: Floats,
    brake: Floats,
    duration: float,
    points: int,
    first: int,
    count: int,
) -> int:
    """Return the first of `count` moments of a brake at which a joint is beyond its bounds; -1 for none.

    The moments are even points of the brake and then both sides of its four breaks; they are looked at from the one at
    `first` on, those before it last. bounds (3, k): the greatest velocity, acceleration and jerk. along (3,): the same
    of the path parameter, on a path that is one straight piece.
    """
    pieces = terms.shape[0]
    powers = terms.shape[1]
    joints = terms.shape[2]
    straight = pieces == 1 and powers == 2
    begin = breaks[0]
    end = breaks[pieces]
    most_speed, most_slope, most_bend = along
    piece = piece_at(breaks, brake[0, 1])
    step = duration / (points - 1)
    phase = 0
    at = first
    for _ in range(count):
        if at < points - 1:
            t = at * step
        elif at == points - 1:
            t = duration
        else:
            side = at - points
            t = brake[side // 2, 0] if side < 6 else duration
            t = min(max(t + (_ASIDE if side % 2 else -_ASIDE) * duration, 0.0), duration)
        while phase > 0 and t < brake[phase, 0]:
            phase -= 1
        while phase < 2 and t >= brake[phase + 1, 0]:
            phase += 1
        x = t - brake[phase, 0]
        c1 = brake[phase, 2]
        c2 = brake[phase, 3]
        c3 = brake[phase, 4]
        u = brake[phase, 1] + x * (c1 + x * (c2 + x * c3))
        speed = c1 + x * (2.0 * c2 + 3.0 * c3 * x)
        slope = 2.0 * c2 + 6.0 * c3 * x
        bend = 6.0 * c3
        if begin <= u <= end:
            if straight:
                if abs(speed) > most_speed or abs(slope) > most_slope or abs(bend) > most_bend:
                    return at
            else:
                while piece > 0 and u < breaks[piece]:
                    piece -= 1
                while piece < pieces - 1 and u >= breaks[piece + 1]:
                    piece += 1
                local = u - breaks[piece]
                squared = speed * speed
                cubed = squared * speed
                mixed = 3.0 * speed * slope
                for j in range(joints):
                    value = 0.0
                    q1 = 0.0
                    q2 = 0.0
                    q3 = 0.0
                    for power in range(powers - 1, -1, -1):
                        q3 = q3 * local + q2
                        q2 = q2 * local + q1
                        q1 = q1 * local + value
                        value = value * local + terms[piece, power, j]
                    q2 *= 2.0
                    q3 *= 6.0
                    if (
                        abs(q1 * speed) > bounds[0, j]
                        or abs(q2 * squared + q1 * slope) > bounds[1, j]
                        or abs(q3 * cubed + q2 * mixed + q1 * bend) > bounds[2, j]
                    ):
                        return at
        at += 1
        if at == points + _SIDES:
            at = 0
    return -1


@inlined
def _points(breaks: Floats, begin: float, end: float) -> int:
    """Return at how many even points a brake from `begin` to `end` of a path is looked at.

    Of a long path, such as a program's, only the pieces that the brake covers count.
    """
    if begin >= end:
        return _FINE
    apart = SHORTEST * (breaks[breaks.shape[0] - 1] - breaks[0])
    covered = 1
    for piece in range(piece_at(breaks, begin), piece_at(breaks, end) + 1):
        if begin + apart < breaks[piece] < end - apart:
            covered += 1
    return max(_FINE, 8 * covered)


@inlined
def allowed_along(breaks: Floats, terms: Floats, limits: Floats, u: float, along: Floats) -> None:
    """Write what velocity, acceleration and jerk (3,) joints with limits (3, k) allow along a path straight from u."""
    piece = piece_at(breaks, u)
    local = min(max(u, breaks[0]), breaks[terms.shape[0]]) - breaks[piece]
    along[:] = math.inf
    for j in range(terms.shape[2]):
        direction = 0.0
        for power in range(terms.shape[1] - 1, 0, -1):
            direction = direction * local + power * terms[piece, power, j]
        if direction != 0.0:
            for order in range(3):
                along[order] = min(along[order], limits[order, j] / abs(direction))


@inlined
def choose_brake(
    breaks: Floats,
    terms: Floats,
    limits: Floats,
    state: tuple[float, float, float],
    left: float,
    brake: Floats,
) -> tuple[int, float]:
    """Write the soonest brake of one track; return what that comes to, and its duration (s).

    limits (3, k): the joints' velocity, acceleration and jerk. GOES_ON: none is sooner than `left`; WAITS: none of
    those that are keeps the limits.
    """
    u, speed, slope = state
    end = breaks[terms.shape[0]]
    along, bounds = np.empty(3), np.empty(limits.shape)
    allowed_along(breaks, terms, limits, u, along)
    acceleration, jerk = along[1], along[2]
    for row in range(3):
        slack = SLACK if row else _ROUNDING
        along[row] *= 1.0 + slack
        for j in range(limits.shape[1]):
            bounds[row, j] = limits[row, j] * (1.0 + slack)
    # Of brakes with the same share of the jerk less acceleration takes longer: so they are merged, soonest first.
    shares = _SHARES.shape[0]
    nexts = np.zeros(shares, np.int64)
    seconds = np.empty(shares)
    for row in range(shares):
        seconds[row] = total(brake_phases(speed, slope, _SHARES[0] * acceleration, _SHARES[row] * jerk))
    result = GOES_ON
    before = -1.0
    before_jerk = -1.0
    # Where the brake before was beyond, this one likely is, too.
    coarse = 0
    fine = 0
    in_fine = False
    while True:
        row = shares - 1
        for other in range(shares - 2, -1, -1):
            if seconds[other] < seconds[row]:
                row = other
        soonest = seconds[row]
        if not soonest + SOONER < left:
            return result, 0.0
        share = _SHARES[row] * jerk
        phases = brake_phases(speed, slope, _SHARES[nexts[row]] * acceleration, share)
        nexts[row] += 1
        seconds[row] = math.inf
        if nexts[row] < shares:
            seconds[row] = total(brake_phases(speed, slope, _SHARES[nexts[row]] * acceleration, share))
        if soonest == before and share == before_jerk:
            continue
        before = soonest
        before_jerk = share
        duration, reach = write_brake(u, speed, slope, share, phases, brake)
        if not reach <= end:
            continue
        result = WAITS
        found = -1
        for look in range(0 if in_fine else 1, 3):
            few = look == 1
            points = _COARSE if few else _points(breaks, u, reach)
            first = coarse if few else fine
            count = 1 if look == 0 else points + _SIDES
            found = _beyond(breaks, terms, bounds, along, brake, duration, points, first, count)
            in_fine = in_fine or few
            if found >= 0:
                if few:
                    coarse = found
                    in_fine = False
                else:
                    fine = min(found, _FINE - 1)
                break
        if found < 0:
            return BRAKES, duration
