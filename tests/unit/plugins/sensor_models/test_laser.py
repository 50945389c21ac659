"""The laser's noise, lost echoes, steps and range against the formulas of docs/sensor-models.md."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import stats
from virtualrobot_plugins.sensor_models.laser import Laser, LaserSettings
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.settings import make_settings

from tests.unit.plugins.sensor_models.truth import ALARM, assert_normal, assert_part, hits

MANY = 100_000


def laser(**settings: Any) -> Laser:  # noqa: ANN401  settings are of many types
    return Laser(LaserSettings(**{"resolution_meters": 0.0, **settings}))


@pytest.mark.parametrize(
    ("limit", "growth"),
    [("none", np.ones_like), ("shot", lambda cosine: cosine**-0.5), ("thermal", lambda cosine: 1.0 / cosine)],
)
def test_noise_has_the_deviation_of_its_distance_and_incidence(
    limit: str, growth: Callable[[Floats], Floats], rng: np.random.Generator
) -> None:
    distance, incidence = rng.uniform(0.5, 20.0, MANY), rng.uniform(0.0, 1.4, MANY)
    model = laser(deviation_meters=0.02, relative_deviation=0.004, noise_limit=limit, bias_meters=0.05)
    said = model.apply(hits(distance, incidence), rng)
    assert said.valid.all()
    expected = np.maximum(0.02, 0.004 * distance) * growth(np.cos(incidence))
    assert_normal((said.distance - distance - 0.05) / expected, 0.0, 1.0)


@pytest.mark.parametrize("limit", ["none", "shot", "thermal"])
def test_readings_are_those_of_the_formulas_one_after_the_other_to_the_last_bit(
    limit: str, rng: np.random.Generator
) -> None:
    """By NumPy, which rounds each product and each sum; chance is drawn in the same order."""
    distance, incidence = rng.uniform(0.5, 20.0, MANY), rng.uniform(0.0, 1.57, MANY)
    reflectance, seed = rng.uniform(0.0, 1.2, MANY), int(rng.integers(2**32))
    lost = rng.random(MANY) < 0.1
    model = laser(
        **{"deviation_meters": 0.02, "relative_deviation": 0.004, "noise_limit": limit, "bias_meters": 0.05},
        **{"resolution_meters": 0.003, "dropout_rate": 0.1, "without_echo": "farthest"},
    )
    away = np.where(lost, np.inf, distance)
    said = model.apply(hits(away, incidence, reflectance, 1.0, 18.0), np.random.default_rng(seed))
    chance = np.random.default_rng(seed)
    valid = ~lost & (chance.random(MANY) >= 0.1)
    cosine, square = np.full(MANY, -0.0000002605), incidence * incidence
    for factor in (0.0000247609, -0.0013888397, 0.0416666418, -0.4999999963, 1.0):
        cosine = cosine * square + factor
    assert np.abs(cosine - np.cos(incidence)).max() < 3e-9  # Abramowitz and Stegun, 4.3.99
    slant = np.maximum(cosine, 0.01)
    spread = np.maximum(0.004 * distance, 0.02) / {"none": 1.0, "shot": np.sqrt(slant), "thermal": slant}[limit]
    told = distance + spread * chance.standard_normal(MANY, dtype=np.float32) + 0.05
    told = np.rint(told * (1.0 / 0.003)) * 0.003
    valid &= (told >= 1.0) & (told <= 18.0)
    np.testing.assert_array_equal(said.valid, valid)
    np.testing.assert_array_equal(said.distance, np.where(valid, told, 18.0))
    np.testing.assert_array_equal(said.intensity, np.where(valid, np.minimum(reflectance * cosine, 1.0), 0.0))


def test_a_scanner_of_the_data_sheet_is_within_its_bounds(rng: np.random.Generator) -> None:
    """Hokuyo URG-04LX: +-10 mm to 1 m, +-1% beyond, taken as two deviations, so that 95.4% lie within."""
    model = laser(deviation_meters=0.005, relative_deviation=0.005)
    for distance, bound in ((0.3, 0.010), (0.9, 0.010), (2.0, 0.020), (4.0, 0.040)):
        said = model.apply(hits(np.full(MANY, distance)), rng)
        assert_part(np.abs(said.distance - distance) <= bound, float(stats.chi2.cdf(4.0, 1)))


def test_distances_are_told_in_steps(rng: np.random.Generator) -> None:
    true = rng.uniform(0.5, 20.0, MANY)
    said = laser(resolution_meters=0.002, deviation_meters=0.0).apply(hits(true), rng)
    steps = said.distance / 0.002
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9 * 1e4)
    off = (said.distance - true) / 0.002
    assert np.abs(off).max() <= 0.5 + 1e-9
    assert stats.kstest(off + 0.5, "uniform").pvalue > ALARM


@pytest.mark.parametrize("spread", [0.05, 0.2])
def test_echoes_are_lost_by_reflectance_slant_and_distance(spread: float, rng: np.random.Generator) -> None:
    """A target at 1/s of the threshold's power is found with probability Phi((s - 1) / spread)."""
    model = laser(detection_range_meters=18.0, detection_reflectance=0.1, detection_spread=spread)
    borderline = (18.0, 0.0, 0.1), (54.0, 0.0, 0.9), (10.0, 1.3, 0.12), (20.0, 0.3, 0.13)
    for distance, incidence, reflectance in (*borderline, (5.0, 0.0, 0.1), (5.0, 1.57, 0.1)):
        over = reflectance * np.cos(incidence) / 0.1 * (18.0 / distance) ** 2 - 1.0
        said = model.apply(hits(np.full(MANY, distance), incidence, reflectance), rng)
        assert_part(said.valid, float(stats.norm.cdf(over / spread)))


