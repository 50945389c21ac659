"""How rays fill a beam, and the ideal model on its axis."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_plugins.sensor_models.beams import AXIS, cone, spot
from virtualrobot_plugins.sensor_models.ideal import Ideal

from tests.unit.plugins.sensor_models.truth import hits


@pytest.mark.parametrize("rays", [1, 7, 64, 500])
def test_a_cone_is_filled_evenly(rays: int) -> None:
    """By solid angle: the cosine to the axis is uniform from that of the half angle to 1 (Archimedes)."""
    beam = cone(rays, 0.4)
    np.testing.assert_allclose(np.linalg.norm(beam, axis=1), 1.0, atol=1e-12)
    np.testing.assert_array_equal(beam[0], AXIS[0])
    assert beam[:, 0].min() >= np.cos(0.4)
    cosines = np.sort(beam[1:, 0])
    even = 1.0 - (1.0 - np.cos(0.4)) * (np.arange(rays, 1, -1) - 0.5) / rays
    np.testing.assert_allclose(cosines, even, atol=1e-12)
    assert np.linalg.norm(beam[:, 1:].mean(axis=0)) <= 0.4 / np.sqrt(rays)


def test_a_spot_is_an_ellipse_filled_evenly() -> None:
    """The second moment of an evenly filled ellipse is a quarter of its half axis' square."""
    beam = spot(400, 0.02, 0.01)
    np.testing.assert_array_equal(beam[0], AXIS[0])
    y, z = beam[:, 1] / beam[:, 0], beam[:, 2] / beam[:, 0]
    assert ((y / 0.01) ** 2 + (z / 0.005) ** 2).max() <= 1.0
    np.testing.assert_allclose([(y**2).mean(), (z**2).mean()], [0.01**2 / 4, 0.005**2 / 4], rtol=0.02)


def test_the_ideal_sensor_says_the_truth_within_its_range(rng: np.random.Generator) -> None:
    incidence, reflectance = rng.uniform(0.0, 1.5, 5), rng.random(5)
    said = Ideal().apply(hits([0.5, 1.0, 7.0, 9.0, np.inf], incidence, reflectance, 1.0, 8.0), rng)
    assert said.valid.tolist() == [False, True, True, False, False]
    np.testing.assert_array_equal(said.distance, [np.inf, 1.0, 7.0, np.inf, np.inf])
    expected = np.where(said.valid, reflectance * np.cos(incidence), 0.0)
    np.testing.assert_array_equal(said.intensity, expected)
