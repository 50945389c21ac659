"""Bad input: refused with the reason, the bad value and what would be right; and the world is as it was before."""

from __future__ import annotations

from typing import Any

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, motion_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, start
from tests.api.moving import about, circular, linear, to_pose, trajectory
from tests.api.reading import array, unchanged
from tests.api.test_asset import upload
from tests.api.test_robot import forward
from tests.api.test_scene import update
from tests.api.test_tool import pick
from tests.kernels import Stubs

FLOAT64, UINT8 = geometry_pb2.NUMERIC_TYPE_FLOAT64, geometry_pb2.NUMERIC_TYPE_UINT8
JOINT = "lbr_iiwa_joint_2"
LINKS = '<link name="a"/><link name="b"/>'
HINGE = '<joint name="j" type="{}"><parent link="{}"/><child link="b"/>{}</joint>'
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'

URDFS = {
    "mesh": ('<link name="a"><visual><geometry><mesh filename="a.stl"/></geometry></visual></link>', "a.stl"),
    "loop": (LINKS + HINGE.format("fixed", "a", "") + HINGE.format("fixed", "b", "").replace('"b"/></', '"a"/></'), ""),
    "parent": (LINKS + HINGE.format("fixed", "c", ""), "'c'"),
    "nan": (LINKS + HINGE.format("revolute", "a", '<origin xyz="0 nan 0"/>' + LIMIT), "nan"),
    "axis": (LINKS + HINGE.format("revolute", "a", '<axis xyz="0 0 0"/>' + LIMIT), "axis"),
    "twice": (LINKS + '<link name="a"/>', "'a'"),
    "limits": (LINKS + HINGE.format("revolute", "a", LIMIT.replace('"-1"', '"2"')), "2"),
    "nothing": ("", "link"),
    "broken": ("<link", ""),
}


@pytest.mark.parametrize("kind", URDFS)
def test_bad_models(stepped: Stubs, kind: str) -> None:
    body, named = URDFS[kind]
    sha256 = upload(stepped, f'<robot name="r">\n{body}\n</robot>'.encode())
    with unchanged(stepped):
        files = [nodes_pb2.AssetFile(uri="bad.urdf", sha256=sha256)]
        refused = refusal(lambda: load(stepped, "bad.urdf", files=files))
    assert refused.reason == ("MISSING_FILE" if kind == "mesh" else "MALFORMED_FILE")
    assert refused.message.startswith("bad.urdf")
    assert named in refused.message


@pytest.mark.parametrize(
    "uri", ["", "model.doc", "nothing.urdf", "package://nowhere/a.urdf", "\0.urdf", "x" * 999 + ".stl"]
)
def test_models_that_are_not_there(stepped: Stubs, uri: str) -> None:
    with unchanged(stepped):
        assert refusal(lambda: load(stepped, uri)).reason in ("INVALID_ARGUMENT", "MISSING_FILE", "MALFORMED_FILE")


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("nodes: []\n", 1, "schema_version: 1"),
        ("schema_version: 2\n", 1, "'2'"),
        ("schema_version: 1\nnodes:\n- name: a\n  objcet: {}\n", 4, "'objcet'; did you mean 'object'?"),
        ("schema_version: 1\nnodes:\n- name: a\n  name: b\n  object: {}\n", 4, "twice; first on line 3"),
        ("schema_version: 1\nnodes:\n- name: a\n  hidden: on\n  object: {}\n", 4, "true or false"),
        ("schema_version: 1\nnodes:\n- name: a\n  object: {}\n  part: {}\n", 5, "only one kind"),
        ("schema_version: 1\nnodes: {\n", 3, "YAML"),
        ("schema_version: 1\nnodes:\n- name: a\n  parent_t_node: {position: {x: .nan}}\n  object: {}\n", 4, "a number"),
    ],
)
def test_bad_scene_files(stepped: Stubs, text: str, line: int, said: str) -> None:
    apply(stepped, create(box("kept")))
    with unchanged(stepped):
        refused = refusal(lambda: stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text, uri="cell.yaml")))
    assert (refused.code, refused.reason) == (grpc.StatusCode.INVALID_ARGUMENT, "MALFORMED_FILE")
    assert refused.message.startswith(f"cell.yaml:{line}")
    assert said in refused.message
    assert (refused.metadata["file"], refused.metadata["line"]) == ("cell.yaml", str(line))


