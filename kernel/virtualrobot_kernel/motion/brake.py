"""Brakes of a running motion and changes of its rate, chosen so that the joints keep their limits, by compiled code.

A rate ramp multiplies the motion's own law, jerk included, so it cannot stop a motion whose law is at its jerk limit.
A brake leaves the law: on each track, from the present state, it is the fastest jerk-limited stop u(t) of the path
parameter on the same path.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.ramp import RateRamp
from virtualrobot_kernel.numeric import braking
from virtualrobot_kernel.numeric.braking import END_TOLERANCE as END_TOLERANCE
from virtualrobot_kernel.numeric.braking import RETRY as RETRY

#: Path parameter u of a track and its first two derivatives by time (1/s, 1/s²).
PathState = tuple[float, float, float]
#: For each track its brake, a law u(t), t >= 0; none while the motion does not brake.
Brakes = tuple[PiecewisePolynomial, ...]

_NO_TABLE = (np.empty((0, 3, 0)), np.empty((0, 2, 0)), np.empty(0), np.empty(0))


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


class _Answer(NamedTuple):
    """Answer of `brake_ahead`, with all that it has written."""

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

    def ask(table: tuple[Array, ...], stop_time: float, begin: float) -> _Answer:
        ramp, tracks = now.ramp, len(plan.tracks)
        state = np.array([*now[:4], ramp.goal, ramp.length, *ramp.coefficients])
        none, not_begun = _no_brakes(tracks)
        brakes, ends, reached = none.copy(), not_begun.copy(), np.empty(tracks)
        for track, law in enumerate(begun):
            count = len(law.coefficients)
            brakes[track, :count, 0] = law.breaks[:-1]
            brakes[track, :count, 1:] = law.coefficients[:, :, 0]
            ends[track] = law.end
        times = np.array([stop_time, begin, plan.duration])
        came, positions = braking.brake_ahead(
            *_arrays(plan), *table, times, stops, asks, wanted, dt, most, state, brakes, ends, reached
        )
        return _Answer(came, positions, state, brakes, ends, reached)

    answer = ask(_NO_TABLE, 0.0, 0.0)
    if answer.came == braking.NEEDS_TABLE:
        data = plan.braking
        answer = ask((data.table, data.beyond, data.max_acceleration, data.max_jerk), data.stop_time, data.begin)
    return answer


def _law(brake: Array, end: float) -> PiecewisePolynomial:
    begun = np.isfinite(brake[:, 0])
    return PiecewisePolynomial(np.append(brake[begun, 0], end), brake[begun, 1:, None])


@lru_cache
def _no_brakes(tracks: int) -> tuple[Array, Array]:
    """Return brakes and ends of a motion that has begun none, as `brake_ahead` takes them; each tick copies them."""
    return np.full((tracks, 3, 5), np.inf), np.full(tracks, -1.0)


# Beside the plans, which the journal keeps for good, and only for the last ones, as their braking tables.
@lru_cache(maxsize=256)
def _arrays(plan: Plan) -> tuple[NDArray[np.int64], Array, Array, Array, Array]:
    """Return a plan's polynomials, limits and goal as `brake_ahead` takes them."""
    shapes, breaks, terms = [], [], []
    for track in plan.tracks:
        for part in (track.path, track.quasi, track.time_law):
            if part is None:
                shapes.append(shapes[-1])  # the path's own derivatives are the velocities
                continue
            shapes.append((sum(map(len, breaks)), sum(map(len, terms)), *part.coefficients.shape))
            breaks.append(part.breaks)
            terms.append(part.coefficients.ravel())
    limits = np.stack([plan.max_velocity, plan.max_acceleration, plan.max_jerk])
    shaped = np.array(shapes, np.int64).reshape(-1, 3, 5)
    return shaped, np.concatenate(breaks), np.concatenate(terms), limits, plan.goal
