"""Which echo a laser's receiver gets of the rays of each beam: surfaces nearer than the pulse blend into one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Booleans, TrueHits

LEAST_DISTANCE = 1e-6
"""Where a surface lies in the aperture, its echo grows no further (m)."""
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
    """(n,) whether there is one."""
    summed_power: Floats | None = None
    """(n,) what `power` returns, where it is not that of one surface alone."""

    def power(self) -> Floats:
        """Return what the receiver gets (n,): the strength over the squared distance, of all surfaces (1/m^2)."""
        if self.summed_power is not None:
            return self.summed_power
        away = np.maximum(self.distance, LEAST_DISTANCE)
        away *= away
        return np.divide(self.strength, away, out=away)


def only_echo(hits: TrueHits) -> Echo:
    """Return the echoes of beams of one ray."""
    true = hits.distance[:, 0]
    found = np.isfinite(true)
    distance = true if found.all() else np.where(found, true, 0.0)
    # In single precision, which is ten times as fast: only noise and intensity come of it.
    cosine = np.cos(hits.incidence[:, 0].astype(np.float32)).astype(np.float64)
    return Echo(distance, cosine, hits.reflectance[:, 0] * cosine, found)


def chosen_echo(hits: TrueHits, pulse: float, threshold: float | None) -> Echo:
    """Return the echo that is told of each beam of k rays, all of which carry equal parts of its power.

    Surfaces in a row, each less than `pulse` (m) behind the one before, are one echo. Of several the strongest is told;
    with a `threshold` of power the first that exceeds it, and the strongest where none does.
    """
    rays = hits.distance.shape[1]
    hit = np.isfinite(hits.distance)
    distance = np.where(hit, hits.distance, 0.0)
    cosine = np.cos(hits.incidence)
    strength = np.where(hit, hits.reflectance * cosine, 0.0) / rays
    spread = 1.0 / np.maximum(distance, LEAST_DISTANCE) ** 2
    weight = np.where(hit, np.maximum(strength, _BLACK), 0.0) * spread
    farthest, nearest = distance.max(axis=1, initial=0.0), np.where(hit, distance, np.inf).min(axis=1, initial=np.inf)
    apart = np.flatnonzero(farthest - nearest > pulse)
    if len(apart):
        power = strength[apart] * spread[apart]
        kept = _told(np.where(hit, distance, np.inf)[apart], weight[apart], power, pulse, threshold)
        weight[apart] *= kept
        strength[apart] *= kept
    total = weight.sum(axis=1)
    found = total > 0.0
    total[~found] = 1.0
    return Echo(
        (weight * distance).sum(axis=1) / total,
        np.where(found, (weight * cosine).sum(axis=1) / total, 1.0),
        strength.sum(axis=1),
        found,
        (strength * spread).sum(axis=1),
    )


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
