"""Pairs that touch as a model is built or stands, and none that touch in some postures only."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from virtualrobot_kernel.collision.built import _box, built_pairs, mounted_pairs
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.world.commands import ClearWorld, CreateNodes, MountTool, SetAllowedPairs
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Frame, Geometry, Pose, Sphere
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    Joint,
    JointLimits,
    JointType,
    Kind,
    Mimic,
    NodeSpec,
    PartData,
    RobotData,
    ToolData,
)

from tests.unit.collision.worlds import ROBOTS, SHAPES, after, robot_nodes, world
from tests.unit.formats.models import ROBOTS as FILES
from tests.unit.world.builders import Z, link, shifted

EVERY = {**ROBOTS, "xarm6_gripper": str(FILES["xarm6_gripper"]), "a1": str(FILES["a1"])}
BUNDLED = files("virtualrobot_plugins.models")
FIXED, REVOLUTE, PRISMATIC = JointType.FIXED, JointType.REVOLUTE, JointType.PRISMATIC
X = (1.0, 0.0, 0.0)
WIDE = JointLimits(-2.0, 2.0, 1.0)


def box(x: float, y: float, z: float, at: Pose | None = None) -> tuple[Figure, ...]:
    """Return a box as a node's only figure."""
    return (Figure(Box((x, y, z)), node_t_figure=shifted() if at is None else at),)


def joint(name: str, kind: JointType = REVOLUTE, limits: JointLimits = WIDE, **more: object) -> Joint:
    return Joint(name, kind, Z, limits, **more)  # pyright: ignore[reportArgumentType]


def body(name: str, parent: str, moves: Joint, figures: tuple[Figure, ...], at: Pose | None = None) -> NodeSpec:
    """Return a link with figures."""
    return replace(link(name, parent, moves, at), figures=figures)


def arm(tip: tuple[Figure, ...] = (), at: Pose | None = None, base: JointType = FIXED) -> list[NodeSpec]:
    """Return an arm: a base of 1 m with a post beside, a link on top that turns, and one on that which turns too."""
    foot = (*box(1.0, 1.0, 1.0, shifted(z=0.5)), *box(0.1, 0.1, 1.0, shifted(0.4, 0.2, 1.5)))
    return [
        NodeSpec("arm", Kind.ROBOT, "world", shifted() if at is None else at, data=RobotData()),
        body("arm.base", "arm", joint("base", base), foot),
        body("arm.turn", "arm.base", joint("turn"), box(0.2, 0.2, 0.2, shifted(z=0.1)), shifted(z=1.0)),
        body("arm.tip", "arm.turn", joint("tip"), tip or box(0.1, 0.1, 0.1, shifted(z=0.3)), shifted()),
    ]


def jaws(parent: str = "world", closed: float = 0.0) -> list[NodeSpec]:
    """Return a gripper whose second finger mimics the first; they touch where the first is at 0."""
    along = JointLimits(-closed, 0.05, 1.0)
    plate = box(0.3, 0.3, 0.1)
    left, right = (Joint(name, PRISMATIC, axis, along) for name, axis in (("left", X), ("right", (-1.0, 0.0, 0.0))))
    return [
        NodeSpec("jaws", Kind.ROBOT, parent, shifted(), data=RobotData()),
        body("jaws.plate", "jaws", joint("base", FIXED), plate),
        body("jaws.left", "jaws.plate", left, box(0.1, 0.1, 0.1, shifted(0.05, 0.0, 0.2))),
        body(
            "jaws.right",
            "jaws.plate",
            replace(right, mimic=Mimic("left")),
            box(0.1, 0.1, 0.1, shifted(-0.05, 0.0, 0.2)),
        ),
    ]


def tool() -> NodeSpec:
    """Return the tool of the jaws."""
    return NodeSpec("jaws.tool", Kind.TOOL, "jaws.plate", shifted(z=0.2), data=ToolData())


def touching(snapshot: Snapshot) -> set[tuple[str, str]]:
    """Return the names of the pairs that a check tells."""
    scene = CollisionScene(SHAPES)
    scene.place(snapshot)
    return {(snapshot.structure.nodes[a].name, snapshot.structure.nodes[b].name) for a, b in scene.touching()}


