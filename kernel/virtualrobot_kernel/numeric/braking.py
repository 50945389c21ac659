"""Brakes of motions on plans: their choice for all tracks, and the walk to where a motion stands, compiled."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64
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
from virtualrobot_kernel.numeric.memory import floats_at, integers_at
from virtualrobot_kernel.numeric.polynomials import one_of, scalar_state, write_all, write_values
from virtualrobot_kernel.numeric.ramps import Limited, choose_ramp, ramp_state, time_when
from virtualrobot_kernel.numeric.rings import BY_ROWS, GOES, MOST_ROWS, ROBOT_JOINTS, WAY, WAY_ROWS, write_tick

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
    """Motion on a plan: arrays that `brakes_ahead` has addresses of, and `ramps` where a braking table is at hand."""

    shapes: Integers
    breaks: Floats
    terms: Floats
    limits: Floats
    joints: Limited
    ramps: bool
    stops: bool
    wanted: float


STATE = 12
"""Number of numbers of that state."""

STOP_TIME, BEGIN, DURATION, WANTED, CAME, ROWS, RESULT = range(STATE, STATE + 7)
OF_TRACKS = RESULT + STATE
"""Places of a motion's other numbers: seconds of a stop from top speed, at which its plan begins and which it lasts,
the rate that it shall have; then, written in place, what it came to, the rows of its way, and its state then; at last
what its tracks have, as `Tracks` tells."""

MOTION = range(17)
(SHAPES, TRACKS, BREAKS, BREAK_COUNT, TERMS, TERM_COUNT, LIMITS, JOINTS, LAST) = MOTION[:9]
(TABLE, TABLE_ROWS, TABLE_COLUMNS, BEYOND, MOST_ACCELERATION, MOST_JERK, STOPS, ASKS) = MOTION[9:17]
"""Columns of a motion's addresses and counts, in the table that `brakes_ahead` takes."""


class Tracks(NamedTuple):
    """Numbers of t tracks, parts of a motion's own: what is told, and then what is written in place.

    begun_ends (t,): how long the brake lasts (s) that each has begun, below 0 while it doesn't brake. begun (t, 3, 5):
    these brakes. ends, brakes: likewise, in the end. reached (t,): where on its path each comes to.
    """

    begun_ends: Floats
    begun: Floats
    ends: Floats
    reached: Floats
    brakes: Floats


def width(tracks: int) -> int:
    """Return the number of numbers of a motion with so many tracks."""
    return OF_TRACKS + 33 * tracks


def tracks_of(numbers: Floats, tracks: int) -> Tracks:
    """Return what a motion's numbers (width,) say of its tracks."""
    at = OF_TRACKS
    return Tracks(
        numbers[at : at + tracks],
        numbers[at + tracks : at + 16 * tracks].reshape((tracks, 3, 5)),
        numbers[at + 16 * tracks : at + 17 * tracks],
        numbers[at + 17 * tracks : at + 18 * tracks],
        numbers[at + 18 * tracks : at + 33 * tracks].reshape((tracks, 3, 5)),
    )


_tracks_of = inlined(tracks_of)


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
    write_all(chosen, state[COEFFICIENTS:])
    return RAMPS


@inlined
def _one_motion(row: Integers, numbers: Floats) -> _Motion:
    """Return the motion that a row of the tables tells of."""
    tracks = row[TRACKS]
    count = row[JOINTS]
    table_rows = row[TABLE_ROWS]
    table_columns = row[TABLE_COLUMNS]
    columns = count if row[STOPS] else table_columns
    joints = Limited(
        floats_at(row[TABLE], table_rows * 3 * table_columns).reshape((table_rows, 3, table_columns)),
        floats_at(row[BEYOND], table_rows * 2 * table_columns).reshape((table_rows, 2, table_columns)),
        floats_at(row[MOST_ACCELERATION], table_columns),
        floats_at(row[MOST_JERK], table_columns),
        columns,
        numbers[STOP_TIME],
        numbers[BEGIN],
        numbers[DURATION],
    )
    return _Motion(
        integers_at(row[SHAPES], tracks * 15).reshape((tracks, 3, 5)),
        floats_at(row[BREAKS], row[BREAK_COUNT]),
        floats_at(row[TERMS], row[TERM_COUNT]),
        floats_at(row[LIMITS], 3 * count).reshape((3, count)),
        joints,
        table_rows > 0,
        row[STOPS] != 0,
        numbers[WANTED],
    )


