"""Brakes of motions on plans: their choice, and the walk to where a motion stands, compiled.

A brake is a law u(t) of up to three pieces, (3, 5): the time (s) at which each begins, inf for one that is not there,
and the coefficients of t^0 ... t^3 from then on.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

from virtualrobot_kernel.numeric.polynomials import one_of, piece_at, scalar_state, write_values
from virtualrobot_kernel.numeric.ramps import SLACK, Limited, choose_ramp, ramp_state, time_when

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]

GOES_ON, WAITS, NEEDS_TABLE, RAMPS, BRAKES, AT_GOAL, STANDS = range(7)
"""Outcomes of a motion: it goes on as it does; it waits for a change, since none fits now; it can't be told without a
braking table; it follows another ramp; it brakes; it is at its goal; it stands at the end of its ramp."""

RETRY = 0.02
"""Seconds after which a change that has not fitted is tried again."""

END_TOLERANCE = 1e-9
"""Seconds of nominal time before its end at which a motion is at its goal."""

#: Shares of what the joints allow on a straight path that are tried, for acceleration and jerk each; the path's
#: curvature takes the rest.
_SHARES = np.array([1.0, 0.8, 0.64, 0.5, 0.4, 0.3, 0.2, 0.1])
#: By how much a brake must stop sooner than the motion does anyway (s): above rounding, far below a tick.
_SOONER = 1e-6
_COARSE, _FINE, _SIDES = 32, 480, 8
_ROUNDING = 1e-9
#: Distance from a break at which its sides are looked at, as a share of the whole law: far above rounding.
_ASIDE = 1e-9
#: Phases shorter than this (s) are left out.
_SHORTEST = 1e-12
_SHORTEST_PATIENCE = 0.1


@inlined
def _phases(speed: float, slope: float, acceleration: float, jerk: float) -> tuple[float, float, float]:
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
    return _with_peak(peak, speed, slope, acceleration, jerk)


@inlined
def _with_peak(peak: float, speed: float, slope: float, acceleration: float, jerk: float) -> tuple[float, float, float]:
    """Return the durations (s) of the phases of a stop whose greatest deceleration would be `peak` (1/s²)."""
    acceleration = max(acceleration, -slope)
    if peak <= acceleration:
        return (slope + peak) / jerk, 0.0, peak / jerk
    peak = acceleration
    hold = (speed + (0.5 * slope * slope - peak * peak) / jerk) / peak
    return (slope + peak) / jerk, hold, peak / jerk


@inlined
def _integrate(
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
        if time <= _SHORTEST:
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
def _brake_at(brake: Floats, t: float) -> tuple[float, float, float, float]:
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
    apart = _SHORTEST * (breaks[breaks.shape[0] - 1] - breaks[0])
    covered = 1
    for piece in range(piece_at(breaks, begin), piece_at(breaks, end) + 1):
        if begin + apart < breaks[piece] < end - apart:
            covered += 1
    return max(_FINE, 8 * covered)


@inlined
def _allowed(breaks: Floats, terms: Floats, limits: Floats, u: float, along: Floats) -> None:
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
def _total(phases: tuple[float, float, float]) -> float:
    return phases[0] + phases[1] + phases[2]


@inlined
def _choose_brake(
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
    slack = np.array([1.0 + _ROUNDING, 1.0 + SLACK, 1.0 + SLACK])
    bounds = limits * slack.reshape((3, 1))
    along = np.empty(3)
    _allowed(breaks, terms, limits, u, along)
    acceleration, jerk = along[1:]
    along *= slack
    # Of brakes with the same share of the jerk less acceleration takes longer: so they are merged, soonest first.
    shares = _SHARES.shape[0]
    nexts = np.zeros(shares, np.int64)
    seconds = np.empty(shares)
    for row in range(shares):
        seconds[row] = _total(_phases(speed, slope, _SHARES[0] * acceleration, _SHARES[row] * jerk))
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
        if not soonest + _SOONER < left:
            return result, 0.0
        share = _SHARES[row] * jerk
        phases = _phases(speed, slope, _SHARES[nexts[row]] * acceleration, share)
        nexts[row] += 1
        seconds[row] = math.inf
        if nexts[row] < shares:
            seconds[row] = _total(_phases(speed, slope, _SHARES[nexts[row]] * acceleration, share))
        if soonest == before and share == before_jerk:
            continue
        before = soonest
        before_jerk = share
        duration, reach = _integrate(u, speed, slope, share, phases, brake)
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


TAU, RAMP_TAU, ELAPSED, WAITING, GOAL, LENGTH, COEFFICIENTS = range(7)
"""Places of a motion's state in an array (12,): nominal time, that at which its ramp began, the seconds since then, for
how long it has waited, and the ramp. They are those of `PlanExecution` and `RateRamp`."""


class _Motion(NamedTuple):
    """Motion on a plan: arrays of `brake_ahead`, and `ramps` where a braking table is at hand."""

    shapes: Integers
    breaks: Floats
    terms: Floats
    limits: Floats
    joints: Limited
    ramps: bool
    stops: bool
    wanted: float


@inlined
def _time_left(duration: float, state: Floats) -> float:
    """Return after how many seconds a motion stands still, at its goal or at the end of a ramp to rate 0."""
    goal = state[GOAL]
    length = state[LENGTH]
    at_goal = time_when(goal, length, state[COEFFICIENTS:], duration - state[RAMP_TAU])
    return (min(at_goal, length) if goal == 0.0 else at_goal) - state[ELAPSED]


@inlined
def _choose_brakes(motion: _Motion, state: Floats, left: float, brakes: Floats, ends: Floats) -> int:
    """Write a brake for each track (t, 3, 5), and their durations (s) (t,); return what it comes to."""
    rate, rate_slope, _, _ = ramp_state(state[GOAL], state[LENGTH], state[COEFFICIENTS:], state[ELAPSED])
    tracks = motion.shapes.shape[0]
    states = np.empty((tracks, 3))
    along = np.empty(3)
    first = 0
    for track in range(tracks):
        law_breaks, law = one_of(motion.breaks, motion.terms, motion.shapes[track, 2])
        if law.shape[1] != 4:
            return WAITS  # the law u = tau of a timed trajectory
        u, u1, u2 = scalar_state(law_breaks, law, state[TAU])
        states[track, 0] = u
        states[track, 1] = u1 * rate
        states[track, 2] = u2 * rate * rate + u1 * rate_slope
        breaks, rated = one_of(motion.breaks, motion.terms, motion.shapes[track, 1])
        limits = motion.limits[:, first : first + rated.shape[2]]
        first += rated.shape[2]
        # With less of both none is quicker: so the rest need not be looked at, where the motion runs to its goal.
        quickest = 0.0
        if states[track, 1] > 0.0 or states[track, 2] != 0.0:
            _allowed(breaks, rated, limits, u, along)
            quickest = _total(_phases(states[track, 1], states[track, 2], along[1], along[2]))
        if not quickest + _SOONER < left:
            return GOES_ON
    result = BRAKES
    first = 0
    for track in range(tracks):
        breaks, rated = one_of(motion.breaks, motion.terms, motion.shapes[track, 1])
        limits = motion.limits[:, first : first + rated.shape[2]]
        first += rated.shape[2]
        u, speed, slope = states[track]
        if speed <= 0.0 and slope == 0.0:
            brakes[track, :, 0] = math.inf
            brakes[track, 0] = 0.0
            brakes[track, 0, 1] = u
            ends[track] = 0.0
            continue
        came, ends[track] = _choose_brake(breaks, rated, limits, (u, speed, slope), left, brakes[track])
        if came == GOES_ON:
            return GOES_ON
        if came == WAITS:
            result = WAITS
    return result


@inlined
def _change(motion: _Motion, state: Floats, brakes: Floats, ends: Floats, chosen: Floats) -> int:
    """Let a motion brake, or follow a ramp to the rate that is wanted; return what that comes to."""
    joints = motion.joints
    left = math.inf
    if motion.stops:
        left = _time_left(joints.duration, state)
        came = _choose_brakes(motion, state, left, brakes, ends)
        if came != WAITS:
            state[WAITING] = 0.0
            if came == BRAKES:
                state[ELAPSED] = 0.0
            return came
    if motion.wanted == state[GOAL]:
        state[WAITING] = 0.0
        return GOES_ON
    if not motion.ramps:
        return NEEDS_TABLE
    now = ramp_state(state[GOAL], state[LENGTH], state[COEFFICIENTS:], state[ELAPSED])
    # At standstill, waiting would change nothing. While there is patience, a better moment for a short ramp is likely
    # nearer than the end of a long one.
    patience = max(joints.stop_time, _SHORTEST_PATIENCE) if now[0] > 0.0 else 0.0
    length = choose_ramp(joints, state[TAU], now, motion.wanted, state[WAITING] < patience, chosen)
    if length == 0.0 or length > left:
        return WAITS
    state[RAMP_TAU] = state[TAU]
    state[ELAPSED] = 0.0
    state[WAITING] = 0.0
    state[GOAL] = motion.wanted
    state[LENGTH] = length
    state[COEFFICIENTS:] = chosen
    return RAMPS


@compiled(
    array_of(int64, 3),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 2),
    array_of(float64, 1),
    array_of(float64, 3),
    array_of(float64, 3),
    array_of(float64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    boolean,
    boolean,
    float64,
    float64,
    int64,
    output_of(float64, 1),
    output_of(float64, 3),
    output_of(float64, 1),
    output_of(float64, 1),
)
def brake_ahead(
    shapes: Integers,
    breaks: Floats,
    terms: Floats,
    limits: Floats,
    goal: Floats,
    table: Floats,
    beyond: Floats,
    most_acceleration: Floats,
    most_jerk: Floats,
    times: Floats,
    stops: bool,
    asks: bool,
    wanted: float,
    dt: float,
    most: int,
    state: Floats,
    brakes: Floats,
    ends: Floats,
    reached: Floats,
) -> tuple[int, Floats]:
    """Return what a motion comes to, and where its joints are until then (m, n), now and a tick apart.

    With `most` = 0 that is what its change now comes to. Otherwise it stops, and the ticks are those until it stands,
    at its goal, by a ramp or by its brakes. It asks for a change as a `PlanExecution` does. Where nothing can be told
    without a braking table, and it is empty, it says so.

    Args:
        shapes: (t, 3, 5) of the path, of what rates it and of the law of t tracks, as in `one_of`.
        breaks: (b,) all their breaks.
        terms: (c,) all their terms.
        limits: (3, n) greatest velocity, acceleration and jerk of the joints.
        goal: (n,) where the joints are at the end of the plan.
        table: (m, 3, c) as in `Braking`, as are the next three; empty where it is not at hand.
        beyond: (m, 2, c).
        most_acceleration: (c,).
        most_jerk: (c,).
        times: (3,) s: for a stop from top speed, when the plan begins and when it ends.
        stops: whether it stops, and may brake.
        asks: whether it asks for a change now.
        wanted: the rate that it shall have.
        dt: s, a tick.
        most: greatest number of ticks.
        state: (12,) the motion, written in place.
        brakes: (t, 3, 5) its brakes, written in place.
        ends: (t,) s, their durations, written in place; the first one is negative while it doesn't brake.
        reached: (t,) where on the paths it comes to, written in place.
    """
    count = limits.shape[1]
    columns = count if stops else most_jerk.shape[0]
    joints = Limited(table, beyond, most_acceleration, most_jerk, columns, times[0], times[1], times[2])
    motion = _Motion(shapes, breaks, terms, limits, joints, table.shape[0] > 0, stops, wanted)
    chosen = np.empty(6)
    came = BRAKES if ends[0] >= 0.0 else WAITS
    at_once = asks
    taus = np.empty(512)
    taus[0] = state[TAU]
    ticks = 0
    while came not in (BRAKES, AT_GOAL, STANDS):
        again = at_once
        if not at_once:
            if ticks == most:
                break
            waiting = 0.0 if state[GOAL] == wanted else state[WAITING] + dt
            again = int(waiting / RETRY) != int(state[WAITING] / RETRY) and waiting > 0.0
            state[WAITING] = waiting
        if again:
            came = _change(motion, state, brakes, ends, chosen)
            if came == NEEDS_TABLE:
                return came, np.empty((0, count))
        if at_once:
            if most == 0:
                return came, np.empty((0, count))
            at_once = False
            continue
        if came == BRAKES:
            break
        state[ELAPSED] += dt
        gone = ramp_state(state[GOAL], state[LENGTH], state[COEFFICIENTS:], state[ELAPSED])[3]
        state[TAU] = max(state[TAU], state[RAMP_TAU] + gone)
        if state[TAU] >= joints.duration - END_TOLERANCE:
            came = AT_GOAL
        elif state[ELAPSED] >= state[LENGTH] and state[GOAL] == 0.0:
            came = STANDS
        ticks += 1
        if ticks == taus.shape[0]:
            more = np.empty(2 * ticks)
            more[:ticks] = taus
            taus = more
        taus[ticks] = state[TAU]
    rest = 0
    if came == BRAKES:
        rest = max(1, math.ceil(min((ends.max() - state[ELAPSED]) / dt, float(most - ticks))))
    rows = np.empty((1 + ticks + rest, count))
    first = 0
    for track in range(shapes.shape[0]):
        path_breaks, path = one_of(breaks, terms, shapes[track, 0])
        law_breaks, law = one_of(breaks, terms, shapes[track, 2])
        u = 0.0
        for row in range(rows.shape[0]):
            if row < ticks or came != BRAKES:
                u = scalar_state(law_breaks, law, taus[row])[0]
            else:
                u = _brake_at(brakes[track], min(state[ELAPSED] + (row - ticks) * dt, ends[track]))[0]
            write_values(path_breaks, path, u, rows[row], first)
        reached[track] = u
        first += path.shape[2]
    if came == AT_GOAL:
        rows[ticks] = goal
    return came, rows


@compiled(array_of(float64, 2), array_of(float64, 2), float64, int64)
def stop_joints(state: Floats, bounds: Floats, dt: float, most: int) -> Floats:
    """Return where joints are (m, k) while each stops as soon as its limits allow, now and a tick apart.

    Args:
        state: (3, k) positions, velocities and accelerations, in rad or m, per s and s².
        bounds: (4, k) least and greatest position, greatest acceleration and jerk. Rounding may have led past a
            position's limit by as much as a float's last places.
        dt: s, a tick.
        most: greatest number of ticks.
    """
    count = state.shape[1]
    brakes = np.empty((count, 3, 5))
    ends = np.empty(count)
    for j in range(count):
        q, v, a = state[:, j]
        acceleration = bounds[2, j]
        jerk = bounds[3, j]
        # It brakes against the velocity that it would have when its acceleration ended at once.
        sign = 1.0 if v + 0.5 * a * abs(a) / jerk >= 0.0 else -1.0
        speed = sign * v
        slope = sign * a
        peak = max(math.sqrt(max(jerk * speed + 0.5 * slope * slope, 0.0)), -slope)
        phases = _with_peak(peak, speed, slope, acceleration, jerk)
        ends[j], _ = _integrate(q, v, a, sign * jerk, phases, brakes[j])
    rows = np.empty((1 + max(1, math.ceil(min(ends.max() / dt, float(most)))), count))
    for row in range(rows.shape[0]):
        for j in range(count):
            q = _brake_at(brakes[j], min(row * dt, ends[j]))[0]
            rows[row, j] = min(max(q, bounds[0, j]), bounds[1, j])
    return rows