def test_a_world_and_a_batch_have_limits(stepped: Stubs) -> None:
    """Work that would hold up the kernel for seconds is refused before it is begun."""
    nodes = "".join(f"- {{name: n{number}, object: {{}}}}\n" for number in range(20_000))  # and the world itself
    scene = scene_pb2.LoadSceneRequest(text=f"schema_version: 1\nnodes:\n{nodes}- {{name: last, object: {{}}}}\n")
    many = [create(nodes_pb2.Node(name=f"n{number}", object=nodes_pb2.SceneObject())) for number in range(20_000)]
    with unchanged(stepped):
        for call, said in (
            (lambda: stepped.scene.LoadScene(scene), "a world may have 20,000 nodes, not 20,002"),
            (lambda: apply(stepped, *many), "a world may have 20,000 nodes, not 20,001"),
            (lambda: apply(stepped, *many, scene_pb2.Command()), "a batch may have 20,000 commands, not 20,001"),
        ):
            refused = refusal(call)
            assert (refused.code, refused.reason) == (grpc.StatusCode.RESOURCE_EXHAUSTED, "TOO_LARGE")
            assert said in refused.message
            assert refused.metadata["limit"] == "20000"


def test_joints_outside_their_limits(stepped: Stubs) -> None:
    """The limits are those of the URDF: 2.09439510239 rad."""
    load(stepped, IIWA, "arm")
    jump = scene_pb2.SetJointPositions(robot="arm", joint_positions={JOINT: -2.2})
    home = nodes_pb2.NamedPosture(name="home", joint_positions={JOINT: -2.2})
    with unchanged(stepped):
        for call in (
            lambda: apply(stepped, scene_pb2.Command(set_joint_positions=jump)),
            lambda: apply(stepped, update("arm", "robot", robot=nodes_pb2.Robot(postures=[home]))),
            lambda: start(stepped, joints("arm", lbr_iiwa_joint_2=-2.2)),
            lambda: forward(stepped, "arm", {JOINT: -2.2}),
            lambda: start(stepped, trajectory("arm", [JOINT], [0.0, 3.0], [[0.0], [-2.2]])),
        ):
            refused = refusal(call)
            assert (refused.code, refused.reason) == (grpc.StatusCode.OUT_OF_RANGE, "LIMIT_EXCEEDED")
            assert refused.metadata["joint"] == JOINT
            assert float(refused.metadata["lower"]) == pytest.approx(-2.09439510239)
            assert JOINT in refused.message
            assert "-2.09" in refused.message


def figure(kind: str, **fields: Any) -> scene_pb2.Command:  # noqa: ANN401 fields of a geometry
    shape = nodes_pb2.Figure()
    getattr(shape, kind).MergeFrom(getattr(nodes_pb2, kind.capitalize())(**fields))
    return create(nodes_pb2.Node(name="a", annotation=nodes_pb2.Annotation(), figures=[shape]))


def raw(shape: list[int], data: bytes, kind: geometry_pb2.NumericType = FLOAT64) -> geometry_pb2.NumericArray:
    return geometry_pb2.NumericArray(type=kind, shape=shape, data=data)


COMMANDS = {
    "no command": scene_pb2.Command(),
    "no kind": create(nodes_pb2.Node(name="a")),
    "a second world": create(nodes_pb2.Node(name="a", world=nodes_pb2.World())),
    "no geometry": create(nodes_pb2.Node(name="a", part=nodes_pb2.Part(), figures=[nodes_pb2.Figure()])),
    "no size": figure("box"),
    "a negative size": figure("box", size=geometry_pb2.Vector3(x=1, y=-1, z=1)),
    "a negative radius": figure("sphere", radius_meters=-0.1),
    "a negative length": figure("cylinder", radius_meters=0.1, length_meters=-1),
    "a mesh without name": figure("mesh"),
    "a mesh without size": figure("mesh", uri="a.stl", scale=geometry_pb2.Vector3(x=1)),
    "no type": figure("points", positions=geometry_pb2.NumericArray(shape=[1, 3], data=bytes(24))),
    "an unknown type": figure("points", positions=raw([1, 3], bytes(24), 77)),  # pyright: ignore[reportArgumentType]
    "too few bytes": figure("points", positions=raw([2, 3], bytes(24))),
    "too many bytes": figure("points", positions=raw([1, 3], bytes(25))),
    "a wrong shape": figure("points", positions=raw([3], bytes(24))),
    "a shape of exabytes": figure("points", positions=raw([2**32 - 1, 2**32 - 1, 3], b"")),
    "colours of other points": figure("points", positions=array(np.zeros((2, 3))), colors=array([[1, 2, 3]], UINT8)),
    "half a segment": figure("lines", segments=array(np.zeros((1, 3)))),
    "a label of a book": figure("label", text="x" * 20_000),
    "a zero quaternion": create(box("a")),
    "an unknown parent": create(box("a", parent="nobody")),
    "a link on no robot": create(nodes_pb2.Node(name="a", link=nodes_pb2.Link())),
    "unknown kinematics": create(nodes_pb2.Node(name="a", robot=nodes_pb2.Robot(kinematics="magic"))),
    "an unknown robot": scene_pb2.Command(select_tool=scene_pb2.SelectTool(robot="nobody")),
    "no robot": pick("", "kept"),
}
COMMANDS["a zero quaternion"].create_node.node.parent_t_node.orientation.SetInParent()


