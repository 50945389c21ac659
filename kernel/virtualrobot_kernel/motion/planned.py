"""Planned motion: geometric paths and time laws as plain arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial, flattened
from virtualrobot_kernel.numeric import samples
from virtualrobot_kernel.numeric.laws import greatest_rates

#: Time between rows of a braking table (s), and the fewest and most rows.
_TABLE_STEP, _TABLE_ROWS = 0.002, (512, 16384)
#: Number of times at which a plan is sampled in one call.
_TOGETHER = 4096
#: Distance from a break at which its sides are evaluated, as a share of the whole law: far above rounding.
_ASIDE = 1e-9


@dataclass(frozen=True, eq=False)
class Track:
    """One path q(u) (k joints) and its law u(tau), tau in [0, duration]; at rest at both ends of the law.

    path_limits: largest |d2u/dt2| and |d3u/dt3| (1/s², 1/s³) of a line or an arc, whose own acceleration and jerk are
    limited; None for paths that only joints limit. quasi: quasi-coordinates, whose derivatives are the velocities where
    the path has quaternions (`motion.orientation`); None where they are the path's own.
    """

    path: PiecewisePolynomial
    time_law: PiecewisePolynomial
    path_limits: tuple[float, float] | None = None
    quasi: PiecewisePolynomial | None = None

    @property
    def rated(self) -> PiecewisePolynomial:
        """Function of u whose derivatives are the velocities of the columns by u."""
        return self.quasi or self.path

    def derivatives(self, tau: Array) -> Array:
        """Return q, dq/dtau, d2q/dtau2 and d3q/dtau3 at nominal times (m,): shape (4, m, k)."""
        _, u1, u2, u3 = (law := self.time_law.states(tau, 3))
        q, q1, q2, q3 = self.path.states(law[0, :, 0], 3)
        if self.quasi is not None:
            q1, q2, q3 = self.quasi.states(law[0, :, 0], 3)[1:]
        return np.stack([q, q1 * u1, q2 * u1**2 + q1 * u2, q3 * u1**3 + 3.0 * q2 * u1 * u2 + q1 * u3])

    @property
    def sides(self) -> Array:
        """Nominal times (m,) on both sides of each break of the law.

        Where law and path break together rounding may find the piece of the law on one side and that of the path on the
        other, with derivatives that there are nowhere. So the sides are a little away from the break.
        """
        breaks = self.time_law.breaks
        aside = _ASIDE * (breaks[-1] - breaks[0])
        return np.clip(np.concatenate([breaks - aside, breaks + aside]), breaks[0], breaks[-1])

    def grid(self, points: int) -> Array:
        """Return nominal times (m,) that cover the law evenly, each of its breaks from both sides included."""
        points = max(points, 8 * len(self.path.coefficients))
        return np.concatenate([np.linspace(self.time_law.start, self.time_law.end, points), self.sides])


@dataclass(frozen=True, eq=False)
class Braking:
    """Derivatives of a plan on an even grid of nominal time, for n joints and the u of l lines and arcs.

    table (N, 3, n + l): first to third derivative at N - 1 times from `begin` to the plan's duration, then zeros.
    beyond (N, 2, n + l): how far the second and third one get beyond those of both rows at the breaks of the laws
    between a row and the next: a time-optimal acceleration is a saw, a pulse of jerk may be shorter than a step.
    max_acceleration, max_jerk (n + l,): the limits of what runs on it. stop_time (s): how long a smooth stop from top
    speed takes. begin: the nominal time (s) of the first row.
    """

    table: Array
    beyond: Array
    max_acceleration: Array
    max_jerk: Array
    stop_time: float
    begin: float


@dataclass(frozen=True, eq=False)
class Plan:
    """Motion of n joints that is at rest at both ends; joints of a group's robots are concatenated.

    A plan that more was joined to while it ran may begin at a nominal time above 0, on its way.

    kind: "ptp", "lin", "circ", "trajectory" or "group". tracks: one for each robot, all with the same duration.
    start, goal (n,): the joints at the ends, to the last bit (rad or m).
    max_velocity, max_acceleration, max_jerk (n,): what running it may reach: the joint limits, or the motion's own
    peaks where a timed trajectory has higher ones (rad or m, per s, s², s³).
    """

    kind: str
    joint_names: tuple[str, ...]
    tracks: tuple[Track, ...]
    start: Array
    goal: Array
    max_velocity: Array
    max_acceleration: Array
    max_jerk: Array
    duration: float = field(init=False)

    def __post_init__(self) -> None:
        """Freeze the arrays and derive the duration (s)."""
        ends = {track.time_law.end for track in self.tracks}
        if len(ends) != 1:
            raise KernelError(f"the tracks of one plan must last equally long, not {sorted(ends)} s")
        object.__setattr__(self, "duration", ends.pop())
        for name in ("start", "goal", "max_velocity", "max_acceleration", "max_jerk"):
            values = np.array(getattr(self, name), dtype=np.float64)
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    @property
    def q_count(self) -> int:
        """Number n of joints."""
        return len(self.joint_names)

    @property
    def braking(self) -> Braking:
        """Data for choosing a change of the rate; made only for a motion that is asked for one."""
        return _braking(self)

    def derivatives(self, tau: Array) -> Array:
        """Return q and its first three derivatives by nominal time at (m,) times: shape (4, m, n)."""
        if len(self.tracks) == 1:
            return self.tracks[0].derivatives(tau)
        return np.concatenate([track.derivatives(tau) for track in self.tracks], axis=2)

    def at(self, taus: Array) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (m, n) at nominal times (m,) at full rate.

        They are those that ticks have, bit for bit.
        """
        shapes, breaks, terms, _, goal = flat(self)
        tracks, parts = len(self.tracks), []
        for first in range(0, len(taus), _TOGETHER):
            some = taus[first : first + _TOGETHER]
            count, rates = len(some), np.tile([0.0, 1.0, 0.0, 0.0], (len(some), 1))
            rates[:, 0] = some
            found = samples.sample_plans(
                np.tile(shapes, (count, 1, 1)),
                breaks,
                terms,
                np.arange(count + 1, dtype=np.int64) * tracks,
                np.tile(goal, count),
                np.full(count, self.duration),
                rates,
                np.zeros((count * tracks, 3)),
            )
            parts.append(found.reshape(3, count, -1))
        q, v, a = np.concatenate(parts, axis=1) if parts else np.zeros((3, 0, self.q_count))
        return q, v, a

    def sample(self, tau: float, rate: float, rate_slope: float) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (n,) at nominal time `tau` when dtau/dt = `rate`.

        rate_slope: d2tau/dt2 in 1/s.
        """
        return sample_plans((self,), [(tau, rate, rate_slope, 0.0)], {})


def sample_plans(
    plans: tuple[Plan, ...],
    states: Sequence[tuple[float, float, float, float]],
    brakes: Mapping[int, Sequence[tuple[float, float, float]]],
) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations (n,) of the joints of plans, one plan after another.

    What comes of one doesn't depend on the others. states: nominal time, its rate and the rate's slope of each, and 1
    where its tracks brake; brakes: of those, by their place, u, du/dt and d2u/dt2 of each track.
    """
    shapes, breaks, terms, tracks, goal, durations, along = _together(plans)
    if brakes:
        along = along.copy()
        for place, found in brakes.items():
            along[tracks[place] : tracks[place + 1]] = found
    q, v, a = samples.sample_plans(shapes, breaks, terms, tracks, goal, durations, np.array(states), along)
    return q, v, a


