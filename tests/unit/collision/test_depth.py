"""Depths against formulas, coal and what they say: moved by it, two only touch."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pytest
import trimesh
from virtualrobot_kernel.collision.depth import TOLERANCE, Depth, depth_of
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.outline import CORNERS, outline_of
from virtualrobot_kernel.collision.pairs import pair_within
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.scene import Detail
from virtualrobot_kernel.collision.tessellation import box_triangles
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.figures import Box, Capsule, Cylinder, Figure, Geometry, Mesh, Pose, Sphere
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.collision.solids import GEOMETRIES, PRIMITIVES, TORUS, coal, in_coal, near, placed, torus
from tests.unit.collision.test_scene import mover
from tests.unit.collision.worlds import scene_of, world
from tests.unit.world.builders import random_pose, shifted


def depth(one: Geometry, pose: Pose, other: Geometry, place: Pose) -> Depth:
    """Return how deep two figures are in each other."""
    return depth_of_two(placed((one, pose), (other, place)))


def depth_of_two(pair: Placed) -> Depth:
    """Return how deep the two elements of a set are in each other."""
    return depth_of(pair, pair, 0, 1)


@lru_cache
def hull_in_coal(geometry: Geometry) -> Any:  # noqa: ANN401 coal has no types
    """Return a figure as coal has it, the torus as its hull."""
    if geometry is not TORUS:
        return in_coal(geometry)
    points = coal.StdVec_Vec3s()
    for vertex in torus()[0].astype(np.float64):
        points.append(vertex)
    return coal.ConvexBase.convexHull(points, False, "Qt")


def apart_by_coal(one: Geometry, pose: Pose, other: Geometry, place: Pose) -> float:
    """Return the distance of two figures' hulls that coal tells; minus the depth where they are in each other."""
    request = coal.DistanceRequest()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-9, 1000
    request.epa_tolerance, request.epa_max_iterations = 1e-9, 2000
    at = [coal.Transform3s(each[:3, :3], each[:3, 3]) for each in (pose, place)]
    return coal.distance(hull_in_coal(one), at[0], hull_in_coal(other), at[1], request, coal.DistanceResult())


@pytest.mark.parametrize(("one", "other"), tuple(combinations_with_replacement(GEOMETRIES, 2)))
def test_moved_by_the_depth_two_only_touch_and_coal_knows_no_shorter_way(
    rng: np.random.Generator, one: str, other: str
) -> None:
    """Coal's own depth is too long for some, by up to centimeters with cylinders and cones; it never is too short."""
    seen = equal = 0
    for _ in range(60):
        pose, place = near(rng, 0.15), near(rng, 0.15)
        theirs = -apart_by_coal(GEOMETRIES[one], pose, GEOMETRIES[other], place)
        if theirs < 1e-4:
            continue
        seen += 1
        found = depth(GEOMETRIES[one], pose, GEOMETRIES[other], place)
        assert found.meters <= theirs + 2 * TOLERANCE
        equal += found.meters >= theirs - 1e-6
        for beyond in (-1e-5, 1e-5):
            moved = place.copy()
            moved[:3, 3] += (found.meters + beyond) * found.way
            gap = apart_by_coal(GEOMETRIES[one], pose, GEOMETRIES[other], moved)
            assert gap < 1e-7 if beyond < 0.0 else gap > 0.0
        assert found.approximate == ("torus" in (one, other))
        back = depth(GEOMETRIES[other], place, GEOMETRIES[one], pose)
        assert back.meters == pytest.approx(found.meters, abs=2 * TOLERANCE)
    assert seen > 10 and equal > 0.6 * seen


