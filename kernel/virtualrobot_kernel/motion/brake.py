"""Brakes of a running motion and changes of its rate, chosen so that the joints keep their limits, by compiled code.

A rate ramp multiplies the motion's own law, jerk included, so it cannot stop a motion whose law is at its jerk limit.
A brake leaves the law: on each track, from the present state, it is the fastest jerk-limited stop u(t) of the path
parameter on the same path.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.planned import Plan, flat
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.ramp import RateRamp
from virtualrobot_kernel.numeric import braking, rings
from virtualrobot_kernel.numeric.braking import END_TOLERANCE as END_TOLERANCE
from virtualrobot_kernel.numeric.braking import RETRY as RETRY
from virtualrobot_kernel.numeric.memory import address_of

#: Path parameter u of a track and its first two derivatives by time (1/s, 1/s²).
PathState = tuple[float, float, float]
#: For each track its brake, a law u(t), t >= 0; none while the motion does not brake.
Brakes = tuple[PiecewisePolynomial, ...]

_NO_ROBOTS = np.empty((0, len(rings.ROBOT)), np.int64)
_NO_PLACES = np.empty(0, np.int64)
_NOTHING = np.empty(0)
_STATE = struct.Struct(f"@{braking.STATE}d")
_OF_PLAN = braking.SHAPES, braking.BREAKS, braking.TERMS, braking.LIMITS, braking.LAST
_COUNTS = braking.TRACKS, braking.BREAK_COUNT, braking.TERM_COUNT, braking.JOINTS
_OF_TABLE = braking.TABLE, braking.BEYOND, braking.MOST_ACCELERATION, braking.MOST_JERK
"""Columns of a plan's addresses, of their counts, and of the addresses of its braking table."""


class RateState(NamedTuple):
    """State of a motion on its plan: nominal time tau and its ramp, as in `PlanExecution`."""

    tau: float
    ramp_tau: float
    elapsed: float
    waiting: float
    ramp: RateRamp


class Change(NamedTuple):
    """Change of a motion that asks for one.

    brakes: none where it does not brake. ramp: the one that it follows now, or None. waits: whether it wants a change
    and none fits yet.
    """

    brakes: Brakes
    ramp: RateRamp | None
    waits: bool


class StopAhead(NamedTuple):
    """Stop of a motion that begins now.

    positions (m, n): where its joints are now and at each tick until it stands. at_goal: whether that is at its goal.
    reached: where on the path each track comes to.
    """

    positions: Array
    at_goal: bool
    reached: tuple[float, ...]


def change(plan: Plan, now: RateState, wanted: float, *, stops: bool) -> Change:
    """Return the change of a motion to the rate `wanted`; one that `stops` brakes, or follows a ramp to rate 0.

    It is, on each track, the soonest brake on which the joints keep the plan's limits, unless the motion stands no
    later without; where none keeps them, the shortest of a fixed list of ramps that does. A ramp that does not fit is
    chosen when waiting for a better moment has taken long enough.
    """
    answer = _asked(plan, now, wanted, stops=stops, asks=True)
    if answer.came == braking.BRAKES:
        return Change(tuple(map(_law, answer.brakes, answer.ends.tolist())), None, False)
    if answer.came == braking.RAMPS:
        goal, length, *coefficients = answer.state[braking.GOAL :].tolist()
        return Change((), RateRamp(goal, length, tuple(coefficients)), False)
    return Change((), None, answer.came == braking.WAITS)


def stop_ahead(plan: Plan, now: RateState, begun: Brakes, dt: float, most: int, *, asks: bool) -> StopAhead:
    """Return how a motion stops, in ticks of `dt` seconds and at most so many of them.

    begun: the brakes that it has begun; asks: whether it begins to stop now.
    """
    answer = _asked(plan, now, 0.0, stops=True, asks=asks, begun=begun, dt=dt, most=most)
    return StopAhead(answer.positions, answer.came == braking.AT_GOAL, tuple(answer.reached.tolist()))


