"""Online trajectories of joints to a goal that is known only now: each joint on its own, as fast as its limits allow.

Made anew in each tick by the library ruckig (Berscheid, Kröger, Jerk-limited Real-time Trajectory Generation with
Arbitrary Target States, RSS 2021): the time-optimal way to a goal continues itself, so a way that is made anew from a
point on it is the same way. Waypoints are never given to ruckig: they would go to a cloud service.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from math import ceil, log2
from operator import add, gt, sub
from threading import get_ident
from typing import NamedTuple

import ruckig

from virtualrobot_kernel.motion.limits import JointLimits

_FARTHEST_SECONDS = 100.0
"""Longest way to a goal, in seconds at the greatest velocity; farther ones count as nearer: ruckig plans two hours."""

MOST_SECONDS = 600.0
"""Longest time (s) of a joint to its greatest acceleration, or with that to its velocity, for ruckig's two hours."""


class JointState(NamedTuple):
    """Positions, velocities and accelerations of k joints: rad or m, per s, per s²."""

    q: tuple[float, ...]
    v: tuple[float, ...]
    a: tuple[float, ...]


class _Range(NamedTuple):
    min: float
    max: float


class _Scaled(NamedTuple):
    """Trajectory whose joints are in `units` (k,) of rad or m, asked as one in rad and m is."""

    trajectory: ruckig.Trajectory
    units: Sequence[float]

    @property
    def duration(self) -> float:
        return self.trajectory.duration

    @property
    def independent_min_durations(self) -> Sequence[float]:
        return self.trajectory.independent_min_durations

    @property
    def position_extrema(self) -> Sequence[_Range]:
        extrema = self.trajectory.position_extrema
        return [_Range(unit * most.min, unit * most.max) for unit, most in zip(self.units, extrema, strict=True)]

    def at_time(self, time: float) -> tuple[Sequence[float], ...]:
        """Return positions, velocities and accelerations (k,)."""
        return tuple(
            [unit * value for unit, value in zip(self.units, values, strict=True)]
            for values in self.trajectory.at_time(time)
        )


class _Leg(NamedTuple):
    """Trajectory of k joints, as ruckig sees it from `origin` (k,), which moves with the velocities `drift` (k,).

    It ends with the velocities `last` (k,); where `rests`, it ends in the origin.
    """

    trajectory: ruckig.Trajectory | _Scaled
    origin: Sequence[float]
    drift: Sequence[float]
    last: Sequence[float]
    rests: bool

    def at(self, time: float) -> JointState:
        """Return the state of the joints; without rounding where a joint's way has ended."""
        ends = self.trajectory.independent_min_durations
        places, speeds, slopes = self.trajectory.at_time(time)
        if min(ends) > time:
            there = [at + drift * time + q for q, at, drift in zip(places, self.origin, self.drift, strict=True)]
            return JointState(tuple(there), tuple(map(add, self.drift, speeds)), tuple(slopes))
        states = []
        going = places, speeds, slopes, self.origin, self.drift
        for q, v, a, origin, drift, end, last in zip(*going, ends, self.last, strict=True):
            at = origin + drift * time
            if end > time:
                states.append((at + q, drift + v, a))
            else:
                states.append((at if self.rests else at + q, last, 0.0))
        return JointState(*zip(*states, strict=True))


class Coupling(NamedTuple):
    """Limits of an actuator that moves several joints: lower <= sum of ratio times joint <= upper."""

    name: str
    terms: tuple[tuple[int, float], ...]
    """Terms of the sum: pairs of a joint's column and its ratio."""
    lower: float
    upper: float

    def value(self, q: Sequence[float]) -> float:
        """Return the sum for joints q (k,)."""
        return sum(ratio * q[column] for column, ratio in self.terms)


class Bounds(NamedTuple):
    """Limits of k joints, (k,) each as in `JointLimits`, and those of actuators that move several of them."""

    lower: list[float]
    upper: list[float]
    acceleration: list[float]
    jerk: list[float]
    couplings: tuple[Coupling, ...]

    @staticmethod
    def of(limits: JointLimits, couplings: Sequence[Coupling]) -> Bounds:
        """Return the bounds of joints with these limits."""
        values = (limits.lower, limits.upper, limits.acceleration, limits.jerk)
        return Bounds(*(value.tolist() for value in values), couplings=tuple(couplings))


