"""Tracking of a frame that one joint of another robot moves: which arms do, how far, how they begin and end.

Where the frame is, is told by the joint's displacement since the motion was planned, in rad or m. An arm catches up
with it by letting the difference go to zero along a quintic, so that from then on it is where the frame is, exactly;
and leaves it by a law of its own, whatever the frame does meanwhile.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import SerialChain

from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.numeric.tracking import follow_frame, weighted_jacobians

OVERSHOOT = 1.75
"""Greatest speed of an arm that catches up, as a multiple of the frame's; a quintic from rest needs 1.512."""

#: Lengths of a catch-up that are tried: 10 ms to 2 min, each a tenth longer than the one before.
_LENGTHS = 0.01 * 1.1 ** np.arange(100.0)
_SHARES = np.linspace(0.0, 1.0, 161)
#: Factor of a second derivative's greatest value: by so much a function may exceed the greatest of its samples.
_BETWEEN = _SHARES[1] ** 2 / 8.0
#: The first derivatives of x^0 ... x^5 at the shares: (6, 161).
_FIRST = np.array([np.polynomial.Polynomial.basis(i).deriv()(_SHARES) for i in range(6)])


@dataclass(frozen=True, eq=False)
class TrackingArm:
    """Arm of k joints that tracks a frame, and the frame's motion seen from its base.

    columns (k,): where its joints are among the motion's. chain: with the tool centre point as its tip; weight (1/m)
    makes linear errors comparable with angular ones. The frame turns (frame_type REVOLUTE) about frame_axis (3,), a
    unit vector, through frame_point (3,) in m, or shifts along it (PRISMATIC), by `ratio` times the joint's
    displacement.
    """

    columns: NDArray[np.intp]
    chain: SerialChain
    weight: float
    frame_type: int
    frame_axis: Array
    frame_point: Array
    ratio: float

    def postures(self, nominal: Array, displacement: Array, near: Array) -> tuple[Array, Array]:
        """Return the postures (m, k) for nominal ones (m, k) at the joint's displacements (m,), and their errors (m,).

        They are those of `follow_frame` that Newton's method finds from `near` (m, k).
        """
        q, error = np.array(near, dtype=np.float64, order="C"), np.empty(len(nominal))
        follow_frame(
            *self.chain[:6],
            self.chain.post[None],
            self.weight,
            self.frame_type,
            self.frame_axis,
            self.frame_point,
            np.ascontiguousarray(nominal),
            self.ratio * displacement,
            q,
            error,
        )
        return q, error

    def jacobians(self, q: Array) -> Array:
        """Return the Jacobians (m, 6, k) of the tool centre point at q (m, k), linear rows times the weight."""
        jacobians = np.empty((len(q), 6, q.shape[1]))
        weighted_jacobians(*self.chain[:6], self.chain.post[None], self.weight, np.ascontiguousarray(q), jacobians)
        return jacobians


@dataclass(frozen=True, eq=False)
class ConveyorTracking:
    """Frame that arms go along with, and what was checked for them when it was planned.

    start: the joint's coordinate when it was planned (rad or m); low, high: between which displacements from there it
    is followed, one of them 0. max_velocity, max_acceleration: those of the joint that the arms keep up with.
    own_acceleration, own_jerk: what catching up and leaving may add, per s² and s³ of the joint.
    """

    arms: tuple[TrackingArm, ...]
    start: float
    low: float
    high: float
    max_velocity: float
    max_acceleration: float
    own_acceleration: float
    own_jerk: float


@dataclass(frozen=True, slots=True)
class CatchUp:
    """Law of the difference between frame and arm on its way to zero: a quintic of x = t / length on [0, length] s."""

    length: float
    coefficients: tuple[float, ...]

    def state(self, t: float) -> tuple[float, float, float]:
        """Return the difference and its first two derivatives by time after `t` s; zeros from `length` on."""
        if t >= self.length:
            return 0.0, 0.0, 0.0
        x = t / self.length
        c0, c1, c2, c3, c4, c5 = self.coefficients
        value = c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
        first = (c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / self.length
        second = (2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))) / self.length**2
        return value, first, second


