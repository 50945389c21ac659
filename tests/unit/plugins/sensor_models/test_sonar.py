"""Sonars under water against formulas of acoustics: speed and loss of sound, ranges, slants, speckle."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from virtualrobot_plugins.sensor_models.sea_water import absorption, speed_of_sound
from virtualrobot_plugins.sensor_models.sonar import Sonar, SonarSettings
from virtualrobot_sdk.kinematics import Floats

from tests.unit.plugins.sensor_models.truth import assert_normal, assert_part, beams, hits, wall

MANY = 20_000
SEA = speed_of_sound(10.0, 35.0, 0.0)


def sonar(**settings: Any) -> Sonar:  # noqa: ANN401  settings are of many types
    """Return a sonar without noise whose assumed speed of sound is the true one."""
    plain = {"deviation_meters": 0.0, "resolution_meters": 0.0, "assumed_speed_meters_per_second": SEA}
    return Sonar(SonarSettings(**{**plain, **settings}))


def test_the_speed_of_sound_is_that_of_another_formula() -> None:
    """K. V. Mackenzie, Nine-term equation for sound speed in the oceans, JASA 70, 807, 1981."""

    def mackenzie(t: float, s: float, d: float) -> float:
        of_heat = 4.591 * t - 5.304e-2 * t**2 + 2.374e-4 * t**3
        of_depth = 1.630e-2 * d + 1.675e-7 * d**2 - 7.139e-13 * t * d**3
        return 1448.96 + of_heat + 1.340 * (s - 35.0) + of_depth - 1.025e-2 * t * (s - 35.0)

    assert mackenzie(25.0, 35.0, 1000.0) == pytest.approx(1550.744, abs=1e-3)  # the value to check by in the paper
    for at in product((2.0, 10.0, 20.0, 30.0), (30.0, 35.0, 40.0), (0.0, 100.0, 1000.0)):
        assert speed_of_sound(*at) == pytest.approx(mackenzie(*at), abs=0.6)
    # Pure water at 20 degrees: 1482.34 m/s (V. A. Del Grosso and C. W. Mader, JASA 52, 1442, 1972).
    assert speed_of_sound(20.0, 0.0, 0.0) == pytest.approx(1482.34, abs=1.0)


def test_absorption_is_that_of_another_formula() -> None:
    """R. E. Francois and G. R. Garrison, Sound absorption based on ocean measurements, JASA 72, 896 and 1879, 1982."""

    def francois_garrison(f: float, t: float, s: float, d: float) -> float:
        c, kelvin = 1412.0 + 3.21 * t + 1.19 * s + 0.0167 * d, 273.0 + t
        boric = 2.8 * np.sqrt(s / 35.0) * 10.0 ** (4.0 - 1245.0 / kelvin)
        magnesium = 8.17 * 10.0 ** (8.0 - 1990.0 / kelvin) / (1.0 + 0.0018 * (s - 35.0))
        first = 8.86 / c * 10.0 ** (0.78 * 8.0 - 5.0) * boric * f**2 / (f**2 + boric**2)
        second = 21.44 * s / c * (1.0 + 0.025 * t) * (1.0 - 1.37e-4 * d + 6.2e-9 * d**2)
        second *= magnesium * f**2 / (f**2 + magnesium**2)
        cold = 4.937e-4 - 2.59e-5 * t + 9.11e-7 * t**2 - 1.50e-8 * t**3
        warm = 3.964e-4 - 1.146e-5 * t + 1.45e-7 * t**2 - 6.5e-10 * t**3
        third = (cold if t <= 20.0 else warm) * (1.0 - 3.83e-5 * d + 4.9e-10 * d**2) * f**2
        return 1e-3 * (first + second + third)

    for at in product((30.0, 115.0, 300.0, 750.0), (2.0, 10.0, 20.0), (30.0, 35.0), (0.0, 300.0)):
        assert absorption(*at) == pytest.approx(francois_garrison(*at), rel=0.1)
    # Fresh water has neither acid nor magnesium sulphate: a twentieth at 30 kHz.
    assert absorption(30.0, 10.0, 0.0, 0.0) < 0.1 * absorption(30.0, 10.0, 35.0, 0.0)


def test_a_wall_across_reads_its_distance_up_to_where_it_is_heard(rng: np.random.Generator) -> None:
    model = sonar(detection_range_meters=40.0, width_radians=0.1, height_radians=0.1, burst_meters=0.2)
    distances = np.linspace(0.5, 40.0, 80)
    said = model.apply(beams([wall(model.beam(), d) for d in distances], farthest=100.0), rng)
    assert said.valid.all()
    late = said.distance - distances
    assert late.min() >= -1e-9
    assert late.max() <= 0.2
    beyond = model.apply(beams([wall(model.beam(), d) for d in (41.0, 60.0)], farthest=100.0), rng)
    assert not beyond.valid.any()


@pytest.mark.parametrize("celsius", [2.0, 25.0])
def test_the_device_knows_time_and_tells_distance_by_the_speed_that_it_assumes(
    celsius: float, rng: np.random.Generator
) -> None:
    """An echo takes 2 r / c there and back, of which the device makes c' t / 2."""
    model = sonar(rays=1, water_temperature_celsius=celsius, assumed_speed_meters_per_second=1500.0)
    delay = 2.0 * 20.0 / speed_of_sound(celsius, 35.0, 0.0)
    said = model.apply(hits([20.0]), rng)
    assert said.distance[0] == pytest.approx(1500.0 * delay / 2.0, abs=1e-9)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0])
