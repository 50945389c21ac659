"""Real robots load whole, and their links are where other engines put them."""

import re
from pathlib import PurePosixPath

import numpy as np
import pinocchio as pin  # pyright: ignore[reportMissingImports]  its wheel has a folder of its own
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.structure import JointType, Kind, LinkData, NodeSpec

from tests.pybullet_models import pybullet
from tests.unit.formats.models import (
    DATA,
    ROBOTS,
    corner_positions,
    count_triangles,
    forward,
    load,
    structure_of,
    without_comments,
)

# Husky's file holds what only its xacro tool and PyBullet read; written out by hand for pinocchio.
OPTENV = {
    "$(optenv HUSKY_IMU_RPY 0 -1.5708 3.1416)": "0 -1.5708 3.1416",
    "$(optenv HUSKY_IMU_XYZ 0.19 0 0.149)": "0.19 0 0.149",
}


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


@pytest.mark.parametrize("robot", ROBOTS)
def test_as_many_meshes_and_links_as_the_file_names(robot: str) -> None:
    text = without_comments(ROBOTS[robot])
    model, _ = load(ROBOTS[robot])
    figures = [figure for node in model.nodes for figure in node.figures]
    count = len(re.findall(r"<mesh\b", text))
    assert model.mesh_count == count == sum(isinstance(figure.geometry, Mesh) for figure in figures)
    assert sum(figure.visual for figure in figures) == len(re.findall(r"<visual\b", text))
    assert sum(figure.collision for figure in figures) == len(re.findall(r"<collision\b", text))
    assert [node.kind for node in model.nodes] == [Kind.ROBOT] + [Kind.LINK] * len(re.findall(r"<link\b", text))


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


@pytest.mark.parametrize("robot", ROBOTS)
def test_links_are_where_pinocchio_puts_them(robot: str, rng: np.random.Generator) -> None:
    nodes = load(ROBOTS[robot], name="it")[0].nodes
    structure, parent_t_node = structure_of(nodes)
    text = ROBOTS[robot].read_text()
    for written, meant in OPTENV.items():
        text = text.replace(written, meant)
    model = pin.buildModelFromXML(text)
    data = model.createData()
    _, robot_index = structure.robot("it")
    for _ in range(20):
        values = joint_values(nodes, rng)
        q = np.array([values[name] for name in robot_index.joint_names])
        theirs = pin.neutral(model)
        for name, value in values.items():
            joint = model.joints[model.getJointId(name)]
            # pinocchio holds a joint without limits as cosine and sine.
            theirs[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        pin.framesForwardKinematics(model, data, theirs)
        world_t_node = forward(structure, parent_t_node, q)
        for node in nodes[1:]:
            frame = model.getFrameId(node.name.removeprefix("it."), pin.FrameType.BODY)
            assert np.abs(world_t_node[node.name] - data.oMf[frame].homogeneous).max() < 1e-9, node.name


@pytest.mark.parametrize("robot", ROBOTS)
def test_links_are_where_pybullet_puts_them(robot: str, rng: np.random.Generator) -> None:
    nodes = load(ROBOTS[robot], name="it")[0].nodes
    structure, parent_t_node = structure_of(nodes)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(ROBOTS[robot]), useFixedBase=True, physicsClientId=client)
        values = joint_values(nodes, rng)
        links = {}
        for i in range(pybullet.getNumJoints(body, physicsClientId=client)):
            info = pybullet.getJointInfo(body, i, physicsClientId=client)
            links[info[12].decode()] = i
            if (value := values.get(info[1].decode())) is not None:
                pybullet.resetJointState(body, i, value, physicsClientId=client)
        _, robot_index = structure.robot("it")
        q = np.array([values[name] for name in robot_index.joint_names])
        world_t_node = forward(structure, parent_t_node, q)
        assert len(links) == len(nodes) - 2  # all but the robot and its base link
        for name, i in links.items():
            if name == "imu_link" and robot == "husky":
                continue  # PyBullet reads $(optenv ...) as zeros
            state = pybullet.getLinkState(body, i, computeForwardKinematics=True, physicsClientId=client)
            pose = np.eye(4)
            pose[:3, 3] = state[4]
            pose[:3, :3] = Rotation.from_quat(state[5]).as_matrix()
            # PyBullet keeps frames relative to centres of mass and cuts small numbers off on its way.
            assert np.abs(world_t_node[f"it.{name}"] - pose).max() < 1e-6, name
    finally:
        pybullet.disconnect(client)


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
