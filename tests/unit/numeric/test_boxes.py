"""Boxes that overlap against coal's, and elements that follow their nodes against NumPy."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.numeric.boxes import follow_nodes, overlapping_boxes

from tests.unit.world.builders import random_pose

coal: Any = import_module("coal")  # it comes with pinocchio and has no types


def test_boxes_overlap_where_coal_says_so(rng: np.random.Generator) -> None:
    """Each two of 60 elements of two blocks, by blocks; flat ones, needles and boxes side by side too."""
    count = 60
    poses = np.array([random_pose(rng) for _ in range(count)])
    poses[::5, :3, :3] = np.eye(3)
    centre, half = rng.uniform(-0.3, 0.3, (2 * count, 3)), rng.uniform(0.01, 0.3, (2 * count, 3))
    half[::7, 0] = 0.0
    half[::11, 1:] = 0.0
    asked = np.triu(np.ones((count, count), np.bool_), 1)
    first_block = np.arange(0, 2 * count + 1, 2)
    everywhere = np.zeros((count, 3)), np.full((count, 3), 10.0)
    boxes = poses, first_block, centre, half
    found, depths = np.empty((10, 4), np.int64), np.empty(10)
    needed = overlapping_boxes(np.arange(count), asked, *everywhere, *boxes, found, depths)
    assert needed > 10  # a result that has no room is told
    found, depths = np.empty((needed, 4), np.int64), np.empty(needed)
    assert overlapping_boxes(np.arange(count), asked, *everywhere, *boxes, found, depths) == needed
    ours = {(a, b) for _, _, a, b in found.tolist()}
    assert len(ours) == needed and {(i, j) for i, j, _, _ in found.tolist()} <= set(
        zip(*np.nonzero(asked), strict=True)
    )
    shapes = [coal.Box(*(2.0 * np.maximum(one, 1e-9))) for one in half]
    at = [poses[block // 2] @ _shift(centre[block]) for block in range(2 * count)]
    places = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in at]
    for i, j in np.argwhere(asked).tolist():
        for a in (2 * i, 2 * i + 1):
            for b in (2 * j, 2 * j + 1):
                result = coal.DistanceResult()
                far = coal.distance(shapes[a], places[a], shapes[b], places[b], coal.DistanceRequest(), result)
                assert ((a, b) in ours) == (far <= 0.0) or abs(far) < 1e-6


def test_only_what_is_asked_and_near_is_looked_at() -> None:
    """Boxes along the axes that do not meet part elements whose blocks would."""
    poses = np.array([np.eye(4)] * 3)
    blocks = np.array([0, 1, 2, 3]), np.zeros((3, 3)), np.ones((3, 3))
    asked = np.array([[False, True, True]])
    centre = np.array([[0.0, 0, 0], [3.0, 0, 0], [1.0, 0, 0]])
    found = np.empty((4, 4), np.int64)
    assert overlapping_boxes(np.array([0]), asked, centre, np.ones((3, 3)), poses, *blocks, found, np.empty(4)) == 1
    assert found[0].tolist() == [0, 2, 0, 2]


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 60])
def test_of_many_elements_those_are_found_whose_boxes_meet(rng: np.random.Generator, count: int) -> None:
    """Boxes along the axes, of some elements in any order against all 300, as NumPy compares each two."""
    centre, half = rng.uniform(-3.0, 3.0, (300, 3)), rng.uniform(0.0, 0.5, (300, 3))
    half[:40] = 5.0 * half[:40]
    poses = np.tile(np.eye(4), (300, 1, 1))
    poses[:, :3, 3] = centre
    own, asked = rng.permutation(300)[:count], rng.random((count, 300)) < 0.7
    blocks = np.arange(301), np.zeros((300, 3)), half
    found, depths = np.empty((20_000, 4), np.int64), np.empty(20_000)
    needed = overlapping_boxes(own, asked, centre, half, poses, *blocks, found, depths)
    apart = np.abs(centre[own, None] - centre) - (half[own, None] + half)
    wanted = np.argwhere(asked & (apart <= 0.0).all(axis=2))
    assert found[:needed, :2].tolist() == [[own[i], other] for i, other in wanted]
    assert depths[:needed] == pytest.approx([-apart[i, other].max() for i, other in wanted], abs=1e-8)


def test_elements_follow_their_nodes(rng: np.random.Generator) -> None:
    """Those of nodes that stand stay as they are, bit for bit."""
    before = np.array([random_pose(rng) for _ in range(6)])
    after = before.copy()
    after[[1, 4]] = [random_pose(rng), random_pose(rng)]
    rows = np.array([0, 1, 1, 3, 4])
    node_t_element = np.array([random_pose(rng) for _ in rows])
    local = rng.uniform(-1, 1, (5, 3)), rng.uniform(0, 1, (5, 3))
    world, centre, half = np.full((5, 4, 4), 7.0), np.full((5, 3), 7.0), np.full((5, 3), 7.0)
    moved = np.empty(5, np.int64)
    assert follow_nodes(after, before, rows, node_t_element, *local, world, centre, half, moved) == 3
    assert moved[:3].tolist() == [1, 2, 4]
    for element in range(5):
        if element in (0, 3):
            assert (world[element] == 7.0).all() and (centre[element] == 7.0).all() and (half[element] == 7.0).all()
            continue
        pose = after[rows[element]] @ node_t_element[element]
        np.testing.assert_allclose(world[element], pose, atol=1e-12)
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners = (local[0][element] + signs * local[1][element]) @ pose[:3, :3].T + pose[:3, 3]
        np.testing.assert_allclose(centre[element] - half[element], corners.min(axis=0), atol=1e-12)
        np.testing.assert_allclose(centre[element] + half[element], corners.max(axis=0), atol=1e-12)


def _shift(by: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = by
    return pose
