"""Robots of Denavit-Hartenberg tables: the tree moves as the table says, figures join up, bad tables say where."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from google.protobuf import json_format
from virtualrobot.v1 import nodes_pb2, scene_pb2
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.dh import read_table
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.messages.dh import denavit_hartenberg
from virtualrobot_kernel.scenes.models import read_model
from virtualrobot_kernel.world.figures import Box, Cylinder, Figure, Frame
from virtualrobot_kernel.world.structure import (
    WORLD_NAME,
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    NodeSpec,
    RobotData,
)
from virtualrobot_sdk.denavit_hartenberg import Row, Table, frames, pose
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.settings import make_settings

from tests.unit.formats.models import MODELS, XacroOnly, disk, forward, structure_of

CONVENTIONS = ["standard", "modified"]
KINDS = ("revolute", "prismatic", "revolute", "revolute", "prismatic", "revolute")


def random_table(rng: np.random.Generator, convention: str) -> Table:
    rows = [
        Row(kind, *(rng.uniform(-1.0, 1.0, 4) * (0.5, np.pi, 0.5, np.pi)).tolist())  # pyright: ignore[reportArgumentType]
        for kind in KINDS
    ]
    ends = [tuple(rng.uniform(-0.5, 0.5, 7).tolist()) for _ in range(2)]
    return Table(convention, tuple(rows), *ends)  # pyright: ignore[reportArgumentType]


def joints_of(table: Table, stroke: float = 0.3) -> tuple[Joint, ...]:
    z = (0.0, 0.0, 1.0)
    turning, sliding = JointLimits(-3.0, 3.0), JointLimits(-stroke / 2, stroke)
    return tuple(
        Joint(f"joint_{i + 1}", JointType.PRISMATIC, z, sliding)
        if row.type == "prismatic"
        else Joint(f"joint_{i + 1}", JointType.REVOLUTE, z, turning)
        for i, row in enumerate(table.rows)
    )


def links(nodes: tuple[NodeSpec, ...]) -> list[NodeSpec]:
    return [node for node in nodes if node.kind is Kind.LINK]


def parsed(**fields: Any) -> tuple[Table, tuple[Joint, ...]]:  # noqa: ANN401  what JSON can say
    """Return what a table in protobuf's JSON mapping comes to."""
    given = {"convention": "DENAVIT_HARTENBERG_CONVENTION_STANDARD", "rows": [{}], **fields}
    return denavit_hartenberg(json_format.ParseDict(given, scene_pb2.DenavitHartenberg()))


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_tree_moves_as_the_table_says(rng: np.random.Generator, convention: str) -> None:
    """The kernel's one forward pass over the nodes against the product of the rows; frame_i is T_0^i."""
    table = random_table(rng, convention)
    structure, poses = structure_of(read_table(table, joints_of(table), name="arm"))
    for q in rng.uniform(-2.0, 2.0, (5, len(KINDS))):
        found = forward(structure, poses, q)
        expected = frames(table, q)
        np.testing.assert_allclose(found["arm.flange"], expected[-1], atol=1e-13)
        np.testing.assert_allclose(found["arm.frame_0"], pose(table.base_t_first), atol=1e-15)
        for i in range(len(KINDS)):
            np.testing.assert_allclose(found[f"arm.frame_{i + 1}"], expected[i], atol=1e-13)


def test_what_the_robot_is_made_of(rng: np.random.Generator) -> None:
    table = random_table(rng, "standard")
    joints = joints_of(table)
    robot, *rest = read_table(table, joints, name="arm", parent="table", base_joint=JointType.FLOATING)
    assert (robot.name, robot.kind, robot.parent) == ("arm", Kind.ROBOT, "table")
    assert [node.name for node in rest] == [
        *("arm.base_link", "arm.link_1", "arm.link_2", "arm.link_3", "arm.link_4", "arm.link_5", "arm.link_6"),
        *("arm.flange", *(f"arm.frame_{i}" for i in range(7))),
    ]
    moved = [node.data.joint for node in rest if isinstance(node.data, LinkData)]
    assert moved[0].type is JointType.FLOATING
    assert tuple(moved[1:7]) == joints
    assert moved[7].type is JointType.FIXED
    assert [node.parent for node in rest[:8]] == ["arm", *(node.name for node in rest[:7])]
    assert isinstance(robot.data, RobotData)
    assert (robot.data.kinematics, robot.data.flange) == ("dh", "flange")
    assert make_settings(Table, robot.data.kinematics_settings) == table
    structure, _ = structure_of(read_table(table, joints, name="arm"))
    assert structure.robots[structure.uid_by_name["arm"]].flange == structure.uid_by_name["arm.flange"]


