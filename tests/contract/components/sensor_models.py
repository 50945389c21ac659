"""Sensor models: an ideal one, one with a cone of rays, a noisy one that counts in steps, and wrong ones."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Readings, TrueHits

FARTHEST = 10.0


class Ideal:
    """Says what is true."""

    def beam(self) -> Floats:
        return np.array([[1.0, 0.0, 0.0]])

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        distance = hits.distance[:, 0]
        return Readings(distance.copy(), hits.reflectance[:, 0].copy(), np.isfinite(distance))


class Cone:
    """Says the nearest of seven rays: one along the axis, and six at 0.2 rad around it."""

    def beam(self) -> Floats:
        around = np.linspace(0.0, 2.0 * np.pi, 6, endpoint=False)
        ring = np.stack([np.full(6, np.cos(0.2)), np.sin(0.2) * np.cos(around), np.sin(0.2) * np.sin(around)], axis=1)
        return np.concatenate([[[1.0, 0.0, 0.0]], ring])

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        distance = hits.distance.min(axis=1, initial=np.inf)
        return Readings(distance, hits.reflectance.mean(axis=1), np.isfinite(distance))


class HalfBeam(Ideal):
    """Wrong: a ray that is not of unit length."""

    def beam(self) -> Floats:
        return np.array([[1.0, 0.0, 0.0], [0.5, 0.0, 0.0]])


class Backwards(Ideal):
    """Wrong: its beam leaves at the back."""

    def beam(self) -> Floats:
        return np.array([[-1.0, 0.0, 0.0]])


class NoBeam(Ideal):
    """Wrong: no rays at all."""

    def beam(self) -> Floats:
        return np.zeros((0, 3))


class Wanders(Ideal):
    """Wrong: other rays each time."""

    def __init__(self) -> None:
        """Begin."""
        self.angle = 0.0

    def beam(self) -> Floats:
        self.angle += 0.01
        return np.array([[np.cos(self.angle), np.sin(self.angle), 0.0]])


class OneEach(Ideal):
    """Wrong: a reading for each ray where one for each beam belongs."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        return Readings(hits.distance.copy(), hits.reflectance.copy(), hits.element != NO_ELEMENT)


class Noisy(Ideal):
    """Normal noise of 1 cm, steps of 5 mm, an echo that fades with slant and distance, dropouts, false echoes.

    What is not valid reads 0.
    """

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        n = len(hits.distance)
        true, incidence = hits.distance[:, 0], hits.incidence[:, 0]
        distance = np.where(np.isfinite(true), true, 0.0) + 0.01 * rng.normal(size=n)
        distance = np.maximum(0.005 * np.round(distance / 0.005), 0.0)
        intensity = hits.reflectance[:, 0] * np.cos(incidence) / (1.0 + np.minimum(distance, 1e6) ** 2 / 100.0)
        valid = np.isfinite(true) & (distance < FARTHEST) & (intensity > 0.01) & (rng.random(n) > 0.02)
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
            distance = (hits.distance + 0.1 * (hits.distance - hits.distance))[:, 0]
        return Readings(distance, hits.reflectance[:, 0].copy(), np.isfinite(distance))


class AlwaysValid(Noisy):
    """Wrong: trusts what it says of nothing."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        said = super().apply(hits, rng)
        return Readings(said.distance, said.intensity, np.ones(len(said.valid), np.bool_))


class Folds(Ideal):
    """Wrong: counts on from 0 past 4 m, as the phase of a modulated light does."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        said = super().apply(hits, rng)
        distance = np.where(said.valid, np.mod(np.where(said.valid, said.distance, 0.0), 4.0), np.inf)
        return Readings(distance, said.intensity, said.valid)


class ChangesHits(Ideal):
    """Wrong: writes its noise into the hits."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        hits.distance[...] += rng.normal(size=hits.distance.shape)
        return super().apply(hits, rng)


class NeedsRays(Ideal):
    """Wrong: falls over an empty scan."""

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        said = super().apply(hits, rng)
        return Readings(np.minimum(said.distance, hits.distance.max()), said.intensity, said.valid)
