"""Brakes and ramps chosen by NumPy, a candidate after the other: what the compiled choice is compared with."""

from __future__ import annotations

import math

import numpy as np
from virtualrobot_kernel.motion.brake import Brakes, RateState
from virtualrobot_kernel.motion.planned import Plan, Track, peaks
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.ramp import RateRamp

SHARES = (1.0, 0.8, 0.64, 0.5, 0.4, 0.3, 0.2, 0.1)
LENGTHS = 1.2 ** np.arange(-12.0, 10.0)
SLACK, SOONER = 0.005, 1e-6


def change(plan: Plan, now: RateState, wanted: float, *, stops: bool) -> tuple[Brakes, RateRamp | None, bool]:
    """Return the brakes, the ramp, and whether it waits for a better moment."""
    left = _time_left(plan, now) if stops else math.inf
    if stops and all(track.time_law.coefficients.shape[1] == 4 for track in plan.tracks):
        choices = [_brake(track, state, limits, left) for track, state, limits in _joints(plan, now)]
        if not all(sooner for _, sooner in choices):
            return (), None, False
        brakes = tuple(brake for brake, _ in choices if brake is not None)
        if len(brakes) == len(choices):
            return brakes, None, False
    if wanted == now.ramp.goal:
        return (), None, False
    rate, slope, curvature, _ = now.ramp.state(now.elapsed)
    patience = max(plan.braking.stop_time, 0.1) if rate > 0.0 else 0.0
    prompt = now.waiting < patience
    columns = plan.q_count if stops else plan.braking.table.shape[2]
    ramp = _ramp(plan, columns, now.tau, (rate, slope, curvature), wanted, prompt)
    return ((), ramp, False) if ramp is not None and ramp.length <= left else ((), None, True)


def _time_left(plan: Plan, now: RateState) -> float:
    at_goal = now.ramp.time_when(plan.duration - now.ramp_tau)
    return (min(at_goal, now.ramp.length) if now.ramp.goal == 0.0 else at_goal) - now.elapsed


def _joints(plan: Plan, now: RateState) -> list[tuple[Track, tuple[float, float, float], Array]]:
    """Return each track with the state of its path parameter and the limits (3, k) of its joints."""
    rate, rate_slope, _, _ = now.ramp.state(now.elapsed)
    found, first = [], 0
    for track in plan.tracks:
        u, u1, u2 = track.time_law.scalar_state(now.tau)
        own = slice(first, first := first + track.path.dimension)
        limits = np.stack([plan.max_velocity[own], plan.max_acceleration[own], plan.max_jerk[own]])
        found.append((track, (u, u1 * rate, u2 * rate**2 + u1 * rate_slope), limits))
    return found


def _brake(
    track: Track, state: tuple[float, float, float], limits: Array, left: float
) -> tuple[PiecewisePolynomial | None, bool]:
    """Return the soonest brake of a track that keeps the limits, and whether one is sooner than `left`."""
    path, (u, speed, slope) = track.rated, state
    if speed <= 0.0 and slope == 0.0:
        return PiecewisePolynomial(np.zeros(2), np.full((1, 1, 1), u)), left > SOONER
    direction = np.abs(path.state(u, 1)[1])
    turning = direction > 0.0
    acceleration, jerk = (float((limit[turning] / direction[turning]).min()) for limit in limits[1:])
    candidates = {
        (sum(phases), j * jerk, phases)
        for j in SHARES
        for a in SHARES
        if (phases := _phases(speed, slope, a * acceleration, j * jerk)) is not None
    }
    sooner = False
    for seconds, j, phases in sorted(candidates):
        if seconds + SOONER >= left:
            break
        brake = _integrated(state, j, phases)
        if brake.scalar_state(brake.end)[0] <= path.end:
            sooner = True
            if _keeps(path, brake, limits):
                return brake, True
    return None, sooner


def _phases(speed: float, slope: float, acceleration: float, jerk: float) -> tuple[float, float, float] | None:
    acceleration = max(acceleration, -slope)
    peak = math.sqrt(jerk * max(speed, 0.0) + 0.5 * slope * slope)
    if peak < -slope:
        return None
    if peak <= acceleration:
        return (slope + peak) / jerk, 0.0, peak / jerk
    hold = (speed + (0.5 * slope * slope - acceleration * acceleration) / jerk) / acceleration
    return (slope + acceleration) / jerk, hold, acceleration / jerk