class StoppableTrajectory(NamedTuple):
    """Trajectory of k joints that can be ended at every moment within their position limits."""

    legs: tuple[_Leg, ...]
    chosen: Sequence[int]
    """Index of each joint's leg in `legs`, (k,)."""
    bounds: Bounds

    @property
    def duration(self) -> float:
        """Duration of the longest of the chosen legs (s)."""
        return max(self.legs[leg].trajectory.duration for leg in set(self.chosen))

    def at(self, time: float) -> JointState:
        """Return the state of the joints `time` seconds from now."""
        states = [leg.at(time) for leg in self.legs]
        chosen = enumerate(self.chosen)
        rows = [[part[joint] for part in states[leg]] for joint, leg in chosen]
        return _inside(JointState(*zip(*rows, strict=True)), self.bounds)


def _inside(there: JointState, bounds: Bounds) -> JointState:
    """Return the state with joints in their limits: rounding may have led past one by a float's last places."""
    return there._replace(q=tuple(map(min, map(max, there.q, bounds.lower), bounds.upper)))


def brake(now: JointState, bounds: Bounds, dt: float) -> tuple[StoppableTrajectory, JointState]:
    """Return the fastest way to standstill, and where it is after `dt` seconds."""
    way = StoppableTrajectory((_brake(now, bounds),), (0,) * len(now.q), bounds)
    return way, way.at(dt)


def follow_velocities(
    now: JointState, wanted: Sequence[float], bounds: Bounds, greatest: Sequence[float], dt: float
) -> tuple[StoppableTrajectory, JointState]:
    """Return the fastest way to the velocities `wanted` (k,), and to a rest at the limit where one is near.

    `greatest` (k,) are the velocities that hold now; a joint that is faster slows down. The way is for the next `dt`
    seconds; it comes with where the joints are then.
    """
    leg = _to_velocities(now, wanted, bounds)
    goals = [
        (upper if speed > 0.0 else lower)
        for speed, lower, upper in zip(wanted, bounds.lower, bounds.upper, strict=True)
    ]
    return _within_limits(now, leg, goals, bounds, greatest, dt)


def follow_positions(
    now: JointState,
    origin: Sequence[float],
    drift: Sequence[float],
    bounds: Bounds,
    greatest: Sequence[float],
    dt: float,
) -> tuple[StoppableTrajectory, JointState]:
    """Return the fastest way to a goal that is at `origin` (k,) now and moves with the velocities `drift` (k,).

    Seen from the goal the joint comes to rest, so it runs up to no goal and swings back from none. Where such a way
    could no longer be ended within the joint's limits, it is the fastest way to a rest at `origin`. `drift` is slower
    than `greatest` (k,), the velocities that hold now; a joint that is faster slows down. The way is for the next `dt`
    seconds; it comes with where the joints are then.
    """
    leg = _to_rest(now, origin, drift, bounds, greatest)
    return brake(now, bounds, dt) if leg is None else _within_limits(now, leg, origin, bounds, greatest, dt)


def can_stop(now: JointState, then: JointState, bounds: Bounds, dt: float) -> bool:
    """Return whether joints that go from one state to another in `dt`, and then brake, keep position limits."""
    if not bounds.couplings and _far_from_limits(now, then, bounds, dt):
        return True
    spans = _spans(now, then, bounds, dt)
    if any(a < lower or b > upper for (a, b), lower, upper in zip(spans, bounds.lower, bounds.upper, strict=True)):
        return False
    for coupling in bounds.couplings:
        lowest, highest = map(sum, _reach(coupling, spans))
        if lowest < coupling.lower or highest > coupling.upper:
            return False
    return True


def _within_limits(
    now: JointState,
    leg: _Leg,
    rests: Sequence[float],
    bounds: Bounds,
    greatest: Sequence[float],
    dt: float,
) -> tuple[StoppableTrajectory, JointState]:
    """Return the way by `leg`, but to a rest at `rests` (k,) for joints that could not stop within limits after `dt`.

    By induction every joint could stop within its limits now. The fastest way to a rest within them never leaves them:
    it turns back no later than the brake does. Of joints that an actuator couples, one that would leave its limits
    brakes, and so do those that lead the actuator beyond its own.
    """
    then = leg.at(dt)
    if not bounds.couplings and _far_from_limits(now, then, bounds, dt):
        return StoppableTrajectory((leg,), (0,) * len(then.q), bounds), then
    spans = _spans(now, then, bounds, dt)
    chosen = [
        1 if lowest < lower or highest > upper else 0
        for (lowest, highest), lower, upper in zip(spans, bounds.lower, bounds.upper, strict=True)
    ]
    if bounds.couplings:
        _brake_coupled(now, bounds, chosen, spans)
    if not any(chosen):
        return StoppableTrajectory((leg,), chosen, bounds), _inside(then, bounds)
    goals = [goal if choice == 1 else place for goal, place, choice in zip(rests, now.q, chosen, strict=True)]
    braking = _brake(now, bounds)
    instead = _to_rest(now, goals, [0.0] * len(goals), bounds, greatest) or braking
    way = StoppableTrajectory((leg, instead, braking), chosen, bounds)
    return way, way.at(dt)


