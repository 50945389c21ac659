"""Brakes of a cancelled motion: on each track, the fastest jerk-limited stop of the path parameter.

A rate ramp multiplies the motion's own law, jerk included, so it cannot stop a motion whose law is at its jerk limit.
A brake leaves the law: from the present state it is a new law u(t) on the same path.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.motion.planned import Plan, Track, peaks
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.ramp import SLACK

#: Shares of what the joints allow on a straight path that are tried, for acceleration and jerk each; the path's
#: curvature takes the rest.
_SHARES = (1.0, 0.8, 0.64, 0.5, 0.4, 0.3, 0.2, 0.1)
#: By how much a brake must stop sooner than the motion does anyway (s): above rounding, far below a tick.
_SOONER = 1e-6
_COARSE, _FINE = 32, 480
_ROUNDING = 1e-9
#: Phases shorter than this (s) are left out.
_SHORTEST = 1e-12

#: Path parameter u of a track and its first two derivatives by time (1/s, 1/s²).
PathState = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class BrakeChoice:
    """Choice of brakes: for each track one law u(t), t >= 0, or None.

    sooner: whether a brake can stop every track before the motion stands still anyway; if so and `brakes` is None,
    none of them keeps the limits of the joints.
    """

    brakes: tuple[PiecewisePolynomial, ...] | None
    sooner: bool


def can_brake(plan: Plan) -> bool:
    """Return True if every track has a jerk-limited law to leave; the law u = tau of a timed trajectory is not one."""
    return all(track.time_law.coefficients.shape[1] == 4 for track in plan.tracks)


def choose_brakes(plan: Plan, states: Sequence[PathState], left: float) -> BrakeChoice:
    """Return, for each track in its state, the soonest brake on which the joints keep the plan's limits.

    left: after how many seconds the motion stands still without a brake; brakes that are not sooner are left out.
    """
    brakes, first = [], 0
    for track, state in zip(plan.tracks, states, strict=True):
        joints = slice(first, first + track.path.dimension)
        first = joints.stop
        limits = np.stack([plan.max_velocity[joints], plan.max_acceleration[joints], plan.max_jerk[joints]])
        choice = _choose_brake(track.rated, state, limits, left)
        if not choice.sooner:
            return choice
        brakes.append(choice.brakes)
    fits = all(brake is not None for brake in brakes)
    return BrakeChoice(tuple(brake for one in brakes for brake in one) if fits else None, True)


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


def _choose_brake(path: PiecewisePolynomial, state: PathState, limits: Array, left: float) -> BrakeChoice:
    """Return the soonest brake of one track; limits (3, k): the joints' velocity, acceleration and jerk."""
    u, speed, slope = state
    if speed <= 0.0 and slope == 0.0:
        brake = PiecewisePolynomial(np.zeros(2), np.full((1, 1, 1), u))
        return BrakeChoice((brake,), True) if left > _SOONER else BrakeChoice(None, False)
    direction = np.abs(path.state(u, 1)[1])
    turning = direction > 0.0
    acceleration, jerk = (float((limit[turning] / direction[turning]).min()) for limit in limits[1:])
    # With less of both none is quicker: so the rest need not be looked at, where the motion runs to its goal.
    quickest = _phases(speed, slope, acceleration, jerk)
    if quickest is None or sum(quickest) + _SOONER >= left:
        return BrakeChoice(None, False)
    candidates = set()
    for j in _SHARES:
        for a in _SHARES:
            phases = _phases(speed, slope, a * acceleration, j * jerk)
            if phases is not None:
                candidates.add((sum(phases), j * jerk, phases))
    sooner = False
    for seconds, jerk, phases in sorted(candidates):
        if seconds + _SOONER >= left:
            break
        brake = _integrated(state, jerk, phases)
        if brake.scalar_state(brake.end)[0] <= path.end:
            sooner = True
            if _keeps(path, brake, limits):
                return BrakeChoice((brake,), True)
    return BrakeChoice(None, sooner)


def _phases(speed: float, slope: float, acceleration: float, jerk: float) -> tuple[float, float, float] | None:
    """Return the durations (s) of the time-optimal stop from u' = speed >= 0, u'' = slope, or None when there is none.

    Jerk -J until u'' = -a_p, jerk 0, jerk +J until u'' = 0. The first and last phase change u' by (u''² - a_p²) / 2J
    and -a_p² / 2J, so without the middle one a_p² = J u' + u''² / 2; where that exceeds A², a_p = A and the middle one
    lasts (u' + u''² / 2J - A² / J) / A. Source: the end of the double S profile, Biagiotti, Melchiorri, Trajectory
    Planning for Automatic Machines and Robots (2008), section 3.4. A is `acceleration` (1/s²), or the deceleration
    -u'' when that is larger already; J is `jerk` (1/s³). None: the deceleration is so large that even jerk +J would
    end it with u' < 0.
    """
    acceleration = max(acceleration, -slope)
    peak = math.sqrt(jerk * max(speed, 0.0) + 0.5 * slope * slope)
    if peak < -slope:
        return None
    if peak <= acceleration:
        return (slope + peak) / jerk, 0.0, peak / jerk
    peak = acceleration
    hold = (speed + (0.5 * slope * slope - peak * peak) / jerk) / peak
    return (slope + peak) / jerk, hold, peak / jerk


def _integrated(state: PathState, jerk: float, phases: tuple[float, float, float]) -> PiecewisePolynomial:
    u, speed, slope = state
    breaks, pieces = [0.0], []
    for time, j in zip(phases, (-jerk, 0.0, jerk), strict=True):
        if time <= _SHORTEST:
            continue
        pieces.append([u, speed, slope / 2.0, j / 6.0])
        u += time * (speed + time * (slope / 2.0 + time * j / 6.0))
        speed += time * (slope + time * j / 2.0)
        slope += time * j
        breaks.append(breaks[-1] + time)
    if not pieces:
        return PiecewisePolynomial(np.zeros(2), np.full((1, 1, 1), u))
    return PiecewisePolynomial(np.array(breaks), np.array(pieces)[:, :, None])


def _keeps(path: PiecewisePolynomial, brake: PiecewisePolynomial, limits: Array) -> bool:
    """Return True if the joints keep their limits (3, k) on a brake: on a few points first, then on many."""
    bounds = limits * (1.0 + np.array([_ROUNDING, SLACK, SLACK]))[:, None]
    track = Track(path, brake)
    few = track.derivatives(np.linspace(0.0, brake.end, _COARSE))[1:]
    if np.any(np.abs(few).max(axis=1) > bounds):
        return False
    begin, end = brake.scalar_state(0.0)[0], brake.scalar_state(brake.end)[0]
    # Of a long path, such as a program's, only what the brake covers is looked at: this is done within a tick.
    covered = Track(path.between(begin, end), brake) if begin < end else track
    return bool(np.all(peaks(covered, _FINE) <= bounds))
