"""The contract suite for sensor models: beams, purity, misses, and readings that grow with the distance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from virtualrobot_sdk.answers import checked_beam, checked_readings
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Readings, TrueHits
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken, Measured
from virtualrobot_sdk.testing.trial import Law, Trial

BEAMS = 500
"""Number of random beams that most laws try."""
STEPS = 12
"""Number of distances at which the mean reading is taken."""
SAMPLES = 2000
"""Number of beams in each mean."""
_DEVIATIONS = 5.0
"""Number of standard errors by which a mean may fall and still be chance."""
_COST_BEAMS = 10000


@dataclass(frozen=True, slots=True)
class SensorFacts:
    """Properties of a sensor model that its author states.

    Attributes:
        nearest, farthest: distances (m) between which it measures a white surface at right angles; the range that it is
            told to be set to.
        valid_misses: largest part of the beams without a hit that are valid: 0 for none, a little for a sensor with
            false echoes, 1 for one that says its greatest range then.
    """

    nearest: float = 0.1
    farthest: float = 10.0
    valid_misses: float = 0.0


SensorTrial = Trial[SensorFacts]


def beam(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """A beam has a ray at least, of unit length and forward along x, and the same each time, in other processes too."""
    first = checked_beam(trial.call("beam"))
    _apply(trial, _random_hits(trial, rng, BEAMS), rng)
    with trial.twin() as twin:
        for where, other in ((" after a scan", trial), (" in another process", twin)):
            if checked_beam(other.call("beam")).tobytes() != first.tobytes():
                raise LawBroken(f"beam returns other rays{where}; they must be the same each time")
    widest = float(np.degrees(np.arccos(np.clip(first[:, 0], -1.0, 1.0))).max())
    return Measured(3, {"rays a beam": float(len(first)), "deg off x": widest})


def readings(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """Types and shapes are right; valid distances are finite, none is NaN or negative, intensities are from 0 to 1."""
    for count in (BEAMS, 1, 7):
        _apply(trial, _random_hits(trial, rng, count), rng)
    _apply(trial, _at(trial, np.full(BEAMS, 1e9)), rng)
    _apply(trial, _at(trial, np.full(BEAMS, 1e-9)), rng)
    return Measured(3 * BEAMS + 8)


def none(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """A scan without beams has no readings."""
    _apply(trial, _random_hits(trial, rng, 0), rng)
    return Measured(1)


def purity(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """Equal hits and equal draws give equal bits: at once, after another scan, and in another process."""
    hits, others = _random_hits(trial, rng, BEAMS), _random_hits(trial, rng, BEAMS // 2)
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
    return Measured(3 * BEAMS)


def misses(trial: SensorTrial, rng: np.random.Generator) -> Measured:
    """Beams that hit nothing are not valid, or as many as the author says; those that are not all read the same."""
    middle = 0.5 * (trial.facts.nearest + trial.facts.farthest)
    hits = _at(trial, np.where(np.arange(4 * BEAMS) % 4 == 0, middle, np.inf))
    said = _apply(trial, hits, rng)
    missed = (hits.element == NO_ELEMENT).all(axis=1)
    part = float(said.valid[missed].mean())
    # As many as chance may give of what the author says (binomial).
    allowed = trial.facts.valid_misses
    allowed += _DEVIATIONS * np.sqrt(allowed * (1.0 - allowed) / missed.sum())
    if part > allowed:
        raise LawBroken(
            f"{part:.1%} of the beams that hit nothing are valid; it may be {trial.facts.valid_misses:.1%} "
            "(`valid_misses` of SensorFacts)"
        )
    kinds = np.unique(said.distance[missed & ~said.valid])
    if len(kinds) > 1:
        raise LawBroken(
            f"beams that hit nothing and are not valid read {kinds[0]:g}, {kinds[1]:g} m and so on; a sensor says one "
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
        said = _apply(trial, _at(trial, np.full(SAMPLES, distance)), rng)
        valid = said.distance[said.valid]
        if len(valid) < SAMPLES // 100:
            raise LawBroken(
                f"{len(valid)} of {SAMPLES} beams to a white surface at {distance:.3g} m are valid; the sensor is said "
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
    """Tell what a beam costs; nothing is demanded."""
    hits = _random_hits(trial, rng, _COST_BEAMS)
    seconds = np.median(trial.seconds(5, "apply", hits, rng))
    return Measured(_COST_BEAMS, {"us a beam": float(1e6 * seconds / _COST_BEAMS)})


LAWS: Mapping[str, Law] = MappingProxyType(
    {law.__name__: law for law in (beam, readings, none, purity, misses, growth, cost)}
)
"""Laws of all sensor models, by name, in the order in which they are tried."""


class SensorModelContract(ComponentContract):
    """Contract of all sensor models; subclass it in a test file.

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
    try:
        return checked_readings(said, len(hits.distance))
    except ComponentFault as fault:
        raise LawBroken(f"{fault}; {_words(hits)}") from fault


def _words(hits: TrueHits) -> str:
    """Return in words what was hit, for a message."""
    if not hits.distance.size:
        return "there were no beams"
    rays = hits.distance.shape[1]
    return (
        f"the beams of {rays} rays hit at {hits.distance.min():.4g} to {hits.distance.max():.4g} m, within the range "
        f"{hits.nearest:g} to {hits.farthest:g} m"
    )


def _rays(trial: SensorTrial) -> int:
    """Return of how many rays the component's beams are."""
    return len(checked_beam(trial.call("beam")))


def _at(trial: SensorTrial, distance: Floats) -> TrueHits:
    """Return beams (n,) all of whose rays hit white surfaces at right angles; inf hits nothing."""
    away = np.repeat(distance[:, None], _rays(trial), axis=1)
    element = np.where(np.isfinite(away), 0, NO_ELEMENT).astype(np.int32)
    white = (element == 0).astype(np.float64)
    return TrueHits(away, np.zeros(away.shape), white, element, trial.facts.nearest, trial.facts.farthest)


def _random_hits(trial: SensorTrial, rng: np.random.Generator, count: int) -> TrueHits:
    """Return hits of all kinds: misses, near and far, at a slant, black and white; beams on one surface and on many."""
    shape = count, _rays(trial)
    alike = rng.random(count) < 0.5

    def drawn(values: Floats) -> Floats:
        return np.where(alike[:, None], values[:, :1], values)

    hit = drawn(rng.random(shape)) < 0.8
    return TrueHits(
        np.where(hit, drawn(rng.uniform(0.0, 2.0 * trial.facts.farthest, shape)), np.inf),
        np.where(hit, drawn(rng.uniform(0.0, np.pi / 2, shape)), 0.0),
        np.where(hit, drawn(rng.random(shape)), 0.0),
        np.where(hit, drawn(rng.integers(0, 5, shape).astype(np.float64)), NO_ELEMENT).astype(np.int32),
        trial.facts.nearest,
        trial.facts.farthest,
    )
