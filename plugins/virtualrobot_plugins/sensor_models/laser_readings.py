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
    noisy = chance.shape[0] > 0
    per_step = 1.0 / resolution if resolution > 0.0 else 0.0
    for i in range(count):
        away = distance[i]
        if noisy:
            spread = max(relative * away, deviation)
            slant = max(cosine[i], LEAST_COSINE)
            if limit == SHOT:
                spread /= math.sqrt(slant)
            elif limit == THERMAL:
                spread /= slant
            away = away + spread * chance[i]
        if bias != 0.0:
            away = away + bias
        if resolution > 0.0:
            away = np.rint(away * per_step) * resolution
        trusted = found[i] & (away >= nearest) & (away <= farthest)
        said[i] = away if trusted else otherwise
        intensity[i] = min(strength[i], 1.0) if trusted else 0.0
        valid[i] = trusted
    return said, intensity, valid