def loaded(before: Snapshot, *nodes: NodeSpec) -> tuple[Snapshot, tuple[tuple[str, str, str], ...]]:
    """Return the world with a model that was imported, and the pairs that were found."""
    create = CreateNodes(nodes)
    pairs = built_pairs(before, [create], SHAPES)
    return after(before, create, *([SetAllowedPairs(built=pairs)] if pairs else [])), pairs


@pytest.mark.parametrize("name", sorted(EVERY))
def test_nothing_touches_of_a_model_as_loaded(name: str) -> None:
    then, pairs = loaded(world(), *robot_nodes(EVERY[name], name))
    assert touching(then) == set()
    # What is found touches: without it the same pairs are told, and no others.
    assert touching(world(CreateNodes(robot_nodes(EVERY[name], name)))) == {pair[:2] for pair in pairs}
    assert pairs == loaded(world(), *robot_nodes(EVERY[name], name))[1]


@pytest.mark.parametrize("file", sorted(one.name for one in BUNDLED.iterdir() if one.name.endswith(".urdf")))
def test_nothing_touches_of_a_bundled_file_as_loaded(file: str) -> None:
    """By its file, without the pairs that the table of models by name adds."""
    then, _ = loaded(world(), *robot_nodes(f"package://virtualrobot_plugins/models/{file}", "robot"))
    assert touching(then) == set()


def test_the_panda_and_its_hand_have_their_reasons() -> None:
    _, pairs = loaded(world(), *robot_nodes(ROBOTS["panda"], "p"))
    assert {(first.removeprefix("p.panda_"), second.removeprefix("p.panda_"), why) for first, second, why in pairs} == {
        ("link5", "link7", "touch as built"),
        ("link5", "hand", "touch as built"),
        ("leftfinger", "rightfinger", "close on each other"),
    }


@pytest.mark.parametrize(
    "geometry", [Box((0.2, 0.4, 0.6)), Sphere(0.3), Capsule(0.1, 0.5), Cylinder(0.1, 0.5), Cone(0.2, 0.5), Frame(0.2)]
)
def test_boxes_come_before_solids_and_are_as_large(geometry: Geometry) -> None:
    solid, box_around = SHAPES.get(geometry), _box(Figure(geometry), SHAPES)
    assert (solid is None) == (box_around is None)
    if solid is not None and box_around is not None:
        np.testing.assert_allclose(box_around, (solid.centre, solid.half + solid.radius), atol=1e-12)


def test_links_that_overlap_however_they_turn_touch_as_built() -> None:
    then, pairs = loaded(world(), *arm(box(0.4, 0.4, 0.4, shifted(z=0.2))))
    assert pairs == (("arm.base", "arm.tip", "touch as built"),)
    assert touching(then) == set()
    undone = after(then, SetAllowedPairs(forbid=(pairs[0][:2],)))
    assert touching(undone) == {pairs[0][:2]}


def test_what_touches_in_some_postures_only_stays_red() -> None:
    """As loaded the tip is 1 mm in the post; turned away by 0.01 rad it is free."""
    then, pairs = loaded(world(), *arm(box(0.1, 0.1, 0.2, shifted(0.4, 0.101, 0.5))))
    assert pairs == ()
    assert touching(then) == {("arm.base", "arm.tip")}


def test_fingers_close_on_each_other_only_where_their_joint_ends() -> None:
    then, pairs = loaded(world(), *jaws())
    assert pairs == (("jaws.left", "jaws.right", "close on each other"),)
    assert touching(then) == set()
    then, pairs = loaded(world(), *jaws(closed=0.02))  # loaded half way, where one could be in the other
    assert (pairs, touching(then)) == ((), {("jaws.left", "jaws.right")})


