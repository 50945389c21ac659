"""Limit check of arms that go along with a frame: every posture of the motion for every place of the frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.conveyor_tracking import OVERSHOOT, TrackingArm
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.planned import Plan, peaks
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.program import Stage
from virtualrobot_kernel.motion.resolved_rate import SMALLEST_SINGULAR_VALUE
from virtualrobot_kernel.planning.actuators import ActuatorLimit
from virtualrobot_kernel.world.actuators import LIMIT_TOLERANCE, beyond

STEP = 0.01
"""Spacing of the frame's places that are checked, in m or rad."""

_TIME_STEP, _FEWEST, _MOST = 0.015, 24, 200
_LARGEST_ERROR, _LARGEST_JUMP = 1e-9, 0.1
#: Every so many places derivatives are taken, and so many moments singular values.
_SPARSE, _THIN = 4, 6
#: For derivatives, in s and in m or rad.
_DT, _DE = 1e-3, 1e-3
#: The share of a velocity limit that the frame must leave to the motion.
_LEFT = 0.05
#: Of what the joints' acceleration limits leave, the share that goes to the frame's own acceleration at most, to
#: catching up and leaving at least and at most, and to both; and of the jerk limits what goes to catching up.
_BELT, _OWN, _BOTH, _JERK = 0.75, (0.2, 0.45), 0.95, 0.4
_MARGIN = 1.005

Place = Callable[[int, float, float, Array], tuple[str, dict[str, object]]]
"""Error text and metadata for a stage, a nominal time (s), the joint's displacement, and the arm's posture."""


@dataclass(frozen=True, eq=False)
class Rates:
    """Joint rates of an arm in one stage, at c places of the frame and m moments: arrays (c, m, k).

    times (m,): nominal, in s. by_time, by_time2: derivatives by nominal time; by_place, by_place2: by the joint's
    displacement; mixed: by both. nominal (m, k): the velocity where the frame was when it was planned.
    """

    stage: int
    times: Array
    places: Array
    nominal: Array
    by_time: Array
    by_time2: Array
    by_place: Array
    by_place2: Array
    mixed: Array


@dataclass(frozen=True)
class Budget:
    """Rates of the frame's joint that arms keep up with, and those left for catching up: unit per s, s², s², s³."""

    velocity: float
    acceleration: float
    own_acceleration: float
    own_jerk: float


def checked_rates(
    tracking_arm: TrackingArm,
    limits: JointLimits,
    actuators: Sequence[ActuatorLimit],
    stage: Stage,
    number: int,
    q: Array,
    ends: tuple[float, float],
    place: Place,
) -> Rates:
    """Return the rates of an arm's joints in a stage that begins with the motion's joints at q (n,).

    ends: the displacements of the joint between which it must go along, one of them 0. Raises LimitError, or
    KernelError with SINGULARITY or UNREACHABLE, that names the place.
    """
    times, states = _nominal(stage, q)
    nominal, velocity, acceleration = (state[:, tracking_arm.columns] for state in states)
    goal = ends[1] if ends[1] > 0.0 else ends[0]
    count = max(2 * _SPARSE, int(np.ceil(abs(goal) / STEP)))
    places = np.linspace(0.0, goal, count + 1)
    table = [nominal]
    thin = np.unique(np.append(np.arange(0, len(times), _THIN), len(times) - 1))
    null_space = _null_space(tracking_arm, nominal[thin])
    for column, e in enumerate(places.tolist()):
        if column:
            predicted = _extrapolated(table)
            found, error = tracking_arm.postures(nominal, np.full(len(times), e), predicted)
            bad = ~(error < _LARGEST_ERROR) | (np.abs(found - predicted).max(axis=1) > _LARGEST_JUMP)
            if bad.any():
                row = int(np.argmax(bad))
                where, metadata = place(number, times[row], e, table[-1][row])
                raise KernelError(
                    f"the arm cannot go along {where}: the next pose has no solution near this one",
                    reason=Reason.UNREACHABLE,
                    **metadata,
                )
            table.append(found)
            _check_limits(table, limits, actuators, times, e, number, place)
        _check_singularity(tracking_arm, null_space, table[-1][thin], times[thin], e, number, place)
    sparse = sorted({*range(0, count + 1, _SPARSE), count})
    rates = [_rates(tracking_arm, nominal, velocity, acceleration, places[j], table[j]) for j in sparse]
    return Rates(number, times, places[sparse], velocity, *(np.stack(arrays) for arrays in zip(*rates, strict=True)))


