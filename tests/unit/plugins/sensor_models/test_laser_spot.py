"""A laser's spot on two surfaces: what lies nearer than the pulse blends, else one echo is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from virtualrobot_plugins.sensor_models.laser import Laser, LaserSettings
from virtualrobot_sdk.kinematics import Floats

from tests.unit.plugins.sensor_models.truth import assert_normal, beams, hits, wall

SPOT = (0.01, 0.01)


def laser(**settings: Any) -> Laser:  # noqa: ANN401  settings are of many types
    plain = {"resolution_meters": 0.0, "deviation_meters": 0.0, "divergence_radians": SPOT, "rays": 64}
    return Laser(LaserSettings(**{**plain, **settings}))


def edge(model: Laser, near: float, far: float, part: float) -> tuple[Floats, Floats, float]:
    """Return distances and incidence (k,) of a spot that a near plate covers by about `part`, and that part exactly."""
    beam = model.beam()
    covered = beam[:, 1] <= np.quantile(beam[:, 1], part)
    (at_near, slant), (at_far, _) = wall(beam, near), wall(beam, far)
    return np.where(covered, at_near, at_far), slant, float(covered.mean())


@pytest.mark.parametrize("part", [0.1, 0.5, 0.8])
def test_an_edge_blends_by_the_power_of_both_surfaces(part: float, rng: np.random.Generator) -> None:
    """Each surface counts by its part of the spot over its squared distance (radar equation)."""
    model = laser(pulse_meters=0.5)
    distance, slant, covered = edge(model, 2.0, 2.3, part)
    said = model.apply(beams((distance, slant)), rng)
    near, far = covered / 2.0**2, (1.0 - covered) / 2.3**2
    expected = (near * 2.0 + far * 2.3) / (near + far)
    assert said.valid.all()
    # The spot's edge is 5 mrad off the axis: 1.3e-5 of the distance.
    np.testing.assert_allclose(said.distance, expected, rtol=2e-5)
    assert 2.0 < said.distance[0] < 2.3


def test_surfaces_farther_apart_than_the_pulse_give_the_strongest_echo(rng: np.random.Generator) -> None:
    model = laser(pulse_meters=0.2)
    # From 2.0 and 2.3 m the powers are equal where the near plate covers 1 / (1 + (2.3 / 2.0)^2) = 43% of the spot.
    for part, expected in ((0.3, 2.3), (0.55, 2.0)):
        distance, slant, covered = edge(model, 2.0, 2.3, part)
        said = model.apply(beams((distance, slant)), rng)
        np.testing.assert_allclose(said.distance, expected, rtol=2e-5)
        share = covered if expected == 2.0 else 1.0 - covered
        np.testing.assert_allclose(said.intensity, share, rtol=1e-3)


def test_the_first_echo_is_told_where_it_has_the_power(rng: np.random.Generator) -> None:
    settings = {"pulse_meters": 0.2, "echo": "first", "detection_reflectance": 0.1, "detection_spread": 0.0}
    # A near plate that covers a tenth sends as much as one of 10% that fills the spot.
    distance, slant, covered = edge(laser(**settings), 2.0, 4.0, 0.1)
    for reach, expected in ((2.0 * np.sqrt(0.1 / covered) * 1.01, 2.0), (2.0 * np.sqrt(0.1 / covered) * 0.99, 4.0)):
        model = laser(detection_range_meters=reach, **settings)
        said = model.apply(beams((distance, slant)), rng)
        assert said.valid.all()
        np.testing.assert_allclose(said.distance, expected, rtol=2e-5)


def test_several_beams_at_once_are_told_each_for_itself(rng: np.random.Generator) -> None:
    model = laser(pulse_meters=0.2)
    mixed = edge(model, 2.0, 4.0, 0.9)[:2]
    blended = edge(model, 2.0, 2.1, 0.5)[:2]
    nothing = np.full(64, np.inf), np.zeros(64)
    half = np.where(model.beam()[:, 1] > 0.0, 3.0, np.inf), np.zeros(64)
    said = model.apply(beams([mixed, wall(model.beam(), 3.0), nothing, blended, half]), rng)
    assert said.valid.tolist() == [True, True, False, True, True]
    alone = [
        model.apply(beams(one), rng).distance[0] for one in (mixed, wall(model.beam(), 3.0), nothing, blended, half)
    ]
    np.testing.assert_allclose(said.distance, alone, rtol=1e-12)
    np.testing.assert_allclose(said.distance[[0, 1, 4]], [2.0, 3.0, 3.0], rtol=2e-5)
    assert 0.4 < said.intensity[4] < 0.6


def test_a_slanted_wall_is_one_surface_however_deep_the_spot_lies_on_it(rng: np.random.Generator) -> None:
    model = laser(pulse_meters=0.1)
    distance, slant = wall(model.beam(), 10.0, np.radians(85.0))
    assert np.ptp(distance) > 1.0
    said = model.apply(beams((distance, slant)), rng)
    weight = np.cos(slant) / distance**2
    np.testing.assert_allclose(said.distance, (weight * distance).sum() / weight.sum(), rtol=1e-6)


def test_each_echo_needs_the_power_itself(rng: np.random.Generator) -> None:
    """Two plates under halves of a spot are found to 1/sqrt(2) of the range where apart, as one where they blend."""
    settings = {"detection_range_meters": 10.0, "detection_reflectance": 1.0, "detection_spread": 0.0, "rays": 2}
    for pulse, valid in ((0.5, True), (0.1, False)):
        model = laser(pulse_meters=pulse, **settings)
        assert model.apply(hits([[9.0, 9.3]]), rng).valid.tolist() == [valid]
        assert model.apply(hits([[6.9, 7.2]]), rng).valid.all()


def test_the_noise_of_a_spot_grows_with_the_slant(rng: np.random.Generator) -> None:
    model = laser(deviation_meters=0.01, noise_limit="thermal", rays=7)
    distance, slant = wall(model.beam(), 5.0, np.radians(60.0))
    said = model.apply(beams((distance, slant), 50_000), rng)
    weight = np.cos(slant) / distance**2
    mean, cosine = ((weight * values).sum() / weight.sum() for values in (distance, np.cos(slant)))
    assert_normal(said.distance, mean, 0.01 / cosine)


def test_a_spot_that_half_misses_sends_half(rng: np.random.Generator) -> None:
    """So that it is found to 1/sqrt(2) of the distance at which a whole one is."""
    model = laser(detection_range_meters=10.0, detection_reflectance=1.0, detection_spread=0.0, rays=2)
    for reach, found in ((0.99, True), (1.01, False)):
        away = 10.0 * np.sqrt(0.5) * reach
        assert model.apply(hits([[away, np.inf]]), rng).valid.tolist() == [found]
        assert model.apply(hits([[away, away]]), rng).valid.all()
