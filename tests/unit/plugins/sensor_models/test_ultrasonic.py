"""The ultrasonic cone against walls: where the first echo comes from, when it is lost, and what the air does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats
from virtualrobot_plugins.sensor_models.ultrasonic import Ultrasonic, UltrasonicSettings

from tests.unit.plugins.sensor_models.truth import ALARM, assert_normal, assert_part, beams, hits, wall

HALF, CRITICAL, BURST = np.radians(15.0), np.radians(25.0), 0.034
MANY = 20_000


def sonar(**settings: Any) -> Ultrasonic:  # noqa: ANN401  settings are of many types
    plain = {"half_angle_radians": HALF, "critical_angle_radians": CRITICAL, "burst_meters": BURST}
    plain |= {"resolution_meters": 0.0, "deviation_meters": 0.0}
    return Ultrasonic(UltrasonicSettings(**{**plain, **settings}))


def test_a_wall_across_reads_its_distance_up_to_where_it_is_heard(rng: np.random.Generator) -> None:
    model = sonar(detection_range_meters=4.5)
    distances = np.linspace(0.02, 4.5, 200)
    said = model.apply(beams([wall(model.beam(), d) for d in distances], farthest=10.0), rng)
    assert said.valid.all()
    late = said.distance - distances
    assert late.min() >= -1e-12
    # The weaker the echo, the later it has swollen to the threshold, by a burst at most.
    assert (late[distances < 2.0] < 1e-3).all()
    assert late.max() <= BURST
    beyond = model.apply(beams([wall(model.beam(), d) for d in (4.55, 5.0, 9.0)], farthest=10.0), rng)
    assert not beyond.valid.any()


@pytest.mark.parametrize("degrees", [3.0, 8.0, 13.0])
def test_a_slanted_wall_reads_as_where_it_stands_across(degrees: float, rng: np.random.Generator) -> None:
    """The region of constant depth: r cos(tilt), not r (Leonard and Durrant-Whyte 1992, section 2.4)."""
    model = sonar()
    said = model.apply(beams(wall(model.beam(), 2.0, np.radians(degrees))), rng)
    across = 2.0 * np.cos(np.radians(degrees))
    # The nearest of 128 rays in the cone is some degrees off the foot of the perpendicular at most.
    assert said.valid.all()
    assert across - 1e-9 <= said.distance[0] <= across / np.cos(np.radians(3.0))


def test_a_smooth_wall_at_a_slant_is_lost_and_a_rough_one_is_not(rng: np.random.Generator) -> None:
    """No ray of the cone meets it below the critical angle where its tilt exceeds both together: 15 + 25 degrees."""
    tilts = np.radians([20.0, 30.0, 41.0, 55.0])
    smooth = sonar()
    said = smooth.apply(beams([wall(smooth.beam(), 1.0, tilt) for tilt in tilts]), rng)
    assert said.valid.tolist() == [True, True, False, False]
    assert said.distance[2:].tolist() == [np.inf, np.inf]
    rough = sonar(roughness=0.3)
    assert rough.apply(beams([wall(rough.beam(), 1.0, tilt) for tilt in tilts]), rng).valid.all()


@pytest.mark.parametrize("degrees", [0.0, 10.0, 20.0])
def test_one_ray_is_heard_as_far_as_mirror_spreading_and_air_allow(degrees: float, rng: np.random.Generator) -> None:
    """cos^2(pi/2 incidence/critical) / r^2 10^(-2 absorption r / 10) equals that of the wall across at its range."""
    model = sonar(rays=1, detection_range_meters=3.0, absorption_decibels_per_meter=1.3)
    part = np.cos(0.5 * np.pi * np.radians(degrees) / CRITICAL) ** 2
    away = np.linspace(0.5, 3.5, 300_001)
    energy = part * 10.0 ** (-0.26 * away) / away**2
    reach = away[energy >= 10.0 ** (-0.26 * 3.0) / 3.0**2].max()
    said = model.apply(hits([0.999 * reach, 1.001 * reach], np.radians(degrees)), rng)
    assert said.valid.tolist() == [True, False]


def test_the_nearer_of_two_things_is_told_if_it_is_loud_enough(rng: np.random.Generator) -> None:
    model = sonar()
    beam = model.beam()
    (behind, slant), (before, _) = wall(beam, 3.0), wall(beam, 1.0)
    plate = np.where(beam[:, 1] > 0.1, before, behind)
    # A rod across one of 128 rays, at the edge of the cone.
    rod, across = behind.copy(), slant.copy()
    rod[-1], across[-1] = 1.0, 0.0
    far, far_slant = wall(beam, 4.0)
    speck = far.copy()
    speck[-1] = 3.9
    cases = [(plate, slant), (rod, across), (speck, far_slant)]
    said = model.apply(beams(cases), rng)
    assert said.distance[0] == pytest.approx(before[beam[:, 1] > 0.1].min())
    assert said.distance[1] == pytest.approx(1.0)
    # At the edge of the cone one ray of 128 from 3.9 m is below the threshold of a wall at 4.5 m.
    assert 4.0 <= said.distance[2] < 4.0 + BURST


@pytest.mark.parametrize("celsius", [-10.0, 35.0])
def test_air_of_another_temperature_scales_the_distance(celsius: float, rng: np.random.Generator) -> None:
    """The way is time by the true speed, the reading time by the assumed one; c = 331.3 + 0.606 T."""
    model = sonar(air_temperature_celsius=celsius, assumed_temperature_celsius=20.0)
    said = model.apply(beams(wall(model.beam(), 1.5)), rng)
    assert said.distance[0] == pytest.approx(1.5 * 343.42 / (331.3 + 0.606 * celsius), rel=1e-6)


def test_noise_and_steps_are_those_of_the_settings(rng: np.random.Generator) -> None:
    model = sonar(deviation_meters=0.004)
    said = model.apply(beams(wall(model.beam(), 1.5), MANY), rng)
    assert_normal(said.distance, 1.5, 0.004)
    stepped = sonar(resolution_meters=0.003, deviation_meters=0.004)
    said = stepped.apply(beams(wall(stepped.beam(), 1.5), MANY), rng)
    steps = said.distance / 0.003
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
    # Rounding adds a twelfth of the step's square (Sheppard).
    assert said.distance.var() == pytest.approx(0.004**2 + 0.003**2 / 12.0, rel=0.06)


def test_strangers_are_heard_at_any_time_and_count_where_they_come_first(rng: np.random.Generator) -> None:
    model = sonar(false_echo_rate=0.1, rays=4)
    nothing = model.apply(hits(np.full((MANY, 4), np.inf), nearest=0.02, farthest=4.02), rng)
    assert_part(nothing.valid, 0.1)
    heard = nothing.distance[nothing.valid]
    assert stats.kstest((heard - 0.02) / 4.0, "uniform").pvalue > ALARM
    before = model.apply(hits(np.full((MANY, 4), 1.02), nearest=0.02, farthest=4.02), rng)
    assert before.valid.all()
    assert_part(before.distance != 1.02, 0.1 * 0.25)
    assert before.distance.max() == 1.02


def test_the_intensity_is_the_part_of_the_cone_that_comes_back(rng: np.random.Generator) -> None:
    model = sonar()
    everywhere = np.full((1, 128), 1.0)
    assert model.apply(hits(everywhere), rng).intensity[0] == pytest.approx(1.0)
    slanted = model.apply(hits(everywhere, 0.5 * CRITICAL), rng)
    assert slanted.intensity[0] == pytest.approx(np.cos(np.pi / 4) ** 2)
    half = model.apply(hits(np.where(model.beam()[None, :, 1] > 0.0, 1.0, np.inf)), rng)
    assert half.intensity[0] == pytest.approx(0.5, abs=0.02)
    for depth, part in ((0.02, 1.0), (0.1, 0.5)):
        steps = np.where(model.beam()[None, :, 1] > 0.0, 1.0, 1.0 + depth)
        assert model.apply(hits(steps), rng).intensity[0] == pytest.approx(part, abs=0.02)