def test_joints_called_as_ours_are_taken_as_they_are() -> None:
    rows = (Row(), Row())
    joints = [Joint(name, JointType.CONTINUOUS, (0.0, 0.0, 1.0)) for name in ("base", "to_flange")]
    nodes = links(read_table(Table("standard", rows), joints, name="arm"))
    names = [node.data.joint.name for node in nodes if isinstance(node.data, LinkData)]
    assert names == ["base_", "base", "to_flange", "to_flange_"]


def test_only_three_sorts_of_base_joints() -> None:
    with pytest.raises(KernelError, match="the base joint cannot be revolute; valid: fixed, floating, planar"):
        joints = [Joint("a", JointType.CONTINUOUS, (0.0, 0.0, 1.0))]
        read_table(Table("standard", (Row(),)), joints, name="arm", base_joint=JointType.REVOLUTE)


def solid(nodes: tuple[NodeSpec, ...]) -> Iterator[tuple[NodeSpec, Figure]]:
    yield from ((node, figure) for node in links(nodes) for figure in node.figures)


def inside(figure: Figure, point: np.ndarray, room: float) -> bool:
    """Return whether a point (3,) in the link's frame lies in a box or cylinder that is `room` larger all round."""
    x, y, z = (np.linalg.inv(figure.node_t_figure) @ [*point, 1.0])[:3]
    match figure.geometry:
        case Box(size):
            return bool((np.abs([x, y, z]) <= np.array(size) / 2 + room).all())
        case Cylinder(radius, length):
            return math.hypot(x, y) <= radius + room and abs(z) <= length / 2 + room
    raise AssertionError(f"{figure.geometry} is neither")


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_figures_join_up_in_every_posture(rng: np.random.Generator, convention: str) -> None:
    """Each joint, and the flange, lies in a figure of the link before it and in one of the link after it."""
    table = random_table(rng, convention)
    nodes = read_table(table, joints_of(table), name="arm")
    structure, poses = structure_of(nodes)
    chain = links(nodes)
    for share in (-0.5, 0.0, 0.5, 1.0):
        q = np.array([share * 0.3 if kind == "prismatic" else rng.uniform(-3.0, 3.0) for kind in KINDS])
        world = forward(structure, poses, q)
        for before, after in pairwise(chain):
            # Where the link is hung on: its frame at zero; the row of a modified table begins d further down along z.
            joint_place = world[before.name] @ after.parent_t_node
            number = chain.index(after) - 1
            if convention == "modified" and number < len(KINDS):
                joint_place = joint_place.copy()
                joint_place[:3, 3] -= joint_place[:3, 2] * table.rows[number].d_meters
            for link in (before, after):
                point = (np.linalg.inv(world[link.name]) @ joint_place)[:3, 3]
                assert any(inside(figure, point, 1e-9) for figure in link.figures), (before.name, link.name, share)


def sizes(figure: Figure) -> np.ndarray:
    """Return the edges of a box, or radius and length of a cylinder."""
    shape = figure.geometry
    assert isinstance(shape, Box | Cylinder)
    return np.array(shape.size if isinstance(shape, Box) else (shape.radius, shape.length))


def test_figures_are_seen_and_collide_and_grow_with_the_arm(rng: np.random.Generator) -> None:
    one = Table("standard", random_table(rng, "standard").rows)
    longer = [replace(row, a_meters=10 * row.a_meters, d_meters=10 * row.d_meters) for row in one.rows]
    ten = Table("standard", tuple(longer))
    small = list(solid(read_table(one, joints_of(one, 0.3), name="arm")))
    great = list(solid(read_table(ten, joints_of(ten, 3.0), name="arm")))
    assert all(figure.visual and figure.collision and figure.material for _, figure in small)
    for (_, a), (_, b) in zip(small, great, strict=True):
        np.testing.assert_allclose(10 * a.node_t_figure[:3, 3], b.node_t_figure[:3, 3], atol=1e-12)
        np.testing.assert_allclose(10 * sizes(a), sizes(b))
        assert sizes(a).min() > 0.0


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_an_upright_arm_stands_on_the_ground(convention: str) -> None:
    table = Table(convention, (Row("revolute", 0.1, 0.0, 0.4), Row("revolute", 0.3)))  # pyright: ignore[reportArgumentType]
    base, first = links(read_table(table, joints_of(table), name="arm"))[:2]
    lowest = [
        (link.parent_t_node @ figure.node_t_figure)[2, 3] - sizes(figure)[-1] / 2
        for link in (base, first)
        for figure in link.figures
        if isinstance(figure.geometry, Cylinder)
    ]
    assert len(lowest) >= 2
    assert min(lowest) > -1e-12


