"""Echo in a laser's receiver of the rays of each beam: surfaces closer together than the pulse blend into one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Booleans, TrueHits

from virtualrobot_plugins.sensor_models.laser_readings import alone

LEAST_DISTANCE = 1e-6
"""Lower bound of the distance in the power of an echo (m): a surface nearer than this gives no more."""
_BLACK = 1e-9
"""Reflectance that counts for a surface of none, so that black surfaces alone have a mean distance too."""


@dataclass(frozen=True, slots=True, eq=False)
class Echo:
    """One echo for each of n beams; what no ray of a beam hits has none."""

    distance: Floats
    """(n,) mean of the surfaces by their power (m); 0 without an echo."""
    cosine: Floats
    """(n,) of the incidence angle, their mean by power; 1 without an echo."""
    strength: Floats
    """(n,) reflectance times cosine, as mean over the beam: what misses or belongs to another echo counts as 0."""
    found: Booleans
    """(n,) true where there is an echo."""
    summed_power: Floats | None = None
    """(n,) power of the echo (1/m^2), as `power` returns it; None where each echo is that of one surface alone."""

    def power(self) -> Floats:
        """Return what the receiver gets (n,): the strength over the squared distance, of all surfaces (1/m^2)."""
        if self.summed_power is not None:
            return self.summed_power
        away = np.maximum(self.distance, LEAST_DISTANCE)
        away *= away
        return np.divide(self.strength, away, out=away)


def only_echo(hits: TrueHits) -> Echo:
    """Return the echoes of beams of one ray."""
    return Echo(
        *alone(*(np.ascontiguousarray(values[:, 0]) for values in (hits.distance, hits.incidence, hits.reflectance)))
    )


def chosen_echo(hits: TrueHits, pulse: float, threshold: float | None) -> Echo:
    """Return the echo that is told of each beam of k rays, all of which carry equal parts of its power.

    Surfaces in a row, each less than `pulse` (m) behind the one before, are one echo. Of several the strongest is told;
    with a `threshold` of power the first that exceeds it, and the strongest where none does.
    """
    # One row for each ray of all beams: sums along the first axis are those of whole rows, which is fast.
    away, reflectance = np.ascontiguousarray(hits.distance.T), np.ascontiguousarray(hits.reflectance.T)
    rays = len(away)
    hit = np.isfinite(away)
    distance = np.where(hit, away, 0.0)
    cosine = _cosine(np.ascontiguousarray(hits.incidence.T))
    strength = reflectance * cosine
    strength /= rays
    spread = np.maximum(distance, LEAST_DISTANCE)
    np.divide(1.0, np.multiply(spread, spread, out=spread), out=spread)
    power = strength * spread
    weight = np.maximum(strength, _BLACK)
    weight *= spread
    weight *= hit
    nearest, farthest = away.min(axis=0, initial=np.inf), distance.max(axis=0, initial=0.0)
    apart = np.flatnonzero(farthest - nearest > pulse)
    if len(apart):
        kept = _told(away[:, apart].T, weight[:, apart].T, power[:, apart].T, pulse, threshold).T
        for values in (weight, strength, power):
            values[:, apart] *= kept
    total = weight.sum(axis=0)
    found = total > 0.0
    weight /= np.where(found, total, 1.0)
    return Echo(
        np.multiply(weight, distance, out=distance).sum(axis=0),
        np.where(found, np.multiply(weight, cosine, out=cosine).sum(axis=0), 1.0),
        strength.sum(axis=0),
        found,
        power.sum(axis=0),
    )


def _cosine(incidence: Floats) -> Floats:
    """Return cosines in single precision, which is ten times as fast: only noise and intensity come of them."""
    return np.cos(incidence.astype(np.float32)).astype(np.float64)


def _told(distance: Floats, weight: Floats, power: Floats, pulse: float, threshold: float | None) -> Booleans:
    """Return which rays belong to the echo that is told, (m, k), of beams whose surfaces are apart."""
    beams, rays = distance.shape
    order = np.argsort(distance, axis=1, kind="stable")
    along = np.take_along_axis(distance, order, axis=1)
    # Rays that hit nothing come last and carry nothing; they may go with the last echo.
    along = np.where(np.isfinite(along), along, along[:, :1])
    number = np.zeros((beams, rays), np.intp)
    np.cumsum(np.diff(along, axis=1) > pulse, axis=1, out=number[:, 1:])
    place = number + rays * np.arange(beams)[:, None]

    def summed(values: Floats) -> Floats:
        values = np.take_along_axis(values, order, axis=1)
        return np.asarray(np.bincount(place.ravel(), values.ravel(), beams * rays), np.float64).reshape(beams, rays)

    told = summed(weight).argmax(axis=1)
    if threshold is not None:
        exceeds = (summed(power) >= threshold) & (summed(weight) > 0.0)
        told = np.where(exceeds.any(axis=1), exceeds.argmax(axis=1), told)
    kept = np.zeros((beams, rays), np.bool_)
    np.put_along_axis(kept, order, number == told[:, None], axis=1)
    return kept