@inlined
def _way_ahead(
    row: Integers, numbers: Floats, dt: float, most: int, ways: Floats, begin: int
) -> tuple[int, int, Floats]:
    """Return what a motion comes to, how many rows its way has, and `ways` with them from `begin` on; it may grow."""
    motion = _one_motion(row, numbers)
    joints = motion.joints
    tracks = row[TRACKS]
    count = row[JOINTS]
    wanted = motion.wanted
    state = numbers[RESULT:OF_TRACKS]
    write_all(numbers[:STATE], state)
    of_tracks = _tracks_of(numbers, tracks)
    ends, reached, brakes = of_tracks.ends, of_tracks.reached, of_tracks.brakes
    write_all(of_tracks.begun_ends, ends)
    write_all(of_tracks.begun.reshape(15 * tracks), brakes.reshape(15 * tracks))
    chosen = np.empty(6)
    came = BRAKES if ends[0] >= 0.0 else WAITS
    at_once = row[ASKS] != 0
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
                return came, 0, ways
        if at_once:
            if most == 0:
                return came, 0, ways
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
            write_all(taus, more)
            taus = more
        taus[ticks] = state[TAU]
    rest = 0
    if came == BRAKES:
        rest = max(1, math.ceil(min((ends.max() - state[ELAPSED]) / dt, float(most - ticks))))
    length = 1 + ticks + rest
    needed = begin + length * count
    if needed > ways.shape[0]:
        more = np.empty(needed)
        write_all(ways[:begin], more)
        ways = more
    rows = ways[begin:needed].reshape((length, count))
    first = 0
    for track in range(tracks):
        path_breaks, path = one_of(motion.breaks, motion.terms, motion.shapes[track, 0])
        law_breaks, law = one_of(motion.breaks, motion.terms, motion.shapes[track, 2])
        u = 0.0
        for place in range(length):
            if place < ticks or came != BRAKES:
                u = scalar_state(law_breaks, law, taus[place])[0]
            else:
                u = brake_at(brakes[track], min(state[ELAPSED] + (place - ticks) * dt, ends[track]))[0]
            write_values(path_breaks, path, u, rows[place], first)
        reached[track] = u
        first += path.shape[2]
    if came == AT_GOAL:
        rows[ticks] = floats_at(row[LAST], count)
    return came, length, ways


@compiled(
    array_of(int64, 2),
    output_of(float64, 2),
    array_of(int64, 2),
    array_of(int64, 1),
    array_of(float64, 1),
    array_of(float64, 1),
    int64,
    int64,
    float64,
    int64,
)
def brakes_ahead(
    motions: Integers,
    numbers: Floats,
    robots: Integers,
    places: Integers,
    q: Floats,
    v: Floats,
    tick: int,
    due: int,
    dt: float,
    most: int,
) -> tuple[int, Floats]:
    """Find where motions come to, write that for the robots of a tick, and return for how many, and the ways.

    With `most` = 0 it is found what the motions' changes now come to. Otherwise they stop, and their ways (w,) go on
    until they stand, at their goals, by a ramp or by their brakes: rows of each motion's joints, now and a tick apart,
    one motion after the other. A motion asks for a change as a `PlanExecution` does. Where nothing can be told without
    a braking table, and it is empty, it says so, and nothing is written for any robot.

    Robots go together: each has as many rows as the longest way. Where that is longer than `most`, or than what is
    kept of a robot, no brake is written with its tick, and the robot isn't counted.

    Args:
        motions: (m, 17) the columns from SHAPES on, all 0 where a row has no motion: addresses of shapes (t, 3, 5) of
            the path, of what rates it and of the law of t tracks, as in `one_of`, of all their breaks and terms, of
            limits (3, n), the greatest velocity, acceleration and jerk of the joints, of where these are at the end of
            the plan (n,), and of the braking table (r, 3, c), (r, 2, c), (c,), (c,) as in `Braking`; with their
            numbers. STOPS: whether it stops, and may brake; ASKS: whether it asks for a change now.
        numbers: (m, w) the columns of each motion from TAU on, as told there; what it comes to is written in place.
        robots: (r, 11) the columns from MEMORY on: where ticks are kept, of how many words each, and of how many
            ticks; the robot's joints k, where they begin in `places`; outputs, lead (ns), the greatest number of rows
            that is kept, and whose way it goes: that of a motion, or that at an address (rows, k), none where it has no
            rows, or none where it stands.
        places: where robots' joints are in q, k of each, and then in v.
        q: (nq,) rad or m.
        v: (nv,) per second.
        tick: its number.
        due: ns at which it was due.
        dt: s, a tick.
        most: greatest number of ticks.
    """
    begins = np.empty(motions.shape[0], np.int64)
    ways = np.empty(0)
    size = 0
    longest = 1
    for place in range(motions.shape[0]):
        begins[place] = size
        numbers[place, CAME] = WAITS
        numbers[place, ROWS] = 0.0
        if motions[place, TRACKS] == 0:
            continue
        came, length, ways = _way_ahead(motions[place], numbers[place], dt, most, ways, size)
        numbers[place, CAME] = came
        numbers[place, ROWS] = length
        if came == NEEDS_TABLE:
            return 0, ways
        size += length * motions[place, JOINTS]
        longest = max(longest, length)
    knows = True
    for place in range(robots.shape[0]):
        if robots[place, GOES] == BY_ROWS:
            longest = max(longest, robots[place, WAY_ROWS])
            knows = knows and robots[place, WAY_ROWS] > 0
    braked = 0
    for place in range(robots.shape[0]):
        robot = robots[place]
        goes = robot[GOES]
        count = robot[ROBOT_JOINTS]
        length = 1
        if goes >= 0:
            length = int(numbers[goes, ROWS])
            way = ways[begins[goes] : begins[goes] + length * count]
        elif goes == BY_ROWS:
            length = robot[WAY_ROWS]
            way = floats_at(robot[WAY], length * count)
        else:
            way = ways[:0]
        rows = longest if knows and longest <= min(most, robot[MOST_ROWS]) else 0
        write_tick(robot, places, q, v, tick, due, way, length, rows)
        braked += rows > 0
    return braked, ways


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