@pytest.mark.parametrize(("one", "other"), tuple(combinations_with_replacement(PRIMITIVES, 2)))
def test_the_normal_of_primitives_is_the_way_of_their_depth(rng: np.random.Generator, one: str, other: str) -> None:
    """Moved along it by the depth, and hardly more, they are apart, as coal says; by hardly less they are not."""
    seen = 0
    while seen < 10:
        pose, place = near(rng, 0.15), near(rng, 0.15)
        pair = placed((PRIMITIVES[one], pose), (PRIMITIVES[other], place))
        found = pair_within(pair, pair, 0, 1, 0.0)
        if found is None or found.normal is None:
            continue
        seen += 1
        meters = depth_of_two(pair).meters
        for beyond in (-1e-5, 1e-5):
            moved = place.copy()
            moved[:3, 3] += (meters + beyond) * found.normal
            gap = apart_by_coal(PRIMITIVES[one], pose, PRIMITIVES[other], moved)
            assert gap < 1e-7 if beyond < 0.0 else gap > 0.0


def test_depths_by_formula(rng: np.random.Generator) -> None:
    """At a random place in the world. A cylinder in the middle of another can go all ways: known to 1e-7 m only."""
    world_t = random_pose(rng)
    x, y, z = rng.uniform(0.05, 0.2, 3)
    across = np.array([[1.0, 0, 0, x], [0, 0, -1, 0.0], [0, 1, 0, 0.0], [0, 0, 0, 1]])
    cases: list[tuple[Geometry, Geometry, Pose, float]] = [
        (Sphere(0.3), Sphere(0.4), shifted(x, y, z), 0.7 - float(np.linalg.norm((x, y, z)))),
        (Sphere(0.3), Sphere(0.4), shifted(), 0.7),
        (Box((1.0, 0.8, 0.6)), Box((0.2, 0.3, 0.1)), shifted(x, y, z), min(0.6 - x, 0.55 - y, 0.35 - z)),
        # A ball at the edge of a box: what its radius reaches over the way to the edge.
        (Box((0.4, 0.4, 0.4)), Sphere(0.4), shifted(0.2 + x, 0.2 + y, 0.0), 0.4 - float(np.hypot(x, y))),
        (Box((0.4, 0.4, 0.4)), Sphere(0.1), shifted(0.2 - x, 0.0, 0.0), min(x, 0.2) + 0.1),
        # Capsules beside each other, and crossed: cores that are x apart.
        (Capsule(0.2, 1.0), Capsule(0.1, 0.5), shifted(x, 0.0, z), 0.3 - x),
        (Capsule(0.2, 1.0), Capsule(0.1, 0.5), across, 0.3 - x),
        (Capsule(0.2, 1.0), Sphere(0.1), shifted(x, y, z), 0.3 - float(np.hypot(x, y))),
        # Cylinders along each other, and one in a box.
        (Cylinder(0.3, 2.0), Cylinder(0.2, 2.0), shifted(x, y, 0.0), 0.5 - float(np.hypot(x, y))),
        (Cylinder(0.3, 2.0), Cylinder(0.2, 2.0), shifted(), 0.5),
        (Box((2.0, 2.0, 0.2)), Cylinder(0.3, 1.0), shifted(x, y, 0.5), 0.1),
    ]
    for one, other, pose, expected in cases:
        found = depth(one, world_t, other, world_t @ pose)
        assert found.meters == pytest.approx(expected, abs=1e-7), (one, other)
        assert not found.approximate


def test_paddings_count_and_what_is_apart_is_less_deep_by_it(rng: np.random.Generator) -> None:
    for one, other in ((Box((0.2, 0.2, 0.2)), Sphere(0.1)), (Cylinder(0.1, 0.2), Capsule(0.05, 0.2))):
        # Apart: depths by coal are too long for some.
        pose, place = near(rng, 0.1), shifted(x=0.6) @ near(rng, 0.1)
        pair = placed((one, pose), (other, place))
        padded = Placed(pair.solids, pair.world_t_element, None, np.array([0.3, 0.9]))
        truth = 1.2 - apart_by_coal(one, pose, other, place)
        assert depth_of_two(padded).meters == pytest.approx(truth, abs=2 * TOLERANCE)


