"""Comparison of ray casters on a scene, and what they cost: the same random rays for each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.rays import Hits, RayScene

from virtualrobot_kernel.components.catalog import Offer
from virtualrobot_kernel.components.running import start
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.sensing.casting import cast_rays

EQUAL_METERS = 1e-3
"""Distances that differ by less are the same."""
AIMED = 2.0 / 3.0
"""Part of the rays that goes towards points of elements; the others go anywhere."""
ROOM = 0.2
"""By which part of the scene's size, and at least by so many meters, rays may begin beside it."""

Floats = NDArray[np.float64]
Told = Callable[[float], bool]
"""Is told which part of the work is done, 0 to 1, and returns whether to go on."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """Result of a ray caster, beside the first one that answered; `fault` says why it could not answer.

    Attributes:
        ray_caster: the component.
        fault: why it could not answer, in words; empty where it did.
        agreement: the part of the rays whose distance is the same to EQUAL_METERS.
        other_element: the part of the rays that hit another element.
        median_difference: of the distances (m), among rays that hit something by both.
        largest_difference: the largest one (m).
        first_cast_seconds: of the first cast, with what the component prepares.
        cast_seconds: of a later cast of all rays.
    """

    ray_caster: str
    fault: str = ""
    agreement: float = 0.0
    other_element: float = 0.0
    median_difference: float = 0.0
    largest_difference: float = 0.0
    first_cast_seconds: float = 0.0
    cast_seconds: float = 0.0


def random_rays(scene: RayScene, count: int, seed: int) -> tuple[Floats, Floats]:
    """Return origins and unit directions (count, 3) through a scene: from anywhere in it, most of them to its elements.

    Each element is aimed at as often as any other, beside one of its vertices.
    """
    rng = np.random.default_rng(seed)
    seen = [i for i, shape in enumerate(scene.shapes) if len(shape.vertices)]
    chosen = rng.integers(max(len(seen), 1), size=count)
    aims, low, high = np.zeros((count, 3)), np.full(3, np.inf), np.full(3, -np.inf)
    for place, i in enumerate(seen):
        pose = scene.world_t_element[i]
        points = scene.shapes[i].vertices @ pose[:3, :3].T + pose[:3, 3]
        low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
        mine = np.flatnonzero(chosen == place)
        aims[mine] = points[rng.integers(len(points), size=len(mine))]
    if not seen:
        low = high = np.zeros(3)
    room = np.maximum(ROOM * (high - low), ROOM)
    origins = rng.uniform(low - room, high + room, (count, 3))
    directions = rng.normal(size=(count, 3))
    aimed = round(AIMED * count) if seen else 0
    # Not at the vertices themselves, where rounding decides which of several triangles is hit.
    directions[:aimed] = aims[:aimed] - origins[:aimed] + rng.normal(scale=0.02, size=(aimed, 3))
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def compared(
    offer: Offer, scene: RayScene, origins: Floats, directions: Floats, first: Hits | None, told: Told
) -> tuple[Comparison, Hits | None]:
    """Return how a component, made for this, does beside the `first` one's hits; and its own hits where it answers.

    Raises KernelError where `told` says that nobody waits any more.
    """
    name, n = offer.about.name, len(directions)
    given_up = False

    def telling(offset: float) -> Callable[[int], bool]:
        def go_on(done: int) -> bool:
            nonlocal given_up
            given_up = not told((offset + done / n) / 2.0)
            return not given_up

        return go_on

    try:
        running = start(offer, {})
        try:
            cold = cast_rays(running, scene, origins, directions, np.inf, telling(0.0))
            warm = cast_rays(running, scene, origins, directions, np.inf, telling(1.0))
        finally:
            running.close()
    except KernelError as error:
        if given_up:
            raise
        return Comparison(name, str(error)), None
    agreement, other, median, largest = differences(warm.hits, warm.hits if first is None else first)
    return Comparison(name, "", agreement, other, median, largest, cold.seconds, warm.seconds), warm.hits


def differences(hits: Hits, first: Hits) -> tuple[float, float, float, float]:
    """Return which part of n rays agrees, which part hits another element, the median and largest difference (m)."""
    both = np.isfinite(hits.distance) & np.isfinite(first.distance)
    apart = np.abs(hits.distance[both] - first.distance[both])
    neither = np.isinf(hits.distance) & np.isinf(first.distance)
    same = int(neither.sum()) + int((apart <= EQUAL_METERS).sum())
    other = float((hits.element != first.element).mean()) if len(both) else 0.0
    median, largest = (float(np.median(apart)), float(apart.max())) if len(apart) else (0.0, 0.0)
    return same / len(both) if len(both) else 1.0, other, median, largest