# Beside the plans, which the journal keeps for good, and only for the last ones, as their braking tables.
@lru_cache(maxsize=256)
def flat(plan: Plan) -> tuple[NDArray[np.int64], Array, Array, Array, Array]:
    """Return a plan's polynomials, as compiled code takes them, its limits and its goal.

    The polynomials (`flattened`) are path, what rates it, and law of each track: shapes (t, 3, 5).
    """
    parts = [part for track in plan.tracks for part in (track.path, track.rated, track.time_law)]
    shapes, breaks, terms = flattened(parts)
    limits = np.stack([plan.max_velocity, plan.max_acceleration, plan.max_jerk])
    return shapes.reshape(-1, 3, 5), breaks, terms, limits, plan.goal


# Few at a time: a tick asks for all that go on plans, the next one mostly for the same.
@lru_cache(maxsize=4)
def _together(plans: tuple[Plan, ...]) -> tuple[NDArray[Any], ...]:
    """Return plans as `numeric.samples` takes them, and what `along` is while none brakes."""
    parts = [flat(plan) for plan in plans]
    shapes, begun = [], np.zeros(2, np.int64)
    for shape, breaks, terms, _, _ in parts:
        shapes.append(shape + np.append(begun, [0, 0, 0]))
        begun += len(breaks), len(terms)
    tracks = np.cumsum([0, *(len(shape) for shape in shapes)])
    breaks, terms, goal = (np.concatenate([part[place] for part in parts]) for place in (1, 2, 4))
    durations = np.array([plan.duration for plan in plans])
    return np.concatenate(shapes), breaks, terms, tracks, goal, durations, np.zeros((tracks[-1], 3))


