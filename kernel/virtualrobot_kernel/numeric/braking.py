"""Brakes of motions on plans: their choice for all tracks, and the walk to where a motion stands, compiled."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined, output_of

from virtualrobot_kernel.numeric.brake_choice import (
    AT_GOAL,
    BRAKES,
    GOES_ON,
    NEEDS_TABLE,
    RAMPS,
    SOONER,
    STANDS,
    WAITS,
    allowed_along,
    choose_brake,
)
from virtualrobot_kernel.numeric.brake_laws import brake_at, brake_phases, phases_with_peak, total, write_brake
from virtualrobot_kernel.numeric.polynomials import one_of, scalar_state, write_values
from virtualrobot_kernel.numeric.ramps import Limited, choose_ramp, ramp_state, time_when

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]

RETRY = 0.02
"""Seconds after which a change that has not fitted is tried again."""

END_TOLERANCE = 1e-9
"""Seconds of nominal time before its end at which a motion is at its goal."""

_SHORTEST_PATIENCE = 0.1

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
            allowed_along(breaks, rated, limits, u, along)
            quickest = total(brake_phases(states[track, 1], states[track, 2], along[1], along[2]))
        if not quickest + SOONER < left:
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
        came, ends[track] = choose_brake(breaks, rated, limits, (u, speed, slope), left, brakes[track])
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
                u = brake_at(brakes[track], min(state[ELAPSED] + (row - ticks) * dt, ends[track]))[0]
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
        phases = phases_with_peak(peak, speed, slope, acceleration, jerk)
        ends[j], _ = write_brake(q, v, a, sign * jerk, phases, brakes[j])
    rows = np.empty((1 + max(1, math.ceil(min(ends.max() / dt, float(most)))), count))
    for row in range(rows.shape[0]):
        for j in range(count):
            q = brake_at(brakes[j], min(row * dt, ends[j]))[0]
            rows[row, j] = min(max(q, bounds[0, j]), bounds[1, j])
    return rows