def test_a_target_of_nine_times_the_reflectance_is_found_three_times_as_far(rng: np.random.Generator) -> None:
    """The data sheets' ranges on 10% and 90% targets go with the root of the reflectance."""
    model = laser(detection_range_meters=10.0, detection_reflectance=0.1, detection_spread=0.0)
    for reflectance, reach in ((0.1, 10.0), (0.9, 30.0)):
        said = model.apply(hits([0.999 * reach, 1.001 * reach], 0.0, reflectance), rng)
        assert said.valid.tolist() == [True, False]


def test_some_readings_are_lost_by_chance(rng: np.random.Generator) -> None:
    assert_part(~laser(dropout_rate=0.03).apply(hits(np.full(MANY, 5.0)), rng).valid, 0.03)


@pytest.mark.parametrize(("said", "value"), [("infinite", np.inf), ("zero", 0.0), ("farthest", 4.0)])
def test_only_what_is_measured_within_the_range_is_valid(said: str, value: float, rng: np.random.Generator) -> None:
    model = laser(without_echo=said, deviation_meters=0.0)
    found = model.apply(hits([0.09, 0.1, 2.0, 4.0, np.inf], nearest=0.1, farthest=4.0), rng)
    assert found.valid.tolist() == [False, True, True, True, False]
    np.testing.assert_array_equal(found.distance, [value, 0.1, 2.0, 4.0, value])
    noisy = laser(deviation_meters=0.1).apply(hits(np.full(MANY, 4.0), nearest=0.1, farthest=4.0), rng)
    # Noise takes half of what lies on the limit beyond it.
    assert_part(noisy.valid, 0.5)
    assert noisy.distance[noisy.valid].max() <= 4.0


def test_the_intensity_is_what_lambert_says(rng: np.random.Generator) -> None:
    incidence, reflectance = rng.uniform(0.0, 1.5, 1000), rng.random(1000)
    said = laser().apply(hits(np.full(1000, 3.0), incidence, reflectance), rng)
    np.testing.assert_allclose(said.intensity, reflectance * np.cos(incidence), atol=1e-6)


def test_black_surfaces_are_told_unless_power_counts(rng: np.random.Generator) -> None:
    black = hits(np.full(10, 3.0), 0.0, 0.0)
    assert laser().apply(black, rng).valid.all()
    assert not laser(detection_range_meters=30.0).apply(black, rng).valid.any()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"divergence_radians": [0.1, 1.0]}, r"divergence_radians is \[0\.1, 1\.0\]; both angles must be from 0"),
        ({"rays": 7}, r"rays is 7, but divergence_radians is \[0, 0\]"),
        ({"rays": 0}, "rays"),
        ({"detection_reflectance": 0.0}, "detection_reflectance"),
        ({"deviation_meters": float("nan")}, "deviation_meters.*must be finite"),
        ({"echo": "last"}, "'first', 'strongest'"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings: dict, said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        make_settings(LaserSettings, settings)