def joints_stop_ahead(
    state: Sequence[Sequence[float]], bounds: Sequence[Sequence[float]], dt: float, most: int
) -> Array:
    """Return where joints are (m, k) while each stops as soon as it can, now and at each tick, at most so many.

    state (3, k): their positions, velocities and accelerations; bounds (4, k): least and greatest position, greatest
    acceleration and jerk.
    """
    return braking.stop_joints(np.array(state), np.array(bounds), dt, most)


def brake_state(brake: PiecewisePolynomial, t: float) -> PathState:
    """Return the state t seconds after the brake began; from its end on exactly at rest."""
    state = brake.scalar_state(t)
    return state if t < brake.end else (state[0], 0.0, 0.0)


def nominal_time(law: PiecewisePolynomial, u: float, low: float) -> float:
    """Return the tau >= low (s) at which a law that never runs back reaches u; its end when it never does.

    Newton's method, kept in an interval that bisection shrinks.
    """
    high = law.end
    tau = low
    for _ in range(100):
        value, slope, _ = law.scalar_state(tau)
        if value < u:
            low = tau
        elif value > u:
            high = tau
        else:
            return tau
        newton = tau + (u - value) / slope if slope > 0.0 else high
        following = newton if low < newton < high else 0.5 * (low + high)
        if abs(following - tau) <= 1e-15 * law.end:
            return following
        tau = following
    return tau


class BrakeTable:
    """Table of motions on plans of one track, a row each: one compiled call finds how all of them stop.

    It is kept between ticks: of a motion that goes on along its plan `tell` says how far it is, and no more.
    """

    def __init__(self, rows: int) -> None:
        """Have room for so many motions."""
        rows = max(rows, 1)
        self._motions = np.zeros((rows, len(braking.MOTION)), np.int64)
        self._numbers = np.zeros((rows, braking.width(1)))
        self._bytes = self._numbers.data.cast("B")
        self._row_bytes = 8 * self._numbers.shape[1]
        self._plans: list[Plan | None] = [None] * rows
        self._rows: list[_Row | None] = [None] * rows

    def tell(self, row: int, plan: Plan, tau: float, ramp_tau: float, elapsed: float, ramp: RateRamp) -> None:
        """Say where a motion is that runs on its plan, as in `RateState`; it begins to stop now."""
        if self._plans[row] is not plan:
            self._take(row, plan, _row(plan, True, True))
        _STATE.pack_into(
            self._bytes, self._row_bytes * row, tau, ramp_tau, elapsed, 0.0, ramp.goal, ramp.length, *ramp.coefficients
        )

    def drop(self, row: int) -> None:
        """Have no motion in a row until one is told again."""
        self._plans[row], self._rows[row] = None, None
        self._motions[row] = 0

    def write(
        self,
        dt: float,
        most: int,
        robots: NDArray[np.int64],
        places: NDArray[np.int64],
        q: Array,
        v: Array,
        tick: int,
        due: int,
    ) -> int:
        """Write a tick of robots with their brakes; return for how many a brake was written. See `brakes_ahead`."""
        tell = self._motions, self._numbers, robots, places, q, v, tick, due, dt, most
        braked, _ = braking.brakes_ahead(*tell)
        lacking = np.flatnonzero(self._numbers[:, braking.CAME] == braking.NEEDS_TABLE).tolist() if not braked else ()
        if lacking:
            for row in lacking:
                plan = self._plans[row]
                assert plan is not None
                self._take(row, plan, _row_with_table(plan, True, True))
            return self.write(dt, most, robots, places, q, v, tick, due)
        return braked

    def _take(self, row: int, plan: Plan, of_plan: _Row) -> None:
        self._plans[row], self._rows[row] = plan, of_plan
        self._motions[row] = of_plan.motion
        self._numbers[row, braking.STOP_TIME : braking.CAME] = (*of_plan.times, 0.0)
        braking.tracks_of(self._numbers[row], 1).begun_ends[:] = -1.0