# Large, and the journal keeps every plan for good: so beside the plans, and only for the last ones.
@lru_cache(maxsize=128)
def _braking(plan: Plan) -> Braking:
    begin = min(track.time_law.start for track in plan.tracks)
    times = np.linspace(begin, plan.duration, int(np.clip((plan.duration - begin) / _TABLE_STEP, *_TABLE_ROWS)))
    tcp_path = [(track.time_law, *track.path_limits) for track in plan.tracks if track.path_limits]

    def rows(at: Array) -> Array:
        derivatives = [plan.derivatives(at)[1:], *(law.states(at, 3)[1:] for law, _, _ in tcp_path)]
        return np.concatenate(derivatives, axis=2).transpose(1, 0, 2)

    table = rows(times)
    table = np.ascontiguousarray(np.concatenate([table, np.zeros((1, *table.shape[1:]))]))
    sides = np.concatenate([track.sides for track in plan.tracks])
    before = np.searchsorted(times[1:-1], sides, side="right")
    ends = np.stack([table[before, 1:], table[before + 1, 1:]])
    between = rows(sides)[:, 1:]
    beyond = np.zeros((len(table), 2, table.shape[2]))
    np.maximum.at(beyond, before, np.maximum(between - ends.max(axis=0), ends.min(axis=0) - between))
    accelerations = np.array([*plan.max_acceleration, *(acceleration for _, acceleration, _ in tcp_path)])
    jerks = np.array([*plan.max_jerk, *(jerk for _, _, jerk in tcp_path)])
    peak = np.abs(table[:, 0]).max(axis=0)
    # Peaks of a quintic step from 1 to 0 in time T: |rate'| 15/8 / T, |rate''| 10/sqrt(3) / T².
    seconds = np.maximum(1.875 * peak / accelerations, np.sqrt(10.0 / np.sqrt(3.0) * peak / jerks))
    return Braking(table, beyond, accelerations, jerks, float(seconds.max(initial=0.0)), begin)


def peaks(track: Track, points: int = 2000) -> Array:
    """Return the largest |velocity|, |acceleration| and |jerk| of a track at nominal rate: (3, k)."""
    greatest = np.empty((3, track.path.dimension))
    greatest_rates(*flattened([track.rated.derivative(), track.time_law]), track.grid(points), greatest)
    return greatest


def planned(
    kind: str,
    path: PiecewisePolynomial,
    time_law: PiecewisePolynomial,
    limits: JointLimits,
    goal: Array | None = None,
    path_limits: tuple[float, float] | None = None,
    quasi: PiecewisePolynomial | None = None,
) -> Plan:
    """Return the plan of one robot; `limits` are the joints' own, not those of a slower move.

    goal: (k,), where the joints end, when that is known better than the path's rounding; path_limits, quasi: see
    `Track`.
    """
    track = Track(path, time_law, path_limits, quasi)
    velocity, acceleration, jerk = peaks(track)
    return Plan(
        kind,
        limits.names,
        (track,),
        path.evaluate(path.start),
        path.evaluate(path.end) if goal is None else goal,
        np.maximum(limits.velocity, velocity),
        np.maximum(limits.acceleration, acceleration),
        np.maximum(limits.jerk, jerk),
    )


def plan_together(plans: Sequence[Plan]) -> Plan:
    """Return one plan in which several robots start and end together.

    Each is slowed down uniformly to the longest, so its path, and its limits, stay; the joints are concatenated.
    """
    if not plans:
        raise KernelError("a group needs at least one motion")
    duration = max(plan.duration for plan in plans)
    return Plan(
        "group",
        tuple(name for plan in plans for name in plan.joint_names),
        tuple(replace(track, time_law=track.time_law.stretched(duration)) for plan in plans for track in plan.tracks),
        np.concatenate([plan.start for plan in plans]),
        np.concatenate([plan.goal for plan in plans]),
        np.concatenate([plan.max_velocity for plan in plans]),
        np.concatenate([plan.max_acceleration for plan in plans]),
        np.concatenate([plan.max_jerk for plan in plans]),
    )
