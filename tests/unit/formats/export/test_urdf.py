"""Robots written as URDF and read back by the kernel's own reader: the same joints, limits, poses and shapes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.export.urdf import roll_pitch_yaw
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.urdf_elements import rotation_from_rpy
from virtualrobot_kernel.world.figures import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Figure,
    Frame,
    Label,
    Material,
    Mesh,
    Sphere,
)
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

from tests.unit.formats.export.worlds import drawn, read_back, snapshot_of, written
from tests.unit.formats.models import ROBOTS, forward, load, structure_of, volume


def links_of(nodes: tuple[NodeSpec, ...]) -> dict[str, NodeSpec]:
    """Return the links by their names without the robot's."""
    robot = nodes[0].name
    return {node.name.removeprefix(f"{robot}."): node for node in nodes[1:]}


def link_data(node: NodeSpec) -> LinkData:
    assert isinstance(node.data, LinkData)
    return node.data


def shapes(node: NodeSpec, visual: bool) -> list[tuple]:
    """Return the shapes of one role: geometry (a mesh by its content and scale) and colour."""
    found = []
    for figure in node.figures:
        if figure.visual if visual else figure.collision:
            shape = figure.geometry
            what = (shape.sha256, shape.scale, [sha for _, sha in shape.files]) if isinstance(shape, Mesh) else shape
            found.append((what, figure.material.color if figure.material and visual else None))
    return found


def assert_same_link(before: NodeSpec, after: NodeSpec, is_root: bool) -> None:
    a, b = link_data(before), link_data(after)
    if not is_root:
        assert (a.joint.name, a.joint.type, a.joint.mimic) == (b.joint.name, b.joint.type, b.joint.mimic)
        if a.joint.type is not JointType.FLOATING:  # whose axis means nothing
            assert a.joint.axis == pytest.approx(b.joint.axis, abs=1e-15)
        assert a.joint.limits == b.joint.limits
        assert np.abs(before.parent_t_node - after.parent_t_node).max() < 1e-14
    assert (a.inertial is None) == (b.inertial is None)
    if a.inertial and b.inertial:
        assert (a.inertial.mass, a.inertial.diagonal, a.inertial.products) == (
            b.inertial.mass,
            b.inertial.diagonal,
            b.inertial.products,
        )
        assert np.abs(a.inertial.link_t_inertial - b.inertial.link_t_inertial).max() < 1e-14
    for visual in (True, False):
        assert shapes(before, visual) == shapes(after, visual)
        for role in (before, after):
            assert all(figure.visual or figure.collision for figure in role.figures)
        poses = [[f.node_t_figure for f in n.figures if (f.visual if visual else f.collision)] for n in (before, after)]
        assert all(np.abs(p - q).max() < 1e-14 for p, q in zip(*poses, strict=True))


