"""The collision scene against coal, which has whole meshes and asks every pair: 2,000 configurations, three robots."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision.scene import Detail
from virtualrobot_kernel.world.commands import CreateNodes, SetAllowedPairs
from virtualrobot_kernel.world.figures import Box, Capsule, Cylinder, Figure, Sphere
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.collision.worlds import (
    after,
    asked,
    coal_distances,
    coal_touches,
    scene_of,
    somewhere,
    with_robots,
)
from tests.unit.world.builders import random_pose

TOUCHING = 1e-6
"""Nearer than this, in meters, it is not said whether two touch: FCL's convex solver ends where it is so near."""


def obstacles(rng: np.random.Generator, count: int) -> CreateNodes:
    """Return primitives round a robot."""
    geometries = (Box((0.2, 0.3, 0.1)), Sphere(0.15), Cylinder(0.1, 0.4), Capsule(0.1, 0.3))
    specs = []
    for place in range(count):
        pose = random_pose(rng)
        pose[:2, 3] *= 0.7  # within the arm's reach
        pose[2, 3] = abs(pose[2, 3])
        figure = Figure(geometries[place % len(geometries)])
        specs.append(NodeSpec(f"obstacle {place}", Kind.OBJECT, parent_t_node=pose, figures=(figure,)))
    return CreateNodes(tuple(specs))


@pytest.mark.long
@pytest.mark.parametrize(("kind", "count"), [("iiwa", 800), ("panda", 800), ("xarm", 400)])
def test_touching_is_what_coal_finds(kind: str, count: int, rng: np.random.Generator) -> None:
    """The arm among obstacles, with itself too; pairs that always touch are allowed, or each sample would be one."""
    snapshot = after(with_robots(kind), obstacles(rng, 8))
    scene = scene_of(snapshot)
    nodes = snapshot.structure.nodes
    stuck = [(nodes[pair.first].name, nodes[pair.second].name, "") for pair in scene.collisions(Detail.PAIRS)]
    snapshot = after(snapshot, SetAllowedPairs(tuple(stuck)))
    scene.place(snapshot)
    pairs, answers = asked(scene), set()
    for _ in range(count):
        scene.place(somewhere(snapshot, rng))
        ours = {(pair.first, pair.second) for pair in scene.collisions(Detail.PAIRS)}
        theirs = coal_touches(scene, pairs)
        unlike = sorted(ours ^ theirs)
        assert [d for d in coal_distances(scene, unlike) if abs(d) > TOUCHING] == [], [nodes[i].name for i in unlike[0]]
        first = {(pair.first, pair.second) for pair in scene.collisions(Detail.FIRST)}
        assert first <= ours and len(first) == bool(ours)
        answers.add(frozenset(ours))
    assert len(answers) > 3


def test_distances_are_those_of_coal(rng: np.random.Generator) -> None:
    """Between an arm of meshes and boxes, spheres and capsules, to 1e-6 m."""
    snapshot = after(with_robots("iiwa"), obstacles(rng, 8))
    scene = scene_of(snapshot)
    robot = {node.uid for node in snapshot.structure.below(snapshot.structure.uid_by_name["iiwa"])}
    # A cylinder's side is cut into triangles where coal's is round: that is 2e-5 of its radius.
    rest = [
        uid
        for uid in scene.bodies.elements
        if uid not in robot and not isinstance(snapshot.structure.nodes[uid].figures[0].geometry, Cylinder)
    ]
    for _ in range(10):
        scene.place(somewhere(snapshot, rng))
        every = scene.distances(robot, rest, 10.0)
        expected = coal_distances(scene, [(pair.first, pair.second) for pair in every])
        assert len(every) == 8 * 6
        np.testing.assert_allclose([pair.distance for pair in every], np.maximum(expected, 0.0), atol=1e-6)
        for pair in every:
            assert np.linalg.norm(pair.points[1] - pair.points[0]) == pytest.approx(pair.distance, abs=1e-9)
        (nearest,) = scene.distances(robot, rest, 0.0)
        assert nearest.distance == every[0].distance
        near = every[20].distance
        assert [pair.distance for pair in scene.distances(robot, rest, near)] == [
            pair.distance for pair in every if pair.distance <= near
        ]
