"""Where joints go in the next moment when their goal is known only now: each on its own, as fast as its limits allow.

Made anew in each tick by the library ruckig (Berscheid, Kröger, Jerk-limited Real-time Trajectory Generation with
Arbitrary Target States, RSS 2021): the time-optimal way to a goal continues itself, so a way that is made anew from a
point on it is the same way. Waypoints are never given to ruckig: they would go to a cloud service.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import ruckig

from virtualrobot_kernel.motion.limits import JointLimits

_FARTHEST_SECONDS = 100.0
"""Goals farther than this at the greatest velocity are taken for nearer ones: ruckig plans for two hours at most."""


class JointState(NamedTuple):
    """Positions, velocities and accelerations of k joints: rad or m, per s, per s²."""

    q: tuple[float, ...]
    v: tuple[float, ...]
    a: tuple[float, ...]


class _Leg(NamedTuple):
    """A way of k joints, as ruckig sees it from `origin` (k,), which moves with the velocities `drift` (k,).

    It ends with the velocities `last` (k,); where `rests`, it ends in the origin.
    """

    trajectory: ruckig.Trajectory
    origin: Sequence[float]
    drift: Sequence[float]
    last: Sequence[float]
    rests: bool

    def at(self, time: float) -> list[tuple[float, float, float]]:
        """Return position, velocity and acceleration of each joint; without rounding where its way has ended."""
        ends = self.trajectory.independent_min_durations
        states = []
        for q, v, a, end, origin, drift, last in zip(
            *self.trajectory.at_time(time), ends, self.origin, self.drift, self.last, strict=True
        ):
            at = origin + drift * time
            if end > time:
                states.append((at + q, drift + v, a))
            else:
                states.append((at if self.rests else at + q, last, 0.0))
        return states


class Way(NamedTuple):
    """A way of k joints that can be ended at every moment within their position limits."""

    leg: _Leg
    instead: _Leg | None
    chosen: tuple[bool, ...]
    limits: JointLimits

    def at(self, time: float) -> JointState:
        """Return where the joints are `time` seconds from now."""
        states = self.leg.at(time)
        if self.instead is not None:
            others = self.instead.at(time)
            states = [other if take else one for one, other, take in zip(states, others, self.chosen, strict=True)]
        q, v, a = zip(*states, strict=True)
        lower, upper = self.limits.lower.tolist(), self.limits.upper.tolist()
        # Rounding may lead past a limit by as much as a float's last places.
        return JointState(tuple(map(min, map(max, q, lower), upper)), v, a)


def brake(now: JointState, limits: JointLimits) -> Way:
    """Return the fastest way to standstill."""
    return Way(_brake(now, limits), None, (), limits)


def follow_velocities(
    now: JointState, wanted: Sequence[float], limits: JointLimits, greatest: Sequence[float], dt: float
) -> Way:
    """Return the fastest way to the velocities `wanted` (k,), and to a rest at the limit where one is near.

    `greatest` (k,) are the velocities that hold now; a joint that is faster slows down. The way is for `dt` seconds.
    """
    leg = _to_velocities(now, wanted, limits)
    goals = [
        (upper if speed > 0.0 else lower)
        for speed, lower, upper in zip(wanted, limits.lower, limits.upper, strict=True)
    ]
    return _within_limits(now, leg, goals, limits, greatest, dt)


def follow_positions(
    now: JointState,
    origin: Sequence[float],
    drift: Sequence[float],
    limits: JointLimits,
    greatest: Sequence[float],
    dt: float,
) -> Way:
    """Return the fastest way to a goal that is at `origin` (k,) now and moves with the velocities `drift` (k,).

    Seen from the goal the joint comes to rest, so it runs up to no goal and swings back from none. Where such a way
    could no longer be ended within the joint's limits, it is the fastest way to a rest at `origin`. `drift` is slower
    than `greatest` (k,), the velocities that hold now; a joint that is faster slows down. The way is for `dt` seconds.
    """
    leg = _to_rest(now, origin, drift, limits, greatest)
    return brake(now, limits) if leg is None else _within_limits(now, leg, origin, limits, greatest, dt)


def _within_limits(
    now: JointState,
    leg: _Leg,
    rests: Sequence[float],
    limits: JointLimits,
    greatest: Sequence[float],
    dt: float,
) -> Way:
    """Return the way by `leg`, but to a rest at `rests` (k,) for joints that could not stop within limits after `dt`.

    By induction every joint could stop within its limits now. The fastest way to a rest within them never leaves them:
    it turns back no later than the brake does.
    """
    q, v, a = (list(values) for values in zip(*leg.at(dt), strict=True))
    extrema = _brake(JointState(tuple(q), tuple(v), tuple(a)), limits).trajectory.position_extrema
    leaves = []
    for before, after, bound, lower, upper, acceleration in zip(
        now.q, q, extrema, limits.lower.tolist(), limits.upper.tolist(), limits.acceleration.tolist(), strict=True
    ):
        # Where it turns round between two ticks, it has been farther than at both by at most this.
        between = acceleration * dt * dt / 8.0
        lowest = min(after + bound.min, min(before, after) - between)
        highest = max(after + bound.max, max(before, after) + between)
        leaves.append(lowest < lower or highest > upper)
    if not any(leaves):
        return Way(leg, None, (), limits)
    goals = [goal if leave else place for goal, place, leave in zip(rests, now.q, leaves, strict=True)]
    instead = _to_rest(now, goals, [0.0] * len(goals), limits, greatest) or _brake(now, limits)
    return Way(leg, instead, tuple(leaves), limits)


def _brake(now: JointState, limits: JointLimits) -> _Leg:
    return _to_velocities(now, [0.0] * len(now.v), limits)


def _to_velocities(now: JointState, wanted: Sequence[float], limits: JointLimits) -> _Leg:
    count = len(now.q)
    given = ruckig.InputParameter(count)
    given.control_interface = ruckig.ControlInterface.Velocity
    given.current_velocity = now.v
    given.target_velocity = wanted
    trajectory = ruckig.Trajectory(count)
    _calculate(given, now.a, limits, trajectory)
    # Seen from where each joint is now.
    return _Leg(trajectory, now.q, [0.0] * count, wanted, False)


def _to_rest(
    now: JointState,
    origin: Sequence[float],
    drift: Sequence[float],
    limits: JointLimits,
    greatest: Sequence[float],
) -> _Leg | None:
    """Return the way to a rest in a moving origin; None where ruckig finds none.

    So it is where the greatest velocity has become about a millionth of the present one: its root finding fails, or the
    way back from where the joint can stop takes too long (a result that its binding cannot name). Braking helps that.
    """
    count = len(now.q)
    places = [
        max(-_FARTHEST_SECONDS * most, min(_FARTHEST_SECONDS * most, q - at))
        for q, at, most in zip(now.q, origin, greatest, strict=True)
    ]
    given = ruckig.InputParameter(count)
    given.current_position = places
    given.current_velocity = [v - speed for v, speed in zip(now.v, drift, strict=True)]
    given.max_velocity = [most - speed for most, speed in zip(greatest, drift, strict=True)]
    given.min_velocity = [-most - speed for most, speed in zip(greatest, drift, strict=True)]
    trajectory = ruckig.Trajectory(count)
    try:
        _calculate(given, now.a, limits, trajectory)
    except (ruckig.RuckigError, ValueError):
        return None
    # A goal that was taken nearer has its own place; q - place is the goal's elsewhere but for rounding.
    origin = [
        at if abs(place) < _FARTHEST_SECONDS * most else q - place
        for q, at, place, most in zip(now.q, origin, places, greatest, strict=True)
    ]
    return _Leg(trajectory, origin, drift, drift, True)


def _calculate(
    given: ruckig.InputParameter, acceleration: Sequence[float], limits: JointLimits, into: ruckig.Trajectory
) -> None:
    given.synchronization = ruckig.Synchronization.No
    given.current_acceleration = acceleration
    given.max_acceleration = limits.acceleration.tolist()
    given.max_jerk = limits.jerk.tolist()
    ruckig.Ruckig(given.degrees_of_freedom).calculate(given, into)
