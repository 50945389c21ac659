"""Meshes that are no good for collisions: empty, not finite, degenerate, not closed, or of a million triangles."""

from __future__ import annotations

import struct
import threading
import time

import numpy as np
import pytest
from virtualrobot.v1 import collision_pb2, kernel_pb2, nodes_pb2, scene_pb2

from tests.api.asking import apply, box, create, refusal
from tests.api.test_asset import upload
from tests.kernels import Stubs

Check = collision_pb2.CheckCollisionRequest
CONTACTS = collision_pb2.COLLISION_DETAIL_CONTACTS


def stl(triangles: np.ndarray) -> bytes:
    """Return triangles (m, 3, 3) as a binary STL file."""
    rows = np.zeros(len(triangles), np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("rest", "<u2")]))
    rows["corners"] = triangles.reshape(-1, 9)
    return bytes(80) + struct.pack("<I", len(triangles)) + rows.tobytes()


def meshed(stubs: Stubs, name: str, data: bytes, uri: str = "some.stl") -> nodes_pb2.Node:
    """Return a node whose figure is a mesh file."""
    figure = nodes_pb2.Figure(mesh=nodes_pb2.Mesh(uri=uri, sha256=upload(stubs, data)))
    return nodes_pb2.Node(name=name, figures=[figure], object=nodes_pb2.SceneObject())


def ball(radius: float, rings: int) -> np.ndarray:
    """Return a ball of 2 * rings^2 triangles (m, 3, 3); those at its poles have no area."""
    along, up = np.meshgrid(np.linspace(0, 2 * np.pi, rings + 1), np.linspace(-np.pi / 2, np.pi / 2, rings + 1))
    points = radius * np.stack([np.cos(along) * np.cos(up), np.sin(along) * np.cos(up), np.sin(up)], axis=2)
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    return np.concatenate([np.stack(one, axis=2).reshape(-1, 3, 3) for one in ((a, b, c), (a, c, d))])


@pytest.fixture
def cell(stubs: Stubs) -> Stubs:
    """Return the stubs of a world with a robot that is a cube of 0.1 m at the origin."""
    robot = box("robot")
    robot.robot.SetInParent()
    apply(stubs, create(robot))
    return stubs


@pytest.mark.parametrize(
    ("uri", "data", "why"),
    [
        ("empty.stl", stl(np.zeros((0, 3, 3))), "the file holds no triangle"),
        ("empty.obj", b"v 0 0 0\n", "the file holds no triangle"),
        ("nan.stl", stl(np.full((1, 3, 3), np.nan)), "vertex 0 is not finite"),
        ("inf.obj", b"v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 1 is not finite"),
        ("other.glb", b"no glTF file", "not a GLB file"),
    ],
    ids=["empty.stl", "empty.obj", "nan.stl", "inf.obj", "other.glb"],
)
def test_meshes_that_are_none_are_refused_by_name(cell: Stubs, uri: str, data: bytes, why: str) -> None:
    """When the node is made, so that none of it is in a world, where it would touch nothing."""
    refused = refusal(lambda: apply(cell, create(meshed(cell, "bad", data, uri))))
    assert refused.reason == "MALFORMED_FILE" and uri in refused.message and why in refused.message
    assert not cell.collision.CheckCollision(Check()).pairs


@pytest.mark.parametrize(
    ("triangles", "touches"),
    [
        (np.zeros((2, 3, 3)), True),
        (np.full((1, 3, 3), 0.06), False),
        (np.array([[[-1.0, 0, 0], [1, 0, 0], [0.5, 0, 0]]]), True),
        (np.array([[[-1.0, 0, 0.06], [1, 0, 0.06], [1, 0, 0.06]]]), False),
    ],
)
def test_triangles_without_area_touch_as_the_points_and_lines_that_they_are(
    cell: Stubs, triangles: np.ndarray, touches: bool
) -> None:
    apply(cell, create(meshed(cell, "thin", stl(triangles))))
    pairs = cell.collision.CheckCollision(Check(detail=CONTACTS)).pairs
    assert bool(pairs) == touches
    for contact in [contact for pair in pairs for contact in pair.contacts]:
        normal = contact.normal
        assert np.linalg.norm((normal.x, normal.y, normal.z)) == pytest.approx(1.0)
        assert max(map(abs, (contact.point.x, contact.point.y, contact.point.z))) <= 1.0
    (nearest,) = cell.collision.MeasureDistances(collision_pb2.MeasureDistancesRequest(first=["robot"])).pairs
    gap = float(np.linalg.norm(np.maximum(np.abs(triangles[0, 0]) - 0.05, 0.0))) if len(triangles) == 1 else 0.0
    assert nearest.distance_meters == pytest.approx(0.0 if touches else min(gap, 0.01 * np.sqrt(3)), abs=0.01)


