"""Bounds for swept checks: no point goes farther than is told, no two boxes are nearer, on random trees and places."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.numeric.distance_bounds import box_gaps, cached_distance_bounds
from virtualrobot_kernel.numeric.forest import (
    FIXED,
    FLOATING,
    PLANAR,
    PRISMATIC,
    REVOLUTE,
    forward_forest,
    topological_order,
)
from virtualrobot_kernel.numeric.motion_bounds import element_travels, joint_travels
from virtualrobot_kernel.numeric.sweeping import boxes_in_reach, pairs_in_reach

from tests.unit.world.builders import random_pose, unit

WIDTHS = {FIXED: 0, REVOLUTE: 1, PRISMATIC: 1, FLOATING: 7, PLANAR: 3}


class Tree(NamedTuple):
    """A forest of n rows, as `forward_forest` takes it."""

    order: np.ndarray
    parent: np.ndarray
    joint_type: np.ndarray
    axis: np.ndarray
    q_index: np.ndarray
    multiplier: np.ndarray
    offset: np.ndarray
    parent_t_node: np.ndarray

    def poses(self, q: np.ndarray) -> np.ndarray:
        """Return the world poses of the rows."""
        out = np.empty((len(self.parent), 4, 4))
        forward_forest(*self, q, out)
        return out


def random_tree(rng: np.random.Generator, kinds: list[int], rows: int = 9) -> tuple[Tree, np.ndarray]:
    """Return a random tree of such joints, two of them mimics where they may be, and coordinates."""
    parent = np.array([-1, *(rng.integers(max(0, row - 3), row) for row in range(1, rows))], np.int32)
    types = rng.choice([FIXED, *kinds], rows).astype(np.int8)
    starts = np.cumsum([0, *(WIDTHS[kind] for kind in types.tolist())])
    q_index = starts[:-1].astype(np.int32)
    multiplier, offset = np.ones(rows), np.zeros(rows)
    for kind in (REVOLUTE, PRISMATIC):
        same = np.flatnonzero(types == kind)
        if len(same) > 1:
            q_index[same[-1]] = q_index[same[0]]
            multiplier[same[-1]], offset[same[-1]] = rng.uniform(-2.0, 2.0, 2)
    axis = np.array([unit(rng) for _ in range(rows)])
    place = np.array([random_pose(rng) for _ in range(rows)])
    place[:, :3, 3] *= 0.3
    return Tree(topological_order(parent), parent, types, axis, q_index, multiplier, offset, place), rng.normal(
        size=max(1, starts[-1])
    )


def wandering(rng: np.random.Generator, q: np.ndarray, steps: int = 200) -> np.ndarray:
    """Return a way (m, nq) that goes forth and back, and stands with some coordinates."""
    phase, speed = rng.uniform(0.0, 7.0, (2, len(q)))
    size = rng.uniform(0.0, 1.0, len(q)) * (rng.random(len(q)) < 0.7)
    time = np.linspace(0.0, 1.0, steps)[:, None]
    return q + size * (np.sin(phase + speed * time) - np.sin(phase))


class Swept(NamedTuple):
    """Elements on the rows of a tree that goes a way, and what is told of it."""

    ways: np.ndarray
    """(m, e, 8, 3) where the corners of each element's box are."""
    nodes: np.ndarray
    """(m, e, 4, 4) where its row is."""
    parent: np.ndarray
    travels: np.ndarray
    pairs: np.ndarray
    against: np.ndarray


NOTHING_KEPT = np.zeros((1, 1, 3, 4)), np.full((1, 1), -1.0)