def _spans(now: JointState, then: JointState, bounds: Bounds, dt: float) -> list[tuple[float, float]]:
    """Return between which positions each joint stays that goes from one state to another within `dt`, then brakes."""
    q, v, _ = then
    extrema = _brake(then, bounds).trajectory.position_extrema
    spans = []
    for joint in range(len(q)):
        between = 0.0
        if now.v[joint] * v[joint] < 0.0:
            # Where it turned round between the ticks, it has been farther than at both by at most this,
            between = bounds.acceleration[joint] * dt**2 / 8.0
        elif now.v[joint] or now.a[joint]:
            # and where it turned twice by this; from standstill, or fast, it doesn't turn.
            slow = min(abs(now.v[joint]), abs(v[joint])) < bounds.jerk[joint] * dt**2 / 8.0
            between = bounds.jerk[joint] * dt**3 / 12.0 if slow else 0.0
        lowest = min(now.q[joint], q[joint] + extrema[joint].min) - between
        highest = max(now.q[joint], q[joint] + extrema[joint].max) + between
        spans.append((lowest, highest))
    return spans


def _far_from_limits(now: JointState, then: JointState, bounds: Bounds, dt: float) -> bool:
    """Return whether each joint can stop within its limits after `dt`, and keeps them until then: quick, and cautious.

    A brake from v and a goes at most |v| t + |a| t²/2 until its acceleration has ended, with t = |a|/j, and from then
    on, at the speed w = |v| + |a| t/2, at most w²/(2 A) + w A/(2 j): what the double S profile takes where it reaches
    the greatest acceleration A, and more than it takes where it doesn't.
    """
    for place, q, v, a, lower, upper, most, jerk in zip(
        now.q, *then, bounds.lower, bounds.upper, bounds.acceleration, bounds.jerk, strict=True
    ):
        time = abs(a) / jerk
        speed = abs(v) + abs(a) * time / 2.0
        way = speed * time + speed / 2.0 * (speed / most + most / jerk)
        way += most * dt**2 / 8.0  # where it turns round between the ticks
        if not (lower + way <= q <= upper - way and lower + way <= place <= upper - way):
            return False
    return True


def _brake_coupled(now: JointState, bounds: Bounds, chosen: list[int], spans: list[tuple[float, float]]) -> None:
    """Make joints brake (`chosen` becomes 2) until no actuator can leave its limits while joints are in their spans.

    First those brake that lead an actuator beyond its limit, so that others may lead it back. By induction all can
    brake within the limits, now and, as what is left of a braking joint's span becomes smaller, after this tick, too.
    """
    extrema = _brake(now, bounds).trajectory.position_extrema
    braking = [(min(q, q + most.min), max(q, q + most.max)) for q, most in zip(now.q, extrema, strict=True)]

    def brakes(columns: Iterable[int]) -> bool:
        moving = [column for column in columns if chosen[column] != 2]
        for column in moving:
            chosen[column], spans[column] = 2, braking[column]
        return bool(moving)

    for coupling in bounds.couplings:
        brakes(column for column, _ in coupling.terms if chosen[column])
    again = True
    while again:
        again = False
        for coupling in bounds.couplings:
            lowest, highest = _reach(coupling, spans)
            least, most = _reach(coupling, braking)
            # Braking is all that can be done, also where rounding has led past a limit.
            columns = [column for column, _ in coupling.terms]
            if sum(lowest) < min(coupling.lower, sum(least)):
                again |= brakes(column for column, a, b in zip(columns, lowest, least, strict=True) if a < b)
            if sum(highest) > max(coupling.upper, sum(most)):
                again |= brakes(column for column, a, b in zip(columns, highest, most, strict=True) if a > b)


