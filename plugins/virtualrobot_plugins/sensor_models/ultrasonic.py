"""The sensor model `ultrasonic`: a cone of sound, its first echo that is loud enough, and walls that mirror sound.

At 40 kHz the wave is 8.6 mm long, so that most walls are smooth to it: they send the sound back only where they stand
almost across it (J. J. Leonard and H. F. Durrant-Whyte, Directed Sonar Sensing for Mobile Robot Navigation, 1992,
chapter 2). A wall at a slant reads as far as the place where it stands across, if the cone reaches there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Readings, TrueHits

from virtualrobot_plugins.sensor_models.beams import cone
from virtualrobot_plugins.sensor_models.bursts import absorption, first_echo, pattern, returned, spreading
from virtualrobot_plugins.sensor_models.saying import WithoutEcho, readings


@dataclass(frozen=True, slots=True)
class UltrasonicSettings:
    """Settings of an ultrasonic range finder; the defaults are those of an HC-SR04 in a room."""

    half_angle_radians: Annotated[
        float, Meta(gt=0, le=1.2, description="Between axis and edge of the cone (rad), where echoes are 6 dB weaker.")
    ] = 0.26
    rays: Annotated[int, Meta(ge=1, le=1024, description="How many rays fill the cone.")] = 128
    detection_range_meters: Annotated[
        float, Meta(gt=0, le=1000, description="How far (m) a wide wall across the axis is heard.")
    ] = 4.5
    critical_angle_radians: Annotated[
        float,
        Meta(gt=0, le=math.pi / 2, description="Incidence angle (rad) from which a smooth surface sends nothing back."),
    ] = 0.44
    roughness: Annotated[
        float, Meta(ge=0, le=1, description="Part of the sound that surfaces scatter to all sides.")
    ] = 0.0
    absorption_decibels_per_meter: Annotated[
        float, Meta(ge=0, le=100, description="What the air takes (dB a meter of the way, there and back).")
    ] = 1.3
    burst_meters: Annotated[
        float,
        Meta(gt=0, le=100, description="Half the length of the burst (m): echoes that overlap count together."),
    ] = 0.034
    deviation_meters: Annotated[float, Meta(ge=0, le=100, description="Standard deviation of a distance (m).")] = 0.001
    resolution_meters: Annotated[
        float, Meta(ge=0, le=100, description="Distances are told in steps of this (m); 0: as they are.")
    ] = 0.003
    air_temperature_celsius: Annotated[float, Meta(ge=-100, le=200, description="The temperature of the air.")] = 20.0
    assumed_temperature_celsius: Annotated[
        float, Meta(ge=-100, le=200, description="The temperature whose speed of sound the device counts with.")
    ] = 20.0
    false_echo_rate: Annotated[
        float,
        Meta(ge=0, le=1, description="Part of the readings in which another device's burst is heard, at any time."),
    ] = 0.0
    without_echo: WithoutEcho = "infinite"


class Ultrasonic:
    """An ultrasonic range finder: the first echo in a cone that is loud enough; smooth walls at a slant are lost."""

    def __init__(self, settings: UltrasonicSettings) -> None:
        """Take the settings and hear the wall that is just loud enough."""
        self._settings = settings
        self._beam = cone(settings.rays, settings.half_angle_radians)
        off_axis = np.arccos(np.clip(self._beam[:, 0], -1.0, 1.0))
        self._gain = pattern(off_axis / settings.half_angle_radians)
        wall = settings.detection_range_meters / self._beam[:, 0]
        overlaps = wall <= wall[0] + settings.burst_meters
        self._threshold = float((self._heard(wall, off_axis)[0] * overlaps).sum())
        self._scale = speed_of_sound(settings.assumed_temperature_celsius) / speed_of_sound(
            settings.air_temperature_celsius
        )

    def beam(self) -> Floats:
        """Return the rays of the cone, (rays, 3)."""
        return self._beam.copy()

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the readings: the first echo above the threshold of each cone, in the device's meters."""
        settings = self._settings
        energy, share = self._heard(np.minimum(hits.distance, hits.farthest), hits.incidence)
        distance, strength, heard = first_echo(hits, energy, share, self._threshold, settings.burst_meters)
        distance *= self._scale
        if settings.deviation_meters > 0.0:
            distance += settings.deviation_meters * rng.standard_normal(len(distance))
        if settings.false_echo_rate > 0.0:
            # A stranger's burst is taken for the echo where it comes first.
            stranger = rng.uniform(hits.nearest, hits.farthest, len(distance))
            deceived = (rng.random(len(distance)) < settings.false_echo_rate) & ~(heard & (distance < stranger))
            distance, heard = np.where(deceived, stranger, distance), heard | deceived
        return readings(distance, strength, heard, hits, settings.resolution_meters, settings.without_echo)

    def _heard(self, distance: Floats, incidence: Floats) -> tuple[Floats, Floats]:
        """Return the energy that each ray brings back (n, k), and what it would, had it not spread on the way."""
        settings = self._settings
        share = self._gain * returned(incidence, settings.critical_angle_radians, settings.roughness)
        air = absorption(distance, settings.absorption_decibels_per_meter)
        return share * spreading(distance) * air, share


def speed_of_sound(celsius: float) -> float:
    """Return the speed of sound in air (m/s) at a temperature, linear about 0 degrees."""
    return 331.3 + 0.606 * celsius
