"""The contract suite for sensor models: purity, what is said of misses, and readings that grow with the distance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.rays import NO_ELEMENT, Readings, TrueHits
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.trial import Law, Trial, checked

RAYS = 500
"""How many random rays most laws try."""
STEPS = 12
"""At how many distances the mean reading is taken."""
SAMPLES = 2000
"""Of how many rays each mean is."""
_DEVIATIONS = 5.0
"""By how many standard errors a mean may fall and still be chance."""
_COST_RAYS = 10000


@dataclass(frozen=True, slots=True)
class SensorFacts:
    """What the author says of a sensor model.

    Attributes:
        nearest, farthest: between which distances (m) it measures a white surface at right angles.
        valid_misses: which part of the rays that hit nothing it may call valid: 0 for none, a little for a sensor with
            false echoes, 1 for one that says its greatest range then.
    """

    nearest: float = 0.1
    farthest: float = 10.0
    valid_misses: float = 0.0


SensorTrial = Trial[SensorFacts]


def readings(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """Types and shapes are right; valid distances are finite, none is NaN or negative, intensities are from 0 to 1."""
    for count in (RAYS, 1, 7):
        _apply(trial, _random_hits(trial, rng, count), rng)
    _apply(trial, _at(np.full(RAYS, 1e9)), rng)
    _apply(trial, _at(np.full(RAYS, 1e-9)), rng)
    return Measured(3 * RAYS + 8)


def none(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """A scan without rays has no readings."""
    _apply(trial, _random_hits(trial, rng, 0), rng)
    return Measured(1)


def purity(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """Equal hits and equal draws give equal bits: at once, after another scan, and in another process."""
    hits, others = _random_hits(trial, rng, RAYS), _random_hits(trial, rng, RAYS // 2)
    draws = int(rng.integers(1 << 32))
    first = _apply(trial, hits, np.random.default_rng(draws))
    with trial.twin() as twin:
        for where, other in (("", trial), (" after another scan", trial), (" in another process", twin)):
            if where:
                _apply(other, others, np.random.default_rng(draws + 1))
            again = _apply(other, hits, np.random.default_rng(draws))
            for name in ("distance", "intensity", "valid"):
                if getattr(first, name).tobytes() != getattr(again, name).tobytes():
                    raise LawBroken(f"the same hits and draws give another {name}{where}; all chance comes of `rng`")
    return Measured(3 * RAYS)


def misses(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """Rays that hit nothing are not valid, or as many as the author says; those that are not all read the same."""
    hits = _at(np.where(np.arange(4 * RAYS) % 4 == 0, 0.5 * (trial.facts.nearest + trial.facts.farthest), np.inf))
    said = _apply(trial, hits, rng)
    missed = hits.element == NO_ELEMENT
    part = float(said.valid[missed].mean())
    # As many as chance may give of what the author says (binomial).
    allowed = trial.facts.valid_misses
    allowed += _DEVIATIONS * np.sqrt(allowed * (1.0 - allowed) / missed.sum())
    if part > allowed:
        raise LawBroken(
            f"{part:.1%} of the rays that hit nothing are valid; it may be {trial.facts.valid_misses:.1%} "
            "(`valid_misses` of SensorFacts)"
        )
    kinds = np.unique(said.distance[missed & ~said.valid])
    if len(kinds) > 1:
        raise LawBroken(
            f"rays that hit nothing and are not valid read {kinds[0]:g}, {kinds[1]:g} m and so on; a sensor says one "
            "thing then (inf, 0 or its greatest range)"
        )
    return Measured(int(missed.sum()), {"of misses are valid": part})


def growth(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """The mean reading grows with the distance, over the range that the author names, by at least half of it.

    A step may fall by chance: by five standard errors of the two means.
    """
    distances = np.linspace(trial.facts.nearest, trial.facts.farthest, STEPS + 2)[1:-1]
    means, errors, worst = np.zeros(STEPS), np.zeros(STEPS), 0.0
    for i, distance in enumerate(distances):
        said = _apply(trial, _at(np.full(SAMPLES, distance)), rng)
        valid = said.distance[said.valid]
        if len(valid) < SAMPLES // 100:
            raise LawBroken(
                f"{len(valid)} of {SAMPLES} rays to a white surface at {distance:.3g} m are valid; the sensor is said "
                f"to measure from {trial.facts.nearest:g} to {trial.facts.farthest:g} m"
            )
        means[i], errors[i] = valid.mean(), valid.std() / np.sqrt(len(valid))
        worst = max(worst, abs(means[i] - distance))
        if i and means[i] < means[i - 1] - _DEVIATIONS * np.hypot(errors[i], errors[i - 1]) - 1e-12:
            raise LawBroken(
                f"at {distance:.4g} m the mean reading is {means[i]:.4g} m, less than {means[i - 1]:.4g} m at "
                f"{distances[i - 1]:.4g} m"
            )
    if means[-1] - means[0] < 0.5 * (distances[-1] - distances[0]):
        raise LawBroken(
            f"from {distances[0]:.3g} to {distances[-1]:.3g} m the mean reading goes from {means[0]:.3g} to "
            f"{means[-1]:.3g} m; it must grow by half of that at least"
        )
    return Measured(STEPS * SAMPLES, {"m off in the mean": worst})


def cost(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """Tell what a ray costs; nothing is demanded."""
    hits = _random_hits(trial, rng, _COST_RAYS)
    seconds = np.median(trial.seconds(5, "apply", hits, rng))
    return Measured(_COST_RAYS, {"us a ray": float(1e6 * seconds / _COST_RAYS)})


LAWS: Mapping[str, Law] = MappingProxyType(
    {law.__name__: law for law in (readings, none, purity, misses, growth, cost)}
)
"""What every sensor model must keep, in the order in which it is tried."""


class SensorModelContract(ComponentContract):
    """What every sensor model must keep; subclass it in a test file.

    class TestMyLidar(SensorModelContract):
        component = "my_package/my_lidar"
        facts = SensorFacts(nearest=0.05, farthest=30.0)
    """

    kind = ComponentKind.SENSOR_MODEL
    laws = LAWS
    facts: ClassVar[SensorFacts] = SensorFacts()


def _apply(trial: SensorTrial, hits: TrueHits, rng: np.random.Generator) -> Readings:
    """Return the readings, of the right types and shapes and with sensible values."""
    # What is drawn in the component's process does not come back: each call has draws of its own.
    said = trial.call("apply", hits, rng.spawn(1)[0])
    if not isinstance(said, Readings):
        raise LawBroken(f"apply returned {type(said).__name__}; it must be Readings")
    shape = hits.distance.shape
    checked(said.distance, "distance", np.float64, shape)
    checked(said.intensity, "intensity", np.float64, shape)
    checked(said.valid, "valid", np.bool_, shape)
    wrong = {
        "a distance that is NaN or negative": ~(said.distance >= 0.0),
        "a valid distance that is not finite": said.valid & np.isinf(said.distance),
        "an intensity that is not from 0 to 1": ~((said.intensity >= 0.0) & (said.intensity <= 1.0)),
    }
    for what, rows in wrong.items():
        if rows.any():
            i = int(np.flatnonzero(rows)[0])
            raise LawBroken(
                f"a ray of {hits.distance[i]:.4g} m, {hits.incidence[i]:.3g} rad and reflectance "
                f"{hits.reflectance[i]:.3g} gives {what}: {said.distance[i]} m, intensity {said.intensity[i]}, "
                f"valid {said.valid[i]}"
            )
    return said


def _at(distance: np.ndarray) -> TrueHits:
    """Return hits on white surfaces at right angles; inf hits nothing."""
    element = np.where(np.isfinite(distance), 0, NO_ELEMENT).astype(np.int32)
    return TrueHits(distance, np.zeros(len(distance)), (element == 0).astype(np.float64), element)


def _random_hits(trial: SensorTrial, rng: np.random.Generator, count: int) -> TrueHits:
    """Return hits of all kinds: misses, near and far, at a slant, black and white."""
    hit = rng.random(count) < 0.8
    return TrueHits(
        np.where(hit, rng.uniform(0.0, 2.0 * trial.facts.farthest, count), np.inf),
        np.where(hit, rng.uniform(0.0, np.pi / 2, count), 0.0),
        np.where(hit, rng.random(count), 0.0),
        np.where(hit, rng.integers(0, 5, count), NO_ELEMENT).astype(np.int32),
    )
