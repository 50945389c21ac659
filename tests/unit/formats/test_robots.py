"""Real robots load whole: triangles, limits, colours, masses; tests of every model say where their links are."""

import re
from pathlib import PurePosixPath

import numpy as np
import pytest
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.structure import JointType, LinkData, NodeSpec

from tests.unit.formats.models import (
    DATA,
    ROBOTS,
    corner_positions,
    count_triangles,
    load,
    structure_of,
    without_comments,
)

# Husky's file holds what only its xacro tool and PyBullet read; written out by hand for pinocchio.


def joints(nodes: tuple[NodeSpec, ...]) -> dict[str, LinkData]:
    return {node.data.joint.name: node.data for node in nodes if isinstance(node.data, LinkData)}


def joint_values(nodes: tuple[NodeSpec, ...], rng: np.random.Generator) -> dict[str, float]:
    """Draw a value for each joint that moves; mimic joints get theirs by m x + b, as URDF says."""
    data = joints(nodes)
    values = {
        name: rng.uniform(-3.0, 3.0)
        for name, link in data.items()
        if link.joint.type.coordinate_count == 1 and not link.joint.mimic
    }
    for name, link in data.items():
        if (mimic := link.joint.mimic) is not None:
            values[name] = mimic.multiplier * values[mimic.joint] + mimic.offset
    return values


@pytest.mark.long
@pytest.mark.parametrize("robot", ROBOTS)
def test_every_triangle_of_every_mesh_is_there(robot: str) -> None:
    model, library = load(ROBOTS[robot])
    meshes = {figure.geometry for node in model.nodes for figure in node.figures if isinstance(figure.geometry, Mesh)}
    assert meshes
    for mesh in meshes:
        data, kind = library.store.get(mesh.sha256), ending(mesh.uri)
        parts = library.load(mesh)
        assert sum(len(part.faces) for part in parts) == count_triangles(data, kind), mesh.uri
        expected = corner_positions(data, kind) * mesh.scale
        used = np.concatenate([part.vertices[part.faces].reshape(-1, 3) for part in parts])
        assert used.min(axis=0) == pytest.approx(expected.min(axis=0), rel=1e-6)
        assert used.max(axis=0) == pytest.approx(expected.max(axis=0), rel=1e-6)


def test_limits_of_the_panda_are_those_of_its_data_sheet() -> None:
    # Franka Emika Robot's documentation, "Limits for Panda": q_min, q_max in rad, dq_max in rad/s, as in its URDF.
    data = joints(load(ROBOTS["panda"])[0].nodes)
    limits = [data[f"panda_joint{i}"].joint.limits for i in range(1, 8)]
    assert [limit.lower for limit in limits] == [-2.9671, -1.8326, -2.9671, -3.1416, -2.9671, -0.0873, -2.9671]
    assert [limit.velocity for limit in limits] == [2.1750] * 4 + [2.6100] * 3
    assert [limit.effort for limit in limits] == [87.0] * 4 + [12.0] * 3


def test_continuous_joints_have_no_limits_of_position() -> None:
    data = joints(load(ROBOTS["husky"])[0].nodes)
    wheels = [link.joint for link in data.values() if link.joint.type is JointType.CONTINUOUS]
    assert len(wheels) == 4
    assert all((joint.limits.lower, joint.limits.upper) == (-np.inf, np.inf) for joint in wheels)


def test_mimic_joints_of_the_xarm_gripper_follow_one_joint() -> None:
    nodes = load(ROBOTS["xarm6_gripper"], name="it")[0].nodes
    mimics = {name: link.joint.mimic for name, link in joints(nodes).items() if link.joint.mimic}
    assert len(mimics) == len(re.findall(r"<mimic\b", without_comments(ROBOTS["xarm6_gripper"]))) > 0
    assert {mimic.joint for mimic in mimics.values()} == {"drive_joint"}
    _, robot_index = structure_of(nodes)[0].robot("it")
    assert not set(mimics) & set(robot_index.joint_names)


def test_husky_has_links_without_shapes_and_the_place_of_its_imu() -> None:
    nodes = {node.name.partition(".")[2]: node for node in load(ROBOTS["husky"])[0].nodes}
    assert nodes["base_footprint"].figures == ()
    assert nodes["imu_link"].parent_t_node[:3, 3] == pytest.approx([0.19, 0.0, 0.149])


def test_husky_wheels_have_the_mass_and_inertia_of_the_file() -> None:
    wheel = next(node for node in load(ROBOTS["husky"])[0].nodes if node.name.endswith("front_left_wheel_link"))
    assert isinstance(wheel.data, LinkData) and wheel.data.inertial is not None
    text = without_comments(ROBOTS["husky"])
    link = text[text.index('<link name="front_left_wheel_link"') :]
    assert wheel.data.inertial.mass == float(re.search(r'mass value="([^"]+)"', link)[1])  # pyright: ignore[reportOptionalSubscript]
    assert wheel.data.inertial.diagonal[0] == float(re.search(r'ixx="([^"]+)"', link)[1])  # pyright: ignore[reportOptionalSubscript]


def test_colours_come_from_material_files_and_from_the_urdf() -> None:
    model, library = load(ROBOTS["panda"])
    hand = next(node for node in model.nodes if node.name.endswith(".panda_hand"))
    mesh = next(figure.geometry for figure in hand.figures if figure.visual)
    assert isinstance(mesh, Mesh)
    # Several materials in one file: as many colours as its MTL file tells for the materials in use.
    folder = DATA / "franka_panda/meshes/visual"
    used = set(re.findall(r"^usemtl (\S+)", (folder / "hand.obj").read_text(), re.MULTILINE))
    told = dict(
        re.findall(r"^newmtl (\S+).*?^Kd ([^\n]+)", (folder / "hand.mtl").read_text(), re.MULTILINE | re.DOTALL)
    )
    expected = sorted(tuple(round(float(word), 2) for word in told[name].split()) for name in used)
    colors = sorted(tuple(round(part, 2) for part in (part_of.color or ())[:3]) for part_of in library.load(mesh))
    assert len(expected) > 1
    assert np.array(colors) == pytest.approx(np.array(expected), abs=0.011)  # 8 bits a colour
    husky = next(node for node in load(ROBOTS["husky"])[0].nodes if node.name.endswith(".base_link"))
    first = next(figure for figure in husky.figures if figure.visual)
    assert first.material is not None and first.material.color == (0.1, 0.1, 0.1, 1.0)  # Black of the file


def test_the_trunk_of_a1_has_its_texture() -> None:
    model, library = load(ROBOTS["a1"])
    trunk = next(node for node in model.nodes if node.name.endswith(".trunk"))
    mesh = next(figure.geometry for figure in trunk.figures if isinstance(figure.geometry, Mesh))
    assert [PurePosixPath(name).name for name, _ in mesh.files] == ["trunk.mtl", "trunk_A1.png"]
    part = library.load(mesh)[0]
    assert part.texture is not None and part.texture.startswith(b"\x89PNG")
    assert part.uv is not None and part.uv.shape == (len(part.vertices), 2)
