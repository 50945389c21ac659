"""Robots written as URDF and read back by the kernel's own reader: the same joints, limits, poses and shapes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.export.urdf import roll_pitch_yaw
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Material, Mesh, Sphere
from virtualrobot_kernel.world.structure import Inertial, Joint, JointLimits, JointType, LinkData, Mimic, NodeSpec
from virtualrobot_sdk.poses import from_roll_pitch_yaw

from tests.unit.formats.export.robots import link, link_data, links_of, made, shapes, turned
from tests.unit.formats.export.worlds import drawn, read_back, snapshot_of, written
from tests.unit.formats.models import (
    ROBOTS,
    TETRAHEDRON,
    TETRAHEDRON_FACES,
    binary_stl,
    forward,
    load,
    structure_of,
    volume,
)


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
    told = [warning for warning in model.warnings if "transmission" not in warning]
    assert len(back.warnings) == len(told), "some models name materials that nobody has"
    assert back.nodes[0].name == "arm" and back.mesh_count == model.mesh_count
    assert [node.name for node in back.nodes] == [node.name for node in model.nodes]
    for place, (one, again) in enumerate(zip(model.nodes[1:], back.nodes[1:], strict=True)):
        assert_same_link(one, again, is_root=place == 0)
    structure, poses = structure_of(back.nodes)
    q = drawn(structure, rng)
    there, again = forward(*structure_of(model.nodes), q), forward(structure, poses, q)
    assert max(np.abs(there[name] - again[name]).max() for name in there) < 1e-12
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
    for name, one in before.items():
        assert_same_link(one, after[name], is_root=False)
    structure, poses = structure_of(model.nodes)
    q = drawn(structure, rng)
    there, again = forward(structure, poses, q), forward(*structure_of(back.nodes), q)
    assert max(np.abs(there[name] - again[name]).max() for name in there) < 1e-12


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
    assert [path for path, _ in exported.files] == ["r.urdf", "meshes/r/cone.stl", "meshes/r/capsule.stl"]
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


def test_the_scale_of_a_mesh_stays_in_the_urdf(tmp_path: Path) -> None:
    library = MeshLibrary(AssetStore())
    sha256 = library.store.put(binary_stl(TETRAHEDRON, TETRAHEDRON_FACES))
    scales = [(2.0, -1.0, 0.1), (1.0, 1.0, 1.0)]
    nodes = made(link("a", "r", None, None, *(Figure(Mesh("tetra.stl", sha256, scale)) for scale in scales)))
    file, exported = written(snapshot_of(nodes), library, "r", ".urdf", tmp_path)
    assert [path for path, _ in exported.files] == ["r.urdf", "meshes/r/tetra.stl"]
    after = links_of(read_back(file, library).nodes)["a"]
    meshes = [figure.geometry for figure in after.figures if figure.visual]
    assert [mesh.scale for mesh in meshes if isinstance(mesh, Mesh)] == scales


@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-4, 0.5])
def test_roll_pitch_yaw_give_the_rotation_back_at_every_pitch(off: float, rng: np.random.Generator) -> None:
    """R = Rz(yaw) Ry(pitch) Rx(roll); at a quarter turn of pitch the plain formulas lose half of the digits."""
    for side in (-1.0, 1.0):
        for roll, yaw in rng.uniform(-np.pi, np.pi, (50, 2)):
            rotation = from_roll_pitch_yaw(roll, side * (0.5 * np.pi - off), yaw)
            again = Rotation.from_euler("xyz", roll_pitch_yaw(rotation)).as_matrix()
            assert np.abs(again - rotation).max() < 1e-14


def test_the_same_robot_gives_the_same_bytes() -> None:
    first, second = (load(ROBOTS["panda"], name="arm") for _ in range(2))
    files = [export_model(snapshot_of(model.nodes), library, "arm", ".urdf") for model, library in (first, second)]
    assert files[0] == files[1]