def test_a_table_without_lengths_is_seen_too() -> None:
    """Three axes that meet: a wrist."""
    table = Table("standard", (Row("revolute", 0.0, np.pi / 2), Row("revolute", 0.0, -np.pi / 2), Row()))
    joints = [Joint(f"joint_{i}", JointType.CONTINUOUS, (0.0, 0.0, 1.0)) for i in range(3)]
    nodes = read_table(table, joints, name="wrist")
    assert len([figure for _, figure in solid(nodes) if isinstance(figure.geometry, Cylinder)]) >= 5
    assert all(not figure.collision for node in nodes for figure in node.figures if isinstance(figure.geometry, Frame))
    assert isinstance(nodes[0].data, RobotData)
    pairs = {(pair.first, pair.second) for pair in nodes[0].data.allowed_collisions}
    assert ("link_1", "link_3") in pairs, "nothing lies between them"


def test_links_far_apart_may_not_touch() -> None:
    table = Table("standard", (Row("revolute", 1.0), Row("revolute", 1.0), Row("revolute", 1.0)))
    nodes = read_table(table, joints_of(table), name="arm")
    assert isinstance(nodes[0].data, RobotData)
    pairs = {(pair.first, pair.second): pair.reason for pair in nodes[0].data.allowed_collisions}
    assert pairs[("link_1", "link_2")] == "Adjacent"
    assert ("link_1", "link_3") not in pairs
    assert ("base_link", "link_2") not in pairs


def test_types_names_and_limits_of_rows() -> None:
    limits = {"lower": -1.0, "upper": 2.0, "velocity": 3.0}
    rows = [
        {"limits": limits},
        {"limits": {"velocity": 3.0}},
        {"type": "JOINT_TYPE_REVOLUTE"},
        {"type": "JOINT_TYPE_PRISMATIC", "name": "lift", "limits": {"lower": 0.0}},
        {"type": "JOINT_TYPE_CONTINUOUS"},
    ]
    table, joints = parsed(rows=rows)
    revolute, continuous, prismatic = JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC
    assert [joint.type for joint in joints] == [revolute, continuous, revolute, prismatic, continuous]
    assert [joint.name for joint in joints] == ["joint_1", "joint_2", "joint_3", "lift", "joint_5"]
    assert [row.type for row in table.rows] == ["revolute", "revolute", "revolute", "prismatic", "revolute"]
    assert joints[0].limits == JointLimits(-1.0, 2.0, 3.0)
    assert (joints[3].limits.lower, joints[3].limits.upper) == (0.0, math.inf)
    assert all(joint.axis == (0.0, 0.0, 1.0) for joint in joints)


