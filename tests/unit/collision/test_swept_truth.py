"""The swept check against coal on real robots with meshes: no contact is missed, and what is free is free.

coal has whole meshes and asks every pair; it comes with the development dependencies.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.collision.joint_path import JointPath, line
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.collision.swept import first_contact
from virtualrobot_kernel.world.commands import CreateNodes, SetAllowedPairs
from virtualrobot_kernel.world.figures import Box, Capsule, Cylinder, Figure, Sphere
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.collision.worlds import (
    after,
    asked,
    coal_distances,
    coal_touches,
    pictured,
    scene_of,
    somewhere,
    with_robots,
)
from tests.unit.world.builders import random_pose

RESOLUTION = 1e-3
"""What comes nearer than this, in meters, may be told as a contact."""

FLAT = 2e-5
"""Sides of cylinders of 1 m radius stand in so far."""


def cell(kind: str, rng: np.random.Generator) -> Snapshot:
    """Return a robot among obstacles, some of them thin; what touches as it stands, or nearly, is allowed."""
    geometries = (Box((0.2, 0.3, 1e-3)), Sphere(0.05), Cylinder(0.01, 0.8), Capsule(0.1, 0.3), Box((0.1, 0.1, 0.1)))
    specs = []
    for place in range(8):
        pose = random_pose(rng)
        pose[2, 3] = abs(pose[2, 3])
        specs.append(
            NodeSpec(f"obstacle {place}", Kind.OBJECT, parent_t_node=pose, figures=(Figure(geometries[place % 5]),))
        )
    snapshot = after(with_robots(kind), CreateNodes(tuple(specs)))
    scene = scene_of(snapshot)
    nodes = snapshot.structure.nodes
    arm = {uid for uid in scene.bodies.elements if not nodes[uid].name.startswith("obstacle")}
    # What stands that near to a link that only turns about itself would be a contact wherever the arm is.
    near = scene.distances(arm, scene.bodies.elements.keys() - arm, 2.0 * RESOLUTION)
    pairs = {(pair.first, pair.second) for pair in (*scene.collisions(Detail.PAIRS), *near)}
    return after(snapshot, SetAllowedPairs(tuple((nodes[one].name, nodes[other].name, "") for one, other in pairs)))


def at(snapshot: Snapshot, path: JointPath, time: float) -> Snapshot:
    """Return the world at a time of a way."""
    return pictured(snapshot.structure, replace(snapshot.state, q=path.at(time)))


def drawn(snapshot: Snapshot, scene: CollisionScene, rng: np.random.Generator, collides: bool) -> np.ndarray:
    """Return random joints that collide or don't, by the scene, which `test_scene_truth` compares with coal."""
    while True:
        there = somewhere(snapshot, rng)
        scene.place(there)
        if bool(scene.collisions(Detail.FIRST)) == collides:
            return there.state.q


@pytest.mark.parametrize(("kind", "count"), [("iiwa", 600), ("panda", 300), ("xarm", 100)])
@pytest.mark.long
def test_no_contact_is_missed(kind: str, count: int, rng: np.random.Generator) -> None:
    """On ways from a free place to one that collides, the first contact is found no later than any that coal sees.

    Where it is told the pair is nearer than the resolution, and nothing touches before, at two random times.
    """
    snapshot = cell(kind, rng)
    scene, sampler = scene_of(snapshot), scene_of(snapshot)
    pairs, between = asked(scene), 0
    for _ in range(count):
        places = [drawn(snapshot, sampler, rng, collides) for collides in (False, True)]
        path = line(places[0], places[1])
        found = first_contact(scene, snapshot, path, resolution=RESOLUTION)
        assert found is not None
        assert found.time <= 1.0
        between += 0.0 < found.time < 1.0
        sampler.place(at(snapshot, path, found.time))
        assert coal_distances(sampler, [(found.first, found.second)])[0] <= RESOLUTION + FLAT
        for time in rng.uniform(0.0, found.time, 2):
            sampler.place(at(snapshot, path, time))
            assert coal_touches(sampler, pairs) == set()
    assert between > 0.5 * count


@pytest.mark.long
@pytest.mark.parametrize("kind", ["iiwa", "panda"])
def test_what_is_told_free_is_free(kind: str, rng: np.random.Generator) -> None:
    """Ways long and short: where no contact is found coal finds none at sixteen random times."""
    snapshot = cell(kind, rng)
    scene, sampler = scene_of(snapshot), scene_of(snapshot)
    pairs, free = asked(scene), 0
    for share in (0.02, 0.1, 0.3, 1.0) * 20:
        start, goal = drawn(snapshot, sampler, rng, False), somewhere(snapshot, rng).state.q
        path = line(start, start + share * (goal - start))
        if first_contact(scene, snapshot, path) is None:
            free += 1
            for time in rng.uniform(0.0, 1.0, 16):
                sampler.place(at(snapshot, path, time))
                assert coal_touches(sampler, pairs) == set()
    assert free > 10
