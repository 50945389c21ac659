"""The collision scene: groups, tool states, what has no body, analytic pairs, and following a world that changes."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from virtualrobot_kernel.collision.allowed import Cause
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.world.commands import (
    AttachNode,
    CreateNodes,
    PickPart,
    RemoveNode,
    SetAllowedPairs,
    SetJointPositions,
    SetToolState,
    UpdateNode,
)
from virtualrobot_kernel.world.figures import Box, Capsule, Figure, Frame, Geometry, Mesh, Pose, Sphere
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec, RobotData, ToolData

from tests.unit.collision.worlds import SHAPES, after, scene_of, somewhere, with_robots, world
from tests.unit.world.builders import arm, part, random_pose, shifted

Names = set[tuple[str, str]]


def body(name: str, geometry: Geometry, pose: Pose, parent: str = "world", kind: Kind = Kind.OBJECT) -> NodeSpec:
    """Return a node with one figure."""
    return NodeSpec(name, kind, parent, pose, figures=(Figure(geometry),))


def mover(name: str, geometry: Geometry, pose: Pose) -> NodeSpec:
    """Return a robot that is nothing but a figure: what belongs to no robot is not asked."""
    return NodeSpec(name, Kind.ROBOT, "world", pose, figures=(Figure(geometry),), data=RobotData())


def touching(snapshot: Snapshot, scene: CollisionScene | None = None, detail: Detail = Detail.PAIRS) -> Names:
    """Return the names of what touches, by a new scene or one that was used before."""
    scene = scene or CollisionScene(SHAPES)
    scene.place(snapshot)
    nodes = snapshot.structure.nodes
    return {(nodes[pair.first].name, nodes[pair.second].name) for pair in scene.collisions(detail)}


def cell() -> Snapshot:
    """Return an arm with boxes for links, a gripper with two states, a table, and parts on it."""
    cube = (Figure(Box((0.1, 0.1, 0.1))),)
    specs = [
        spec
        if spec.kind is not Kind.LINK
        else NodeSpec(spec.name, spec.kind, spec.parent, spec.parent_t_node, False, cube, spec.data)
        for spec in arm().specs
    ]
    table = body("table", Box((1.0, 1.0, 0.1)), shifted(x=3.0))
    return world(CreateNodes((*specs, table, part("a", shifted(x=3.0, z=0.1)), part("b", shifted(x=3.05, z=0.1)))))


def test_only_pairs_with_a_robot_are_asked() -> None:
    """The parts are in each other and touch the table; the fingers of this arm are in each other too."""
    assert touching(cell()) == {("arm.left", "arm.right")}
    reached = after(cell(), UpdateNode("arm", parent_t_node=shifted(x=2.0, z=-0.2)))
    assert {pair[1] for pair in touching(reached) if pair[0] in ("arm.left", "arm.right", "arm.hand")} >= {"table"}


@pytest.mark.parametrize("apart", [-1e-3, 1e-3])
def test_spheres_boxes_and_capsules_touch_where_formulas_say(apart: float, rng: np.random.Generator) -> None:
    """Two spheres, two boxes face to face, and a capsule beside a capsule, anywhere: a millimeter decides."""
    pairs: list[tuple[Geometry, Geometry, float]] = [
        (Sphere(0.2), Sphere(0.3), 0.5),
        (Box((0.4, 0.3, 0.2)), Box((0.6, 0.2, 0.1)), 0.5),
        (Capsule(0.1, 0.5), Capsule(0.2, 0.7), 0.3),
        (Sphere(0.2), Box((0.4, 0.4, 0.4)), 0.4),
        (Sphere(0.2), Capsule(0.1, 0.4), 0.3),
    ]
    for first, second, reach in pairs:
        at = random_pose(rng)
        beside = at @ shifted(x=reach + apart)
        snapshot = world(CreateNodes((mover("one", first, at), body("two", second, beside))))
        assert bool(touching(snapshot)) == (apart < 0.0)
        scene = scene_of(snapshot)
        (near,) = scene.distances([2], [3], 0.0)
        assert near.distance == pytest.approx(max(apart, 0.0), abs=1e-9)
        if apart < 0.0:
            (found,) = scene.collisions(Detail.CONTACTS)
            assert found.depth is not None
            assert found.depth.meters == pytest.approx(-apart, abs=1e-7) and not found.depth.approximate
            (contacts, *_) = found.contacts
            np.testing.assert_allclose(contacts.normal, at[:3, 0], atol=1e-6)


def test_hidden_nodes_collide_and_sensors_and_annotations_do_not() -> None:
    ball = Figure(Sphere(0.1))
    bodiless = (
        NodeSpec("note", Kind.ANNOTATION, figures=(ball,)),
        NodeSpec("lidar", Kind.RANGE_SENSOR, figures=(ball,), data=RangeSensor()),
        NodeSpec("lamp", Kind.LIGHT, figures=(ball,)),
        NodeSpec("seen", Kind.OBJECT, figures=(Figure(Sphere(0.1), collision=False),)),
        NodeSpec("frame", Kind.OBJECT, figures=(Figure(Frame()),)),
    )
    robot = mover("robot", Sphere(0.1), shifted())
    assert touching(world(CreateNodes((robot, *bodiless)))) == set()
    hidden = NodeSpec("wall", Kind.OBJECT, hidden=True, figures=(ball,))
    assert touching(world(CreateNodes((robot, *bodiless, hidden)))) == {("robot", "wall")}


def test_a_tool_collides_as_its_state_has_it() -> None:
    """Open fingers reach the wall, closed ones don't."""
    figures = (Figure(Box((1.0, 0.1, 0.1)), tool_state="open"), Figure(Box((0.1, 0.1, 0.1)), tool_state="closed"))
    gripper = NodeSpec("gripper", Kind.TOOL, "robot", figures=figures, data=ToolData(states={"open": {}, "closed": {}}))
    snapshot = world(
        CreateNodes((NodeSpec("robot", Kind.ROBOT, data=RobotData()), gripper, body("wall", Sphere(0.1), shifted(0.4))))
    )
    scene = CollisionScene(SHAPES)
    assert touching(snapshot, scene) == {("gripper", "wall")}
    assert touching(after(snapshot, SetToolState("gripper", "closed")), scene) == set()
    assert touching(snapshot, scene) == {("gripper", "wall")}


