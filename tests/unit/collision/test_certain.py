"""Configurations and ways that balls call certainly free FCL calls free; what touches is in doubt."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.collision.certain import CertainlyFree, room_of
from virtualrobot_kernel.collision.joint_path import of_path
from virtualrobot_kernel.collision.node_pairs import moves
from virtualrobot_kernel.collision.pairs import least_distance
from virtualrobot_kernel.collision.swept import RESOLUTION, first_contact
from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.planning.robots import arm_of, standing_at
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Geometry, Sphere
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.tiers import Draws, every_fifth
from tests.unit.collision.worlds import after, scene_of, with_robots
from tests.unit.world.builders import shifted

NEAR = 2e-3
"""So near are two places of a way of about a metre, of length 1, where things that graze each other begin to touch."""


ROUND = 2e-3
"""Greatest difference (m) of balls and FCL at round figures: these are triangles to balls, thicker by their error."""


def crowded(kind: str, rng: np.random.Generator) -> Snapshot:
    """Return an arm among figures of all kinds, some of them large enough to have a link inside."""
    figures: list[Geometry] = []
    for _ in range(3):
        a, b = rng.uniform(0.05, 0.3, 2)
        figures += [Box((a, b, 2.0 * a)), Sphere(a), Capsule(0.5 * a, b), Cylinder(a, b), Cone(a, b)]
    figures.append(Box((0.9, 0.9, 0.9)))
    specs = []
    for number, one in enumerate(figures):
        away, angle = rng.uniform(0.35, 0.7) + (0.45 if number == len(figures) - 1 else 0.1), rng.uniform(-np.pi, np.pi)
        pose = shifted(x=away * np.cos(angle), y=away * np.sin(angle), z=rng.uniform(0.0, 1.2))
        specs.append(NodeSpec(f"thing {number}", Kind.OBJECT, "world", pose, figures=(Figure(one),)))
    return after(with_robots(kind), CreateNodes(tuple(specs)))


@pytest.mark.parametrize("kind", every_fifth(["iiwa", "panda", "xarm"]))
def test_what_is_certain_is_free(kind: str, rng: np.random.Generator, draws: Draws) -> None:
    snapshot = crowded(kind, rng)
    robot = snapshot.structure.node(kind, Kind.ROBOT)
    arm, scene = arm_of(snapshot, robot), scene_of(snapshot)
    chain = arm.serial()
    moved = standing_at(snapshot, arm.q_index, snapshot.state.q[arm.q_index] + np.linspace(0.1, 0.7, len(arm.q_index)))
    balls = CertainlyFree(scene, snapshot, arm.q_index, {robot.uid}, partial(moves, snapshot, moved))
    lower, upper = np.maximum(chain.lower, -np.pi), np.minimum(chain.upper, np.pi)
    configurations = rng.uniform(lower, upper, (draws(200), len(lower)))
    certain = balls.places(configurations)
    # What stands and touches already is no matter of the arm's: pairs that are asked move on its ways.
    counted = {tuple(sorted(pair)) for pair in scene.bodies.uids[balls.pairs].tolist()}
    free = []
    for q in configurations:
        scene.place(standing_at(snapshot, arm.q_index, q))
        free.append(not scene.touching({robot.uid}) & counted)
    assert np.all(np.array(free)[certain])
    assert certain.sum() > 0.5 * np.sum(free), "balls are but a little larger than what they are around"
    room = room_of(lower, upper, np.zeros((0, len(lower))), np.zeros(0), np.zeros(0))
    for q in configurations[certain][: draws(2)]:
        scene.place(standing_at(snapshot, arm.q_index, q))
        nearest = min(least_distance(scene.placed, one, other, np.inf) for one, other in balls.pairs.tolist())
        assert not balls.line(room, q, q, 0.1, nearest + ROUND)
        assert nearest < ROUND or balls.line(room, q, q, 0.1, nearest - ROUND)
    proven = 0
    ends = configurations[np.array(free)][: draws(25) + 1]
    for begin, end in pairwise(ends):
        end = begin + 0.5 * (end - begin)
        path = of_path(snapshot.state.q, arm.q_index, joint_line(begin, end))
        doubtful = list(balls.doubts(path, 0.5 * RESOLUTION))
        # A way that balls don't know of is halved until FCL has measured all that is near.
        contact = first_contact(scene, snapshot, replace(path, pieces=()), robots={robot.uid})
        if contact is not None:
            # Either tells a contact by the resolution before it.
            assert any(since - NEAR <= contact.time <= until + NEAR for since, until in doubtful)
        proven += not doubtful
        assert np.all(np.diff(np.ravel(doubtful)) >= 0.0)
        known = first_contact(scene, snapshot, path, robots={robot.uid})
        assert (known is None) == (contact is None)
        if contact is not None and known is not None:
            assert (known.first, known.second) == (contact.first, contact.second)
            assert abs(known.time - contact.time) <= NEAR
    assert proven
