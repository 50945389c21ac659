"""The infrared sensor's voltage against Sharp's data sheet, and its errors, which grow with the distance's square."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from virtualrobot_plugins.sensor_models.infrared import Infrared, InfraredSettings
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.settings import make_settings

from tests.unit.plugins.sensor_models.truth import assert_normal, hits

RANGE = {"nearest": 0.1, "farthest": 0.8}
OFFSET = 0.0042
SLOPE = 1.9 / (1.0 / (0.1 + OFFSET) - 1.0 / (0.8 + OFFSET))
"""V m; and the voltage at no end of distance:"""
BASE = 0.4 - SLOPE / (0.8 + OFFSET)


def sharp(**settings: Any) -> Infrared:  # noqa: ANN401  settings are of many types
    return Infrared(InfraredSettings(**{"deviation_volts": 0.0, "converter_bits": 32, **settings}))


def test_the_curve_is_that_of_the_data_sheet() -> None:
    """GP2Y0A21YK: 0.4 V at 80 cm, 1.9 V more at 10 cm; its figure 2 shows 1.3 V at 20 cm and 0.75 V at 40 cm."""
    volts = sharp().voltage(np.array([0.1, 0.2, 0.4, 0.8]))
    np.testing.assert_allclose(volts[[0, 3]], [2.3, 0.4], rtol=1e-12)
    np.testing.assert_allclose(volts[[1, 2]], [1.3, 0.75], atol=0.1)
    # 20.99 V cm / d + 0.19 V, as someone measured at one of them.
    measured = 0.2099 / np.array([0.15, 0.2, 0.3, 0.5, 0.7]) + 0.19
    np.testing.assert_allclose(sharp().voltage(np.array([0.15, 0.2, 0.3, 0.5, 0.7])), measured, atol=0.1)


def test_a_quiet_sensor_reads_the_truth_within_its_range(rng: np.random.Generator) -> None:
    true = np.array([0.099, 0.1001, 0.2, 0.5, 0.7999, 0.81, np.inf])
    said = sharp().apply(hits(true, **RANGE), rng)
    assert said.valid.tolist() == [False, True, True, True, True, False, False]
    np.testing.assert_allclose(said.distance[1:5], true[1:5], rtol=1e-6)


def test_what_is_nearer_than_the_peak_reads_farther_and_is_trusted(rng: np.random.Generator) -> None:
    """At half of the peak's distance the voltage is half of the peak's, and the program takes it for a far thing."""
    model = sharp(peak_meters=0.07)
    folded = 0.5 * (SLOPE / (0.07 + OFFSET) + BASE)
    said = model.apply(hits([0.035], **RANGE), rng)
    assert said.valid.all()
    assert said.distance[0] == pytest.approx(SLOPE / (folded - BASE) - OFFSET, rel=1e-6)
    assert said.distance[0] > 0.1
    readings = model.apply(hits(np.linspace(0.02, 0.048, 9), **RANGE), rng).distance
    assert (np.diff(readings) < 0.0).all()


def test_the_error_grows_with_the_square_of_the_distance(rng: np.random.Generator) -> None:
    """By dV (d + k)^2 / a, since V = a / (d + k) + b."""
    model = sharp(deviation_volts=1e-4)
    for true in (0.15, 0.3, 0.6, 0.75):
        said = model.apply(hits(np.full(50_000, true), **RANGE), rng)
        assert said.valid.all()
        assert_normal(said.distance, true, 1e-4 * (true + OFFSET) ** 2 / SLOPE)


def test_the_converter_steps_in_volts(rng: np.random.Generator) -> None:
    model = sharp(converter_bits=10, converter_volts=5.0)
    volts = np.linspace(0.4, 2.3, 5000)
    said = model.apply(hits(SLOPE / (volts - BASE) - OFFSET, **RANGE), rng)
    found = said.distance[said.valid]
    steps = (SLOPE / (found + OFFSET) + BASE) / (5.0 / 1023)
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-6)
    assert np.abs(steps - volts[said.valid] / (5.0 / 1023)).max() <= 0.5 + 1e-6
    # From 80 to 10 cm: 1.9 V are 388.7 steps, with those at both ends.
    assert 388 <= len(np.unique(np.rint(steps))) <= 390


def test_colour_does_not_count_but_black_is_not_seen(rng: np.random.Generator, seed: int) -> None:
    """The data sheet's curves of white (90%) and grey (18%) paper are one; the spot's place counts, not its light."""
    model = sharp(deviation_volts=0.015, least_reflectance=0.05)
    true = rng.uniform(0.15, 0.7, 1000)
    white, grey = (model.apply(hits(true, 0.0, r, **RANGE), np.random.default_rng(seed)) for r in (0.9, 0.18))
    np.testing.assert_array_equal(white.distance, grey.distance)
    assert not model.apply(hits([0.5], 0.0, 0.0, **RANGE), rng).valid.any()
    wild = sharp(deviation_volts=0.3).apply(hits(np.full(1000, np.inf), **RANGE), rng)
    assert 0.05 < wild.valid.mean() < 0.4  # 0.28 V above nothing look like a thing at 80 cm
    edge = 0.05 * (0.4 / 0.8) ** 2
    seen = sharp(least_reflectance=0.05).apply(hits([0.4, 0.4], 0.0, [1.01 * edge, 0.99 * edge], **RANGE), rng)
    assert seen.valid.tolist() == [True, False]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"near_volts": 0.3}, r"0\.3 V at 0\.1 m and 0\.4 V at 0\.8 m; the voltage must fall"),
        ({"peak_meters": 0.2}, r"peak_meters is 0\.2; it must be at most near_meters, 0\.1"),
        ({"converter_bits": 2}, "converter_bits"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings: dict, said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        make_settings(InfraredSettings, settings)
