"""SDFormat: the models of pybullet_data as PyBullet loads them, and small ones by the specification."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import nodes_pb2
from virtualrobot_kernel.messages.nodes import node_spec
from virtualrobot_kernel.world.figures import Box
from virtualrobot_kernel.world.structure import JointType, LinkData, NodeSpec
from virtualrobot_plugins.importers.sdf.importer import SdfImporter

from tests.pybullet_models import pybullet
from tests.unit.formats.models import DATA, forward, structure_of
from tests.unit.plugins.importers.reading import refusal, scene

ROBOTS = ["kuka_iiwa/model.sdf", "kuka_iiwa/kuka_with_gripper.sdf", "kuka_iiwa/kuka_with_gripper2.sdf"]
ROBOTS += ["gripper/wsg50_one_motor_gripper_new.sdf", "gripper/wsg50_with_r2d2_gripper.sdf"]


def specs(text: bytes | str, files: dict[str, bytes] | None = None) -> tuple[NodeSpec, ...]:
    """Return the nodes of a file as the kernel makes them from the scene; meshes are left away, no file is read."""
    nodes = []
    for message in scene(SdfImporter(), text, "m.sdf", files).nodes:
        without = nodes_pb2.Node()
        without.CopyFrom(message)
        del without.figures[:]
        without.figures.extend(figure for figure in message.figures if not figure.HasField("mesh"))
        nodes.append(node_spec(without))
    return tuple(nodes)


@contextmanager
def loaded(path: Path) -> Iterator[tuple[int, list[int]]]:
    """Yield PyBullet's client and the bodies of a file."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        yield client, list(pybullet.loadSDF(str(path), physicsClientId=client))
    finally:
        pybullet.disconnect(client)


@pytest.mark.parametrize("name", ROBOTS)
def test_links_are_where_pybullet_puts_them(name: str, rng: np.random.Generator) -> None:
    nodes = specs((DATA / name).read_bytes())
    structure, parent_t_node = structure_of(nodes)
    robot = nodes[0].name
    joints = {node.data.joint.name: node for node in nodes if isinstance(node.data, LinkData)}
    with loaded(DATA / name) as (client, bodies):
        (body,) = bodies
        infos = [
            pybullet.getJointInfo(body, i, physicsClientId=client)
            for i in range(pybullet.getNumJoints(body, physicsClientId=client))
        ]
        moving = {info[1].decode(): i for i, info in enumerate(infos) if info[2] != pybullet.JOINT_FIXED}
        _, index = structure.robot(robot)
        assert sorted(index.joint_names) == sorted(moving)
        for joint, i in moving.items():
            data = joints[joint].data
            assert isinstance(data, LinkData)
            lower, upper = infos[i][8:10]
            if data.joint.type is not JointType.CONTINUOUS and lower < upper:
                assert (data.joint.limits.lower, data.joint.limits.upper) == pytest.approx((lower, upper))
        # Where a link weighs is the same for both, however each lays its frames: so centres of mass are compared.
        for _ in range(10):
            values = {joint: rng.uniform(-2.0, 2.0) for joint in moving}
            for joint, value in values.items():
                pybullet.resetJointState(body, moving[joint], value, physicsClientId=client)
            world_t_node = forward(structure, parent_t_node, np.array([values[n] for n in index.joint_names]))
            ours = {
                node.name.removeprefix(f"{robot}."): world_t_node[node.name] @ node.data.inertial.link_t_inertial
                for node in nodes
                if isinstance(node.data, LinkData) and node.data.inertial is not None
            }
            theirs = {}
            for i, info in enumerate(infos):
                state = pybullet.getLinkState(body, i, computeForwardKinematics=True, physicsClientId=client)
                theirs[info[12].decode()] = pose(state[0], state[1])
            common = [link for link in theirs if link in ours]
            assert len(common) >= len(moving)
            # PyBullet puts the base where it likes, so the first link aligns the two.
            aligned = theirs[common[0]] @ np.linalg.inv(ours[common[0]])
            for link in common[1:]:
                assert (aligned @ ours[link])[:3, 3] == pytest.approx(theirs[link][:3, 3], abs=1e-6), link


def pose(position: tuple[float, ...], quaternion: tuple[float, ...]) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_quat(quaternion).as_matrix(), position
    return matrix