@pytest.mark.long
def test_a_mesh_of_a_million_triangles_keeps_no_others_waiting(cell: Stubs) -> None:
    """Its first check takes seconds, in a thread of its own: other calls are answered meanwhile."""
    triangles = ball(1.0, 708)
    assert len(triangles) > 1_000_000
    apply(cell, create(meshed(cell, "planet", stl(triangles))))
    checked, waits = threading.Event(), []

    def ask() -> None:
        while not checked.is_set():
            began = time.monotonic()
            cell.kernel.GetInfo(kernel_pb2.GetInfoRequest())
            waits.append(time.monotonic() - began)
            time.sleep(0.01)

    asking = threading.Thread(target=ask)
    asking.start()
    began = time.monotonic()
    first = cell.collision.CheckCollision(Check())
    seconds = time.monotonic() - began
    checked.set()
    asking.join()
    assert not first.pairs, "the robot is inside, and a mesh is a surface"
    assert len(waits) > 3 and max(waits) < 0.5 * seconds, (seconds, waits)
    apply(cell, create(box("part", x=5.0)))
    (nearest,) = cell.collision.MeasureDistances(
        collision_pb2.MeasureDistancesRequest(first=["planet"], second=["part"])
    ).pairs
    assert nearest.distance_meters == pytest.approx(5.0 - 0.05 - 1.0, abs=1e-4)
    touching = box("at its skin", x=0.98)
    touching.robot.SetInParent()
    apply(cell, create(touching))
    (pair,) = cell.collision.CheckCollision(Check(detail=CONTACTS)).pairs
    assert pair.depth_approximate and pair.depth_meters == pytest.approx(1.0 - 0.93, abs=0.005)


def listed(stubs: Stubs, *nodes: str) -> list[collision_pb2.CollisionMesh]:
    request = collision_pb2.ListCollisionMeshesRequest(nodes=nodes)
    return list(stubs.collision.ListCollisionMeshes(request).meshes)


def hulled(node: nodes_pb2.Node, vertices: int) -> scene_pb2.Command:
    node.figures[0].mesh.collision_hull_vertices = vertices
    mask = {"paths": ["figures"]}
    return scene_pb2.Command(update_node=scene_pb2.UpdateNode(name=node.name, node=node, update_mask=mask))


def test_a_mesh_collides_as_a_hull_when_it_shall(cell: Stubs) -> None:
    """The robot is inside of a ball, which is a surface, and a solid as a hull; the report tells what became of it."""
    planet = meshed(cell, "planet", stl(ball(1.0, 15)))
    apply(cell, create(planet))
    (mesh,) = listed(cell)
    assert (mesh.node, mesh.figure, mesh.uri) == ("planet", 0, "some.stl")
    assert (mesh.mesh_triangles, mesh.triangles, mesh.hull) == (450, 450, False)
    assert "30 of the 450 triangles of some.stl have no area" in mesh.warning
    assert not cell.collision.CheckCollision(Check()).pairs
    apply(cell, hulled(planet, 32))
    (mesh,) = listed(cell, "planet")
    assert (mesh.mesh_triangles, mesh.triangles, mesh.hull, mesh.warning) == (450, 60, True, "")
    assert 0.01 < mesh.deviation_meters < 0.3 and mesh.seconds > 0.0 and not mesh.convex
    (pair,) = cell.collision.CheckCollision(Check(detail=CONTACTS)).pairs
    assert pair.depth_approximate and pair.depth_meters > 1.0
    apply(cell, hulled(planet, 256))
    (mesh,) = listed(cell)
    assert mesh.deviation_meters == 0.0 and mesh.convex
    (pair,) = cell.collision.CheckCollision(Check(detail=CONTACTS)).pairs
    assert not pair.depth_approximate and pair.depth_meters == pytest.approx(1.05, abs=0.03)
    saved = cell.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    assert "collision_hull_vertices: 256" in saved
    apply(cell, hulled(planet, 0))
    assert not listed(cell)[0].hull and not cell.collision.CheckCollision(Check()).pairs
    for wrong in (3, 257):
        refused = refusal(lambda wrong=wrong: apply(cell, hulled(planet, wrong)))
        assert refused.reason == "LIMIT_EXCEEDED" and "collision_hull_vertices" in refused.message
    assert refusal(lambda: listed(cell, "nobody")).reason == "UNKNOWN_NAME"


@pytest.mark.long
def test_the_hull_of_a_million_triangles_is_small(cell: Stubs) -> None:
    """Decimated: told is how far it is off, which is what a ball leaves out of a body of 64 corners."""
    planet = meshed(cell, "planet", stl(ball(1.0, 708)))
    planet.figures[0].mesh.collision_hull_vertices = 64
    apply(cell, create(planet))
    (mesh,) = listed(cell)
    assert (mesh.mesh_triangles, mesh.triangles) == (2 * 708**2, 124)
    assert 0.03 < mesh.deviation_meters < 0.15
    assert len(cell.collision.CheckCollision(Check()).pairs) == 1