def catch_up(tracking: ConveyorTracking, gap: float, speed: float, slope: float) -> CatchUp:
    """Return the shortest of a list of quintics to zero from a difference with its derivatives that keeps the limits.

    The limits: the difference's acceleration and jerk are the tracking's own, its speed what `OVERSHOOT` leaves. Where
    none keeps them all, as from an acceleration beyond them, it is the one that exceeds them least.
    """
    if not (gap or speed or slope):
        return CatchUp(0.0, (0.0,) * 6)
    coefficients = np.array([_to_zero(gap, speed * length, slope * length**2) for length in _LENGTHS])
    second, third = _greatest(coefficients)
    away = (-(coefficients @ _FIRST) * np.sign(speed or gap)).max(axis=1) + _BETWEEN * third
    excess = np.maximum(
        away / _LENGTHS / ((OVERSHOOT - 1.0) * tracking.max_velocity), third / _LENGTHS**3 / tracking.own_jerk
    )
    excess = np.maximum(excess, second / _LENGTHS**2 / max(tracking.own_acceleration, abs(slope)))
    keeps = excess <= 1.0 + 1e-12
    place = int(np.argmax(keeps) if keeps.any() else np.argmin(excess))
    return CatchUp(float(_LENGTHS[place]), tuple(coefficients[place].tolist()))


@dataclass(frozen=True, slots=True)
class Leave:
    """Law of an arm that comes to rest on its own: its speed is a cubic of x = t / length, 0 from `length` s on.

    place, speed, slope: where it is at t = 0, and the derivatives by time.
    """

    place: float
    speed: float
    slope: float
    length: float

    def state(self, t: float) -> tuple[float, float, float]:
        """Return place, speed and acceleration after `t` s."""
        x = min(t / self.length, 1.0)
        rest, growth = 1.0 - x, 2.0 * self.speed + self.slope * self.length
        gone = self.speed * (1.0 - rest**3) / 3.0 + growth * x * x * (0.5 - x * (2.0 / 3.0 - 0.25 * x))
        speed = rest * rest * (self.speed + growth * x)
        slope = (rest * rest * growth - 2.0 * rest * (self.speed + growth * x)) / self.length
        return self.place + self.length * gone, speed, slope

    @property
    def end(self) -> float:
        """Place at which it comes to rest, in the unit of `place`."""
        return self.place + self.length * (self.speed / 2.0 + self.slope * self.length / 12.0)


def leave(tracking: ConveyorTracking, place: float, speed: float, slope: float) -> Leave:
    """Return the law that comes to rest from a place with its derivatives as soon as the tracking's own limits allow.

    The cubic's jerk is at most 6 v/T² + 4 a/T, its acceleration on the way 3/2 v/T and a third of the one at first.
    """
    speed_size, slope_size, jerk = abs(speed), abs(slope), tracking.own_jerk
    by_jerk = (2.0 * slope_size + math.sqrt(4.0 * slope_size**2 + 6.0 * jerk * speed_size)) / jerk
    length = max(1.5 * speed_size / tracking.own_acceleration, by_jerk, float(_LENGTHS[0]))
    return Leave(place, speed, slope, length)


def _to_zero(value: float, first: float, second: float) -> tuple[float, ...]:
    return (
        value,
        first,
        0.5 * second,
        -10.0 * value - 6.0 * first - 1.5 * second,
        15.0 * value + 8.0 * first + 1.5 * second,
        -6.0 * value - 3.0 * first - 0.5 * second,
    )


def _greatest(coefficients: Array) -> tuple[Array, Array]:
    """Return the greatest second and third derivatives (m,) in [0, 1] of quintics (m, 6), at an end or an extremum."""
    _, _, c2, c3, c4, c5 = coefficients.T[:, :, None]
    with np.errstate(all="ignore"):
        vertex = -c4 / (5.0 * c5)
        apart = np.sqrt(np.maximum(vertex**2 - c3 / (10.0 * c5), 0.0))
    x = np.hstack((np.zeros_like(c2), np.ones_like(c2), vertex, vertex - apart, vertex + apart))
    x = np.clip(np.nan_to_num(x), 0.0, 1.0)
    second = 2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))
    third = 6.0 * c3 + x * (24.0 * c4 + x * 60.0 * c5)
    return np.abs(second).max(axis=1), np.abs(third).max(axis=1)