def test_an_empty_or_broken_mesh_touches_nothing() -> None:
    def load(mesh: Mesh) -> tuple:
        if mesh.uri == "broken.stl":
            raise OSError("it is gone")
        return ()

    from virtualrobot_kernel.collision.geometry import CollisionShapes

    scene = CollisionScene(CollisionShapes(load))
    meshes = [body(uri, Mesh(uri, "0" * 64), shifted()) for uri in ("broken.stl", "empty.stl")]
    snapshot = world(
        CreateNodes((mover("robot", Sphere(0.1), shifted()), *meshes, body("far", Sphere(0.1), shifted(1))))
    )
    scene.place(snapshot)
    assert scene.collisions(Detail.PAIRS) == []
    (nearest,) = scene.distances([2], [3, 4, 5], 0.0)
    assert (nearest.second, nearest.distance) == (5, pytest.approx(0.8))


def test_a_scene_that_follows_finds_what_a_new_one_finds(rng: np.random.Generator) -> None:
    """Moves, new nodes, gone ones, other figures, parts picked and put away: in any order."""
    snapshot = after(
        with_robots("panda"),
        CreateNodes(tuple(part(f"p{i}", random_pose(rng) @ shifted(), "world") for i in range(12))),
    )
    scene = CollisionScene(SHAPES)
    for step in range(60):
        name = f"p{rng.integers(12)}"
        match step % 6:
            case 0:
                snapshot = somewhere(snapshot, rng)
            case 1 if name in snapshot.structure.uid_by_name:
                snapshot = after(snapshot, AttachNode(name, str(rng.choice(["world", "panda.panda_link4"]))))
            case 2 if name in snapshot.structure.uid_by_name:
                snapshot = after(snapshot, RemoveNode(name))
            case 3:
                name = f"new {step}"
                snapshot = after(snapshot, CreateNodes((part(name, random_pose(rng)),)))
            case 4 if name in snapshot.structure.uid_by_name:
                snapshot = after(
                    snapshot, UpdateNode(name, figures=(Figure(Sphere(0.2)), Figure(Box((0.3, 0.1, 0.2)))))
                )
            case 5:
                snapshot = after(snapshot, UpdateNode("panda", parent_t_node=shifted(*rng.uniform(-0.3, 0.3, 3))))
        assert touching(snapshot, scene) == touching(snapshot)
        assert touching(snapshot, scene, Detail.CONTACTS) == touching(snapshot)
        gc.collect(0)