def test_one_ray_is_heard_as_far_as_scattering_spreading_and_water_allow(
    degrees: float, rng: np.random.Generator
) -> None:
    """Lambert: cos(incidence) / r^2 10^(-2 absorption r / 10) equals that of the wall across at its range."""
    model = sonar(rays=1, detection_range_meters=50.0, frequency_kilohertz=750.0)
    loss = absorption(750.0, 10.0, 35.0, 0.0)
    away = np.linspace(5.0, 60.0, 500_001)
    energy = np.cos(np.radians(degrees)) * 10.0 ** (-0.2 * loss * away) / away**2
    reach = away[energy >= 10.0 ** (-0.2 * loss * 50.0) / 50.0**2].max()
    said = model.apply(hits([0.999 * reach, 1.001 * reach], np.radians(degrees)), rng)
    assert said.valid.tolist() == [True, False]


def test_a_mirror_is_heard_across_alone(rng: np.random.Generator) -> None:
    smooth = sonar(rays=1, roughness=0.0, critical_angle_radians=0.3)
    assert smooth.apply(hits([10.0, 10.0], np.array([0.1, 0.31])), rng).valid.tolist() == [True, False]


@pytest.mark.parametrize("part", [0.3, 1.0, 2.0])
def test_speckle_loses_echoes_as_rayleigh_has_it(part: float, rng: np.random.Generator) -> None:
    """A mean energy E exceeds the threshold T with exp(-T / E): the square of Rayleigh's amplitude is exponential."""
    model = sonar(rays=1, speckle=True, detection_range_meters=50.0, frequency_kilohertz=0.001)
    said = model.apply(hits(np.full(MANY, 50.0 * np.sqrt(part))), rng)
    assert_part(said.valid, float(np.exp(-part)))


def test_noise_is_what_was_set(rng: np.random.Generator) -> None:
    for distance, settings, deviation in (
        (2.0, {"deviation_meters": 0.02, "relative_deviation": 0.005}, 0.02),
        (20.0, {"deviation_meters": 0.02, "relative_deviation": 0.005}, 0.1),
    ):
        said = sonar(rays=1, **settings).apply(hits(np.full(MANY, distance)), rng)
        assert_normal(said.distance, distance, deviation)


def level_bottom(beam: Floats, height: float) -> tuple[Floats, Floats]:
    """Return distance and incidence (k,) of a level beam's rays on a level bottom below."""
    down = -beam[:, 2]
    below = down > 1e-9
    away = np.where(below, height / np.where(below, down, 1.0), np.inf)
    return away, np.where(below, np.arccos(np.clip(down, -1.0, 1.0)), 0.0)


def test_a_flat_beam_sees_the_bottom_where_its_lower_edge_meets_it(rng: np.random.Generator) -> None:
    """Nowhere nearer than height / sin(half of the beam's height), and not much farther."""
    flat = {"width_radians": 0.0175, "height_radians": np.radians(20.0), "rays": 256, "burst_meters": 0.02}
    model = sonar(detection_range_meters=300.0, **flat)
    nearest = 2.0 / np.sin(np.radians(10.0))
    said = model.apply(beams(level_bottom(model.beam(), 2.0)), rng)
    assert said.valid.all()
    assert nearest - 1e-9 <= said.distance[0] <= 1.2 * nearest


def test_a_pole_before_the_bottom_is_told_first(rng: np.random.Generator) -> None:
    model = sonar(width_radians=0.0175, height_radians=np.radians(20.0), rays=256)
    away, incidence = level_bottom(model.beam(), 2.0)
    pole = np.abs(model.beam()[:, 1]) < 0.004
    away, incidence = np.where(pole, 6.0, away), np.where(pole, 0.0, incidence)
    assert model.apply(beams((away, incidence)), rng).distance[0] == pytest.approx(6.0)