def test_the_kiva_shelf_is_an_object_as_pybullet_has_it() -> None:
    path = DATA / "kiva_shelf/model.sdf"
    message = scene(SdfImporter(), path.read_bytes(), str(path))
    (node,) = message.nodes
    assert node.WhichOneof("kind") == "object" and node.name == "Amazon Pod"
    boxes = [figure for figure in node.figures if figure.HasField("box")]
    (visual,) = [figure for figure in node.figures if figure.HasField("mesh")]
    assert visual.mesh.uri == "meshes/pod_lowres.stl"
    color = visual.material.color
    assert (color.red, color.green, color.blue, color.alpha) == pytest.approx((0.9, 0.8, 0.5, 1.0))
    assert all(list(figure.roles) == [nodes_pb2.FIGURE_ROLE_COLLISION] for figure in boxes)
    world_t_node = node_spec(nodes_pb2.Node(name="n", parent_t_node=node.parent_t_node, object={})).parent_t_node
    ours = []
    for figure in boxes:
        at = nodes_pb2.Node(name="n", parent_t_node=figure.node_t_figure, object={})
        ours.append((world_t_node @ node_spec(at).parent_t_node)[:3, 3])
    with loaded(path) as (client, (body,)):
        shapes = pybullet.getCollisionShapeData(body, -1, physicsClientId=client)
        base = pose(*pybullet.getBasePositionAndOrientation(body, physicsClientId=client))
    theirs = [(base @ pose(shape[5], shape[6]))[:3, 3] for shape in shapes]
    assert len(theirs) == len(ours) == 21
    assert np.array(ours) == pytest.approx(np.array(theirs), abs=1e-5)


def test_every_file_of_pybullet_s_is_read() -> None:
    files = sorted(DATA.rglob("*.sdf"))
    assert len(files) == 15
    for path in files:
        translation = SdfImporter().translate(path.read_bytes(), str(path), {})
        assert json.loads(translation.data)["nodes"], path


def test_a_world_of_two_robots_of_one_name() -> None:
    path = DATA / "kuka_iiwa/model2.sdf"
    translation = SdfImporter().translate(path.read_bytes(), str(path), {})
    names = [node["name"] for node in json.loads(translation.data)["nodes"] if "robot" in node]
    assert names == ["lbr_iiwa", "lbr_iiwa_2"]
    assert translation.warnings == ("model2.sdf:410: there is a model 'lbr_iiwa' already; this one is 'lbr_iiwa_2'",)


BOX = "<geometry><box><size>1 2 3</size></box></geometry>"


def sdf(body: str, version: str = "1.9") -> str:
    return f'<?xml version="1.0"?>\n<sdf version="{version}">\n{body}\n</sdf>\n'


def test_kinds_of_models() -> None:
    text = sdf(
        f"""<world name="w">
        <model name="table"><static>true</static><pose>1 2 3 0 0 0</pose>
          <link name="a"><pose>0 0 1 0 0 0</pose><visual name="v"><pose>0 1 0 0 0 0</pose>{BOX}</visual></link></model>
        <model name="brick"><link name="a"><inertial><mass>2.5</mass></inertial>
          <collision name="c">{BOX}</collision></link></model>
        <model name="pair"><link name="a"><inertial><mass>1</mass></inertial></link>
          <link name="b"><pose>1 0 0 0 0 0</pose><inertial><mass>2</mass></inertial></link>
          <joint name="j" type="fixed"><parent>a</parent><child>b</child></joint></model>
        <model name="loose"><pose>0 0 5 0 0 0</pose><link name="a"/>
          <link name="b"><pose>1 0 0 0 0 0</pose></link></model>
        <model name="post"><link name="a"/>
          <joint name="j" type="fixed"><parent>world</parent><child>a</child></joint></model>
        <light name="sun"/><physics/><plugin name="p"/><plugin name="q"/>
        </world>"""
    )
    translation = SdfImporter().translate(text.encode(), "w.world", {})
    message = scene(SdfImporter(), text, "w.world")
    kinds = {node.name: node.WhichOneof("kind") for node in message.nodes}
    assert kinds == {
        "table": "object",
        "brick": "part",
        "pair": "part",
        "loose_a": "part",
        "loose_b": "part",
        "post": "object",
    }
    nodes = {node.name: node for node in message.nodes}
    assert nodes["brick"].part.mass_kilograms == 2.5 and nodes["pair"].part.mass_kilograms == 3.0
    at = nodes["table"].figures[0].node_t_figure.position
    assert (at.x, at.y, at.z) == (0.0, 1.0, 1.0)
    at = nodes["loose_b"].parent_t_node.position
    assert (at.x, at.y, at.z) == (1.0, 0.0, 5.0)
    assert translation.warnings == (
        "w.world:15: <light> is left out",
        "w.world:15: <physics> is left out",
        "w.world:15: <plugin> is left out, 2 times",
    )