def travels_of(pairs: np.ndarray, at: Any, depth: np.ndarray, boxes: Any) -> np.ndarray:  # noqa: ANN401 tuples of arrays
    """Return how far pairs (k, 2) go together, where nothing is known that would leave any out; 0 for none."""
    rows, poses, centre, half = boxes
    blocks = np.arange(len(rows) + 1), centre, half
    ends = (poses, centre, half, np.full(len(pairs), -1.0), np.full(len(pairs), 3, np.int8))
    left, travels, found = np.empty(len(pairs), np.int64), np.empty(len(pairs)), np.zeros(len(pairs))
    every, slots = np.arange(len(pairs)), np.full(len(pairs), -1)
    tree = (*at, depth, rows, centre, half)
    count = pairs_in_reach(every, pairs, slots, *tree, *blocks, *NOTHING_KEPT, *ends, *ends, np.inf, 1.0, left, travels)
    found[left[:count]] = travels[:count]
    return found


def swept(rng: np.random.Generator, kinds: list[int]) -> Swept:
    """Return a random tree with a box on each row, and the bounds told at a random place of a random way."""
    tree, start = random_tree(rng, kinds)
    way = wandering(rng, start)
    travel = np.abs(np.diff(way, axis=0)).sum(axis=0)
    rows = len(tree.parent)
    joint, moving = np.zeros((rows, 2)), np.zeros(rows, np.bool_)
    depth, moved = np.zeros(rows, np.int32), np.zeros(rows, np.int32)
    coordinates = tree.joint_type, tree.q_index, tree.multiplier
    count = joint_travels(tree.order, tree.parent, *coordinates, travel, way[0], way[-1], joint, moving, depth, moved)
    assert sorted(moved[:count].tolist()) == np.flatnonzero(moving).tolist()
    nodes = np.array([tree.poses(q) for q in way])
    local = np.array([random_pose(rng) for _ in range(rows)])
    centre, half = rng.normal(size=(rows, 3)) * 0.2, rng.uniform(0.0, 0.3, (rows, 3))
    poses = nodes @ local
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = centre[:, None] + signs * half[:, None]
    ways = np.einsum("meij,ecj->meci", poses[:, :, :3, :3], corners) + poses[:, :, None, :3, 3]
    place = int(rng.integers(len(way)))
    at = nodes[place], tree.parent, tree.joint_type, tree.axis, joint, moving
    boxes = np.arange(rows), poses[place].copy(), centre, half
    travels = np.empty(rows)
    element_travels(*at, *boxes, travels)
    pairs = np.array([(one, other) for one in range(rows) for other in range(one)])
    against = travels_of(pairs, at, depth, boxes)
    return Swept(ways, nodes, tree.parent, travels, pairs, against)


def carrier(parent: np.ndarray, one: int, other: int) -> int:
    """Return the lowest row that is at or above both; -1: the world."""
    above = []
    while one >= 0:
        above.append(one)
        one = int(parent[one])
    while other >= 0 and other not in above:
        other = int(parent[other])
    return other


def length(way: np.ndarray) -> np.ndarray:
    """Return how long ways (m, ..., 3) are."""
    return np.linalg.norm(np.diff(way, axis=0), axis=-1).sum(axis=0)


@pytest.mark.parametrize(
    "kinds",
    [[REVOLUTE], [REVOLUTE, PRISMATIC], [PLANAR, REVOLUTE], [FLOATING, REVOLUTE], [FLOATING, PLANAR, PRISMATIC]],
)
def test_no_corner_goes_farther_than_told(kinds: list[int], rng: np.random.Generator) -> None:
    """In the world, and two seen from what carries both, which is how much nearer they can come to each other."""
    tight = []
    for _ in range(12):  # of those with floating joints one in four has no tight bound
        told = swept(rng, kinds)
        gone = length(told.ways)
        assert (gone.max(axis=1) <= told.travels + 1e-9).all()
        for (one, other), bound in zip(told.pairs.tolist(), told.against.tolist(), strict=True):
            row = carrier(told.parent, one, other)
            frame = told.nodes[:, row] if row >= 0 else np.tile(np.eye(4), (len(told.nodes), 1, 1))
            seen = told.ways[:, [one, other]] - frame[:, None, None, :3, 3]
            assert length(np.einsum("mji,mecj->meci", frame[:, :3, :3], seen)).max(axis=1).sum() <= bound + 1e-9
            assert bound <= told.travels[one] + told.travels[other] + 1e-9
        moved = told.travels > 0.0
        assert (gone[~moved] == 0.0).all()
        tight += (gone.max(axis=1)[moved] / told.travels[moved]).tolist()
    assert max(tight) > 0.2


