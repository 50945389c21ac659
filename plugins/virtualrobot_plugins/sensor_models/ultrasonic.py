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
from virtualrobot_sdk.rays import Booleans, Readings, TrueHits

from virtualrobot_plugins.sensor_models.beams import cone
from virtualrobot_plugins.sensor_models.saying import WithoutEcho, readings

EDGE_DECIBELS = 6.0
"""Loss of an echo at the edge of the cone against one on its axis (dB)."""
LEAST_DISTANCE = 1e-3
"""Lower bound of the distance in the power of an echo (m): nearer surfaces give no more."""


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
        gain = 10.0 ** (-EDGE_DECIBELS / 10.0 * (off_axis / settings.half_angle_radians) ** 2)
        self._gain = gain / gain.sum()
        wall = settings.detection_range_meters / self._beam[:, 0]
        overlaps = wall <= wall[0] + settings.burst_meters
        self._threshold = float((self._energy(wall, off_axis) * overlaps).sum())
        self._scale = speed_of_sound(settings.assumed_temperature_celsius) / speed_of_sound(
            settings.air_temperature_celsius
        )

    def beam(self) -> Floats:
        """Return the rays of the cone, (rays, 3)."""
        return self._beam.copy()

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the readings: the first echo above the threshold of each cone, in the device's meters."""
        settings = self._settings
        distance, strength, heard = self._first_echo(hits)
        distance *= self._scale
        if settings.deviation_meters > 0.0:
            distance += settings.deviation_meters * rng.standard_normal(len(distance))
        if settings.false_echo_rate > 0.0:
            # A stranger's burst is taken for the echo where it comes first.
            stranger = rng.uniform(hits.nearest, hits.farthest, len(distance))
            deceived = (rng.random(len(distance)) < settings.false_echo_rate) & ~(heard & (distance < stranger))
            distance, heard = np.where(deceived, stranger, distance), heard | deceived
        return readings(distance, strength, heard, hits, settings.resolution_meters, settings.without_echo)

    def _energy(self, distance: Floats, incidence: Floats) -> Floats:
        """Return what each ray brings back (..., k): its part of the cone, the mirror, the spreading and the air."""
        settings = self._settings
        air = 10.0 ** (-0.2 * settings.absorption_decibels_per_meter * distance)
        spreading = 1.0 / np.maximum(distance, LEAST_DISTANCE) ** 2
        return self._gain * returned(incidence, settings) * spreading * air

    def _first_echo(self, hits: TrueHits) -> tuple[Floats, Floats, Booleans]:
        """Return where the sound of each cone first exceeds the threshold (n,), its strength, and whether it does.

        The strength is the part of the cone that comes back within a burst of there, had it not spread on the way.
        """
        burst, (beams, rays) = self._settings.burst_meters, hits.distance.shape
        hit = hits.distance <= hits.farthest
        beyond = hits.farthest + 2.0 * burst
        distance = np.where(hit, hits.distance, beyond)
        energy = np.where(hit, self._energy(distance, hits.incidence), 0.0)
        share = np.where(hit, self._gain * returned(hits.incidence, self._settings), 0.0)
        order = np.argsort(distance, axis=1, kind="stable")
        distance, energy, share = (np.take_along_axis(a, order, axis=1) for a in (distance, energy, share))
        # The sound of each moment is that of all echoes that began less than a burst ago: one search in all rows,
        # which are laid one behind the other.
        row = np.arange(beams)[:, None]
        laid = distance + row * 2.0 * (distance.max(initial=0.0) + burst)
        first = np.searchsorted(laid.ravel(), (laid - burst).ravel()).reshape(beams, rays) - row * rays
        loud = _sums_from(energy, first) >= self._threshold * (1.0 - 1e-9)
        at = loud.argmax(axis=1)[:, None]
        heard = np.asarray(loud.any(axis=1))
        told = np.where(heard, np.take_along_axis(distance, at, axis=1)[:, 0], 0.0)
        return told, (share * (np.abs(distance - told[:, None]) <= burst)).sum(axis=1), heard


def returned(incidence: Floats, settings: UltrasonicSettings) -> Floats:
    """Return the part of the sound that a surface sends back at these incidence angles (rad).

    A mirror fades to nothing at the critical angle, as cos^2(pi/2 incidence/critical); roughness scatters its part.
    """
    part = np.minimum(incidence / settings.critical_angle_radians, 1.0)
    mirrored = (1.0 - settings.roughness) * np.cos(0.5 * math.pi * part) ** 2
    return mirrored + settings.roughness * np.cos(incidence)


def speed_of_sound(celsius: float) -> float:
    """Return the speed of sound in air (m/s) at a temperature, linear about 0 degrees."""
    return 331.3 + 0.606 * celsius


def _sums_from(values: Floats, first: np.ndarray) -> Floats:
    """Return for each place of a row (n, k) the sum of the values from the place `first` (n, k) of it up to itself."""
    sums = np.concatenate([np.zeros((len(values), 1)), np.cumsum(values, axis=1)], axis=1)
    return sums[:, 1:] - np.take_along_axis(sums, first, axis=1)
