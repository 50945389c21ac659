"""Depths against coal's, and of what there is none."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from virtualrobot_kernel.collision.depth import depth_of

from tests.unit.collision.solids import GEOMETRIES, distance_by_coal, near, placed

KNOWN = {("box", "box"), ("box", "sphere"), ("sphere", "sphere"), ("sphere", "capsule"), ("capsule", "capsule")}


@pytest.mark.parametrize(("one", "other"), list(combinations_with_replacement(GEOMETRIES, 2)))
def test_depths_are_those_of_coal_or_are_not_told(rng: np.random.Generator, one: str, other: str) -> None:
    """In both orders."""
    seen = 0
    for _ in range(40):
        pose, place = near(rng, 0.15), near(rng, 0.15)
        both = placed((GEOMETRIES[one], pose), (GEOMETRIES[other], place))
        depths = {depth_of(both, 0, 1), depth_of(both, 1, 0)}
        if (one, other) not in KNOWN:
            assert depths == {None}
            continue
        theirs = distance_by_coal(GEOMETRIES[one], pose, GEOMETRIES[other], place)
        if theirs < -1e-4:
            seen += 1
            for depth in depths:
                assert depth == pytest.approx(-theirs, abs=1e-6)
    assert (seen > 5) == ((one, other) in KNOWN)