class _Answer(NamedTuple):
    """Answer of `brakes_ahead` about one motion."""

    came: int
    positions: Array
    state: Array
    brakes: Array
    ends: Array
    reached: Array


def _asked(
    plan: Plan,
    now: RateState,
    wanted: float,
    *,
    stops: bool,
    asks: bool,
    begun: Brakes = (),
    dt: float = 0.0,
    most: int = 0,
) -> _Answer:
    """Return what a motion comes to; its braking table is made only where nothing can be told without it."""
    ramp, tracks = now.ramp, len(plan.tracks)
    numbers = np.empty((1, braking.width(tracks)))
    numbers[0, : braking.STATE] = (*now[:4], ramp.goal, ramp.length, *ramp.coefficients)
    numbers[0, braking.WANTED] = wanted
    told = braking.tracks_of(numbers[0], tracks)
    told.begun_ends[:] = -1.0
    for track, law in enumerate(begun):
        count = len(law.coefficients)
        told.begun[track, :, 0] = np.inf
        told.begun[track, :count, 0] = law.breaks[:-1]
        told.begun[track, :count, 1:] = law.coefficients[:, :, 0]
        told.begun_ends[track] = law.end

    def ask(row: _Row) -> tuple[int, Array]:
        numbers[0, braking.STOP_TIME : braking.WANTED] = row.times
        motion = row.motion[None]
        _, ways = braking.brakes_ahead(motion, numbers, _NO_ROBOTS, _NO_PLACES, _NOTHING, _NOTHING, 0, 0, dt, most)
        return int(numbers[0, braking.CAME]), ways

    came, ways = ask(_row(plan, stops, asks))
    if came == braking.NEEDS_TABLE:
        came, ways = ask(_row_with_table(plan, stops, asks))
    rows = int(numbers[0, braking.ROWS])
    state = numbers[0, braking.RESULT : braking.OF_TRACKS]
    return _Answer(came, ways.reshape(rows, plan.q_count), state, told.brakes, told.ends, told.reached)


def _law(brake: Array, end: float) -> PiecewisePolynomial:
    begun = np.isfinite(brake[:, 0])
    return PiecewisePolynomial(np.append(brake[begun, 0], end), brake[begun, 1:, None])


class _Row(NamedTuple):
    """Row of a plan in a table of motions.

    motion (17,): addresses and counts. times (s): of a stop from top speed, at which it begins, and which it lasts.
    kept: the arrays at these addresses.
    """

    motion: NDArray[np.int64]
    times: tuple[float, float, float]
    kept: tuple[NDArray[np.int64] | Array, ...]


# Beside the plans, which the journal keeps for good, and only for the last ones, as their braking tables.
@lru_cache(maxsize=256)
def _row(plan: Plan, stops: bool, asks: bool) -> _Row:
    """Return the row of a plan without its braking table; `stops` and `asks` as in `brakes_ahead`."""
    kept = *flat(plan), _NOTHING
    motion = np.zeros(len(braking.MOTION), np.int64)
    motion[list(_OF_PLAN)] = list(map(address_of, kept[:-1]))
    motion[list(_COUNTS)] = len(plan.tracks), len(kept[1]), len(kept[2]), plan.q_count
    motion[list(_OF_TABLE)] = address_of(_NOTHING)
    motion[braking.STOPS], motion[braking.ASKS] = stops, asks
    return _Row(motion, (0.0, 0.0, plan.duration), kept)


def _row_with_table(plan: Plan, stops: bool, asks: bool) -> _Row:
    """Return the same with the braking table."""
    without, data = _row(plan, stops, asks), plan.braking
    table = data.table, data.beyond, data.max_acceleration, data.max_jerk
    motion = without.motion.copy()
    motion[list(_OF_TABLE)] = list(map(address_of, table))
    motion[braking.TABLE_ROWS], motion[braking.TABLE_COLUMNS] = data.table.shape[0], data.table.shape[2]
    return _Row(motion, (data.stop_time, data.begin, plan.duration), (*without.kept, *table))
