"""Paddings: elements that count as thicker touch where they are nearer than both paddings together."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
import pytest
from virtualrobot_kernel.collision.pairs import near_pairs
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.sampling import sample_touches
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.world.commands import CreateNodes, SetCollisionSettings
from virtualrobot_kernel.world.figures import Box, Sphere
from virtualrobot_kernel.world.state import Snapshot

from tests.tiers import Draws
from tests.unit.collision.solids import GEOMETRIES, distance_by_coal, near, placed
from tests.unit.collision.test_scene import body, mover
from tests.unit.collision.test_scene_truth import obstacles
from tests.unit.collision.worlds import SHAPES, after, scene_of, somewhere, with_robots, world
from tests.unit.world.builders import shifted

FAR = 10.0
STAND_IN = 2e-6
"""What flat triangles may leave of the curved sides of a cylinder and a cone of 0.1 m."""


def thicker(padding: tuple[float, ...], elements: Placed) -> Placed:
    """Return the same elements with paddings."""
    return Placed(elements.solids, elements.world_t_element, None, np.array(padding))


def two_balls(gap: float, **paddings: float) -> Snapshot:
    """Return a robot that is a ball at the origin and a ball of 0.2 m beside it, so far apart."""
    balls = (mover("robot", Sphere(0.2), shifted()), body("ball", Sphere(0.2), shifted(x=0.4 + gap)))
    return after(world(CreateNodes(balls)), SetCollisionSettings(paddings=tuple(paddings.items())))


@pytest.mark.parametrize(("one", "other"), tuple(combinations_with_replacement(GEOMETRIES, 2)))
def test_distances_are_without_the_paddings(rng: np.random.Generator, draws: Draws, one: str, other: str) -> None:
    """Of random pairs: what is nearer than both paddings touches, what isn't is so much nearer; points stay."""
    touched = 0
    for _ in range(draws(20)):
        poses = near(rng, 0.3), near(rng, 0.3)
        bare = [placed((GEOMETRIES[name], pose)) for name, pose in zip((one, other), poses, strict=True)]
        (true,) = near_pairs(bare[0], bare[1], FAR)
        paddings = rng.uniform(0.0, 0.2, 2)
        sides = [thicker((padding,), side) for padding, side in zip(paddings, bare, strict=True)]
        (pair,) = near_pairs(sides[0], sides[1], FAR)
        assert pair.distance == pytest.approx(max(true.distance - paddings.sum(), 0.0), abs=STAND_IN)
        found = near_pairs(sides[0], sides[1])
        assert bool(found) == (true.distance <= paddings.sum()) or abs(true.distance - paddings.sum()) < STAND_IN
        if found:
            touched += 1
            assert found[0].normal is not None and np.linalg.norm(found[0].normal) == pytest.approx(1.0)
        if true.distance > 0.0:
            # The points are those of the true surfaces; where several are equally near, any of them.
            assert np.linalg.norm(pair.points[1] - pair.points[0]) == pytest.approx(true.distance, abs=STAND_IN)
            if found:
                np.testing.assert_allclose(found[0].contacts, found[0].points.mean(axis=0)[None], atol=1e-12)
    assert touched


@pytest.mark.parametrize("detail", Detail)
def test_two_touch_where_they_are_nearer_than_both_paddings(detail: Detail) -> None:
    """Two balls 30 mm apart; a change of a padding is seen by a scene that follows."""
    scene = CollisionScene(SHAPES)
    for paddings, touch in (
        ({}, False),
        ({"ball": 0.029}, False),
        ({"ball": 0.031}, True),
        ({"robot": 0.02, "ball": 0.011}, True),
        ({"robot": 0.02, "ball": 0.009}, False),
    ):
        scene.place(two_balls(0.03, **paddings))
        assert bool(scene.collisions(detail)) == touch
        (nearest,) = scene.distances([2], [3], 0.0)
        assert nearest.distance == pytest.approx(max(0.03 - sum(paddings.values()), 0.0), abs=1e-12)
        np.testing.assert_allclose(nearest.points[:, 0], (0.2, 0.23), atol=1e-12)


