"""How the suite for ray casters looks at an answer: types and shapes, and distances from the truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.ray_truth import reference
from virtualrobot_sdk.testing.trial import Trial, checked, numbers

_NORMAL = 1e-3
"""How far a normal may be from the triangle's (length of the difference)."""


@dataclass(frozen=True, slots=True)
class CasterFacts:
    """What the author says of a ray caster.

    Attributes:
        precision: the largest error of a distance (m), for scenes and rays within 10 m: the default is good for single
            precision.
    """

    precision: float = 1e-4


RayTrial = Trial[CasterFacts]


def cast(trial: RayTrial, scene: RayScene, origins: Floats, directions: Floats, max_range: float = np.inf) -> Hits:
    """Return the hits, of the right types and shapes, finite where they must be, normals of unit length or 0."""
    hits = trial.call("cast", scene, origins, directions, max_range)
    if not isinstance(hits, Hits):
        raise LawBroken(f"cast returned {type(hits).__name__}; it must be Hits")
    n = len(origins)
    checked(hits.distance, "distance", np.float64, (n,))
    checked(hits.element, "element", np.int32, (n,))
    checked(hits.normal, "normal", np.float64, (n, 3))
    is_hit = hits.element != NO_ELEMENT
    wrong = {
        "a distance that is NaN or below 0": ~(hits.distance >= 0.0),
        "an element that is not there": is_hit & ((hits.element < 0) | (hits.element >= len(scene.shapes))),
        "a distance without an element, or an element at no distance": np.isfinite(hits.distance) != is_hit,
        "a miss with a normal": ~is_hit & hits.normal.any(axis=1),
        "a normal that is not of unit length": is_hit & ~(np.abs(np.linalg.norm(hits.normal, axis=1) - 1.0) <= 1e-6),
        "a normal turned away from the ray's origin": is_hit & ~((hits.normal * directions).sum(axis=1) <= 1e-6),
    }
    for what, rows in wrong.items():
        if rows.any():
            i = int(np.flatnonzero(rows)[0])
            raise LawBroken(
                f"{ray_words(origins, directions, i)} gives {what}: distance {hits.distance[i]}, element "
                f"{hits.element[i]}, normal {numbers(hits.normal[i])}"
            )
    return hits


def as_reference(
    trial: RayTrial, scene: RayScene, origins: Floats, directions: Floats, max_range: float = np.inf
) -> float:
    """Return the worst distance from the reference's (m)."""
    found = cast(trial, scene, origins, directions, max_range)
    truth = reference(scene, origins, directions, max_range, 10.0 * trial.facts.precision)
    return compared(trial, found, truth.hits, truth.sure, origins, directions)


def compared(trial: RayTrial, found: Hits, true: Hits, sure: np.ndarray, origins: Floats, directions: Floats) -> float:
    """Return the worst distance of what was found from the truth (m) among the rays that are sure."""
    with np.errstate(invalid="ignore"):
        off = np.where(found.distance == true.distance, 0.0, np.abs(found.distance - true.distance))
    # A surface that is met at a slant moves the hit by more than it moves itself.
    slant = np.maximum(0.05, np.abs((true.normal * directions).sum(axis=1)))
    apart = np.linalg.norm(found.normal - true.normal, axis=1) > _NORMAL
    wrong = sure & ((off * slant > trial.facts.precision) | (found.element != true.element) | apart)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise LawBroken(
            f"{ray_words(origins, directions, i)} meets {met(found, i)}; it must be {met(true, i)} "
            f"({int(wrong.sum())} of {len(wrong)} rays are wrong)"
        )
    return float(np.where(sure & np.isfinite(off), off, 0.0).max(initial=0.0))


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
