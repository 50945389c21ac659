"""First echo of a burst of sound: of all that comes back, the first moment at which it is loud enough."""

from __future__ import annotations

import math

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Booleans, TrueHits

EDGE_DECIBELS = 6.0
"""Loss of an echo at the edge of a beam against one on its axis (dB), there and back."""
LEAST_DISTANCE = 1e-3
"""Lower bound of the distance in the power of an echo (m): nearer surfaces give no more."""


def pattern(part: Floats) -> Floats:
    """Return the gain (k,) of each ray of a beam, 1 in all; `part` (k,) is its angle by that of the edge."""
    gain = 10.0 ** (-EDGE_DECIBELS / 10.0 * part**2)
    return gain / gain.sum()


def spreading(distance: Floats) -> Floats:
    """Return what is left of a ray's energy that a surface has sent back: 1 / r^2 of the way back (1/m^2)."""
    return 1.0 / np.maximum(distance, LEAST_DISTANCE) ** 2


def absorption(distance: Floats, decibels_per_meter: float) -> Floats:
    """Return what the medium leaves of an echo's energy, on the way there and back."""
    return 10.0 ** (-0.2 * decibels_per_meter * distance)


def returned(incidence: Floats, critical: float, roughness: float) -> Floats:
    """Return the part of the sound that a surface sends back at these incidence angles (rad).

    A mirror fades to nothing at the angle `critical` (rad), as cos^2(pi/2 incidence/critical); roughness scatters its
    part to all sides (Lambert).
    """
    part = np.minimum(incidence / critical, 1.0)
    return (1.0 - roughness) * np.cos(0.5 * math.pi * part) ** 2 + roughness * np.cos(incidence)


def first_echo(
    hits: TrueHits, energy: Floats, share: Floats, threshold: float, burst: float
) -> tuple[Floats, Floats, Booleans]:
    """Return where the sound of each beam first exceeds the threshold (n,), its strength, and whether it does.

    The sound of each moment is that of all echoes that began less than a burst ago. Rays that hit nothing in range
    count for nothing.

    Args:
        hits: what the k rays of n beams hit.
        energy: (n, k) what each ray brings back.
        share: (n, k) the same, had it not spread on the way; the strength is its sum within a burst of the reading.
        threshold: energy that is heard.
        burst: half the length of the burst (m).
    """
    beams, rays = hits.distance.shape
    hit = hits.distance <= hits.farthest
    distance = np.where(hit, hits.distance, hits.farthest + 2.0 * burst)
    energy, share = np.where(hit, energy, 0.0), np.where(hit, share, 0.0)
    order = np.argsort(distance, axis=1, kind="stable")
    distance, energy, share = (np.take_along_axis(a, order, axis=1) for a in (distance, energy, share))
    # One search in all rows, which are laid one behind the other.
    row = np.arange(beams)[:, None]
    laid = distance + row * 2.0 * (distance.max(initial=0.0) + burst)
    first = np.searchsorted(laid.ravel(), (laid - burst).ravel()).reshape(beams, rays) - row * rays
    loud = _sums_from(energy, first) >= threshold * (1.0 - 1e-9)
    at = loud.argmax(axis=1)[:, None]
    heard = np.asarray(loud.any(axis=1))
    told = np.where(heard, np.take_along_axis(distance, at, axis=1)[:, 0], 0.0)
    return told, (share * (np.abs(distance - told[:, None]) <= burst)).sum(axis=1), heard


def _sums_from(values: Floats, first: np.ndarray) -> Floats:
    """Return for each place of a row (n, k) the sum of the values from the place `first` (n, k) of it up to itself."""
    sums = np.concatenate([np.zeros((len(values), 1)), np.cumsum(values, axis=1)], axis=1)
    return sums[:, 1:] - np.take_along_axis(sums, first, axis=1)
