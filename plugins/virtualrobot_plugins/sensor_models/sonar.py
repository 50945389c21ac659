"""The sensor model `sonar`: echo sounders, scanning sonars and the beams of multibeam sonars under water.

A beam is wide or flat; its first echo that is loud enough is told. Surfaces are rough to wavelengths of millimeters and
scatter sound to all sides (Lambert's law: R. J. Urick, Principles of Underwater Sound, chapter 8), so that echoes come
back at a slant, too, and fluctuate: many scatterers at random places make an amplitude after Rayleigh.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Readings, TrueHits

from virtualrobot_plugins.sensor_models import sea_water
from virtualrobot_plugins.sensor_models.beams import spot
from virtualrobot_plugins.sensor_models.bursts import absorption, first_echo, pattern, returned, spreading
from virtualrobot_plugins.sensor_models.saying import WithoutEcho, readings


@dataclass(frozen=True, slots=True)
class SonarSettings:
    """Settings of a sonar under water; the defaults are those of a small echo sounder in the sea."""

    width_radians: Annotated[
        float,
        Meta(gt=0, le=2.4, description="Full angle of the beam along y (rad); echoes at its edge are 6 dB weaker."),
    ] = 0.436
    height_radians: Annotated[float, Meta(gt=0, le=2.4, description="Full angle of the beam along z (rad).")] = 0.436
    rays: Annotated[int, Meta(ge=1, le=1024, description="How many rays fill the beam.")] = 128
    frequency_kilohertz: Annotated[
        float, Meta(gt=0, le=3000, description="Frequency (kHz), by which water absorbs sound.")
    ] = 115.0
    detection_range_meters: Annotated[
        float, Meta(gt=0, le=1e4, description="How far (m) a wide wall across the axis is heard.")
    ] = 100.0
    roughness: Annotated[
        float,
        Meta(ge=0, le=1, description="Part of the sound that surfaces scatter to all sides; the rest they mirror."),
    ] = 1.0
    critical_angle_radians: Annotated[
        float, Meta(gt=0, le=math.pi / 2, description="Incidence angle (rad) from which a mirror sends nothing back.")
    ] = 0.44
    speckle: Annotated[
        bool, Meta(description="Whether echoes of rough surfaces fluctuate, after Rayleigh, each ray's by itself.")
    ] = False
    burst_meters: Annotated[
        float, Meta(gt=0, le=100, description="Half the length of the burst (m): echoes that overlap count together.")
    ] = 0.05
    deviation_meters: Annotated[float, Meta(ge=0, le=100, description="Standard deviation of a distance (m).")] = 0.005
    relative_deviation: Annotated[
        float, Meta(ge=0, le=1, description="Standard deviation as part of the distance, where that is more.")
    ] = 0.0
    resolution_meters: Annotated[
        float, Meta(ge=0, le=100, description="Distances are told in steps of this (m); 0: as they are.")
    ] = 0.01
    water_temperature_celsius: Annotated[float, Meta(ge=-2, le=40, description="Temperature of the water.")] = 10.0
    salinity: Annotated[float, Meta(ge=0, le=45, description="Salt in the water (g/kg); 0: fresh water.")] = 35.0
    depth_meters: Annotated[float, Meta(ge=0, le=1000, description="Depth (m) at which sound is reckoned.")] = 0.0
    assumed_speed_meters_per_second: Annotated[
        float, Meta(ge=1000, le=2000, description="Speed of sound (m/s) that the device counts with.")
    ] = 1500.0
    without_echo: WithoutEcho = "infinite"


class Sonar:
    """A sonar under water: the first echo in a beam that is loud enough, by the time that sound takes."""

    def __init__(self, settings: SonarSettings) -> None:
        """Take the settings and hear the wall that is just loud enough."""
        self._settings = settings
        self._beam = spot(settings.rays, settings.width_radians, settings.height_radians)
        across = np.arctan2(self._beam[:, 1], self._beam[:, 0]) / (0.5 * settings.width_radians)
        up = np.arctan2(self._beam[:, 2], self._beam[:, 0]) / (0.5 * settings.height_radians)
        self._gain = pattern(np.hypot(across, up))
        water = settings.water_temperature_celsius, settings.salinity, settings.depth_meters
        self._absorption = sea_water.absorption(settings.frequency_kilohertz, *water)
        self._scale = settings.assumed_speed_meters_per_second / sea_water.speed_of_sound(*water)
        wall = settings.detection_range_meters / self._beam[:, 0]
        overlaps = wall <= wall[0] + settings.burst_meters
        off_axis = np.arccos(np.clip(self._beam[:, 0], -1.0, 1.0))
        self._threshold = float((self._heard(wall, off_axis)[0] * overlaps).sum())

    def beam(self) -> Floats:
        """Return the rays of the beam, (rays, 3)."""
        return self._beam.copy()

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the readings: the first echo above the threshold of each beam, in the device's meters."""
        settings = self._settings
        energy, share = self._heard(np.minimum(hits.distance, hits.farthest), hits.incidence)
        if settings.speckle:
            # The square of an amplitude after Rayleigh is distributed exponentially.
            energy = energy * rng.standard_exponential(energy.shape)
        distance, strength, heard = first_echo(hits, energy, share, self._threshold, settings.burst_meters)
        distance *= self._scale
        deviation = np.maximum(settings.deviation_meters, settings.relative_deviation * distance)
        if deviation.any():
            distance += deviation * rng.standard_normal(len(distance))
        return readings(distance, strength, heard, hits, settings.resolution_meters, settings.without_echo)

    def _heard(self, distance: Floats, incidence: Floats) -> tuple[Floats, Floats]:
        """Return the energy that each ray brings back (n, k), and what it would, had it not spread on the way."""
        settings = self._settings
        share = self._gain * returned(incidence, settings.critical_angle_radians, settings.roughness)
        return share * spreading(distance) * absorption(distance, self._absorption), share
