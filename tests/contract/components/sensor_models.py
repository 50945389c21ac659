"""Sensor models: an ideal one, a noisy one that counts in steps, and wrong ones."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.rays import NO_ELEMENT, Readings, TrueHits

FARTHEST = 10.0


class Ideal:
    """Says what is true."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        return Readings(hits.distance.copy(), hits.reflectance.copy(), hits.element != NO_ELEMENT)


class Noisy:
    """Normal noise of 1 cm, steps of 5 mm, an echo that fades with slant and distance, dropouts, false echoes.

    What is not valid reads 0.
    """

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        n = len(hits.distance)
        distance = np.where(np.isfinite(hits.distance), hits.distance, 0.0) + 0.01 * rng.normal(size=n)
        distance = np.maximum(0.005 * np.round(distance / 0.005), 0.0)
        intensity = hits.reflectance * np.cos(hits.incidence) / (1.0 + np.minimum(distance, 1e6) ** 2 / 100.0)
        valid = (hits.element != NO_ELEMENT) & (distance < FARTHEST) & (intensity > 0.01) & (rng.random(n) > 0.02)
        false_echo = ~valid & (rng.random(n) < 0.01)
        distance = np.where(false_echo, rng.uniform(0.0, FARTHEST, n), np.where(valid, distance, 0.0))
        return Readings(distance, np.clip(intensity, 0.0, 1.0), valid | false_echo)


class OwnChance(Noisy):
    """Wrong: its chance is its own, so that no scan can be repeated."""

    def __init__(self) -> None:
        """Begin."""
        self.rng = np.random.default_rng(1)

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        return super().apply(hits, self.rng)


class Remembers(Ideal):
    """Wrong: mixes in what it read last."""

    def __init__(self) -> None:
        """Begin."""
        self.last = 0.0

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        said = super().apply(hits, rng)
        said.distance[...] += 0.1 * self.last
        self.last = float(np.where(said.valid, said.distance, 0.0).max(initial=0.0))
        return said


class NoisyMisses(Ideal):
    """Wrong: NaN where nothing is hit, as noise on infinity less infinity gives."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        with np.errstate(invalid="ignore"):
            distance = hits.distance + 0.1 * (hits.distance - hits.distance)
        return Readings(distance, hits.reflectance.copy(), hits.element != NO_ELEMENT)


class AlwaysValid(Noisy):
    """Wrong: trusts what it says of nothing."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        said = super().apply(hits, rng)
        return Readings(said.distance, said.intensity, np.ones(len(said.valid), np.bool_))


class Folds(Ideal):
    """Wrong: counts on from 0 past 4 m, as the phase of a modulated light does."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        finite = np.isfinite(hits.distance)
        distance = np.where(finite, np.mod(np.where(finite, hits.distance, 0.0), 4.0), np.inf)
        return Readings(distance, hits.reflectance.copy(), finite)


class ChangesHits(Ideal):
    """Wrong: writes its noise into the hits."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        hits.distance[...] += rng.normal(size=len(hits.distance))
        return super().apply(hits, rng)


class NeedsRays(Ideal):
    """Wrong: falls over an empty scan."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        farthest = hits.distance.max()
        return Readings(np.minimum(hits.distance, farthest), hits.reflectance.copy(), hits.element != NO_ELEMENT)
