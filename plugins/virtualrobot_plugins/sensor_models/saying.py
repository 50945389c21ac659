"""Output stage of the sensor models: quantisation, range, and the value of a beam without a valid reading."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Booleans, Readings, TrueHits

WithoutEcho = Annotated[
    Literal["infinite", "zero", "farthest"],
    Meta(description="What a beam without a valid reading says: inf, 0 or the greatest distance of the sensor."),
]


def readings(
    distance: Floats, strength: Floats, valid: Booleans, hits: TrueHits, resolution: float, without_echo: WithoutEcho
) -> Readings:
    """Return readings of measured distances (n,), told in steps of `resolution` (m; 0: as they are).

    What is told as a distance outside the sensor's range is not valid. `strength` (n,) becomes the intensity, cut to 0
    to 1; it is 0 where there is no valid reading.
    """
    if resolution > 0.0:
        steps = distance * (1.0 / resolution)
        distance = np.multiply(np.rint(steps, out=steps), resolution, out=steps)
    valid = valid & (distance >= hits.nearest) & (distance <= hits.farthest)
    other = distance_without_echo(without_echo, hits)
    intensity = np.where(valid, strength, 0.0)
    return Readings(np.where(valid, distance, other), np.minimum(intensity, 1.0, out=intensity), valid)


def distance_without_echo(without_echo: WithoutEcho, hits: TrueHits) -> float:
    """Return what a beam without a valid reading says (m)."""
    return {"infinite": np.inf, "zero": 0.0, "farthest": hits.farthest}[without_echo]