def _integrated(
    state: tuple[float, float, float], jerk: float, phases: tuple[float, float, float]
) -> PiecewisePolynomial:
    u, speed, slope = state
    breaks, pieces = [0.0], []
    for time, j in zip(phases, (-jerk, 0.0, jerk), strict=True):
        if time > 1e-12:
            pieces.append([u, speed, slope / 2.0, j / 6.0])
            u += time * (speed + time * (slope / 2.0 + time * j / 6.0))
            speed += time * (slope + time * j / 2.0)
            slope += time * j
            breaks.append(breaks[-1] + time)
    return PiecewisePolynomial(np.array(breaks), np.array(pieces)[:, :, None])


def _keeps(path: PiecewisePolynomial, brake: PiecewisePolynomial, limits: Array) -> bool:
    bounds = limits * (1.0 + np.array([1e-9, SLACK, SLACK]))[:, None]
    track = Track(path, brake)
    few = track.derivatives(np.linspace(0.0, brake.end, 32))[1:]
    begin, end = brake.scalar_state(0.0)[0], brake.scalar_state(brake.end)[0]
    covered = Track(path.between(begin, end), brake) if begin < end else track
    return not np.any(np.abs(few).max(axis=1) > bounds) and bool(np.all(peaks(covered, 480) <= bounds))


def _ramp(
    plan: Plan, columns: int, tau: float, state: tuple[float, float, float], goal: float, prompt: bool
) -> RateRamp | None:
    """Return the shortest ramp that fits; where none does the one least beyond the limits, unless it is `prompt`."""
    least, least_excess = None, np.inf
    for length in np.maximum(plan.braking.stop_time * (LENGTHS[:15] if prompt else LENGTHS), 1e-3).tolist():
        ramp = _quintic(*state, goal, length)
        excess = _excess(plan, columns, tau, ramp, 32)
        if excess <= SLACK and _stays_in_range(ramp):
            excess = _excess(plan, columns, tau, ramp, 480)
            if excess <= SLACK:
                return ramp
        if excess < least_excess:
            least, least_excess = ramp, excess
    return least if least is not None and not prompt and _stays_in_range(least) else None


def _quintic(rate: float, slope: float, curvature: float, goal: float, length: float) -> RateRamp:
    """Return the ramp by the linear system of value and two derivatives at both ends."""
    ends = np.array([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0]])
    ends = np.concatenate([ends, [[1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]]])
    coefficients = np.linalg.solve(ends, [rate, slope * length, curvature * length**2, goal, 0.0, 0.0])
    return RateRamp(goal, length, tuple(coefficients.tolist()))


def _excess(plan: Plan, columns: int, tau: float, ramp: RateRamp, samples: int) -> float:
    """Return by what share the first `columns` exceed a limit most; inf where the rate leaves [0, 1]."""
    times = np.linspace(0.0, 1.0, samples + 1) * ramp.length
    r, r1, r2, gone = (np.array(values)[:, None] for values in zip(*map(ramp.state, times.tolist()), strict=True))
    if np.any(r < -1e-12) or np.any(r > 1.0 + 1e-12):
        return np.inf
    data = plan.braking
    last = len(data.table) - 1
    before = ((tau + gone[:, 0] - data.begin) * ((last - 1) / (plan.duration - data.begin))).astype(np.intp)
    more2, more3 = data.beyond[np.clip(before, 0, last)][:, :, :columns].transpose(1, 0, 2)
    worst = 0.0
    for rows in (before, before + 1):
        s1, s2, s3 = data.table[np.clip(rows, 0, last)][:, :, :columns].transpose(1, 0, 2)
        acceleration = np.abs(s2 * r**2 + s1 * r1) + more2 * r**2
        jerk = np.abs(s3 * r**3 + 3.0 * s2 * r * r1 + s1 * r2) + more3 * r**3 + more2 * np.abs(3.0 * r * r1)
        ratios = (acceleration / data.max_acceleration[:columns], jerk / data.max_jerk[:columns])
        worst = max(worst, *(float(ratio.max()) for ratio in ratios))
    return worst - 1.0


def _stays_in_range(ramp: RateRamp) -> bool:
    if ramp.coefficients[1] == 0.0 and ramp.coefficients[2] == 0.0:
        return True
    polynomial = np.polynomial.Polynomial(ramp.coefficients)
    turns = polynomial.deriv().roots()
    extremes = polynomial(turns.real[(np.abs(turns.imag) < 1e-9) & (turns.real > 0.0) & (turns.real < 1.0)])
    return bool(np.all((extremes >= -1e-12) & (extremes <= 1.0 + 1e-12)))