def test_one_joint_is_told_exactly() -> None:
    """A point 2 m from a hinge goes 2 m a radian; on a slider, what this goes; a rigid neighbour sees nothing."""
    for kind, expected in ((REVOLUTE, 1.0), (PRISMATIC, 0.5)):
        tree = Tree(
            np.array([0, 1], np.int32),
            np.array([-1, 0], np.int32),
            np.array([kind, FIXED], np.int8),
            np.tile([0.0, 0.0, 1.0], (2, 1)),
            np.zeros(2, np.int32),
            np.ones(2),
            np.zeros(2),
            np.tile(np.eye(4), (2, 1, 1)),
        )
        joint, moving = np.zeros((2, 2)), np.zeros(2, np.bool_)
        depth, moved = np.zeros(2, np.int32), np.zeros(2, np.int32)
        half_way = np.array([0.5])
        coordinates = tree.joint_type, tree.q_index, tree.multiplier
        places = np.zeros(1), half_way
        assert joint_travels(tree.order, tree.parent, *coordinates, half_way, *places, joint, moving, depth, moved) == 2
        elements = np.tile(np.eye(4), (2, 1, 1))
        elements[:, 0, 3] = 2.0
        at: Any = (tree.poses(np.zeros(1)), tree.parent, tree.joint_type, tree.axis, joint, moving)
        boxes = np.arange(2), elements, np.zeros((2, 3)), np.zeros((2, 3))
        travels = np.empty(2)
        element_travels(*at, *boxes, travels)
        np.testing.assert_allclose(travels, expected)
        assert travels_of(np.array([[0, 1]]), at, depth, boxes)[0] == 0.0


def test_boxes_in_reach_are_those_that_both_ways_bridge(rng: np.random.Generator) -> None:
    """Compared with all pairs; more than there is room for are counted; what stands still meets nothing."""
    count = 40
    centre, half = rng.uniform(-2.0, 2.0, (count, 3)), rng.uniform(0.0, 0.3, (count, 3))
    travel = rng.uniform(0.0, 0.5, count) * (rng.random(count) < 0.5)
    own, asked = np.arange(0, count, 3), rng.random((14, count)) < 0.8
    gap = np.maximum(np.abs(centre[own, None] - centre[None]) - half[own, None] - half[None], 0.0)
    both = travel[own, None] + travel[None]
    near = asked & (np.linalg.norm(gap, axis=2) <= both) & (both > 0.0)
    expected = [(int(own[i]), int(j)) for i, j in np.argwhere(near)]
    found = np.empty((count * count, 2), np.int64)
    end = boxes_in_reach(own, asked, centre, half, travel, found, 5)
    assert [tuple(pair) for pair in found[5:end].tolist()] == expected
    assert boxes_in_reach(own, asked, centre, half, travel, np.empty((3, 2), np.int64), 0) == len(expected)


