"""The sensor model `ideal`: one ray a beam, and what it truly hits."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Readings, TrueHits

from virtualrobot_plugins.sensor_models.beams import AXIS


class Ideal:
    """The true distance of the beam's axis, within the sensor's range; inf elsewhere."""

    def beam(self) -> Floats:
        """Return the axis alone, (1, 3)."""
        return AXIS.copy()

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the true distances; the intensity is reflectance times the cosine of the incidence angle (Lambert)."""
        distance = hits.distance[:, 0]
        valid = (distance >= hits.nearest) & (distance <= hits.farthest)
        intensity = hits.reflectance[:, 0] * np.cos(hits.incidence[:, 0])
        return Readings(np.where(valid, distance, np.inf), np.where(valid, intensity, 0.0), valid)