def test_shapes_and_colours() -> None:
    shapes = {
        "box": "<box><size>1 2 3</size></box>",
        "sphere": "<sphere><radius>0.5</radius></sphere>",
        "cylinder": "<cylinder><radius>0.1</radius><length>0.4</length></cylinder>",
        "capsule": "<capsule><radius>0.1</radius><length>0.4</length></capsule>",
        "cone": "<cone><radius>0.1</radius><length>0.4</length></cone>",
        "mesh": "<mesh><uri>model://a/b.dae</uri><scale>1 2 -3</scale><submesh><name>x</name></submesh></mesh>",
        "ellipsoid": "<ellipsoid><radii>1 2 3</radii></ellipsoid>",
        "polyline": "<polyline><point>0 0</point><height>1</height></polyline>",
        "empty": "<empty/>",
        "flat": "<box><size>1 0 3</size></box>",
    }
    visuals = "".join(f'<visual name="{name}"><geometry>{text}</geometry></visual>' for name, text in shapes.items())
    materials = [
        "<material><diffuse>0.1 0.2 0.3 0.5</diffuse></material><transparency>0.5</transparency>",
        "<material><script><name>Gazebo/Orange</name></script></material>",
        "<material><ambient>1 0 0</ambient></material>",
        "<material><script><name>Mine</name></script></material>",
    ]
    visuals += "".join(f'<visual name="m{i}">{BOX}{text}</visual>' for i, text in enumerate(materials))
    text = sdf(f'<model name="m"><link name="l">{visuals}</link></model>')
    translation = SdfImporter().translate(text.encode(), "m.sdf", {})
    (node,) = scene(SdfImporter(), text, "m.sdf").nodes
    assert [figure.WhichOneof("geometry") for figure in node.figures] == [
        *("box", "sphere", "cylinder", "capsule", "cone", "mesh"),
        *("box",) * 4,
    ]
    mesh = node.figures[5].mesh
    assert mesh.uri == "model://a/b.dae" and (mesh.scale.x, mesh.scale.y, mesh.scale.z) == (1.0, 2.0, -3.0)
    colors = [figure.material.color for figure in node.figures[6:9]]
    assert [(c.red, c.green, c.blue, c.alpha) for c in colors] == [
        (0.1, 0.2, 0.3, 0.25),
        (1.0, 0.5088, 0.0468, 1.0),  # diffuse of Gazebo/Orange in Gazebo's gazebo.material
        (1.0, 0.0, 0.0, 1.0),
    ]
    assert not node.figures[9].HasField("material")
    told = "\n".join(translation.warnings)
    for words in ("not only 'x'", "a <ellipsoid> is left out", "a <polyline> is left out", "this <box> has no extent"):
        assert words in told
    assert "the material script 'Mine' is not known" in told


def test_a_plane_is_a_thin_plate_below_it() -> None:
    plane = "<geometry><plane><normal>1 0 0</normal><size>4 2</size></plane></geometry>"
    text = sdf(f'<model name="m"><static>1</static><link name="l"><visual name="v">{plane}</visual></link></model>')
    (node,) = specs(text)
    (figure,) = node.figures
    assert isinstance(figure.geometry, Box) and figure.geometry.size == (4.0, 2.0, 0.001)
    assert figure.node_t_figure[:3, 2] == pytest.approx([1.0, 0.0, 0.0])
    assert figure.node_t_figure[:3, 3] == pytest.approx([-0.0005, 0.0, 0.0])


def test_a_refusal_names_file_line_and_element() -> None:
    text = sdf(
        '<model name="m">\n<link name="l">\n<visual name="v"><geometry><sphere/></geometry></visual></link></model>'
    )
    assert refusal(SdfImporter(), text, "a/m.sdf") == "m.sdf:5: link 'l': <sphere> needs <radius>"


def test_sensors_of_links_and_joints() -> None:
    """A laser on a moving link, whose frame is its joint's, a force sensor in the joint, a camera on a static box."""
    text = (
        '<sdf version="1.9"><world name="w"><model name="arm"><link name="base"/>'
        '<link name="tip"><pose>1 0 0 0 0 0</pose><sensor name="laser" type="gpu_lidar"><pose>0 0 0.25 0 0 0</pose>'
        '<lidar><range><max>5</max></range></lidar></sensor><sensor name="laser" type="imu"/>'
        '<sensor name="odd" type="air_pressure"/></link>'
        '<joint name="hinge" type="continuous"><pose>-0.5 0 0 0 0 0</pose><parent>base</parent><child>tip</child>'
        '<axis><xyz>0 0 1</xyz></axis><sensor name="wrist" type="force_torque"/></joint></model>'
        '<model name="box"><static>true</static><link name="l"><pose>0 0 2 0 0 0</pose>'
        '<sensor name="eye" type="camera"><camera/></sensor></link></model></world></sdf>'
    )
    nodes = {node.name: node for node in specs(text)}
    laser, wrist, eye = nodes["arm.laser"], nodes["arm.wrist"], nodes["box.eye"]
    assert (laser.parent, wrist.parent, eye.parent) == ("arm.tip", "arm.tip", "box")
    # The link's node is where the joint is, half a meter before the link's own frame.
    np.testing.assert_allclose(laser.parent_t_node[:3, 3], [0.5, 0, 0.25])
    np.testing.assert_allclose(wrist.parent_t_node, np.eye(4))
    np.testing.assert_allclose(eye.parent_t_node[:3, 2:].T, [[1, 0, 0], [0, 0, 2]], atol=1e-12)
    assert "arm.laser_2" in nodes
    (warning,) = SdfImporter().translate(text.encode(), "m.sdf", {}).warnings
    assert warning.startswith("m.sdf:1: sensor 'odd': it is left out: its type 'air_pressure'")