def cloud(rng: np.random.Generator, centre: np.ndarray, half: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Return points of a box at a pose: its corners and others, of which a third are on its surface."""
    share = rng.uniform(-1.5, 1.5, (120, 3)).clip(-1.0, 1.0)
    share[:8] = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return (centre + share * half) @ pose[:3, :3].T + pose[:3, 3]


def bound_by_blocks(poses: np.ndarray, first_block: np.ndarray, centre: np.ndarray, half: np.ndarray) -> float:
    """Return what is found out of two elements' distance when one of them goes far."""
    tree = np.full(2, -1, np.int32), np.zeros(2, np.int8), np.zeros((2, 3))
    going = np.array([[0.0, 100.0], [0.0, 0.0]]), np.array([True, False]), np.zeros(2, np.int32)
    boxes = np.zeros((2, 3)), np.full((2, 3), 100.0)
    ends = [(poses, *boxes, np.zeros(1), np.zeros(1, np.int8)) for _ in (0, 1)]
    one, left, travels = np.zeros(1, np.int64), np.empty(1, np.int64), np.empty(1)
    rest = np.arange(2), *boxes, first_block, centre, half, *NOTHING_KEPT
    count = pairs_in_reach(
        one, np.array([[0, 1]]), one - 1, poses, *tree, *going, *rest, *ends[0], *ends[1], np.inf, 1.0, left, travels
    )
    assert (count, travels[0]) == (1, 100.0)
    assert ends[0][4].tolist() == [2]
    assert ends[0][3] == ends[1][3]
    return float(ends[0][3][0])


def test_boxes_are_never_nearer_than_told(rng: np.random.Generator) -> None:
    """Against the nearest of many points, single boxes and blocks of elements that move; parallel ones exactly."""
    for _ in range(30):
        poses = np.array([random_pose(rng), random_pose(rng)])
        centre, half = rng.normal(size=(5, 3)) * 0.3, rng.uniform(0.01, 0.4, (5, 3))
        points = [cloud(rng, centre[box], half[box], poses[0 if box < 2 else 1]) for box in range(5)]
        gaps = np.empty((2, 3))
        box_gaps(0, 1, poses, centre[:2], half[:2], centre[2:], half[2:], gaps)
        near = [[np.linalg.norm(a[:, None] - b[None], axis=2).min() for b in points[2:]] for a in points[:2]]
        assert (gaps <= np.array(near)).all()
        assert gaps.min() - 1e-9 <= bound_by_blocks(poses, np.array([0, 2, 5]), centre, half) <= np.min(near)
    turn = np.tile(random_pose(rng), (2, 1, 1))
    turn[1, :3, 3] = turn[0, :3, 3] + turn[0, :3, :3] @ [3.0, 4.0, 0.0]
    gap, small = np.empty((1, 1)), np.full((1, 3), 0.5)
    box_gaps(0, 1, turn, np.zeros((1, 3)), small, np.zeros((1, 3)), small, gap)
    assert gap[0, 0] == pytest.approx(np.hypot(2.0, 3.0), abs=1e-8)


def test_a_remembered_distance_holds_less_what_has_moved(rng: np.random.Generator) -> None:
    """Two boxes' points at another place are never nearer than told; at the same place it is the distance itself."""
    told = []
    for _ in range(100):
        poses = np.array([random_pose(rng), random_pose(rng)])
        centre, half = rng.normal(size=(2, 3)) * 0.3, rng.uniform(0.01, 0.4, (2, 3))
        points = [rng.uniform(-1.0, 1.0, (60, 3)) * half[box] + centre[box] for box in (0, 1)]

        def distance(at: np.ndarray, points: list[np.ndarray] = points) -> float:
            ours, theirs = (own @ pose[:3, :3].T + pose[:3, 3] for own, pose in zip(points, at, strict=True))
            return float(np.linalg.norm(ours[:, None] - theirs[None], axis=2).min())

        kept = (np.linalg.inv(poses[0]) @ poses[1])[None, None, :3].copy()
        pairs, slots, found = np.array([[0, 1], [0, 1]]), np.array([0, -1]), np.empty(2)
        measured = np.array([[distance(poses)]])
        cached_distance_bounds(pairs, slots, poses, centre, half, kept, measured, found)
        np.testing.assert_allclose(found, [measured[0, 0], 0.0], atol=1e-8)
        both = random_pose(rng)
        moved = np.array([both @ poses[0], both @ poses[1]])
        cached_distance_bounds(pairs, slots, moved, centre, half, kept, measured, found)
        assert found[0] == pytest.approx(measured[0, 0], abs=1e-8)
        step = np.eye(4)
        step[:3, :3] = Rotation.from_rotvec(rng.normal(size=3) * 0.1).as_matrix()
        step[:3, 3] = rng.normal(size=3) * 0.05
        moved[1] = moved[1] @ step
        cached_distance_bounds(pairs, slots, moved, centre, half, kept, measured, found)
        assert found[0] <= distance(moved)
        told.append(found[0] > 0.0)
    assert any(told)
