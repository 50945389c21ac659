"""Checks of a ray caster's answer in its suite: types and shapes, and distances from the truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.ray_checks import checked_hits
from virtualrobot_sdk.rays import NO_ELEMENT, Booleans, Hits, RayScene
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.ray_truth import reference
from virtualrobot_sdk.testing.trial import Trial, numbers

_NORMAL = 1e-3
"""Largest error of a normal from the triangle's (length of the difference)."""
_GRAZING = 1e-3
"""Slant (cosine to the normal) below which a hit may be no farther off than at this one."""


@dataclass(frozen=True, slots=True)
class CasterFacts:
    """Properties of a ray caster that its author states.

    Attributes:
        precision: the largest error of a distance (m), for scenes and rays within 10 m: the default is good for single
            precision.
        exact_curves: true where it meets curved surfaces (`Shape.primitive`) as they are meant, to 1e-6 of the range,
            and never the triangles that stand for them.
    """

    precision: float = 1e-4
    exact_curves: bool = False


RayTrial = Trial[CasterFacts]


def cast(trial: RayTrial, scene: RayScene, origins: Floats, directions: Floats, max_range: float = np.inf) -> Hits:
    """Return the hits, of the right types and shapes, finite where they must be, normals of unit length or 0."""
    return checked_hits(trial.call("cast", scene, origins, directions, max_range), scene, origins, directions)


def as_reference(
    trial: RayTrial, scene: RayScene, origins: Floats, directions: Floats, max_range: float = np.inf
) -> float:
    """Return the worst distance from the reference's (m)."""
    found = cast(trial, scene, origins, directions, max_range)
    truth = reference(scene, origins, directions, max_range, 10.0 * trial.facts.precision)
    return compared(trial, found, truth.hits, truth.sure, origins, directions)


def compared(trial: RayTrial, found: Hits, true: Hits, sure: Booleans, origins: Floats, directions: Floats) -> float:
    """Return the worst distance of what was found from the truth (m) among the rays that are sure."""
    must_be(found, true, sure & apart(found, true, directions, trial.facts.precision), origins, directions)
    return worst_error(found, true, sure)


def apart(found: Hits, true: Hits, directions: Floats, precision: float) -> Booleans:
    """Return whether each ray (n,) meets another element, or the surface by more than `precision` (m) elsewhere."""
    # A surface that is met at a slant moves the hit by more than it moves itself.
    slant = np.maximum(_GRAZING, np.abs((true.normal * directions).sum(axis=1)))
    turned = np.linalg.norm(found.normal - true.normal, axis=1) > _NORMAL
    return (_error(found, true) * slant > precision) | (found.element != true.element) | turned


def must_be(found: Hits, true: Hits, wrong: Booleans, origins: Floats, directions: Floats) -> None:
    """Raise LawBroken with the first ray that is wrong, if one is."""
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise LawBroken(
            f"{ray_words(origins, directions, i)} meets {met(found, i)}; it must be {met(true, i)} "
            f"({int(wrong.sum())} of {len(wrong)} rays are wrong)"
        )


def worst_error(found: Hits, true: Hits, sure: Booleans) -> float:
    """Return the largest error of a distance (m) among the rays that are sure and hit."""
    off = _error(found, true)
    return float(np.where(sure & np.isfinite(off), off, 0.0).max(initial=0.0))


def _error(found: Hits, true: Hits) -> Floats:
    with np.errstate(invalid="ignore"):
        return np.where(found.distance == true.distance, 0.0, np.abs(found.distance - true.distance))


def nonsense(scene: RayScene, origins: Floats, directions: Floats) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused."""
    for what, value in (("NaN", np.nan), ("infinity", np.inf)):
        for name, given in (("origin", origins), ("direction", directions)):
            broken = given.copy()
            broken[-1, 1] = value
            rays = (broken, directions) if name == "origin" else (origins, broken)
            yield "cast", (scene, *rays, 10.0), f"{name} with {what}"
    poses = scene.world_t_element.copy()
    poses[0, 0, 3] = np.nan
    yield "cast", (RayScene(scene.shapes, poses), origins, directions, 10.0), "an element's pose with NaN"
    yield "cast", (RayScene(scene.shapes, poses[:-1]), origins, directions, 10.0), "fewer poses than shapes"
    for factor in (0.0, 2.0, 1.0 + 1e-4):
        broken = directions.copy()
        broken[0] *= factor
        yield "cast", (scene, origins, broken, 10.0), f"a direction of length {factor}"
    yield "cast", (scene, origins[:-1], directions, 10.0), "fewer origins than directions"
    yield "cast", (scene, origins[:, :2], directions[:, :2], 10.0), "rays in two dimensions"
    for max_range in (np.nan, -1.0, 0.0):
        yield "cast", (scene, origins, directions, max_range), f"a range of {max_range}"


def ray_words(origins: Floats, directions: Floats, i: int) -> str:
    """Return a ray in words."""
    return f"the ray from {numbers(origins[i])} along {numbers(directions[i])}"


def met(hits: Hits, i: int) -> str:
    """Return in words what a ray meets."""
    if hits.element[i] == NO_ELEMENT:
        return "nothing"
    return f"element {hits.element[i]} at {hits.distance[i]:.6g} m with the normal {numbers(hits.normal[i])}"