def _reach(coupling: Coupling, spans: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    """Return the least and the greatest terms of an actuator's position, a joint each, with each joint in its span."""
    ways = [(ratio * spans[column][0], ratio * spans[column][1]) for column, ratio in coupling.terms]
    return list(map(min, ways)), list(map(max, ways))


def _brake(now: JointState, bounds: Bounds) -> _Leg:
    return _to_velocities(now, [0.0] * len(now.v), bounds)


def _to_velocities(now: JointState, wanted: Sequence[float], bounds: Bounds) -> _Leg:
    try:
        trajectory = _velocities(now, wanted, bounds)
    except (ruckig.RuckigError, ValueError):
        # Its last check is that the end is met to amounts that are fixed, which rounding exceeds where a joint is very
        # fast. In units in which nothing but the jerk is above 1 it doesn't; powers of 2 round nothing.
        units = [
            2.0 ** ceil(log2(max(1.0, abs(v), abs(a), abs(speed), most)))
            for v, a, speed, most in zip(now.v, now.a, wanted, bounds.acceleration, strict=True)
        ]

        def scaled(values: Sequence[float]) -> list[float]:
            return [value / unit for value, unit in zip(values, units, strict=True)]

        less = bounds._replace(acceleration=scaled(bounds.acceleration), jerk=scaled(bounds.jerk))
        slower = now._replace(v=scaled(now.v), a=scaled(now.a))
        trajectory = _Scaled(_velocities(slower, scaled(wanted), less), units)
    # Seen from where each joint is now.
    return _Leg(trajectory, now.q, [0.0] * len(now.q), wanted, False)


def _velocities(now: JointState, wanted: Sequence[float], bounds: Bounds) -> ruckig.Trajectory:
    given = _input(get_ident(), len(now.q), ruckig.ControlInterface.Velocity)
    given.current_velocity = now.v
    given.target_velocity = wanted
    trajectory = ruckig.Trajectory(len(now.q))
    _calculate(given, now.a, bounds, trajectory)
    return trajectory


def _to_rest(
    now: JointState,
    origin: Sequence[float],
    drift: Sequence[float],
    bounds: Bounds,
    greatest: Sequence[float],
) -> _Leg | None:
    """Return the way to a rest in a moving origin; None where ruckig finds none.

    So it is where the greatest velocity has become about a millionth of the present one: its root finding fails, or the
    way back from where the joint can stop takes too long (a result that its binding cannot name). Braking helps that.
    """
    count = len(now.q)
    places = list(map(sub, now.q, origin))
    if max(map(abs, places)) > _FARTHEST_SECONDS * min(greatest):
        farthest = [_FARTHEST_SECONDS * most for most in greatest]
        if any(map(gt, map(abs, places), farthest)):
            places = [max(-far, min(far, place)) for place, far in zip(places, farthest, strict=True)]
            origin = [q - place for q, place in zip(now.q, places, strict=True)]
    given = _input(get_ident(), count, ruckig.ControlInterface.Position)
    given.current_position = places
    given.current_velocity = list(map(sub, now.v, drift))
    given.max_velocity = list(map(sub, greatest, drift))
    given.min_velocity = [-most - speed for most, speed in zip(greatest, drift, strict=True)]
    trajectory = ruckig.Trajectory(count)
    try:
        _calculate(given, now.a, bounds, trajectory)
    except (ruckig.RuckigError, ValueError):
        return None
    return _Leg(trajectory, origin, drift, drift, True)


def _calculate(
    given: ruckig.InputParameter, acceleration: Sequence[float], bounds: Bounds, into: ruckig.Trajectory
) -> None:
    given.current_acceleration = acceleration
    given.max_acceleration = bounds.acceleration
    given.max_jerk = bounds.jerk
    _calculator(get_ident(), given.degrees_of_freedom).calculate(given, into)


@lru_cache(maxsize=64)
def _input(thread: int, joints: int, interface: ruckig.ControlInterface) -> ruckig.InputParameter:
    """Return what so many joints are asked with in a thread; whoever asks sets all that is not the same each time."""
    del thread
    given = ruckig.InputParameter(joints)
    given.control_interface, given.synchronization = interface, ruckig.Synchronization.No
    return given


@lru_cache(maxsize=64)
def _calculator(thread: int, joints: int) -> ruckig.Ruckig:
    """Return what calculates ways of so many joints in a thread; it keeps nothing of one for the next."""
    del thread
    return ruckig.Ruckig(joints)