@pytest.mark.parametrize("kind", COMMANDS)
def test_bad_commands(stepped: Stubs, kind: str) -> None:
    apply(stepped, create(box("kept")))
    with unchanged(stepped):
        refused = refusal(lambda: apply(stepped, create(box("before")), COMMANDS[kind]))
    assert refused.reason in ("INVALID_ARGUMENT", "UNKNOWN_NAME", "MISSING_FILE")
    assert len(refused.message) > 20, "words that help"


def test_bad_moves(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    far = np.eye(4)
    far[0, 3] = 9.0
    point = motion_pb2.PointToPoint
    with unchanged(stepped):
        for reason, moves in (
            ("INVALID_ARGUMENT", []),
            ("INVALID_ARGUMENT", [motion_pb2.Move(robot="arm")]),
            ("INVALID_ARGUMENT", [motion_pb2.Move(robot="arm", point_to_point=point())]),
            ("INVALID_ARGUMENT", [motion_pb2.Move(robot="arm", point_to_point=point(pose=motion_pb2.PoseGoal()))]),
            ("UNKNOWN_NAME", [motion_pb2.Move(robot="arm", point_to_point=point(posture="hmoe"))]),
            ("INVALID_ARGUMENT", [joints("arm")]),
            ("UNKNOWN_NAME", [joints("arm", elbow=0.0)]),
            ("UNKNOWN_NAME", [joints("nobody", elbow=0.0)]),
            ("INVALID_ARGUMENT", [joints("arm", 1.5, lbr_iiwa_joint_1=0.5)]),
            ("INVALID_ARGUMENT", [joints("arm", -0.5, lbr_iiwa_joint_1=0.5)]),
            ("INVALID_ARGUMENT", [joints("arm", lbr_iiwa_joint_1=0.5), joints("arm", lbr_iiwa_joint_1=0.1)]),
            ("UNREACHABLE", [to_pose("arm", far)]),
            ("UNKNOWN_NAME", [to_pose("arm", far, "nowhere")]),
            ("INVALID_ARGUMENT", [linear("arm", far, max_velocity_meters_per_second=-1.0)]),
            ("INVALID_ARGUMENT", [circular("arm", far)]),
            ("INVALID_ARGUMENT", [circular("arm", via=np.ones(3))]),
            ("INVALID_ARGUMENT", [circular("arm", center=about([0.1, 0.0, 1.0]))]),
            ("INVALID_ARGUMENT", [circular("arm", center=motion_pb2.ArcCenter(angle_radians=1.0))]),
            ("INVALID_ARGUMENT", [circular("arm", far, np.ones(3), max_velocity_meters_per_second=-1.0)]),
            ("INVALID_ARGUMENT", [circular("arm", far, np.ones(3), orientation=7)]),
            ("UNKNOWN_NAME", [circular("arm", far, np.ones(3), reference="nowhere")]),
            ("UNKNOWN_NAME", [circular("nobody", far, np.ones(3))]),
            ("INVALID_ARGUMENT", [trajectory("arm", [JOINT], [0.0], [[0.0]])]),
            ("INVALID_ARGUMENT", [trajectory("arm", [JOINT], [0.0, 1.0], [[0.0, 0.0], [0.0, 0.0]])]),
            ("INVALID_ARGUMENT", [trajectory("arm", [JOINT], [0.0, 1.0, 1.0], [[0.0], [0.1], [0.2]])]),
            ("INVALID_ARGUMENT", [trajectory("arm", [JOINT], [0.0, 1.0], [[0.5], [0.1]])]),
            ("INVALID_ARGUMENT", [trajectory("arm", [JOINT, JOINT], [0.0, 1.0], np.zeros((2, 2)))]),
            ("LIMIT_EXCEEDED", [trajectory("arm", [JOINT], [0.0, 0.01], [[0.0], [1.0]])]),
        ):
            refused = refusal(lambda moves=moves: start(stepped, *moves))
            assert refused.reason == reason, (moves, refused)
