"""Where things touch: points and normals of contacts whose place is known."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.pairs import Pair, near_pairs
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.collision.tessellation import PIECE, box_triangles, pieces, turned_triangles
from virtualrobot_kernel.collision.touching import touches
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Frame, Geometry, Label, Mesh, Pose, Sphere

from tests.unit.collision.solids import TORUS, placed, torus
from tests.unit.world.builders import random_pose, shifted

DEEP = 0.001


def boxed(mesh: Mesh) -> tuple[Submesh, ...]:
    """Return a box whose edges are the mesh's scale."""
    corners, faces = box_triangles(mesh.scale)
    return (Submesh(corners.astype(np.float32), faces),)


def box_mesh(size: tuple[float, float, float]) -> Mesh:
    """Return a box that is a mesh."""
    return Mesh("box.stl", "1" * 64, size)


def contact(one: Geometry, pose: Pose, other: Geometry, place: Pose) -> Pair:
    """Return the only pair of two figures; meshes are boxes."""
    library = CollisionShapes(boxed)
    solids = [library.get(one), library.get(other)]
    assert solids[0] and solids[1]
    (pair,) = near_pairs(Placed([solids[0]], pose[None]), Placed([solids[1]], place[None]))
    return pair


def normal_of(pair: Pair) -> np.ndarray:
    """Return the normal of a pair that touches."""
    assert pair.normal is not None
    return pair.normal


SMALL: dict[str, Geometry] = {
    "box": Box((0.2, 0.2, 0.2)),
    "mesh": box_mesh((0.2, 0.2, 0.2)),
    "sphere": Sphere(0.1),
    "cylinder": Cylinder(0.1, 0.2),
    "cone": Cone(0.1, 0.2),
    "capsule": Capsule(0.05, 0.1),
}
TABLES: dict[str, Geometry] = {"box": Box((2.0, 2.0, 0.2)), "mesh": box_mesh((2.0, 2.0, 0.2))}


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("small", SMALL)
def test_a_thing_on_a_table(rng: np.random.Generator, small: str, table: str) -> None:
    """It sinks in by 1 mm: the normal is the table's, and the points are on its top, below the thing; and reversed."""
    world = random_pose(rng)
    on_top = world @ shifted(rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), 0.2 - DEEP)
    down = -world[:3, 2]
    pair = contact(SMALL[small], on_top, TABLES[table], world)
    np.testing.assert_allclose(normal_of(pair), down, atol=1e-6)
    points = (pair.contacts - world[:3, 3]) @ world[:3, :3]
    assert np.abs(points[:, 2] - 0.1).max() <= DEEP
    beside = (pair.contacts - on_top[:3, 3]) @ world[:3, :3]
    assert np.abs(beside[:, :2]).max() <= 0.1 + 1e-6
    np.testing.assert_array_equal(pair.points, [pair.contacts[0]] * 2)
    reversed_pair = contact(TABLES[table], world, SMALL[small], on_top)
    np.testing.assert_allclose(normal_of(reversed_pair), -down, atol=1e-6)


def test_a_peg_through_a_ring_does_not_touch(rng: np.random.Generator) -> None:
    """A hull would: the torus has a hole of radius 0.2 m."""
    pose = random_pose(rng)
    assert near_pairs(placed((TORUS, pose)), placed((Cylinder(0.19, 1.0), pose))) == []
    (pair,) = near_pairs(placed((TORUS, pose)), placed((Cylinder(0.19, 1.0), pose)), 0.5)
    assert pair.distance == pytest.approx(0.01, abs=2e-3)
    assert len(near_pairs(placed((TORUS, pose)), placed((Cylinder(0.21, 1.0), pose)))) == 1


def test_what_is_inside_a_solid_touches_it(rng: np.random.Generator) -> None:
    """A mesh is a surface: inside of one is no contact."""
    pose = random_pose(rng)
    solids: tuple[Geometry, ...] = (Box((3, 3, 3)), Sphere(2), Cylinder(2, 3), Capsule(2, 1))
    for solid in solids:
        for inside in (TORUS, Sphere(0.1), Box((0.1, 0.2, 0.1))):
            (pair,) = near_pairs(placed((inside, pose)), placed((solid, pose)))
            assert pair.distance == 0.0
            assert pair.normal is not None
    library = CollisionShapes(boxed)
    big, small = library.get(box_mesh((3, 3, 3))), library.get(box_mesh((1, 1, 1)))
    assert big and small
    assert near_pairs(Placed([big], pose[None]), Placed([small], pose[None])) == []


