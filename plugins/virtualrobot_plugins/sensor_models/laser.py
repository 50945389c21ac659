"""The sensor model `laser`: time-of-flight and phase-shift range finders, single ones and scanners.

Power that comes back from a surface wider than the beam: P ~ reflectance cos(incidence) / r^2 (B. Hofle and N. Pfeifer,
Correction of laser scanning intensity data, ISPRS J. Photogrammetry and Remote Sensing 62, 2007).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.compiled.cache import make_ready
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Booleans, Readings, TrueHits

from virtualrobot_plugins.sensor_models.beams import spot
from virtualrobot_plugins.sensor_models.echoes import chosen_echo, only_echo
from virtualrobot_plugins.sensor_models.laser_readings import NONE, SHOT, THERMAL, told
from virtualrobot_plugins.sensor_models.saying import WithoutEcho, distance_without_echo

_NOISE_LIMITS = {"none": NONE, "shot": SHOT, "thermal": THERMAL}
_SURE = 6.0
"""Spreads off the threshold from which on an echo is found, or lost, for certain (by chance in 1 of 10^9)."""


@dataclass(frozen=True, slots=True)
class LaserSettings:
    """Settings of a laser range finder; the defaults are those of a small 2D scanner."""

    deviation_meters: Annotated[
        float, Meta(ge=0, le=100, description="Least standard deviation of a distance (m), at right angles.")
    ] = 0.01
    relative_deviation: Annotated[
        float, Meta(ge=0, le=1, description="Standard deviation as part of the distance, where that is more.")
    ] = 0.0
    noise_limit: Annotated[
        Literal["none", "shot", "thermal"],
        Meta(
            description="What the noise comes of, which says how it grows with the incidence angle: not at all, of the "
            "light itself (by 1/sqrt(cos)) or of the receiver (by 1/cos)."
        ),
    ] = "shot"
    bias_meters: Annotated[float, Meta(ge=-100, le=100, description="What the device adds to a distance (m).")] = 0.0
    resolution_meters: Annotated[
        float, Meta(ge=0, le=100, description="Distances are told in steps of this (m); 0: as they are.")
    ] = 0.001
    detection_range_meters: Annotated[
        float,
        Meta(
            ge=0,
            le=1e6,
            description="How far (m) a target of detection_reflectance at right angles is found in half of all tries; "
            "0: whatever is within range is found.",
        ),
    ] = 0.0
    detection_reflectance: Annotated[
        float, Meta(gt=0, le=1, description="Reflectance of the target that detection_range_meters is said of.")
    ] = 0.1
    detection_spread: Annotated[
        float, Meta(ge=0, le=1, description="Standard deviation of the echo's power, as part of the threshold.")
    ] = 0.1
    dropout_rate: Annotated[float, Meta(ge=0, le=1, description="Part of the readings that are lost by chance.")] = 0.0
    divergence_radians: Annotated[
        tuple[float, float],
        Meta(description="Full angles of the beam along y and z (rad), below 1; met by as many rays as `rays` says."),
    ] = (0.0, 0.0)
    rays: Annotated[int, Meta(ge=1, le=256, description="How many rays make up a beam; 1: the axis alone.")] = 1
    pulse_meters: Annotated[
        float,
        Meta(
            ge=0,
            le=1e6,
            description="Surfaces under one beam that are nearer to each other (m) give one blended echo.",
        ),
    ] = 0.5
    echo: Annotated[Literal["first", "strongest"], Meta(description="Which of several echoes of a beam is told.")] = (
        "strongest"
    )
    without_echo: WithoutEcho = "infinite"

    def __post_init__(self) -> None:
        """Raise ArgumentError for a divergence that is none, or several rays without one."""
        if not all(0.0 <= angle < 1.0 for angle in self.divergence_radians):
            raise ArgumentError(
                f"divergence_radians is {list(self.divergence_radians)}; both angles must be from 0 to below 1",
                field="divergence_radians",
            )
        if self.rays > 1 and max(self.divergence_radians) == 0.0:
            raise ArgumentError(
                f"rays is {self.rays}, but divergence_radians is [0, 0]: all rays would be one; say the beam's angles",
                field="rays",
            )


class Laser:
    """A laser range finder: noise by distance and slant, lost echoes, steps, and blended distances at edges."""

    def __init__(self, settings: LaserSettings) -> None:
        """Take the settings."""
        make_ready()
        self._settings = settings
        self._beam = spot(settings.rays, *settings.divergence_radians)
        reach = settings.detection_range_meters
        self._threshold = settings.detection_reflectance / reach**2 if reach > 0.0 else 0.0

    def beam(self) -> Floats:
        """Return the rays of the spot, (rays, 3)."""
        return self._beam.copy()

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the readings: one echo a beam, found or lost by its power, with noise, in steps."""
        settings, threshold = self._settings, self._threshold
        if hits.distance.shape[1] == 1:
            echo = only_echo(hits)
        else:
            echo = chosen_echo(hits, settings.pulse_meters, threshold if settings.echo == "first" else None)
        found = echo.found
        if threshold > 0.0:
            found = found & is_detected(echo.power(), threshold, settings.detection_spread, rng)
        if settings.dropout_rate > 0.0:
            found = found & (rng.random(len(found)) >= settings.dropout_rate)
        noisy = settings.deviation_meters > 0.0 or settings.relative_deviation > 0.0
        return Readings(
            *told(
                np.ascontiguousarray(echo.distance),
                *(echo.cosine, echo.strength, found),
                rng.standard_normal(len(found) if noisy else 0, dtype=np.float32),
                *(settings.deviation_meters, settings.relative_deviation),
                _NOISE_LIMITS[settings.noise_limit],
                *(settings.bias_meters, settings.resolution_meters, hits.nearest, hits.farthest),
                distance_without_echo(settings.without_echo, hits),
            )
        )


def is_detected(power: Floats, threshold: float, spread: float, rng: np.random.Generator) -> Booleans:
    """Return whether echoes of this power (n,) exceed the threshold, with noise of `spread` as part of it."""
    detected = power > threshold
    # Only what is near the threshold needs chance.
    unsure = np.flatnonzero(np.abs(power - threshold) < _SURE * spread * threshold)
    over = power[unsure] / threshold - 1.0
    detected[unsure] = over + spread * rng.standard_normal(len(unsure)) > 0.0
    return detected