def _nominal(stage: Stage, q: Array) -> tuple[Array, Array]:
    """Return nominal times (m,) of a stage and the motion's joints then, with two derivatives: (3, m, n)."""
    if stage.plan is None or stage.plan.duration == 0.0:
        return np.zeros(1), np.stack([q, np.zeros_like(q), np.zeros_like(q)])[:, None]
    duration = stage.plan.duration
    breaks = np.concatenate([track.time_law.breaks for track in stage.plan.tracks])
    if len(breaks) > _MOST:
        breaks = breaks[:: len(breaks) // _MOST + 1]
    grid = np.linspace(0.0, duration, int(np.clip(duration / _TIME_STEP, _FEWEST, _MOST)))
    times = np.unique(np.clip(np.concatenate([grid, breaks, np.nextafter(breaks, -np.inf)]), 0.0, duration))
    states = np.zeros((3, len(times), len(q)))
    states[0] = q
    states[:, :, list(stage.columns)] = stage.plan.derivatives(times)[:3]
    return times, states


def _extrapolated(table: Sequence[Array]) -> Array:
    if len(table) == 1:
        return table[0]
    return 2.0 * table[-1] - table[-2] if len(table) == 2 else 3.0 * (table[-1] - table[-2]) + table[-3]


def _check_limits(
    table: Sequence[Array],
    limits: JointLimits,
    actuators: Sequence[ActuatorLimit],
    times: Array,
    e: float,
    number: int,
    place: Place,
) -> None:
    q = table[-1]
    # Between places that are looked at joints go beyond both by at most an eighth of the second difference.
    bend = (q - 2.0 * table[-2] + table[-3]) / 8.0 if len(table) > 2 else np.zeros_like(q)
    outside = (q + np.abs(bend) > limits.upper + TOLERANCE) | (q - np.abs(bend) < limits.lower - TOLERANCE)
    if outside.any():
        row, joint = (int(i) for i in np.argwhere(outside)[0])
        where, metadata = place(number, times[row], e, q[row])
        raise limits.error(joint, float(q[row, joint]), f"going along meets a joint limit {where}", **metadata)
    for one in actuators:
        positions, more = one.rest + q @ one.ratios, np.abs(bend @ one.ratios) - LIMIT_TOLERANCE
        outside = (positions + more > one.actuator.upper) | (positions - more < one.actuator.lower)
        if outside.any():
            row = int(np.argmax(outside))
            where, metadata = place(number, times[row], e, q[row])
            error = beyond(one.robot, one.actuator, float(positions[row]), f" {where}")
            error.metadata.update({key: str(value) for key, value in metadata.items()})
            raise error


def _null_space(tracking_arm: TrackingArm, nominal: Array) -> Array:
    """Return the projectors (m, k, k) on the null spaces at nominal postures (m, k): zeros for up to six joints."""
    count = nominal.shape[1]
    if count <= 6:
        return np.zeros((len(nominal), count, count))
    jacobians = tracking_arm.jacobians(nominal)
    return np.eye(count) - np.linalg.pinv(jacobians) @ jacobians


def _check_singularity(
    tracking_arm: TrackingArm, null_space: Array, q: Array, times: Array, e: float, number: int, place: Place
) -> None:
    """Raise KernelError (SINGULARITY) where what `follow_frame` solves at q (m, k) is nearly singular."""
    jacobians = tracking_arm.jacobians(q)
    system = jacobians.transpose(0, 2, 1) @ jacobians + null_space
    smallest = np.sqrt(np.maximum(np.linalg.eigvalsh(system)[:, 0], 0.0))
    worst = int(np.argmin(smallest))
    if smallest[worst] < SMALLEST_SINGULAR_VALUE:
        where, metadata = place(number, float(times[worst]), e, q[worst])
        raise KernelError(
            f"going along meets a singularity {where}: the smallest singular value of the Jacobian is "
            f"{smallest[worst]:.3g}, it must be at least {SMALLEST_SINGULAR_VALUE}",
            reason=Reason.SINGULARITY,
            singular_value=float(smallest[worst]),
            **metadata,
        )


def _rates(tracking_arm: TrackingArm, q: Array, v: Array, a: Array, e: float, near: Array) -> tuple[Array, ...]:
    """Return the derivatives that `Rates` holds at one place, by differences; near (m, k): the postures there."""

    def at(t: float, x: float) -> Array:
        return tracking_arm.postures(q + t * (v + 0.5 * t * a), np.full(len(q), e + x), near)[0]

    here, later, before, far, back = near, at(_DT, 0.0), at(-_DT, 0.0), at(0.0, _DE), at(0.0, -_DE)
    both = at(_DT, _DE) + at(-_DT, -_DE)
    return (
        (later - before) / (2.0 * _DT),
        (later - 2.0 * here + before) / _DT**2,
        (far - back) / (2.0 * _DE),
        (far - 2.0 * here + back) / _DE**2,
        (both - later - before - far - back + 2.0 * here) / (2.0 * _DT * _DE),
    )


def fastest_at(rates: Sequence[tuple[Rates, JointLimits]]) -> tuple[Array, Array]:
    """Return the frame's places (c,) and the greatest velocities (c,) of its joint that all arms keep up with there."""
    places = rates[0][0].places
    fastest = np.full(len(places), np.inf)
    for one, limits in rates:
        for slope, bend, overshoot in _along(one):
            keeps_up = ((1.0 - _LEFT) * limits.velocity / slope).min(axis=(1, 2))
            # At this velocity the centripetal part alone takes half of an acceleration limit.
            turns = np.sqrt(0.5 * limits.acceleration / np.maximum(bend, 1e-9)).min(axis=(1, 2))
            fastest = np.minimum(fastest, np.minimum(keeps_up, turns) / overshoot)
    return places, fastest


def _along(rates: Rates) -> Iterator[tuple[Array, Array, float]]:
    """Yield derivatives by the frame's place, first and second, each with how much faster than the frame the arm is."""
    # Catching up happens where the motion begins.
    for rows, overshoot in ((slice(None), 1.0), (slice(0, 1), OVERSHOOT if rates.stage == 0 else 1.0)):
        yield np.maximum(np.abs(rates.by_place[:, rows]), 1e-9), np.abs(rates.by_place2[:, rows]), overshoot


def budget(rates: Sequence[tuple[Rates, JointLimits]], velocity: float, acceleration: float) -> Budget:
    """Return the budget of all arms' limits for keeping up with a joint of this greatest velocity and acceleration.

    The velocity is no more than the least one of `fastest_at`.
    """
    slack, jerk = np.inf, np.inf
    for one, limits in rates:
        for slope, bend, overshoot in _along(one):
            slack = min(slack, float(((limits.acceleration - bend * (overshoot * velocity) ** 2) / slope).min()))
            jerk = min(jerk, float((limits.jerk / slope).min()))
    kept_up = min(acceleration, _BELT * slack)
    own = float(np.clip(_BOTH * slack - kept_up, _OWN[0] * slack, _OWN[1] * slack))
    return Budget(velocity, kept_up, own, _JERK * jerk)


def stretch(rates: Rates, limits: JointLimits, budget: Budget) -> float:
    """Return by what factor, at least 1, a stage has to be slower for an arm to keep its limits while it goes along."""
    along = np.abs(rates.by_place)
    room = limits.velocity - along * budget.velocity
    share = room / np.maximum(np.abs(rates.by_time), 1e-12)
    room = _room(rates, limits, budget)
    mixed = 2.0 * np.abs(rates.mixed) * budget.velocity
    root = np.sqrt(mixed**2 + 4.0 * np.abs(rates.by_time2) * room)
    share = np.minimum(share, 2.0 * room / np.maximum(mixed + root, 1e-12))
    factor = 1.0 / float(share.min())
    return factor * _MARGIN if factor > 1.0 else 1.0


def _room(rates: Rates, limits: JointLimits, budget: Budget) -> Array:
    """Return the acceleration (c, m, k) that the frame leaves to the motion, per s²."""
    reserve = max(budget.acceleration, budget.own_acceleration)
    along = np.abs(rates.by_place) * reserve + np.abs(rates.by_place2) * budget.velocity**2
    return limits.acceleration - along


def braking_share(rates: Rates, limits: JointLimits, budget: Budget, factor: float) -> float:
    """Return the share of the joints' limits, up to 1, that pausing and braking on the nominal path may take.

    It is what the same change of speed along the path takes of what the frame leaves, for the worst place.
    """
    moving = np.abs(rates.nominal).max(axis=1) > 1e-6 * np.abs(rates.nominal).max(initial=1e-9)
    if not moving.any():
        return 1.0
    mixed = 2.0 * np.abs(rates.mixed) * budget.velocity / factor
    room = np.maximum(_room(rates, limits, budget) - mixed, 0.1 * limits.acceleration)[:, moving]
    there = (room / np.maximum(np.abs(rates.by_time[:, moving]), 1e-12)).min(axis=2)
    here = (limits.acceleration / np.maximum(np.abs(rates.nominal[moving]), 1e-12)).min(axis=1)
    return min(1.0, 0.9 * float((there / here).min()))


def slowed(stage: Stage, factor: float, columns: dict[int, float]) -> Stage:
    """Return a stage that is slower by a factor; columns: which of the motion's joints brake with what share."""
    plan = stage.plan
    if plan is None:
        return stage
    tracks = tuple(
        replace(track, time_law=track.time_law.stretched(plan.duration * factor)) if factor > 1.0 else track
        for track in plan.tracks
    )
    share = np.array([columns.get(column, 1.0) for column in stage.columns])
    # A change of speed must leave room for what the motion itself does at most.
    reached = np.concatenate([peaks(track) for track in tracks], axis=1)
    limited: Plan = replace(
        plan,
        tracks=tracks,
        max_acceleration=np.maximum(share * plan.max_acceleration, reached[1]),
        max_jerk=np.maximum(share * plan.max_jerk, reached[2]),
    )
    return replace(
        stage,
        plan=limited,
        steps=tuple((float(time * factor), step) for time, step in stage.steps),
        zones=tuple((float(time * factor), step) for time, step in stage.zones),
        marks=tuple((float(time * factor), signal, value) for time, signal, value in stage.marks),
    )