def test_meshes_are_cut_into_pieces_that_hold_each_triangle_once(rng: np.random.Generator) -> None:
    vertices, faces = torus()
    parts = list(pieces(vertices.astype(np.float64), faces))
    assert max(map(len, parts)) <= PIECE
    assert sorted(map(tuple, np.concatenate(parts).tolist())) == sorted(map(tuple, faces.tolist()))
    # Neighbours: together their boxes are hardly larger than the torus.
    sizes = [np.ptp(vertices[part].reshape(-1, 3), axis=0).prod() for part in parts]
    assert sum(sizes) < 1.2 * np.ptp(vertices, axis=0).prod()


@pytest.mark.parametrize("radii", [(0.1, 0.1), (0.1, 0.0)])
def test_turned_surfaces_are_closed(radii: tuple[float, float]) -> None:
    """Their volume by the divergence theorem: that of the cylinder or cone, less what flat sides stand in."""
    vertices, faces = turned_triangles(*radii, 0.4)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    exact = np.pi * 0.4 * (0.01 if radii[1] else 0.01 / 3)
    assert 0.0 < exact - volume < 1e-4 * exact


def test_solids_are_made_once_and_annotations_are_none() -> None:
    library = CollisionShapes(boxed)
    assert library.get(Sphere(0.1)) is library.get(Sphere(0.1))
    assert library.get(box_mesh((1, 1, 1))) is library.get(box_mesh((1, 1, 1)))
    assert library.get(Frame()) is None
    assert library.get(Label("here")) is None


def test_a_mesh_that_cannot_be_read_touches_nothing(caplog: pytest.LogCaptureFixture) -> None:
    def broken(mesh: Mesh) -> tuple[Submesh, ...]:
        raise OSError("gone")

    library = CollisionShapes(broken)
    solid = library.get(TORUS)
    assert solid is not None and solid is library.get(TORUS)
    nothing = Placed([solid], np.eye(4)[None])
    assert near_pairs(nothing, placed((Box((9, 9, 9)), np.eye(4))), 5.0) == near_pairs(nothing, nothing, 5.0) == []
    assert caplog.text.count("torus.stl") == 1


def test_those_that_are_the_deepest_in_each_other_come_first(rng: np.random.Generator) -> None:
    """Boxes along the axes, which are as deep in each other as the least of their overlaps."""
    box = Box((0.2, 0.2, 0.2))
    off = rng.uniform(-0.19, 0.19, (20, 3))
    together = placed((box, np.eye(4)), *((box, shifted(*each)) for each in off.tolist()))
    asked = np.arange(21)[None] > 0
    found, deepest_first = (
        [other - 1 for _, other, _, _ in together.overlaps(np.array([0]), asked, first)] for first in (False, True)
    )
    assert found == list(range(20))
    assert deepest_first == np.argsort(np.abs(off).max(axis=1)).tolist()


def test_boxes_that_stand_on_boxes_have_contacts(rng: np.random.Generator) -> None:
    """Whether they touch is a matter of rounding, but it is the same with contacts and without."""
    count = 0
    for _ in range(60):
        pose, place, height = np.eye(4), np.eye(4), rng.uniform(0.05, 0.2)
        turn = rng.choice([0.0, 0.5 * np.pi, rng.uniform(-np.pi, np.pi)])
        place[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        pose[2, 3] = rng.uniform(-1.0, 1.0)
        place[:3, 3] = *rng.uniform(-0.5, 0.5, 2), pose[2, 3] + 0.01 + 0.5 * height
        table, box = (Box((2.0, 2.0, 0.02)), pose), (Box((0.15, 0.1, height)), place)
        both = placed(table, box)
        found = near_pairs(placed(table), placed(box))
        pieces = both.overlaps(np.array([0]), np.array([[False, True]]))
        assert any(touches(both, *each) for each in pieces) == bool(found)
        for pair in found:
            count += 1
            assert normal_of(pair) == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)
            assert len(pair.contacts) > 0 and pair.contacts[:, 2] == pytest.approx(pose[2, 3] + 0.01, abs=1e-9)
            assert np.abs(pair.contacts[:, :2] - place[:2, 3]).max() < 0.1
    assert count > 0
