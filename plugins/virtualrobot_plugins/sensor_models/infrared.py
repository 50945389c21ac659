"""The sensor model `infrared`: triangulation by a light spot on a position-sensitive detector, told as a voltage.

The spot moves as 1/(d + k), so that the voltage does (Sharp, Application note on distance measuring sensors, with
d + 0.42 cm for the GP2Y0A21YK); noise and steps of the converter are in volts, so that the error grows as (d + k)^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import Readings, TrueHits

from virtualrobot_plugins.sensor_models.beams import AXIS
from virtualrobot_plugins.sensor_models.saying import WithoutEcho, readings


@dataclass(frozen=True, slots=True)
class InfraredSettings:
    """Settings of a triangulating sensor; the defaults are those of Sharp's GP2Y0A21YK0F on a 10 bit converter."""

    near_meters: Annotated[float, Meta(gt=0, le=100, description="A distance (m) whose voltage is known ...")] = 0.10
    near_volts: Annotated[float, Meta(gt=0, le=100, description="... and its voltage.")] = 2.3
    far_meters: Annotated[float, Meta(gt=0, le=100, description="A greater distance (m) ...")] = 0.80
    far_volts: Annotated[float, Meta(gt=0, le=100, description="... and its lower voltage.")] = 0.4
    offset_meters: Annotated[
        float, Meta(ge=0, le=10, description="The k of V = a / (d + k) + b (m), which straightens the curve.")
    ] = 0.0042
    peak_meters: Annotated[
        float,
        Meta(ge=0, le=100, description="Distance (m) of the greatest voltage; nearer, it falls in line with it."),
    ] = 0.07
    deviation_volts: Annotated[float, Meta(ge=0, le=10, description="Standard deviation of the voltage.")] = 0.015
    converter_bits: Annotated[int, Meta(ge=4, le=32, description="How many bits the converter has.")] = 10
    converter_volts: Annotated[float, Meta(gt=0, le=100, description="The converter's greatest voltage.")] = 5.0
    least_reflectance: Annotated[
        float,
        Meta(
            ge=0,
            le=1,
            description="Reflectance times cosine of the incidence angle that is just seen at far_meters; nearer, less "
            "is enough, by the square of the distance. What is seen is told alike, whatever its colour.",
        ),
    ] = 0.05
    without_echo: WithoutEcho = "infinite"

    def __post_init__(self) -> None:
        """Raise ArgumentError for a curve that does not fall from near to far, or whose peak lies behind that."""
        if not (self.near_meters < self.far_meters and self.near_volts > self.far_volts):
            raise ArgumentError(
                f"{self.near_volts:g} V at {self.near_meters:g} m and {self.far_volts:g} V at {self.far_meters:g} m; "
                "the voltage must fall from near to far",
                field="near_volts",
            )
        if self.peak_meters > self.near_meters:
            raise ArgumentError(
                f"peak_meters is {self.peak_meters:g}; it must be at most near_meters, {self.near_meters:g}",
                field="peak_meters",
            )


class Infrared:
    """A triangulating infrared sensor: told alike by every colour, rough when far, and wrong when too near."""

    def __init__(self, settings: InfraredSettings) -> None:
        """Take the settings and draw the curve through its two known points."""
        self._settings = settings
        near, far = (1.0 / (d + settings.offset_meters) for d in (settings.near_meters, settings.far_meters))
        self._slope = (settings.near_volts - settings.far_volts) / (near - far)
        self._base = settings.far_volts - self._slope * far

    def beam(self) -> Floats:
        """Return the axis alone, (1, 3)."""
        return AXIS.copy()

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return the readings that a program gets from the converter's numbers by the curve's inverse.

        It has the voltage alone: what is nearer than the peak reads farther than it is, and is trusted; so is noise
        where nothing is seen, if it is great enough to look like a thing within the range.
        """
        settings, true = self._settings, hits.distance[:, 0]
        strength = hits.reflectance[:, 0] * np.cos(hits.incidence[:, 0])
        hit = np.isfinite(true)
        distance = np.where(hit, true, 0.0)
        seen = hit & (strength >= settings.least_reflectance * (distance / settings.far_meters) ** 2)
        volts = np.where(seen, self.voltage(distance), self._base)
        if settings.deviation_volts > 0.0:
            volts = volts + settings.deviation_volts * rng.standard_normal(len(volts))
        step = settings.converter_volts / (2**settings.converter_bits - 1)
        volts = np.clip(np.rint(volts / step) * step, 0.0, settings.converter_volts)
        over = volts - self._base
        told = np.where(over > 0.0, self._slope / np.where(over > 0.0, over, 1.0) - settings.offset_meters, np.inf)
        return readings(told, strength, over > 0.0, hits, 0.0, settings.without_echo)

    def voltage(self, distance: Floats) -> Floats:
        """Return the voltage (n,) at distances (n,): a / (d + k) + b from the peak on, in line with d before it."""
        peak = self._settings.peak_meters
        volts = self._slope / (np.maximum(distance, peak) + self._settings.offset_meters) + self._base
        return volts * np.minimum(distance / peak, 1.0) if peak > 0.0 else volts