def test_poses_of_a_table() -> None:
    quarter = {"position": {"z": 0.5}, "orientation": {"x": 2.0, "w": 2.0}}
    table, _ = parsed(base_t_first=quarter, convention="DENAVIT_HARTENBERG_CONVENTION_MODIFIED")
    assert (table.convention, table.last_t_flange) == ("modified", None)
    assert table.base_t_first is not None
    np.testing.assert_allclose(table.base_t_first, (0, 0, 0.5, math.sqrt(0.5), 0, 0, math.sqrt(0.5)), atol=1e-15)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"convention": "DENAVIT_HARTENBERG_CONVENTION_UNSPECIFIED"}, "convention must be one of DENAVIT_HARTENBERG_"),
        ({"convention": 7}, "convention must be one of"),
        ({"rows": []}, "rows is empty; a table has a row for each joint"),
        ({"rows": [{}, {"alpha_radians": "NaN"}]}, "rows[1].alpha_radians is nan; it must be a finite number"),
        ({"rows": [{"a_meters": "Infinity"}]}, "rows[0].a_meters is inf"),
        ({"rows": [{"d_meters": 1e13}]}, "rows[0].d_meters is 1e+13; it must be a finite number of at most 1e+12"),
        ({"rows": [{}, {}, {"type": "JOINT_TYPE_FLOATING"}]}, "rows[2].type is floating; a row can be revolute, cont"),
        ({"rows": [{"type": "JOINT_TYPE_FIXED"}]}, "rows[0].type is fixed; a row can be"),
        ({"rows": [{"type": 99}]}, "rows[0].type is 99, which has no meaning; give one of"),
        ({"rows": [{"name": "a"}, {}, {"name": "a"}]}, "rows[2].name: the joint 'a' is that of rows[0] already"),
        ({"rows": [{}, {"name": "joint_1"}]}, "rows[1].name: the joint 'joint_1' is that of rows[0] already"),
        (
            {"rows": [{}, {"limits": {"lower": 2.0, "upper": 1.0}}]},
            "rows[1].limits are 2 to 1; the lower one must be the lesser",
        ),
        ({"rows": [{"limits": {"lower": "NaN"}}]}, "rows[0].limits are nan to inf"),
        ({"rows": [{"limits": {"velocity": -1.0}}]}, "rows[0].limits.velocity must be 0 or above, not -1"),
        (
            {"rows": [{"type": "JOINT_TYPE_CONTINUOUS", "limits": {"upper": 1.0}}]},
            "rows[0].limits: a continuous joint turns without end",
        ),
        ({"base_t_first": {"position": {"x": "NaN"}}}, "base_t_first.position must be finite"),
        ({"last_t_flange": {"orientation": {}}}, "last_t_flange.orientation must be a quaternion of a length above 0"),
    ],
)
def test_bad_tables_are_refused_by_row_and_field(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(KernelError) as refused:
        parsed(**fields)
    assert f"denavit_hartenberg.{message}" in str(refused.value)
    assert refused.value.reason is (Reason.NAME_TAKEN if ".name:" in message else Reason.INVALID_ARGUMENT)


@pytest.mark.parametrize("base", [nodes_pb2.JOINT_TYPE_PLANAR, nodes_pb2.JOINT_TYPE_FLOATING])
def test_a_known_arm_that_is_a_scene_stands_on_any_base(base: nodes_pb2.JointType) -> None:
    """The arms of our tables are scenes of links, which carry a base joint of their own."""
    files = disk()
    library = MeshLibrary(files.store, XacroOnly(MODELS))
    for name in ("ur5e", "palletizer", "ar_manipulator"):
        request = scene_pb2.ModelSource(uri=f"model://{name}", name="agv", base_joint=base)
        model = read_model(library, request, files, ())
        (first,) = [node for node in model.nodes if node.kind is Kind.LINK and node.parent == "agv"]
        assert isinstance(first.data, LinkData)
        assert (first.data.joint.type.name, first.data.joint.axis) == (
            nodes_pb2.JointType.Name(base).removeprefix("JOINT_TYPE_"),
            (0.0, 0.0, 1.0),
        )
        structure, _ = structure_of(model.nodes)
        names = list(structure.robots[structure.uid_by_name["agv"]].coordinates)
        assert names[:2] == [f"{first.data.joint.name}/{axis}" for axis in "xy"]


def test_what_has_no_base_of_its_own_takes_no_base_joint() -> None:
    files = disk()
    library = MeshLibrary(files.store, XacroOnly(MODELS))
    planar = nodes_pb2.JOINT_TYPE_PLANAR
    with pytest.raises(KernelError, match=r"takes no base joint \(planar\): it has no robot that stands by itself"):
        read_model(library, scene_pb2.ModelSource(uri="model://vacuum_gripper", base_joint=planar), files, ())
    with pytest.raises(KernelError, match=r"is a scene .* the SRDF file 'a\.srdf' is not for it"):
        read_model(library, scene_pb2.ModelSource(uri="model://ur5e", srdf_uri="a.srdf"), files, ())


@pytest.mark.parametrize("name", ["", "left"])
def test_a_known_model_may_be_a_scene_file_with_a_table(name: str) -> None:
    """`model://NAME` gives the robot under any name, below any node, on any base."""
    known = Model("paper", "six axes", "package://virtualrobot_plugins/models/ar_manipulator.yaml")
    files = disk()
    request = scene_pb2.ModelSource(
        uri="model://paper", name=name, parent="table", base_joint=nodes_pb2.JOINT_TYPE_PLANAR
    )
    request.parent_t_node.position.x = 2.0
    nodes = read_model(MeshLibrary(files.store, XacroOnly({"paper": known})), request, files, {"ar_manipulator"}).nodes
    robot, base = nodes[:2]
    assert robot.name == (name or "ar_manipulator_2")
    assert (robot.parent, robot.parent_t_node[0, 3]) == ("table", 2.0)
    assert isinstance(base.data, LinkData)
    assert base.data.joint.type is JointType.PLANAR
    assert isinstance(robot.data, RobotData)
    assert robot.data.source.endswith("ar_manipulator.yaml")
    structure, _ = structure_of((replace(robot, parent=WORLD_NAME), *nodes[1:]))
    flange = structure.robots[structure.uid_by_name[robot.name]].flange
    assert structure.nodes[flange].name == f"{robot.name}.flange"
