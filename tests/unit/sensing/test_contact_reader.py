"""Contact sensors in small worlds: who feels whom, how far, where, and what follows when nodes are renamed or gone."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.touching import MOST_POINTS
from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.sensing.contact_content import Contact
from virtualrobot_kernel.sensing.contact_reader import ContactReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.commands import (
    AttachNode,
    CreateNodes,
    RemoveNode,
    SetJointPositions,
    SetToolState,
    UpdateNode,
)
from virtualrobot_kernel.world.figures import Box, Cylinder, Figure, Mesh, Sphere
from virtualrobot_kernel.world.sensing import ContactSensor
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, NodeSpec, ToolData

from tests.unit.collision.solids import TORUS, load
from tests.unit.sensing.moments import snapshot_at
from tests.unit.world.builders import Change, after, empty, link, random_pose, shifted

BALL = (Figure(Sphere(0.1)),)


def ball(name: str, x: float, kind: Kind = Kind.OBJECT, parent: str = "world") -> NodeSpec:
    return NodeSpec(name, kind, parent, shifted(x=x), figures=BALL)


def sensor(parent: str, **settings: object) -> NodeSpec:
    return NodeSpec("skin", Kind.CONTACT_SENSOR, parent, data=ContactSensor(**settings))  # pyright: ignore[reportArgumentType]


def no_mesh(mesh: Mesh) -> tuple[Submesh, ...]:
    raise AssertionError(f"there is no {mesh}")


def reader_of(change: Change) -> ContactReader:
    return ContactReader(snapshot_at(change, 0), change.structure.node("skin"), CollisionShapes(no_mesh))


def felt(change: Change, reader: ContactReader | None = None) -> tuple[Contact, ...]:
    moment = Moment(snapshot_at(change, 7), (), 1, np.random.default_rng(0))
    return (reader or reader_of(change)).read(moment).contacts


def pairs(change: Change) -> list[tuple[str, str]]:
    return [(one.element, one.other) for one in felt(change)]


def robot() -> CreateNodes:
    """Return a robot along x, each link a ball, with a tool, a part that it holds, and another robot on it."""
    return CreateNodes(
        (
            NodeSpec("r", Kind.ROBOT, figures=BALL),
            NodeSpec("r.arm", Kind.LINK, "r", shifted(x=0.15), figures=BALL, data=link("", "", Joint("a")).data),
            NodeSpec(
                "r.hand",
                Kind.LINK,
                "r.arm",
                shifted(x=0.15),
                figures=BALL,
                data=link("", "", Joint("slide", JointType.PRISMATIC)).data,
            ),
            NodeSpec("tool", Kind.TOOL, "r.hand", shifted(x=0.1), figures=BALL, data=ToolData()),
            ball("held", 0.1, Kind.PART, "tool"),
            NodeSpec("r2", Kind.ROBOT, "r.hand", shifted(z=0.15), figures=BALL),
        )
    )


def test_distance_points_and_order() -> None:
    """Balls of 0.1 m on a line: 0.05 m and 0.15 m away; one is out of range, and one touches."""
    nodes = (ball("me", 0.0), ball("b", 0.35), ball("a", -0.25), ball("far", 0.8), ball("in", 0.15))
    change = after(empty(), CreateNodes((*nodes, sensor("me", range_meters=0.2))))
    touching, near, farther = felt(change)
    assert [one.element for one in (touching, near, farther)] == ["me"] * 3
    assert (touching.other, near.other, farther.other) == ("in", "a", "b")
    assert touching.distance == 0.0 and touching.normal is not None
    np.testing.assert_allclose(touching.normal, (1, 0, 0), atol=1e-9)
    np.testing.assert_allclose(touching.point, (0.075, 0, 0), atol=1e-9)
    np.testing.assert_array_equal(touching.point, touching.other_point)
    assert near.distance == pytest.approx(0.05) and farther.distance == pytest.approx(0.15)
    np.testing.assert_allclose(near.point, (-0.1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(near.other_point, (-0.15, 0, 0), atol=1e-12)
    assert near.normal is None


def test_without_a_range_only_what_touches() -> None:
    nodes = (ball("me", 0.0), ball("near", 0.2001), ball("touches", -0.1999))
    assert pairs(after(empty(), CreateNodes((*nodes, sensor("me"))))) == [("me", "touches")]


def test_the_own_robot_is_not_felt_but_what_it_holds_and_carries_is() -> None:
    change = after(empty(), robot(), CreateNodes((ball("wall", 0.32), sensor("r.arm"))))
    assert set(pairs(change)) == {
        ("r.arm", "wall"),
        ("r.hand", "wall"),
        ("tool", "wall"),
        ("held", "wall"),
        ("r2", "wall"),
    }
    alone = after(change, UpdateNode("skin", data=ContactSensor("tool")), AttachNode("held", "r.hand"))
    assert set(pairs(alone)) == {("tool", "held"), ("tool", "wall"), ("tool", "r2")}


def test_watched_and_ignored_nodes() -> None:
    change = after(empty(), robot(), CreateNodes((ball("wall", 0.32), ball("cover", 0.0, parent="wall"))))
    skin = sensor("world", watched="tool", ignored=("wall", "r2"))
    assert pairs(after(change, CreateNodes((skin,)))) == []
    skin = sensor("world", watched="tool", ignored=("cover", "held"))
    assert pairs(after(change, CreateNodes((skin,)))) == [("tool", "r2"), ("tool", "wall")]


def test_a_world_that_is_watched_feels_nothing() -> None:
    assert pairs(after(empty(), CreateNodes((ball("a", 0.0), ball("b", 0.1), sensor("world"))))) == []


def test_only_figures_that_collide_and_are_there_count() -> None:
    """Not those that are only seen, nor hidden nodes, nor annotations, nor figures of another state of a tool."""
    open_only = (Figure(Sphere(0.1), tool_state="open"),)
    nodes = (
        ball("me", 0.0),
        NodeSpec("seen", Kind.OBJECT, figures=(Figure(Sphere(0.1), collision=False),)),
        NodeSpec("hidden", Kind.OBJECT, hidden=True),
        ball("below", 0.1, parent="hidden"),
        ball("note", 0.1, Kind.ANNOTATION),
        NodeSpec("unseen", Kind.OBJECT, figures=(Figure(Sphere(0.1), visual=False),)),
        NodeSpec("grip", Kind.TOOL, figures=open_only, data=ToolData(states={"open": {}, "closed": {}})),
        sensor("me"),
    )
    change = after(empty(), CreateNodes(nodes))
    assert set(pairs(change)) == {("me", "unseen"), ("me", "grip")}
    reader = reader_of(change)
    closed = after(change, SetToolState("grip", "closed"))
    assert [one.other for one in felt(closed, reader)] == ["unseen"]
    assert [one.other for one in felt(after(closed, UpdateNode("hidden", hidden=False)), reader)] == ["below", "unseen"]


def test_a_box_about_the_sensor_filters_points(rng: np.random.Generator) -> None:
    """A torus that lies in a plate: only points of the curve inside the sensor's box are told, at most so many."""
    world = random_pose(rng)
    nodes = (
        NodeSpec("ring", Kind.PART, "world", world, figures=(Figure(TORUS),)),
        NodeSpec("plate", Kind.OBJECT, "world", world @ shifted(z=-0.14), figures=(Figure(Box((2.0, 2.0, 0.1))),)),
    )
    turned = shifted(x=0.3, z=-0.1) @ np.array([[0, -1.0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    change = after(empty(), CreateNodes((*nodes, NodeSpec("skin", Kind.CONTACT_SENSOR, "ring", turned))))

    def contacts(size: tuple[float, float, float] | None) -> np.ndarray:
        settings = ContactSensor(region_size=size)
        now = after(change, UpdateNode("skin", data=settings))
        reader = ContactReader(snapshot_at(now, 0), now.structure.node("skin"), CollisionShapes(load))
        told = felt(now, reader)
        assert all(one.normal is not None and abs(one.normal @ world[:3, 2] + 1) < 1e-6 for one in told)
        points = np.array([one.point for one in told]).reshape(-1, 3)
        return (points - world[:3, 3]) @ world[:3, :3]

    every = contacts(None)
    assert len(every) == MOST_POINTS
    np.testing.assert_allclose(every[:, 2], -0.09, atol=1e-6)  # the plate's top
    assert np.ptp(every[:, 0]) > 0.6
    some = contacts((0.1, 0.2, 0.1))  # the sensor's x is the ring's y
    assert 2 <= len(some) < MOST_POINTS
    assert np.abs(some[:, 1]).max() <= 0.05 and np.abs(some[:, 0] - 0.3).max() <= 0.1
    assert len(contacts((0.01, 0.01, 0.001))) == 0


def test_near_points_outside_the_box_are_not_told() -> None:
    nodes = (ball("me", 0.0), ball("other", 0.5))
    for size, count in (((0.1, 0.1, 0.1), 0), ((0.3, 0.1, 0.1), 1)):
        assert len(felt(after(empty(), CreateNodes((*nodes, sensor("me", range_meters=1, region_size=size)))))) == count


def test_moving_things_are_felt_where_they_are() -> None:
    change = after(
        empty(), robot(), CreateNodes((ball("wall", 1.0), sensor("tool", ignored=("r2", "held"), range_meters=1)))
    )
    reader = reader_of(change)
    for position in (0.0, 0.1, 0.3):
        (told,) = felt(after(change, SetJointPositions("r", {"slide": position})), reader)
        assert told.distance == pytest.approx(0.4 - position, abs=1e-12)


def test_names_follow_when_nodes_are_renamed() -> None:
    change = after(
        empty(), robot(), CreateNodes((ball("wall", 0.32), sensor("world", watched="r.hand", ignored=("wall",))))
    )
    for old, new, expected in (
        ("r.hand", "r.gripper", ("r.gripper", ("wall",))),
        ("r", "robot", ("robot.hand", ("wall",))),
        ("wall", "fence", ("r.hand", ("fence",))),
        ("held", "box", ("r.hand", ("wall",))),
    ):
        renamed = after(change, UpdateNode(old, new_name=new))
        data = renamed.structure.node("skin").data
        assert isinstance(data, ContactSensor)
        assert (data.watched, data.ignored) == expected
        felt(renamed)


def test_nodes_that_are_not_there_are_named() -> None:
    change = after(empty(), robot(), CreateNodes((ball("wall", 0.32), sensor("world", watched="tool"))))
    reader = reader_of(change)
    with pytest.raises(UnknownNameError, match="no node named 'tool'"):
        felt(after(change, RemoveNode("tool")), reader)
    wrong = after(change, UpdateNode("skin", data=ContactSensor("r.hnd")))
    with pytest.raises(UnknownNameError, match=r"no node named 'r.hnd'; did you mean 'r.hand'"):
        reader_of(wrong)


def test_a_hundred_things_in_a_row(rng: np.random.Generator) -> None:
    """All pairs by the formula for spheres."""
    places = rng.uniform(-1, 1, (100, 3))
    nodes = [NodeSpec(f"n{i}", Kind.OBJECT, "world", shifted(*place), figures=BALL) for i, place in enumerate(places)]
    change = after(empty(), CreateNodes((*nodes, NodeSpec("me", Kind.OBJECT, figures=(Figure(Cylinder(0.2, 0.01)),)))))
    told = felt(after(change, CreateNodes((sensor("n0", range_meters=0.5, ignored=("me",)),))))
    distances = {f"n{i}": np.linalg.norm(places[i] - places[0]) - 0.2 for i in range(1, 100)}
    expected = {name for name, distance in distances.items() if distance <= 0.5}
    assert {one.other for one in told} == expected
    for one in told:
        assert one.distance == pytest.approx(max(distances[one.other], 0.0), abs=1e-9)
