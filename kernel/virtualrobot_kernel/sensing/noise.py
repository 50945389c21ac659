"""Noise of measured numbers: white noise, a bias, a bias that walks, steps and a range.

IEEE Std 952-1997 (annex B) has the same terms for gyroscopes: white noise, bias, and rate random walk, whose standard
deviation grows with the square root of time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.sensing import NoiseModel

Floats = NDArray[np.float64]

BLOCK = 256
"""Number of ticks of a walk that are drawn at once."""

BIAS, WALK = 1, 2
"""Kind of what is drawn, as a part of the key of its random numbers."""


class Noise:
    """Spoils one measured vector; used by one thread.

    Bias and walk are pure functions of the sensor's seed, the channel, and how many ticks ago the sensor was started:
    so readings that are left out, or asked for between others, change nothing of later ones. White noise comes of the
    reading's own generator.
    """

    def __init__(self, model: NoiseModel, seed: int, channel: int, size: int) -> None:
        """Spoil vectors (size,) as `model` says; each channel of a sensor has noise of its own."""
        self._model = model
        self._seed, self._channel, self._size = seed, channel, size
        self._bias: Floats = model.bias_standard_deviation * self._drawn((BIAS,), (size,))
        self._walk = _Walk(self)

    def spoiled(self, values: Floats, moment: Moment) -> Floats:
        """Return what is told of true values (size,) in a reading."""
        return self.told(values + self.error(moment.elapsed, moment.snapshot.tick_seconds, moment.rng))

    def error(self, elapsed: int, tick_seconds: float, rng: np.random.Generator) -> Floats:
        """Return by how much a reading is off (size,), some ticks after the start, before steps and range."""
        # Drawn even when it counts for nothing, so that one setting doesn't change what another one draws.
        error = self._bias + self._model.standard_deviation * rng.standard_normal(self._size)
        if self._model.bias_walk > 0.0:
            error += self._model.bias_walk * np.sqrt(tick_seconds) * self._walk.after(elapsed)
        return error

    def told(self, values: Floats) -> Floats:
        """Return values (size,) in steps and within the range."""
        if self._model.resolution > 0.0:
            values = np.round(values / self._model.resolution) * self._model.resolution
        if self._model.range > 0.0:
            values = np.clip(values, -self._model.range, self._model.range)
        return values

    def _drawn(self, key: tuple[int, ...], shape: tuple[int, ...]) -> Floats:
        """Return standard normal numbers that depend on seed, channel and key alone."""
        sequence = np.random.SeedSequence(self._seed, spawn_key=(self._channel, *key))
        return np.random.default_rng(sequence).standard_normal(shape)


class _Walk:
    """The sum of one standard normal number for each tick; it keeps the block that it was asked for last."""

    def __init__(self, noise: Noise) -> None:
        self._noise = noise
        self._begin(0, np.zeros(noise._size))

    def after(self, ticks: int) -> Floats:
        """Return the sum (size,) after some ticks; before the first one there is none."""
        ticks = max(ticks, 0)
        if ticks < self._block * BLOCK:
            self._begin(0, np.zeros_like(self._sums[0]))
        while ticks >= (self._block + 1) * BLOCK:
            self._begin(self._block + 1, self._sums[BLOCK])
        return self._sums[ticks - self._block * BLOCK]

    def _begin(self, block: int, total: Floats) -> None:
        steps = self._noise._drawn((WALK, block), (BLOCK, len(total)))
        self._block = block
        self._sums = total + np.concatenate([np.zeros((1, len(total))), np.cumsum(steps, axis=0)])
