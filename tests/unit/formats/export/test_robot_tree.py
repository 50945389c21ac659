"""What becomes of a robot's frame, names, limits, tools and settings where URDF has no word for them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.world.figures import Box, Cylinder, Figure, Frame, Label, Material, Sphere
from virtualrobot_kernel.world.structure import (
    Inertial,
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    Mimic,
    NodeSpec,
    RobotData,
    ToolData,
)

from tests.unit.formats.export.robots import link, link_data, links_of, made, shapes, turned
from tests.unit.formats.export.worlds import read_back, snapshot_of, written
from tests.unit.formats.models import ROBOTS, load


def test_the_robots_own_frame_becomes_a_link_where_it_must(tmp_path: Path, rng: np.random.Generator) -> None:
    library = MeshLibrary(AssetStore())
    cases = {
        "two roots": made(link("a"), link("b")),
        "moved root": made(link("a", "r", None, turned(rng))),
        "moving root": made(link("a", "r", Joint("j", JointType.CONTINUOUS))),
        "figures": [replace(made()[0], figures=(Figure(Sphere(0.1)),)), link("a")],
    }
    for case, nodes in cases.items():
        file, _ = written(snapshot_of(nodes), library, "r", ".urdf", tmp_path / case)
        after = links_of(read_back(file, library).nodes)
        assert set(after) == {"r", *links_of(tuple(nodes))}, case
        for name, node in links_of(tuple(nodes)).items():
            assert after[name].parent == "r.r"
            assert np.abs(after[name].parent_t_node - node.parent_t_node).max() < 1e-14
        assert bool(after["r"].figures) == (case == "figures")
    assert library.store.has(export_model(snapshot_of(made(link("r"), link("s"))), library, "r", ".urdf").files[0][1])


def test_a_link_may_have_the_robots_name(tmp_path: Path) -> None:
    library = MeshLibrary(AssetStore())
    file, _ = written(snapshot_of(made(link("r"), link("s"))), library, "r", ".urdf", tmp_path)
    assert [element.get("name") for element in ElementTree.parse(file).iter("link")] == ["r_2", "r", "s"]


def test_limits_that_urdf_cannot_say_are_told(tmp_path: Path) -> None:
    one_sided, none = JointLimits(lower=-1.0), JointLimits()
    nodes = made(
        link("base"),
        link("a", "r.base", Joint("a", JointType.REVOLUTE, limits=none)),
        link("b", "r.base", Joint("b", JointType.CONTINUOUS, limits=one_sided)),
        link("c", "r.base", Joint("c", JointType.PRISMATIC, limits=none)),
        link("d", "r.base", Joint("d", JointType.PRISMATIC, limits=JointLimits(0.0, 1.0, 2.0, 3.0, 4.0))),
    )
    library = MeshLibrary(AssetStore())
    file, exported = written(snapshot_of(nodes), library, "r", ".urdf", tmp_path)
    after = links_of(read_back(file, library).nodes)
    joints = {name: link_data(node).joint for name, node in after.items()}
    assert [joints[name].type for name in "abc"] == [JointType.CONTINUOUS, JointType.REVOLUTE, JointType.PRISMATIC]
    assert [(joints[name].limits.lower, joints[name].limits.upper) for name in "bc"] == [(-1.0, 1e9), (-1e9, 1e9)]
    told = "\n".join(exported.warnings)
    for words in ("'a' has no position limits", "'b' has position limits", "'b' lacks", "'c' lacks", "acceleration"):
        assert words in told
    assert len(exported.warnings) == 5


def test_names_become_plain_and_differ(tmp_path: Path) -> None:
    nodes = [
        NodeSpec("my robot", Kind.ROBOT, data=RobotData()),
        NodeSpec("my robot.base", Kind.LINK, "my robot", data=LinkData(Joint("base"))),
        NodeSpec("my robot.ü 1", Kind.LINK, "my robot.base", data=LinkData(Joint("j", JointType.FIXED))),
        NodeSpec("my robot.é 1", Kind.LINK, "my robot.base", data=LinkData(Joint("", JointType.FIXED))),
        NodeSpec("other", Kind.LINK, "my robot.base", data=LinkData(Joint("a b", JointType.CONTINUOUS))),
        NodeSpec("base", Kind.LINK, "other", data=LinkData(Joint("j", JointType.CONTINUOUS, mimic=Mimic("a b")))),
    ]
    nodes[2] = replace(nodes[2], data=LinkData(Joint("joint", JointType.FIXED)))
    library = MeshLibrary(AssetStore())
    file, exported = written(snapshot_of(nodes), library, "my robot", ".urdf", tmp_path)
    assert file.name == "my_robot.urdf"
    tree = ElementTree.parse(file)
    assert [element.get("name") for element in tree.iter("link")] == ["base", "_1", "_1_2", "other", "base_2"]
    assert [element.get("name") for element in tree.findall("joint")] == ["joint", "joint_2", "a_b", "j"]
    assert [element.get("joint") for element in tree.iter("mimic")] == ["a_b"]
    (warning,) = exported.warnings
    assert "'my robot' to 'my_robot'" in warning and "'a b' to 'a_b'" in warning
    after = links_of(read_back(file, library).nodes)
    assert link_data(after["base_2"]).joint.mimic == Mimic("a_b")


def test_tools_are_written_and_parts_are_not(tmp_path: Path, rng: np.random.Generator) -> None:
    model, library = load(ROBOTS["iiwa"], name="arm")
    flange, mount, tip = "arm.lbr_iiwa_link_7", turned(rng), turned(rng)
    tool = ToolData(
        {"tip": tip, "laser": np.eye(4)},
        {"open": {}, "closed": {}},
        Inertial(0.9, turned(rng), (0.1, 0.2, 0.3), (0.0, 0.0, 0.0)),
    )
    jaws = tuple(Figure(Box((size, 0.1, 0.1)), tool_state=state) for size, state in ((0.2, "open"), (0.3, "closed")))
    material = Material((1.0, 0.0, 0.0, 1.0), friction=0.9)
    nodes = [
        *model.nodes,
        NodeSpec("changer", Kind.ADAPTER, flange, mount, figures=(Figure(Cylinder(0.05, 0.02)),)),
        NodeSpec("gun", Kind.TOOL, "changer", figures=(*jaws, Figure(Frame()), Figure(Label("a"))), data=tool),
        NodeSpec("held", Kind.PART, "gun", figures=(Figure(Sphere(0.1)),)),
        NodeSpec("below", Kind.OBJECT, "held"),
        NodeSpec("cable", Kind.OBJECT, "arm.lbr_iiwa_link_3", figures=(Figure(Sphere(0.1), material=material),)),
    ]  # fmt: skip
    nodes[3] = replace(nodes[3], hidden=True, figures=(*nodes[3].figures, Figure(Sphere(0.2), material=material)))
    snapshot = snapshot_of(nodes, tool_states={"gun": "closed"})
    file, exported = written(snapshot, library, "arm", ".urdf", tmp_path)
    after = links_of(read_back(file, library).nodes)
    assert set(after) - set(links_of(tuple(model.nodes))) == {"changer", "gun", "gun_tip", "gun_laser"}
    assert after["changer"].parent == flange and after["gun"].parent == "arm.changer"
    assert after["gun_tip"].parent == "arm.gun" and np.abs(after["gun_tip"].parent_t_node - tip).max() < 1e-14
    assert np.abs(after["changer"].parent_t_node - mount).max() < 1e-14
    assert link_data(after["gun"]).joint.type is JointType.FIXED
    inertial = link_data(after["gun"]).inertial
    assert inertial and (inertial.mass, inertial.diagonal) == (0.9, (0.1, 0.2, 0.3))
    assert [shape for shape, _ in shapes(after["gun"], True)] == [Box((0.3, 0.1, 0.1))]
    told = exported.warnings
    assert [text.split(" is ")[0] for text in told[:2]] == ["the adapter 'changer'", "the tool 'gun'"]
    assert "'closed'" in told[1]
    assert told[2].endswith("'held', 'cable'")
    assert f": {nodes[3].name!r} will be seen" in told[3]
    assert "'gun' are left out" in told[4] and "friction" in told[5] and len(told) == 6


def test_what_only_srdf_can_say_is_told() -> None:
    nodes = made(link("a", "r", Joint("j", JointType.CONTINUOUS)), flange="a", postures={"home": {"j": 0.5}})
    library = MeshLibrary(AssetStore())
    (warning,) = export_model(snapshot_of(nodes), library, "r", ".urdf").warnings
    assert "the flange, postures of 'r'" in warning


def test_only_robots_are_urdf() -> None:
    library = MeshLibrary(AssetStore())
    world = snapshot_of(
        [*made(link("a")), NodeSpec("table", Kind.OBJECT), NodeSpec("bare", Kind.ROBOT, data=RobotData())]
    )
    for name, words in {
        "": "the world is none; robots: 'bare', 'r'",
        "table": "'bare', 'r'",
        "r.a": "its robot is 'r'",
    }.items():
        with pytest.raises(KernelError, match=words):
            export_model(world, library, name, ".urdf")
    with pytest.raises(KernelError, match="'bare' has no link"):
        export_model(world, library, "bare", ".urdf")
    with pytest.raises(KernelError, match="no robot yet"):
        export_model(snapshot_of([NodeSpec("table", Kind.OBJECT)]), library, "table", ".urdf")