@pytest.mark.parametrize("name", ["iiwa", "panda", "r2d2", "a1", "xarm6_gripper"])
def test_a_robot_comes_back(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    model, library = load(ROBOTS[name], name="arm")
    before = snapshot_of(model.nodes, drawn(structure_of(model.nodes)[0], rng))  # the posture is not in the file
    file, exported = written(before, library, "arm", ".urdf", tmp_path)
    assert exported.warnings == ()
    assert file.name == "arm.urdf" and exported.files[0][0] == "arm.urdf"
    back = read_back(file, library)
    assert len(back.warnings) == len(model.warnings), "some models name materials that nobody has"
    assert back.nodes[0].name == "arm" and back.mesh_count == model.mesh_count
    assert [node.name for node in back.nodes] == [node.name for node in model.nodes]
    for place, (link, again) in enumerate(zip(model.nodes[1:], back.nodes[1:], strict=True)):
        assert_same_link(link, again, is_root=place == 0)
    structure, poses = structure_of(back.nodes)
    q = drawn(structure, rng)
    there, again = forward(*structure_of(model.nodes), q), forward(structure, poses, q)
    assert max(np.abs(there[link] - again[link]).max() for link in there) < 1e-12
    # Written once more it is the same file: nothing is lost on the way.
    second, _ = written(snapshot_of(back.nodes), library, "arm", ".urdf", tmp_path / "again")
    assert second.read_bytes() == file.read_bytes()


@pytest.mark.parametrize("base", [JointType.FLOATING, JointType.PLANAR])
def test_a_moving_base_stays_a_joint(base: JointType, tmp_path: Path, rng: np.random.Generator) -> None:
    model, library = load(ROBOTS["r2d2"], base, name="droid")
    file, exported = written(snapshot_of(model.nodes), library, "droid", ".urdf", tmp_path)
    assert exported.warnings == ()
    back = read_back(file, library)
    before, after = links_of(model.nodes), links_of(back.nodes)
    assert set(after) - set(before) == {"droid"} and not after["droid"].figures
    assert after["base_link"].parent == "droid.droid"
    for name, link in before.items():
        assert_same_link(link, after[name], is_root=False)
    structure, poses = structure_of(model.nodes)
    q = drawn(structure, rng)
    there, again = forward(structure, poses, q), forward(*structure_of(back.nodes), q)
    assert max(np.abs(there[link] - again[link]).max() for link in there) < 1e-12


def made(*links: NodeSpec, **data: object) -> list[NodeSpec]:
    """Return a robot `r` with the given links."""
    return [NodeSpec("r", Kind.ROBOT, data=RobotData(**data)), *links]  # pyright: ignore[reportArgumentType]


def link(
    name: str, parent: str = "r", joint: Joint | None = None, place: np.ndarray | None = None, *figures: Figure
) -> NodeSpec:
    return NodeSpec(
        f"r.{name}",
        Kind.LINK,
        parent,
        np.eye(4) if place is None else place,
        figures=figures,
        data=LinkData(joint or Joint(f"to_{name}")),
    )


def turned(rng: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
    pose[:3, 3] = rng.uniform(-1.0, 1.0, 3)
    return pose


def test_a_robot_made_by_hand_with_all_joints_and_shapes(tmp_path: Path, rng: np.random.Generator) -> None:
    axis = rng.normal(size=3)
    axis = tuple((axis / np.linalg.norm(axis)).tolist())
    limits = JointLimits(-1.25, 0.1 + 0.2, 1.5, 6.0, 60.0, 33.0)
    cone = Figure(Cone(0.1, 0.3), turned(rng))
    color = Material((0.1, 0.2, 0.3, 0.4))
    nodes = made(
        link("base", "r", None, None, Figure(Box((1, 2, 3)), turned(rng), color)),
        link("a", "r.base", Joint("a", JointType.REVOLUTE, axis, limits), turned(rng), cone),
        link("b", "r.a", Joint("b", JointType.PRISMATIC, axis, limits), turned(rng), Figure(Capsule(0.1, 0.3))),
        link("c", "r.b", Joint("c", JointType.CONTINUOUS, axis), turned(rng), Figure(Cylinder(0.1, 0.3), visual=False)),
        link(
            "d", "r.a", Joint("d", JointType.REVOLUTE, axis, limits, Mimic("a", -0.5, 0.125)), turned(rng),
            Figure(Sphere(0.25), collision=False), Figure(Cone(0.1, 0.3)),
        ),
        link("e", "r.c", Joint("e", JointType.FLOATING), turned(rng)),
        link("f", "r.d", Joint("f", JointType.PLANAR, axis), turned(rng)),
    )  # fmt: skip
    nodes[1] = replace(
        nodes[1], data=LinkData(Joint("base"), Inertial(2.5, turned(rng), (0.1, 0.2, 0.3), (0.01, 0.02, 0.03)))
    )
    library = MeshLibrary(AssetStore())
    file, exported = written(snapshot_of(nodes), library, "r", ".urdf", tmp_path)
    assert exported.warnings == ()
    assert [path for path, _ in exported.files] == ["r.urdf", "meshes/cone.stl", "meshes/capsule.stl"]
    back = read_back(file, library)
    before, after = links_of(tuple(nodes)), links_of(back.nodes)
    assert set(before) == set(after)
    for name in before:
        a, b = link_data(before[name]), link_data(after[name])
        if name != "base":
            assert np.abs(before[name].parent_t_node - after[name].parent_t_node).max() < 1e-14
            assert (a.joint.name, a.joint.type, a.joint.limits, a.joint.mimic) == (
                b.joint.name,
                b.joint.type,
                b.joint.limits,
                b.joint.mimic,
            )
            assert name == "e" or a.joint.axis == pytest.approx(b.joint.axis, abs=1e-15)
    assert [figure.geometry for figure in after["c"].figures] == [Cylinder(0.1, 0.3)]
    assert [(figure.visual, figure.collision) for figure in after["d"].figures] == [
        (True, False),
        (True, False),
        (False, True),
    ]
    assert after["base"].figures[0].material == color
    # The cone is a mesh now: its volume by the formula, less what 48 flat sides lack; its tip where it was.
    mesh = after["a"].figures[0].geometry
    assert isinstance(mesh, Mesh)
    (part,) = library.load(mesh)
    assert 0.98 * np.pi * 0.01 * 0.1 < volume(part.vertices, part.faces) <= np.pi * 0.01 * 0.1
    assert part.vertices[part.vertices[:, 2].argmax()] == pytest.approx([0.0, 0.0, 0.15], abs=1e-6)
    assert np.abs(after["a"].figures[0].node_t_figure - cone.node_t_figure).max() < 1e-14
    inertial = link_data(after["base"]).inertial
    assert inertial and (inertial.mass, inertial.products) == (2.5, (0.01, 0.02, 0.03))


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
    tool = ToolData({"tip": tip, "laser": np.eye(4)}, {"open": {}, "closed": {}})
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


@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-4, 0.5])
def test_roll_pitch_yaw_give_the_rotation_back_at_every_pitch(off: float, rng: np.random.Generator) -> None:
    """R = Rz(yaw) Ry(pitch) Rx(roll); at a quarter turn of pitch the plain formulas lose half of the digits."""
    for side in (-1.0, 1.0):
        for roll, yaw in rng.uniform(-np.pi, np.pi, (50, 2)):
            rotation = rotation_from_rpy(roll, side * (0.5 * np.pi - off), yaw)
            again = Rotation.from_euler("xyz", roll_pitch_yaw(rotation)).as_matrix()
            assert np.abs(again - rotation).max() < 1e-14


def test_the_same_robot_gives_the_same_bytes() -> None:
    first, second = (load(ROBOTS["panda"], name="arm") for _ in range(2))
    files = [export_model(snapshot_of(model.nodes), library, "arm", ".urdf") for model, library in (first, second)]
    assert files[0] == files[1]
