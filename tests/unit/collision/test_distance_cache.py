"""Measured distances that are kept: what holds for other places, what is kept of many."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision.distance_cache import KEPT, LEAST, DistanceCache

from tests.unit.collision.solids import GEOMETRIES, near, placed
from tests.unit.world.builders import shifted


def balls(x: float) -> np.ndarray:
    """Return the poses of two elements so far apart."""
    return np.array([shifted(), shifted(x=x)])


def test_the_best_of_what_is_kept_holds(rng: np.random.Generator) -> None:
    """From each place where it was measured a sphere's distance falls as it comes nearer; the oldest is forgotten."""
    sphere = GEOMETRIES["sphere"]
    kept = DistanceCache(placed((sphere, near(rng)), (sphere, near(rng))))
    pair = np.array([[0, 1]])
    assert kept.slots(pair)[0] == -1
    assert kept.add(0, 1, balls(0.4), 0.5 * LEAST) == -1
    slot = kept.add(0, 1, balls(1.0), 0.6)
    assert kept.slots(pair)[0] == slot
    assert kept.bound(0, 1, slot, balls(0.9)) == pytest.approx(0.5, abs=1e-8)
    assert kept.bound(0, 1, slot, balls(0.3)) == 0.0
    kept.add(0, 1, balls(2.0), 1.5)
    for x, bound in ((2.2, 1.3), (1.0, 0.6), (1.4, 0.9)):  # the better of both
        assert kept.bound(0, 1, slot, balls(x)) == pytest.approx(bound, abs=1e-8)
    for _ in range(KEPT - 1):
        assert kept.add(0, 1, balls(3.0), 2.4) == slot
    assert kept.bound(0, 1, slot, balls(1.0)) == pytest.approx(0.5, abs=1e-8)


def test_of_too_many_pairs_all_are_forgotten_between_ways(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Slots hold until they are asked for the next time, so that a way in work loses nothing."""
    monkeypatch.setattr("virtualrobot_kernel.collision.distance_cache.MOST", 20)
    sphere = GEOMETRIES["sphere"]
    count = 30
    kept = DistanceCache(placed(*((sphere, near(rng)) for _ in range(count))))
    poses = np.tile(np.eye(4), (count, 1, 1))
    slots = [kept.add(0, other, poses, 0.1 * other) for other in range(1, count)]
    assert len(set(slots)) == count - 1
    assert kept.bound(0, 17, slots[16], poses) == pytest.approx(1.7, abs=1e-8)
    assert (kept.slots(np.array([[0, 17]])) == -1).all()
