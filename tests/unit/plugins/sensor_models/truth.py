"""What the tests of sensor models share: true hits on walls, and bounds for what chance may do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, TrueHits

ALARM = 1e-9
"""How often a bound may be passed by chance; some hundred are looked at in a run."""


def hits(
    distance: ArrayLike,
    incidence: ArrayLike = 0.0,
    reflectance: ArrayLike = 1.0,
    nearest: float = 0.0,
    farthest: float = 1000.0,
) -> TrueHits:
    """Return hits of beams of one ray for distances (n,), of k rays for (n, k); inf hits nothing."""
    away = np.asarray(distance, np.float64)
    away = away[:, None] if away.ndim == 1 else away
    hit = np.isfinite(away)
    angles, parts = (
        np.where(hit, np.broadcast_to(_column(values), away.shape), 0.0) for values in (incidence, reflectance)
    )
    return TrueHits(away, angles, parts, np.where(hit, 0, NO_ELEMENT).astype(np.int32), nearest, farthest)


def _column(values: ArrayLike) -> Floats:
    array = np.asarray(values, np.float64)
    return array[:, None] if array.ndim == 1 else array


def wall(beam: Floats, distance: float, tilt: float = 0.0) -> tuple[Floats, Floats]:
    """Return distance and incidence (k,) of a beam's rays on a wall that the axis meets at `distance` (m).

    `tilt` (rad) is the angle between the axis and the wall's normal, about z. Rays that go away from it hit nothing.
    """
    normal = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    cosine = beam @ normal
    ahead = cosine > 1e-9
    away = np.where(ahead, distance * np.cos(tilt) / np.where(ahead, cosine, 1.0), np.inf)
    return away, np.where(ahead, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)


def beams(rays: Sequence[tuple[Floats, Floats]] | tuple[Floats, Floats], count: int = 1, **others: float) -> TrueHits:
    """Return hits of `count` equal beams, or of one beam for each pair of distances and incidence angles (k,)."""
    pairs = [rays] * count if isinstance(rays, tuple) else list(rays)
    distance, incidence = (np.array([pair[i] for pair in pairs]) for i in (0, 1))
    return hits(distance, incidence, **others)


def assert_normal(samples: Floats, mean: float, deviation: float) -> None:
    """Fail unless independent samples (n,) may be normal with this mean and standard deviation."""
    n = len(samples)
    off = abs(samples.mean() - mean) / (deviation / np.sqrt(n))
    assert off < stats.norm.isf(ALARM / 2), f"the mean of {n} is {samples.mean():.6g}, {off:.1f} errors off {mean:.6g}"
    square = ((samples - mean) ** 2).sum() / deviation**2
    low, high = stats.chi2.ppf([ALARM / 2, 1 - ALARM / 2], n)
    assert low < square < high, f"the deviation of {n} is {samples.std():.6g}; it should be {deviation:.6g}"
    p = stats.kstest((samples - mean) / deviation, "norm").pvalue
    assert p > ALARM, f"{n} samples are not normal (Kolmogorov and Smirnov: p = {p:.2g})"


def assert_part(found: np.ndarray, part: float) -> None:
    """Fail unless so many of the independent trials (n,) may be true by chance when each is with probability `part`."""
    low, high = stats.binom.ppf([ALARM / 2, 1 - ALARM / 2], len(found), part)
    assert low <= found.sum() <= high, f"{found.mean():.4%} of {len(found)}; it should be {part:.4%}"