def test_a_robot_stands_on_objects_that_are_not_its_parent() -> None:
    table = NodeSpec("table", Kind.OBJECT, "world", shifted(z=0.4), figures=box(2.0, 2.0, 0.8))
    plate = NodeSpec("plate", Kind.OBJECT, "table", shifted(z=0.4), figures=box(0.5, 0.5, 0.1))
    cell, standing = world(CreateNodes((table, plate))), shifted(z=0.8)
    then, pairs = loaded(cell, *arm(at=standing))
    assert pairs == (("table", "arm.base", "stands on 'table'"), ("plate", "arm.base", "stands on 'plate'"))
    assert touching(then) == set()
    # A base that moves does not stand; nor does one on a part, which may be taken away.
    assert loaded(cell, *arm(at=standing, base=JointType.PLANAR))[1] == ()
    box_below = NodeSpec("box", Kind.PART, "world", shifted(z=0.4), figures=box(2.0, 2.0, 0.8), data=PartData())
    then, pairs = loaded(world(CreateNodes((box_below,))), *arm(at=standing))
    assert (pairs, touching(then)) == ((), {("box", "arm.base")})
    # What the arm reaches into stays red, and so does another robot.
    shelf = NodeSpec("shelf", Kind.OBJECT, "world", shifted(z=1.3), figures=box(0.3, 0.3, 0.1))
    then, pairs = loaded(world(CreateNodes((shelf,))), *arm())
    assert (pairs, touching(then)) == ((), {("shelf", "arm.tip")})
    then, pairs = loaded(
        then,
        *(
            replace(one, name=one.name.replace("arm", "twin"), parent=one.parent.replace("arm", "twin"))
            for one in arm()
        ),
    )
    assert pairs == () and ("arm.base", "twin.base") in touching(then)


@pytest.mark.parametrize("kind", [Kind.ROBOT, Kind.TOOL, Kind.OBJECT])
def test_what_is_mounted_may_touch_the_links_next_to_it(kind: Kind) -> None:
    """The plate reaches 5 cm into the base, two joints away, and into the link between."""
    cell, _ = loaded(world(), *arm())
    nodes = jaws("arm.tip")
    if kind is not Kind.ROBOT:
        data = ToolData({}, {}) if kind is Kind.TOOL else None
        nodes = [NodeSpec("jaws.plate", kind, "arm.tip", shifted(), figures=nodes[1].figures, data=data)]
    then, pairs = loaded(cell, *nodes)
    assert set(pairs) - {("jaws.left", "jaws.right", "close on each other")} == {
        ("arm.turn", "jaws.plate", "mounted on 'arm.tip'")
    }
    assert {pair for pair in touching(then) if "jaws.plate" in pair} == {("arm.base", "jaws.plate")}


def test_what_is_mounted_later_is_looked_at_with_what_carries_it() -> None:
    """Its own pairs are as they were: what somebody has forbidden meanwhile stays so."""
    cell, found = loaded(world(CreateNodes(tuple(arm()))), *jaws(), tool())
    cell = after(cell, SetAllowedPairs(forbid=(found[0][:2],)))
    for node in ("jaws", "jaws.tool"):  # the tool brings its gripper
        pairs = mounted_pairs(cell, [MountTool("arm", node, "arm.tip")], SHAPES)
        assert pairs == (("arm.turn", "jaws.plate", "mounted on 'arm.tip'"),)
    assert mounted_pairs(cell, [MountTool("arm", "arm.base", "arm.tip")], SHAPES) == ()  # refused elsewhere


def test_a_part_that_is_loaded_into_a_hand_is_not_mounted() -> None:
    cell, _ = loaded(world(), *arm())
    held = NodeSpec("held", Kind.PART, "arm.tip", shifted(), figures=box(0.3, 0.3, 0.1), data=PartData())
    assert loaded(cell, held)[1] == ()


def test_only_the_nodes_that_are_named_are_looked_at_and_what_a_file_allows_is_its_own() -> None:
    overlapping = arm(box(0.4, 0.4, 0.4, shifted(z=0.2)))
    create, before = CreateNodes(tuple(overlapping)), world(CreateNodes(tuple(jaws())))
    names = {spec.name for spec in overlapping}
    found = built_pairs(before, [ClearWorld(), create], SHAPES, names)
    assert [pair[:2] for pair in found] == [("arm.base", "arm.tip")]
    assert built_pairs(before, [ClearWorld(), create], SHAPES, ()) == ()
    said = SetAllowedPairs((("arm.tip", "arm.base", "we know"),))
    assert built_pairs(before, [create, said], SHAPES, names) == ()
    assert built_pairs(before, [CreateNodes(tuple(jaws()))], SHAPES) == ()  # the names are taken: refused elsewhere