def test_a_contact_of_what_is_padded_lies_between_the_true_surfaces() -> None:
    (found,) = scene_of(two_balls(0.03, robot=0.05)).collisions(Detail.CONTACTS)
    assert found.depth is not None and found.depth.meters == pytest.approx(0.02, abs=1e-7)
    (contacts,) = found.contacts
    np.testing.assert_allclose(contacts.points, [(0.215, 0.0, 0.0)], atol=1e-12)
    np.testing.assert_allclose(contacts.normal, (1.0, 0.0, 0.0), atol=1e-12)


def test_a_change_of_other_settings_keeps_the_bodies() -> None:
    """A mode that changes costs a scene nothing."""
    snapshot = two_balls(0.03, robot=0.01)
    scene = scene_of(snapshot)
    before = scene.bodies
    scene.place(after(snapshot, SetCollisionSettings(look_ahead_seconds=1.0)))
    assert scene.bodies is before
    scene.place(after(snapshot, SetCollisionSettings(paddings=(("robot", 0.0),))))
    assert scene.bodies is not before


def test_a_padded_arm_touches_what_coal_finds_nearer_than_that(rng: np.random.Generator) -> None:
    """Of an arm of meshes among primitives, at random configurations."""
    padding = 0.03
    bare = after(with_robots("iiwa"), obstacles(rng, 8))
    nodes = bare.structure.nodes
    links = [node.name for node in bare.structure.below(bare.structure.uid_by_name["iiwa"])]
    rest = [f"obstacle {place}" for place in range(8)]
    padded = after(bare, SetCollisionSettings(paddings=tuple((name, padding) for name in links)))
    scene, plain = scene_of(padded), scene_of(bare)
    uids = [[bare.structure.uid_by_name[name] for name in side] for side in (links, rest)]
    seen = 0
    count = 0
    while count < 30 or (not seen and count < 300):
        count += 1
        snapshot = somewhere(bare, rng)
        plain.place(snapshot)
        scene.place(replace(snapshot, state=replace(snapshot.state, collisions=padded.state.collisions)))
        gaps = {(pair.first, pair.second): pair.distance for pair in plain.distances(uids[0], uids[1], 1.0)}
        expected = {pair for pair, gap in gaps.items() if gap <= padding}
        found = {
            (pair.first, pair.second) for pair in scene.collisions(Detail.PAIRS) if nodes[pair.second].name in rest
        }
        unlike = found ^ expected
        assert all(abs(gaps[pair] - padding) < 1e-9 for pair in unlike)
        assert {
            (pair.first, pair.second) for pair in scene.collisions(Detail.CONTACTS) if nodes[pair.second].name in rest
        } == found
        assert bool(scene.collisions(Detail.FIRST)) == bool(scene.collisions(Detail.PAIRS))
        seen += len(expected - {pair for pair, gap in gaps.items() if gap == 0.0})
    assert seen > 0


def test_a_padded_cylinder_is_round(rng: np.random.Generator) -> None:
    """Its sides are triangles, which stand in by 2e-6 m; a nanometer decides all the same."""
    cylinder, wall = GEOMETRIES["cylinder"], Box((0.2, 3.0, 3.0))
    for angle in rng.uniform(0, 2 * np.pi, 20):
        turned = np.eye(4)
        turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        for spare, touch in ((-1e-9, False), (1e-9, True)):
            specs = (mover("robot", cylinder, turned), body("wall", wall, shifted(x=0.4)))
            padding = 0.2 + spare
            snapshot = after(world(CreateNodes(specs)), SetCollisionSettings(paddings=(("wall", padding),)))
            assert distance_by_coal(cylinder, turned, wall, shifted(x=0.4)) == pytest.approx(0.2, abs=1e-8)
            scene = scene_of(snapshot)
            assert bool(scene.collisions(Detail.PAIRS)) == touch
            assert bool(scene.collisions(Detail.CONTACTS)) == touch


def test_the_search_for_allowed_pairs_sees_paddings(rng: np.random.Generator) -> None:
    """A padding of half a meter makes links of an arm touch in each sample that hardly ever did."""
    bare = with_robots("iiwa")
    links = [node.name for node in bare.structure.below(bare.structure.uid_by_name["iiwa"])]
    padded = after(bare, SetCollisionSettings(paddings=tuple((name, 0.5) for name in links)))
    robot = bare.structure.robots[bare.structure.uid_by_name["iiwa"]]
    few, many = (
        sum(sample_touches(scene_of(each), each, robot, 5, rng, lambda _: True).counts.values())
        for each in (bare, padded)
    )
    assert many > few