def test_a_picked_part_collides_as_part_of_the_robot() -> None:
    """It may touch the gripper and its fingers, not the link above them nor the table it is taken from."""
    snapshot = after(cell(), UpdateNode("arm", parent_t_node=shifted(x=1.9, z=-0.2)))
    snapshot = after(snapshot, PickPart("arm", "a", max_distance=1.0))
    scene = scene_of(snapshot)
    uid = snapshot.structure.uid_by_name
    why = scene.bodies.allowed.why
    assert scene.bodies.allowed.groups[uid["a"]] == uid["arm"]
    assert [why(uid["a"], uid[name]) for name in ("arm.left", "arm.right")] == [(Cause.HELD, "")] * 2
    assert why(uid["a"], uid["arm.hand"]) == (Cause.RIGID, "")
    assert why(uid["a"], uid["arm.one"]) is None and why(uid["a"], uid["table"]) is None
    assert ("table", "a") in touching(snapshot)
    assert ("a", "b") in touching(snapshot)
    assert not {pair for pair in touching(snapshot) if "a" in pair and pair[0].startswith("arm")}


def test_picking_a_part_among_500_finds_what_a_new_scene_finds(rng: np.random.Generator) -> None:
    """Five parts, one after the other, in a scene that follows."""
    places = rng.uniform(-2.0, 2.0, (500, 3))
    parts = CreateNodes(tuple(part(f"p{i}", shifted(*place)) for i, place in enumerate(places)))
    snapshot = after(cell(), parts)
    scene = scene_of(snapshot)
    for chosen in rng.choice(500, 5, replace=False):
        snapshot = after(snapshot, PickPart("arm", f"p{chosen}", max_distance=10.0))
        snapshot = after(snapshot, SetJointPositions("arm", {"a": rng.uniform(-1, 1), "b": rng.uniform(-1, 1)}))
        assert touching(snapshot, scene) == touching(snapshot)


def test_pairs_of_clients_may_touch_until_they_may_not() -> None:
    snapshot = world(
        CreateNodes(
            (
                mover("robot", Sphere(0.1), shifted()),
                body("one", Sphere(0.1), shifted()),
                body("two", Sphere(0.1), shifted()),
            )
        )
    )
    scene = CollisionScene(SHAPES)
    assert touching(snapshot, scene) == {("robot", "one"), ("robot", "two")}
    snapshot = after(snapshot, SetAllowedPairs((("one", "robot", "it may"),)))
    assert touching(snapshot, scene) == {("robot", "two")}
    assert scene.bodies.allowed.why(3, 2) == (Cause.CLIENT, "it may")
    assert [near.second for near in scene.distances([2], [3, 4], 1.0)] == [4]
    assert touching(after(snapshot, SetAllowedPairs(forbid=(("robot", "one"),))), scene) == {
        ("robot", "one"),
        ("robot", "two"),
    }
