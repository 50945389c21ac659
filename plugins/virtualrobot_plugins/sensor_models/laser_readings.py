"""Readings of a laser range finder from its echoes, in one compiled pass: noise, bias, steps and range."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import boolean, float32, float64, int64
from virtualrobot_sdk.compiled.cache import array_of, compiled
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Booleans, Singles

NONE, SHOT, THERMAL = range(3)
"""Origins of noise that grows with the incidence angle: none, the light itself, the receiver."""

LEAST_COSINE = 0.01
"""Least cosine of the incidence angle in the noise: where the beam grazes a surface, the noise grows no further."""


@compiled(
    *(array_of(float64, 1), array_of(float64, 1), array_of(float64, 1), array_of(boolean, 1), array_of(float32, 1)),
    *(float64, float64, int64, float64, float64, float64, float64, float64),
    exact=True,
)
def told(
    distance: Floats,
    cosine: Floats,
    strength: Floats,
    found: Booleans,
    chance: Singles,
    deviation: float,
    relative: float,
    limit: int,
    bias: float,
    resolution: float,
    nearest: float,
    farthest: float,
    otherwise: float,
) -> tuple[Any, Any, Any]:
    """Return distances, intensities and which of them are valid, (n,) each.

    The standard deviation of the noise is that of a surface at right angles over the ratio of signal to noise. That
    ratio goes with the root of the power where the light's own shot noise prevails, with the power where the receiver's
    thermal noise does.

    Args:
        distance: (n,) m, of the echoes; anything finite where there is none.
        cosine: (n,) of the incidence angles.
        strength: (n,) of the echoes: the intensity, which is cut to 1.
        found: (n,) whether there is an echo.
        chance: (n,) standard normal numbers; none where there is no noise.
        deviation: least standard deviation of a distance (m), at right angles.
        relative: standard deviation as part of the distance, where that is more.
        limit: what the noise comes of: NONE, SHOT or THERMAL.
        bias: added to distances (m).
        resolution: the step (m) in which they are told; 0: as they are.
        nearest: the least distance that is valid (m).
        farthest: the greatest one (m).
        otherwise: the distance that is told where none is valid.
    """
    count = distance.shape[0]
    said, intensity, valid = np.empty(count), np.empty(count), np.empty(count, np.bool_)
    per_step = 1.0 / resolution if resolution > 0.0 else 0.0
    # Loops of few arrays each: the compiler takes several beams at once.
    if chance.shape[0] > 0:
        for i in range(count):
            spread = max(relative * distance[i], deviation)
            slant = max(cosine[i], LEAST_COSINE)
            slowly = math.sqrt(slant)
            spread /= slowly if limit == SHOT else slant if limit == THERMAL else 1.0
            said[i] = distance[i] + spread * chance[i]
    else:
        for i in range(count):
            said[i] = distance[i]
    if bias != 0.0:
        for i in range(count):
            said[i] += bias
    if resolution > 0.0:
        for i in range(count):
            said[i] = np.rint(said[i] * per_step) * resolution
    for i in range(count):
        valid[i] = found[i] & (said[i] >= nearest) & (said[i] <= farthest)
    for i in range(count):
        said[i] = said[i] if valid[i] else otherwise
    for i in range(count):
        intensity[i] = min(strength[i], 1.0) if valid[i] else 0.0
    return said, intensity, valid


@compiled(array_of(float64, 1), array_of(float64, 1), array_of(float64, 1), exact=True)
def alone(distance: Floats, incidence: Floats, reflectance: Floats) -> tuple[Any, Any, Any, Any]:
    """Return the echoes of beams of one ray: distance, cosine, strength and whether there is one, (n,) as `Echo` has.

    The cosine is by the polynomial 4.3.99 of M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 1964: to
    3e-9.

    Args:
        distance: (n,) m, of what rays hit; inf where there is nothing.
        incidence: (n,) rad.
        reflectance: (n,).
    """
    count = distance.shape[0]
    away, cosine, strength = np.empty(count), np.empty(count), np.empty(count)
    found = np.empty(count, np.bool_)
    for i in range(count):
        found[i] = distance[i] < np.inf
    for i in range(count):
        away[i] = distance[i] if distance[i] < np.inf else 0.0
    for i in range(count):
        square = incidence[i] * incidence[i]
        p = -0.0000002605 * square + 0.0000247609
        p = p * square - 0.0013888397
        p = p * square + 0.0416666418
        p = p * square - 0.4999999963
        cosine[i] = p * square + 1.0
    for i in range(count):
        strength[i] = reflectance[i] * cosine[i]
    return away, cosine, strength, found
