"""Pairs against formulas, coal and trimesh: what touches, how far the rest is apart, and where."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
import trimesh
from virtualrobot_kernel.collision.pairs import near_pairs
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.tessellation import SEGMENTS
from virtualrobot_kernel.world.figures import Box, Cylinder, Sphere

from tests.unit.collision.solids import GEOMETRIES, TORUS, distance_by_coal, near, placed, torus
from tests.unit.world.builders import random_pose, shifted

FAR = 10.0
EVERYWHERE = float("inf")
CURVED = {"cylinder", "cone"}
EXACT = 1e-8
"""What coal's convex solver leaves, and more than ours."""
NEAR = 1e-4
"""At distances below this (m) it leaves more."""
STAND_IN = (np.pi / SEGMENTS) ** 2 / 2 * 0.1
"""Of the cylinder and the cone, whose radius is 0.1 m; of two of them, twice as much."""


@pytest.mark.parametrize(("one", "other"), tuple(combinations_with_replacement(GEOMETRIES, 2)))
def test_distances_and_touches_agree_with_coal(rng: np.random.Generator, one: str, other: str) -> None:
    tolerance = EXACT + STAND_IN * len([name for name in (one, other) if name in CURVED])
    apart = 0
    for _ in range(25):
        pose, place = near(rng), near(rng)
        theirs = distance_by_coal(GEOMETRIES[one], pose, GEOMETRIES[other], place)
        first, second = placed((GEOMETRIES[one], pose)), placed((GEOMETRIES[other], place))
        (pair,) = near_pairs(first, second, FAR)
        if theirs > NEAR:
            apart += 1
            assert pair.normal is None
            assert -EXACT <= pair.distance - theirs <= tolerance
            # The points are as far apart as they are said to be, and each is on its own figure.
            assert np.linalg.norm(pair.points[1] - pair.points[0]) == pytest.approx(pair.distance, abs=1e-12)
            for geometry, at, point in zip((one, other), (pose, place), pair.points, strict=True):
                dot = distance_by_coal(GEOMETRIES[geometry], at, Sphere(1e-5), shifted(*point))
                assert dot <= 1e-8 and (geometry in ("torus", *CURVED) or dot >= -3e-5)
        elif theirs < -1e-6 or (theirs <= 0.0 and {one, other} == {"torus"}):
            assert pair.distance == 0.0
            assert pair.normal is not None and np.linalg.norm(pair.normal) == pytest.approx(1.0)
            assert len(pair.contacts) >= 1
    assert apart >= 3


def test_boxes_corner_to_corner() -> None:
    (pair,) = near_pairs(
        placed((Box((0.2, 0.4, 0.6)), np.eye(4))), placed((Box((0.2, 0.2, 0.2)), shifted(1, 1, 1))), FAR
    )
    np.testing.assert_allclose(pair.points, [(0.1, 0.2, 0.3), (0.9, 0.9, 0.9)], atol=1e-9)
    assert pair.distance == pytest.approx(np.sqrt(0.8**2 + 0.7**2 + 0.6**2), abs=1e-9)


def test_points_on_a_mesh_agree_with_trimesh(rng: np.random.Generator) -> None:
    """From a small sphere: the nearest point of all triangles, by another library."""
    vertices, faces = torus()
    triangles = vertices.astype(np.float64)[faces]
    pose = random_pose(rng)
    for _ in range(20):
        local = rng.uniform(-1, 1, 3)
        points = trimesh.triangles.closest_point(triangles, np.tile(local, (len(triangles), 1)))
        distances = np.linalg.norm(points - local, axis=1)
        nearest, distance = points[distances.argmin()], distances.min()
        place = shifted(*(pose[:3, :3] @ local + pose[:3, 3]))
        (pair,) = near_pairs(placed((TORUS, pose)), placed((Sphere(1e-3), place)), FAR)
        if distance < 1e-3:
            continue
        assert pair.distance == pytest.approx(distance - 1e-3, abs=1e-9)
        np.testing.assert_allclose(pair.points[0], pose[:3, :3] @ nearest + pose[:3, 3], atol=1e-7)


def test_only_pairs_within_the_range_are_told(rng: np.random.Generator) -> None:
    """Against all distances; the broad phase must not leave one out."""
    names = list(GEOMETRIES)
    first = [(GEOMETRIES[names[i % 6]], near(rng, 0.9)) for i in range(8)]
    second = [(GEOMETRIES[names[i % 5]], near(rng, 0.9)) for i in range(9)]
    limit = 0.6
    every = near_pairs(placed(*first), placed(*second), EVERYWHERE)
    assert len(every) == 72
    some = near_pairs(placed(*first), placed(*second), limit)
    expected = [(pair.first, pair.second, pair.distance) for pair in every if pair.distance <= limit]
    assert sorted((pair.first, pair.second, pair.distance) for pair in some) == sorted(expected)
    distances = [pair.distance for pair in some]
    assert distances == sorted(distances) and 0 < len(distances) < 72
    touching = near_pairs(placed(*first), placed(*second))
    assert [pair.distance for pair in touching] == [0.0] * distances.count(0.0)


def test_what_moved_is_elsewhere(rng: np.random.Generator) -> None:
    elements = [(geometry, near(rng, 1.0)) for geometry in GEOMETRIES.values()]
    moved = [(geometry, near(rng, 1.0) if i % 2 else pose) for i, (geometry, pose) in enumerate(elements)]
    probe = placed((Box((0.1, 0.1, 0.1)), near(rng)))
    followed = placed(*elements)
    followed.move(np.array([pose for _, pose in moved]))
    for ours, theirs in zip(near_pairs(probe, followed, FAR), near_pairs(probe, placed(*moved), FAR), strict=True):
        assert (ours.second, ours.distance) == (theirs.second, theirs.distance)


def test_objects_are_taken_over_where_the_solids_are_the_same(rng: np.random.Generator) -> None:
    """More of one kind, others gone, all elsewhere: as if made anew."""
    old = placed(*((GEOMETRIES[name], near(rng)) for name in ("box", "box", "torus", "cone", "sphere")))
    elements = [(GEOMETRIES[name], near(rng)) for name in ("torus", "box", "capsule", "box", "box", "cone")]
    new = placed(*elements)
    kept = {id(old.piece(row)) for row in range(old.first_piece[-1])}
    taken = Placed(new.solids, new.world_t_element, old)
    probe = placed((Box((0.1, 0.1, 0.1)), near(rng)))
    for ours, theirs in zip(near_pairs(probe, taken, FAR), near_pairs(probe, new, FAR), strict=True):
        assert (ours.second, ours.distance) == (theirs.second, theirs.distance)
    assert (
        sum(id(taken.piece(row)) in kept for row in range(taken.first_piece[-1])) == old.first_piece[4]
    )  # all but the sphere


def test_nothing_is_near_nothing() -> None:
    box = placed((Box((1, 1, 1)), np.eye(4)))
    assert near_pairs(placed(), box, FAR) == near_pairs(box, placed(), FAR) == near_pairs(placed(), placed()) == []


def test_a_cylinder_is_round(rng: np.random.Generator) -> None:
    """Beside a box's face, where flat sides would stand in by most."""
    radius = 0.4
    for angle in rng.uniform(0, 2 * np.pi, 10):
        turned = np.eye(4)
        turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        (pair,) = near_pairs(
            placed((Cylinder(radius, 1.0), turned)), placed((Box((0.2, 3.0, 3.0)), shifted(x=0.7))), FAR
        )
        assert 0.0 <= pair.distance - 0.2 <= (np.pi / SEGMENTS) ** 2 / 2 * radius