def in_parts(mesh: trimesh.Trimesh, count: int = 1) -> Placed:
    """Return copies of a mesh at the origin."""
    vertices, faces = np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.int32)
    solid = CollisionShapes(lambda _: (Submesh(vertices, faces),)).get(Mesh("some.stl", "0" * 64))
    assert solid
    return Placed([solid] * count, np.tile(np.eye(4), (count, 1, 1)))


def test_a_convex_mesh_is_exact_and_others_are_their_hulls(rng: np.random.Generator) -> None:
    corners, faces = box_triangles((0.4, 0.3, 0.2))
    box = trimesh.Trimesh(corners, faces, process=False)
    ball = trimesh.creation.icosphere(subdivisions=2)
    dented = ball.copy()
    dented.vertices[7] *= 0.9
    open_ball = trimesh.Trimesh(ball.vertices, ball.faces[1:], process=False)
    two_balls = trimesh.Trimesh(
        np.concatenate([ball.vertices, ball.vertices + 3.0]),
        np.concatenate([ball.faces, ball.faces + len(ball.vertices)]),
        process=False,
    )
    exact = [in_parts(each).solids[0].outline.exact for each in (box, ball, dented, open_ball, two_balls)]
    assert exact == [True, True, False, False, False]
    pair = in_parts(box, 2)
    place = rng.uniform(0.0, 0.05, 3)
    pair.move(np.array([np.eye(4), shifted(*place)]))
    found = depth_of_two(pair)
    assert found.meters == pytest.approx(min((0.4, 0.3, 0.2) - place), abs=1e-7) and not found.approximate


def test_a_mesh_of_many_corners_is_approximate(rng: np.random.Generator) -> None:
    """Balls of 40,962 corners: of these 2,048 count, so that the depth is a little less than that of balls."""
    pair = in_parts(trimesh.creation.icosphere(subdivisions=6, radius=0.5), 2)
    outline = pair.solids[0].outline
    assert len(outline.corners) <= CORNERS and not outline.exact
    pair.move(np.array([np.eye(4), shifted(0.3, 0.4, 0.3)]))
    found = depth_of_two(pair)
    truth = 1.0 - float(np.linalg.norm((0.3, 0.4, 0.3)))
    assert truth - 0.01 < found.meters <= truth and found.approximate


def test_flat_meshes_have_outlines(rng: np.random.Generator) -> None:
    """Of one triangle, and of a disc of many: how deep they are in a box is a matter of these."""
    triangle = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    assert outline_of(triangle).exact
    angle = rng.uniform(0, 2 * np.pi, (3000, 3))
    disc = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=2)
    outline = outline_of(disc)
    assert len(outline.corners) <= CORNERS
    np.testing.assert_allclose(np.linalg.norm(outline.corners, axis=1), 1.0)
    assert np.ptp(np.sort(np.arctan2(outline.corners[:, 1], outline.corners[:, 0]))) > 6.0
    points = np.zeros((5, 3, 3))
    assert np.isfinite(outline_of(points).corners).all()


def test_several_figures_of_a_node_are_approximate() -> None:
    """A ball in two boxes of a node, 5 cm deep in one and 2 cm in the other: told are 5 cm."""
    boxes = (
        Figure(Box((0.2, 0.2, 0.2)), shifted(x=0.25)),
        Figure(Box((0.2, 0.2, 0.2)), shifted(x=-0.28)),
    )
    specs = (mover("robot", Sphere(0.2), shifted()), NodeSpec("boxes", Kind.OBJECT, figures=boxes))
    (found,) = scene_of(world(CreateNodes(specs))).collisions(Detail.CONTACTS)
    assert found.depth is not None and found.depth.approximate
    assert found.depth.meters == pytest.approx(0.05, abs=2 * TOLERANCE)
    (single,) = scene_of(world(CreateNodes((specs[0], replace(specs[1], figures=boxes[1:]))))).collisions(
        Detail.CONTACTS
    )
    assert single.depth is not None and not single.depth.approximate
    assert single.depth.meters == pytest.approx(0.02, abs=2 * TOLERANCE)
