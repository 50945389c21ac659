"""Trees that are said to stay apart do so on straight ways, by FCL; points leave straight ways by a bow at the most."""

from __future__ import annotations

from itertools import pairwise

import fcl
import numpy as np
import pytest
from virtualrobot_kernel.numeric.balls import ball_tree
from virtualrobot_kernel.numeric.forest import PRISMATIC, REVOLUTE, ROOT
from virtualrobot_kernel.numeric.motion_bounds import bow, corners_of
from virtualrobot_kernel.numeric.polynomials import bends_of, strays
from virtualrobot_kernel.numeric.straight_ways import trees_stay_apart
from virtualrobot_sdk.poses import rotation_matrix

from tests.tiers import Draws
from tests.unit.numeric.test_balls import SIZE, model_of, triangles_of
from tests.unit.numeric.test_sweeping import random_tree
from tests.unit.world.builders import random_pose

pytestmark = pytest.mark.long  # compiles what elsewhere goes into other functions

STEPS = 20
"""At so many places of each half of a way it is looked."""


def stay_apart(one: np.ndarray, other: np.ndarray, turns: np.ndarray, margin: float) -> bool:
    """Return what is said of triangles (n, 3, 3) that go from one of three places (3, 3, 4) to the next, and others."""
    last, side = np.full(2, -1), 0
    room = np.empty((512, 2), np.int64), np.empty((4, 3, 3)), np.empty((3, 3))
    trees = ball_tree(one, SIZE), one, ball_tree(other, SIZE), other
    said = trees_stay_apart(*trees, turns, margin, 1e9, last, side, *room)
    swapped = last[::-1].copy()
    assert trees_stay_apart(*trees, turns, margin, 1e9, swapped, 1 - side, *room) == said, "hints change nothing"
    return said


def distance_on(one: np.ndarray, other: np.ndarray, turns: np.ndarray) -> float:
    """Return the least distance (m) that FCL measures while each point goes straight from one place to the next."""
    still, least = model_of(other), np.inf
    places = [one @ turn[:, :3].T + turn[:, 3] for turn in turns]
    for begin, end in pairwise(places):
        for part in np.linspace(0.0, 1.0, STEPS):
            there = model_of(begin + part * (end - begin))
            least = min(least, fcl.distance(there, still, fcl.DistanceRequest(), fcl.DistanceResult()))
    return max(least, 0.0)


def test_what_stays_apart_fcl_measures_apart(rng: np.random.Generator, draws: Draws) -> None:
    told = 0
    for _ in range(draws(60)):
        one, other = triangles_of(rng, int(rng.integers(1, 6))), triangles_of(rng, int(rng.integers(1, 6)))
        turned, at, turns = rotation_matrix(rng.normal(size=3)), rng.uniform(-0.5, 0.5, 3), np.empty((3, 3, 4))
        for turn in turns:
            turn[:, :3] = rotation_matrix(rng.normal(scale=0.05, size=3)) @ turned
            turn[:, 3] = at + rng.normal(scale=0.05, size=3)
        least = distance_on(one, other, turns)
        assert not stay_apart(one, other, turns, least + 1e-6)
        if stay_apart(one, other, turns, 0.005):
            told += 1
            assert least > 0.005 - 1e-6
        apart = least > 0.1
        assert not apart or stay_apart(one, other, turns, 0.005), "balls of a centimetre tell what is so far apart"
    assert told


def test_a_plate_slides_over_another_one() -> None:
    """A plate that slides 20 cm at a distance of 1 mm stays farther than 0.99 mm, and not than 1.01 mm."""
    corners = np.array([[[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0]]])
    turns = np.zeros((3, 3, 4))
    turns[:, :, :3], turns[:, 2, 3], turns[:, 0, 3] = np.eye(3), 1e-3, (-0.1, 0.0, 0.1)
    assert stay_apart(corners, corners, turns, 0.99e-3)
    assert not stay_apart(corners, corners, turns, 1.01e-3)


def test_points_leave_straight_lines_by_no_more_than_a_bow(rng: np.random.Generator, draws: Draws) -> None:
    """Joints go by two cubics, with a jump of their speed where these meet; on even ways a bow is of second order."""
    greatest = 0.0
    for _ in range(draws(100)):
        tree, q = random_tree(rng, [REVOLUTE, PRISMATIC])
        pose, centre, half = random_pose(rng), rng.normal(0.0, 0.1, (1, 3)), rng.uniform(0.0, 0.2, (1, 3))
        row, k = len(tree.parent) - 1, len(q)
        breaks, terms = np.array([0.0, rng.uniform(0.2, 0.8), 1.0]), rng.normal(0.0, 0.2, (2, 4, k))
        even, bounds = rng.random() < 0.3, []
        if even:
            terms[1, 1], terms[:, 2:] = terms[0, 1], 0.0
        terms[0, 0] = q
        terms[1, 0] = np.einsum("p,pk->k", breaks[1] ** np.arange(4), terms[0])
        for length in (1.0, 0.5):
            ends = np.array([0.0, 0.4, 1.0]) * length
            u = np.concatenate([np.linspace(ends[0], ends[1], STEPS), np.linspace(ends[1], ends[2], STEPS)])
            piece = (u >= breaks[1]).astype(int)
            powers = (u - breaks[piece])[:, None] ** np.arange(4)
            way = np.einsum("up,upk->uk", powers, terms[piece])
            gone = np.abs(np.diff(way, axis=0))
            travel = np.maximum(gone[: STEPS - 1].sum(axis=0), gone[STEPS:].sum(axis=0))
            bends, stray = np.empty((2, 2, k)), np.empty(k)
            bends_of(breaks, terms, bends)
            strays(breaks, bends, ends, np.zeros(k), stray)
            halves = way[:STEPS], way[STEPS:]
            parts = np.linspace(0.0, 1.0, STEPS)[:, None]
            for one in halves:
                assert np.all(np.abs(one - (one[0] + parts * (one[-1] - one[0]))) <= stray + 1e-12)
            joint, astray = np.zeros((row + 1, 2)), np.zeros((row + 1, 2))
            for each in range(row + 1):
                if tree.joint_type[each] in (REVOLUTE, PRISMATIC):
                    column, place = 0 if tree.joint_type[each] == REVOLUTE else 1, tree.q_index[each]
                    joint[each, column] = abs(tree.multiplier[each]) * travel[place]
                    astray[each, column] = abs(tree.multiplier[each]) * stray[place]
            nodes = tree.poses(way[STEPS])
            corners, room = np.empty((8, 3)), np.empty(2)
            corners_of(0, row, nodes, (nodes[row] @ pose)[None], centre, half, corners, room)
            args = nodes, tree.parent, tree.joint_type, tree.axis, joint, astray, corners, room
            bound = bow(row, ROOT, *args)
            signs = np.array([[(corner >> axis & 1) * 2.0 - 1.0 for axis in range(3)] for corner in range(8)])
            local = np.column_stack([centre + signs * half, np.ones(8)])
            for one in halves:
                points = np.array([(tree.poses(at)[row] @ pose @ local.T).T[:, :3] for at in one])
                off = points - (points[0] + parts[:, :, None] * (points[-1] - points[0]))
                most = float(np.linalg.norm(off, axis=2).max())
                assert most <= bound + 1e-9
                greatest = max(greatest, most / bound if bound > 0.0 else 0.0)
            bounds.append(bound)
        if even:
            assert bounds[1] <= 0.3 * bounds[0]
    assert greatest > 0.1, "the bound is not far above what happens"
