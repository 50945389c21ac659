"""Noise against its parameters: tests whose false alarms are rarer than one in a million runs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2, norm, t
from virtualrobot_kernel.sensing.noise import BLOCK, Noise
from virtualrobot_kernel.world.sensing import NoiseModel

ALARM = 1e-8
"""Of each side of each test."""
TICK = 0.004


def assert_mean_and_deviation(samples: np.ndarray, mean: float, deviation: float) -> None:
    """Student's t for the mean, chi-square for the variance (W. Press et al., Numerical Recipes, chapter 14)."""
    count = samples.size
    found = samples.std(ddof=1)
    assert abs(samples.mean() - mean) <= t.isf(ALARM, count - 1) * found / np.sqrt(count)
    ratio = (count - 1) * found**2 / deviation**2
    assert chi2.isf(1.0 - ALARM, count - 1) <= ratio <= chi2.isf(ALARM, count - 1)


def readings(model: NoiseModel, seed: int, ticks: np.ndarray, size: int = 3, value: float = 0.0) -> np.ndarray:
    noise = Noise(model, seed, 0, size)
    values = np.full(size, value)
    return np.array(
        [noise.told(values + noise.error(int(at), TICK, np.random.default_rng((seed, int(at))))) for at in ticks]
    )


def test_white_noise(seed: int) -> None:
    told = readings(NoiseModel(standard_deviation=0.03), seed, np.arange(1, 4001), value=2.0)
    assert_mean_and_deviation(told, 2.0, 0.03)
    axes = np.corrcoef(told.T)[np.triu_indices(3, 1)]
    steps = np.corrcoef(told[1:, 0], told[:-1, 0])[0, 1]
    # The correlation of independent numbers is normal with deviation 1 / sqrt(n).
    assert np.abs([*axes, steps]).max() < norm.isf(ALARM) / np.sqrt(len(told))


def test_a_bias_is_drawn_once_for_each_sensor(seed: int) -> None:
    model = NoiseModel(bias_standard_deviation=0.2)
    told = [readings(model, seed + sensor, np.array([5, 17, 90])) for sensor in range(1500)]
    assert all((one == one[0]).all() for one in told)
    assert_mean_and_deviation(np.array([one[0] for one in told]), 0.0, 0.2)


def test_a_walk_grows_with_the_root_of_time(seed: int) -> None:
    """`bias_walk` is its deviation after one second, so twice that after four; its steps are independent."""
    ticks = np.array([0, 250, 1000])
    told = np.array([readings(NoiseModel(bias_walk=0.5), seed + sensor, ticks) for sensor in range(1000)])
    assert (told[:, 0] == 0.0).all()
    assert_mean_and_deviation(told[:, 1], 0.0, 0.5)
    assert_mean_and_deviation(told[:, 2], 0.0, 1.0)
    assert_mean_and_deviation(told[:, 2] - told[:, 1], 0.0, 0.5 * np.sqrt(3.0))


def test_readings_repeat_to_the_bit_though_some_are_left_out(seed: int) -> None:
    model = NoiseModel(0.01, 0.1, 0.3, 1e-4, 5.0)
    ticks = np.arange(100, 100 + 5 * BLOCK)
    every = readings(model, seed, ticks)
    some = np.unique([0, *np.random.default_rng(seed).choice(len(ticks), 40, replace=False)])
    np.testing.assert_array_equal(readings(model, seed, ticks[some]), every[some])
    np.testing.assert_array_equal(readings(model, seed, ticks), every)
    assert (readings(model, seed + 1, ticks[:5]) != every[:5]).any()


def test_a_walk_can_be_asked_of_an_earlier_tick(seed: int) -> None:
    noise = Noise(NoiseModel(bias_walk=1.0), seed, 0, 2)
    ticks = [0, 3, 700, 5, 699, -1]
    found = [noise.error(at, TICK, np.random.default_rng(1)).tolist() for at in ticks]
    again = {at: noise.error(at, TICK, np.random.default_rng(1)).tolist() for at in sorted(ticks)}
    assert found == [again[at] for at in ticks]
    assert found[0] == found[-1] == [0.0, 0.0]


def test_channels_have_noise_of_their_own(seed: int) -> None:
    model = NoiseModel(bias_standard_deviation=1.0, bias_walk=1.0)
    first, second = [Noise(model, seed, channel, 3).error(0, TICK, np.random.default_rng(0)) for channel in (0, 1)]
    assert (first != second).all()


@pytest.mark.parametrize(("resolution", "limit"), [(0.25, 0.0), (0.0, 1.3), (0.25, 1.3)])
def test_steps_and_range(rng: np.random.Generator, resolution: float, limit: float) -> None:
    values = rng.uniform(-3.0, 3.0, 500)
    told = Noise(NoiseModel(resolution=resolution, range=limit), 0, 0, 500).told(values)
    inside = np.abs(told) < limit if limit else np.ones(500, bool)
    assert (np.abs(told[~inside]) == limit).all()
    assert (np.sign(told[~inside]) == np.sign(values[~inside])).all()
    if resolution:
        np.testing.assert_array_equal(np.round(told[inside] / resolution) * resolution, told[inside])
    assert np.abs(told - values)[inside].max() <= resolution / 2 + 1e-12
    assert inside.any() and (not limit or not inside.all())


def test_without_noise_numbers_are_as_they_are(rng: np.random.Generator) -> None:
    values = rng.normal(size=3)
    noise = Noise(NoiseModel(), 7, 0, 3)
    np.testing.assert_array_equal(noise.told(values + noise.error(9, TICK, rng)), values)
