"""Quintic ramps of the rate of a running motion, chosen so that the joints keep their limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.polynomial import Array

#: Share of a limit by which a ramp may exceed it, in the samples that it is checked at.
SLACK = 0.005
#: Lengths that are tried, in units of the plan's stop time: 0.11 to 5.2, each 1.2 times the one before; the first
#: ones, up to 1.44, stop about as fast as is possible from top speed.
_LENGTHS = 1.2 ** np.arange(-12.0, 10.0)
_PROMPT = 15
_SHORTEST = 1e-3
_TOGETHER = 8
_ROUNDING = 1e-12
_COARSE, _FINE = 32, 480


@dataclass(frozen=True, slots=True)
class RateRamp:
    """Rate dtau/dt as a quintic of x = t / length on [0, length] s, then constantly `goal`.

    coefficients: of x^0 ... x^5, in the unit of the rate (1). A ramp of length 0 is the constant rate `goal`.
    """

    goal: float
    length: float = 0.0
    coefficients: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def state(self, t: float) -> tuple[float, float, float, float]:
        """Return rate, its first and second derivative (1/s, 1/s²), and the nominal time gone by since t = 0 (s)."""
        if t >= self.length:
            c0, c1, c2, c3, c4, c5 = self.coefficients
            gone = self.length * (c0 + c1 / 2.0 + c2 / 3.0 + c3 / 4.0 + c4 / 5.0 + c5 / 6.0)
            return self.goal, 0.0, 0.0, gone + self.goal * (t - self.length)
        x = t / self.length
        c0, c1, c2, c3, c4, c5 = self.coefficients
        rate = c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
        slope = (c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / self.length
        curvature = (2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))) / self.length**2
        gone = t * (c0 + x * (c1 / 2.0 + x * (c2 / 3.0 + x * (c3 / 4.0 + x * (c4 / 5.0 + x * c5 / 6.0)))))
        return rate, slope, curvature, gone

    def time_when(self, gone: float) -> float:
        """Return the time (s) at which the nominal time `gone` (s) has gone by; inf when the rate falls to 0 before."""
        at_end = self.state(self.length)[3]
        if at_end < gone:
            return self.length + (gone - at_end) / self.goal if self.goal > 0.0 else math.inf
        low, high = 0.0, self.length
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.state(middle)[3] < gone else (low, middle)
        return high


@dataclass(frozen=True, slots=True)
class RampChoice:
    """Choice of a ramp: the shortest that fits, or the one least beyond the limits; None when none stays in [0, 1]."""

    ramp: RateRamp | None
    fits: bool


def quintic_ramp(rate: float, slope: float, curvature: float, goal: float, length: float) -> RateRamp:
    """Return the ramp from a rate with its derivatives to `goal` with zero derivatives, twice differentiable."""
    return RateRamp(goal, length, _coefficients(rate, slope, curvature, goal, length))


def choose_ramp(
    plan: Plan, tau: float, rate: float, slope: float, curvature: float, goal: float, *, prompt: bool, joints_only: bool
) -> RampChoice:
    """Return the shortest of a fixed list of ramps to `goal` on which the joints keep the plan's limits.

    `prompt` leaves out the ramps that are much longer than a stop from top speed; `joints_only` lets the acceleration
    of a line or an arc exceed its own limits as far as the joints can follow. A ramp is tried from nominal time
    `tau` (s) at the given rate with its derivatives (1/s, 1/s²). With s(tau) the joints at nominal time and r the
    rate, it is checked that acceleration s'' r² + s' r' and jerk s''' r³ + 3 s'' r r' + s' r'' keep their limits.
    """
    lengths = np.maximum(plan.braking.stop_time * (_LENGTHS[:_PROMPT] if prompt else _LENGTHS), _SHORTEST)
    columns = plan.q_count if joints_only else plan.braking.table.shape[2]
    least, least_excess = None, np.inf
    for first in range(0, len(lengths), _TOGETHER):
        batch = lengths[first : first + _TOGETHER]
        excess = _excess(plan, columns, tau, rate, slope, curvature, goal, batch, _COARSE)
        for length, value in zip(batch, excess, strict=True):
            ramp = quintic_ramp(rate, slope, curvature, goal, float(length))
            if value <= SLACK and _stays_in_range(ramp):
                value = _excess(plan, columns, tau, rate, slope, curvature, goal, np.array([length]), _FINE)[0]
                if value <= SLACK:
                    return RampChoice(ramp, True)
            if value < least_excess:
                least, least_excess = ramp, value
    return RampChoice(least if least is not None and _stays_in_range(least) else None, False)


def _coefficients(
    rate: float, slope: float, curvature: float, goal: float, length: float
) -> tuple[float, float, float, float, float, float]:
    rise, c1, c2 = goal - rate, slope * length, curvature * length * length
    return (
        rate,
        c1,
        0.5 * c2,
        10.0 * rise - 6.0 * c1 - 1.5 * c2,
        -15.0 * rise + 8.0 * c1 + 1.5 * c2,
        6.0 * rise - 3.0 * c1 - 0.5 * c2,
    )


def _excess(
    plan: Plan,
    columns: int,
    tau: float,
    rate: float,
    slope: float,
    curvature: float,
    goal: float,
    lengths: Array,
    samples: int,
) -> Array:
    """Return by what share each ramp exceeds the first `columns` limits most (m,), inf where its rate leaves [0, 1]."""
    x = np.linspace(0.0, 1.0, samples + 1)
    coefficients = np.array([_coefficients(rate, slope, curvature, goal, float(length)) for length in lengths])
    powers = x ** np.arange(6)[:, None]
    degree = np.arange(6.0)
    rates = coefficients @ powers
    slopes = (coefficients[:, 1:] * degree[1:]) @ powers[:5] / lengths[:, None]
    curvatures = (coefficients[:, 2:] * (degree * (degree - 1.0))[2:]) @ powers[:4] / lengths[:, None] ** 2
    taus = tau + (coefficients / (degree + 1.0)) @ (powers * x) * lengths[:, None]
    braking = plan.braking
    last = len(braking.table) - 1
    max_acceleration, max_jerk = braking.max_acceleration[:columns], braking.max_jerk[:columns]
    r, r1, r2 = (values.reshape(-1, 1) for values in (rates, slopes, curvatures))
    before = ((taus - braking.begin) * ((last - 1) / (plan.duration - braking.begin))).astype(np.intp).ravel()
    worst = np.zeros(len(lengths))
    # Both rows beside each time and what is beyond them in between, since acceleration and jerk may jump there; past
    # the end of the plan the joints stand still, which is the last row. Velocity needs no check: a rate of at most 1
    # never exceeds the plan's own.
    peak2, peak3 = braking.beyond[:, :, :columns].take(np.clip(before, 0, last), axis=0).transpose(1, 0, 2)
    more_acceleration, more_jerk = peak2 * r**2, peak3 * r**3 + peak2 * np.abs(3.0 * r * r1)
    for rows in (before, before + 1):
        s1, s2, s3 = braking.table[:, :, :columns].take(np.clip(rows, 0, last), axis=0).transpose(1, 0, 2)
        ratio = (np.abs(s2 * r**2 + s1 * r1) + more_acceleration) / max_acceleration
        jerk = np.abs(s3 * r**3 + s2 * (3.0 * r * r1) + s1 * r2) + more_jerk
        np.maximum(ratio, jerk / max_jerk, out=ratio)
        np.maximum(worst, ratio.reshape(len(lengths), -1).max(axis=1), out=worst)
    worst -= 1.0
    outside = (rates < -_ROUNDING).any(axis=1) | (rates > 1.0 + _ROUNDING).any(axis=1)
    return np.where(outside, np.inf, worst)


def _stays_in_range(ramp: RateRamp) -> bool:
    """Return True if the rate stays in [0, 1], also between samples: a ramp that reverses another one may overshoot."""
    if ramp.coefficients[1] == 0.0 and ramp.coefficients[2] == 0.0:
        return True  # from a constant rate it is monotone
    polynomial = np.polynomial.Polynomial(ramp.coefficients)
    turns = polynomial.deriv().roots()
    extremes = polynomial(turns.real[(np.abs(turns.imag) < 1e-9) & (turns.real > 0.0) & (turns.real < 1.0)])
    return bool(np.all((extremes >= -_ROUNDING) & (extremes <= 1.0 + _ROUNDING)))
