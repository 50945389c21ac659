"""Meshes that collide as hulls: solids that hold the mesh, against coal and the triangles themselves."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from virtualrobot_kernel.collision.geometry import CollisionShapes, Solid
from virtualrobot_kernel.collision.pairs import near_pairs
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.commands import CreateNodes, SetCollisionSettings
from virtualrobot_kernel.world.figures import Box, Cylinder, Mesh, Sphere

from tests.tiers import Draws
from tests.unit.collision.solids import coal, in_coal, near, torus
from tests.unit.collision.test_scene import body, mover
from tests.unit.collision.worlds import after, world
from tests.unit.world.builders import shifted

RING = Mesh("ring.stl", "0" * 64)


def load(mesh: Mesh) -> tuple[Submesh, ...]:
    """Return the torus, or what else the name says."""
    if mesh.uri in ("flat.stl", "tiny.stl"):
        size = 1.0 if mesh.uri == "flat.stl" else 0.01
        corners = size * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
        return (Submesh(corners, np.array([[0, 1, 2]], np.int32)),)
    if mesh.uri == "ball.stl":
        ball = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
        return (Submesh(np.asarray(ball.vertices, np.float32), np.asarray(ball.faces, np.int32)),)
    if mesh.uri == "lost.stl":
        raise OSError("it is gone")
    return (Submesh(*torus()),)


SHAPES = CollisionShapes(load)


def solid(mesh: Mesh) -> Solid:
    """Return what a mesh collides as."""
    made = SHAPES.get(mesh)
    assert made is not None and made.mesh is not None
    return made


def hull(uri: str, vertices: int) -> Mesh:
    """Return a mesh that collides as a hull."""
    return Mesh(uri, "0" * 64, collision_hull_vertices=vertices)


@pytest.mark.parametrize("vertices", [8, 64, 256])
@pytest.mark.parametrize("other", [Box((0.3, 0.2, 0.5)), Sphere(0.2), Cylinder(0.1, 0.4)])
def test_a_hull_is_touched_where_coal_says(
    rng: np.random.Generator, draws: Draws, vertices: int, other: Box | Sphere
) -> None:
    """And its distances are those of coal's hull of the same corners."""
    made = solid(hull("ring.stl", vertices))
    points = coal.StdVec_Vec3s()
    for corner in made.outline.corners:
        points.append(corner)
    theirs, against = coal.ConvexBase.convexHull(points, False, "Qt"), in_coal(other)
    bare = SHAPES.get(other)
    assert bare
    request = coal.DistanceRequest()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-9, 1000
    touched = 0
    for _ in range(draws(60)):
        poses = near(rng, 0.3), near(rng, 0.4)
        at = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in poses]
        gap = coal.distance(theirs, at[0], against, at[1], request, coal.DistanceResult())
        (pair,) = near_pairs(Placed([made], poses[0][None]), Placed([bare], poses[1][None]), 9.0)
        if abs(gap) > 1e-6:
            assert (pair.normal is not None) == (gap < 0.0)
            assert pair.distance == pytest.approx(max(gap, 0.0), abs=3e-6)
            touched += gap < 0.0
    assert 0 < touched < 60


def test_a_hull_of_few_corners_misses_nothing(rng: np.random.Generator) -> None:
    """Whatever touches the triangles touches the thickened hull too; a distance to it is never more."""
    exact, few = solid(Mesh("ball.stl", "0" * 64)), hull("ball.stl", 12)
    margin = solid(few).margin
    assert 0.05 < margin < 0.3
    probe = SHAPES.get(Box((0.1, 0.2, 0.3)))
    assert probe
    for _ in range(100):
        pose, place = near(rng, 0.2), near(rng, 0.8)
        at = Placed([probe], place[None])
        (true,) = near_pairs(Placed([exact], pose[None]), at, 9.0)
        thick = Placed([solid(few)], pose[None], None, np.array([margin]))
        (pair,) = near_pairs(thick, at, 9.0)
        assert pair.distance <= true.distance + 1e-9
        # It is too much by at most twice the margin: what sticks out on one side, and the margin on the other.
        assert pair.distance >= true.distance - 2 * margin


def test_a_scene_takes_hulls_and_their_margins() -> None:
    """A peg in a ring touches the ring's hull; margins and paddings add up."""
    scene = CollisionScene(SHAPES)
    peg = mover("robot", Sphere(0.05), shifted())
    for mesh, touches in ((RING, False), (hull("ring.stl", 256), True), (hull("ring.stl", 8), True)):
        scene.place(world(CreateNodes((peg, body("ring", mesh, shifted())))))
        assert bool(scene.collisions(Detail.PAIRS)) == touches
        assert len(scene.collisions(Detail.CONTACTS)) == touches
        if touches:
            depth = scene.collisions(Detail.CONTACTS)[0].depth
            assert depth is not None and depth.approximate
    ball = hull("ball.stl", 12)
    specs = (mover("robot", Sphere(0.1), shifted(x=2.0)), body("ball", ball, shifted()))
    snapshot = after(world(CreateNodes(specs)), SetCollisionSettings(paddings=(("ball", 0.1),)))
    scene.place(snapshot)
    np.testing.assert_allclose(scene.bodies.padding, (0.0, 0.1 + solid(ball).margin))


def test_what_became_of_a_mesh_is_told() -> None:
    made = solid(hull("ball.stl", 16))
    assert made.mesh is not None
    assert (made.mesh.triangles, sum(len(piece.triangles) for piece in made.pieces)) == (320, 28)
    assert made.mesh.warning == "" and made.mesh.seconds > 0.0
    flat = solid(hull("flat.stl", 16))
    assert flat.solid is None and flat.margin == 0.0 and flat.mesh is not None
    assert "flat.stl are in a plane" in flat.mesh.warning
    lost = solid(hull("lost.stl", 16))
    assert lost.mesh is not None and "lost.stl cannot be read and touches nothing: it is gone" in lost.mesh.warning
    exact = solid(hull("ball.stl", 256))
    assert exact.margin == 0.0 and exact.outline.exact


def test_what_is_deep_inside_a_hull_touches_it(rng: np.random.Generator) -> None:
    """Triangles and solids, wherever they are: a hull has an inside."""
    made = solid(hull("ball.stl", 256))
    assert len(made.pieces) == 1
    small = [SHAPES.get(geometry) for geometry in (Box((0.01, 0.01, 0.01)), Sphere(0.01), Cylinder(0.01, 0.01))]
    for probe in (*small, solid(Mesh("tiny.stl", "1" * 64))):
        assert probe
        for _ in range(30):
            place = near(rng, 0.25)
            (pair,) = near_pairs(Placed([made], np.eye(4)[None]), Placed([probe], place[None]))
            assert pair.distance == 0.0 and pair.normal is not None
