"""Robots of Denavit-Hartenberg tables through the contract: by message or scene file, as another robot's kinematics."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path
from typing import Any

import grpc
import numpy as np
import pytest
from google.protobuf import json_format, struct_pb2
from virtualrobot.v1 import motion_pb2, nodes_pb2, robot_pb2, scene_pb2

from tests.api.asking import load, refusal
from tests.api.moving import to_pose
from tests.api.reading import matrices, matrix, pose, values
from tests.kernels import Stubs
from tests.unit.plugins.paper_arm import Lengths, closed_form

MODELS = Path(str(resources.files("virtualrobot_plugins"))) / "models"
PAPER = (MODELS / "ar_manipulator.yaml").read_text("utf-8")
LENGTHS = Lengths(a_1=0.05, a_2=0.2, d_1=0.28, d_4=0.18, d_6=0.08)
"""Of the shipped arm; the file says them too."""

RIGHT = math.pi / 2
# Corke and Armstrong-Helouvry 1994; the pedestal of puma560.urdf is 0.67183 m high.
PUMA = {
    "convention": "standard",
    "base_t_first": [0.0, 0.0, 0.67183, 0.0, 0.0, 0.0, 1.0],
    "rows": [
        {"alpha_radians": RIGHT},
        {"a_meters": 0.4318},
        {"a_meters": 0.0203, "alpha_radians": -RIGHT, "d_meters": 0.15005},
        {"d_meters": 0.4318, "alpha_radians": RIGHT},
        {"alpha_radians": -RIGHT},
        {},
    ],
}


def request(rows: list[dict[str, Any]], convention: str = "STANDARD", **fields: Any) -> scene_pb2.ImportModelRequest:  # noqa: ANN401  any field of the request
    table = {"convention": f"DENAVIT_HARTENBERG_CONVENTION_{convention}", "rows": rows}
    return json_format.ParseDict({"model": {"denavit_hartenberg": table, **fields}}, scene_pb2.ImportModelRequest())


def load_scene(stubs: Stubs, text: str, uri: str = "") -> scene_pb2.LoadSceneResponse:
    return stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text, uri=uri))


def forward(stubs: Stubs, robot: str, q: np.ndarray) -> tuple[np.ndarray, dict[str, float]]:
    """Return world_t_tcp with the arm's joints at q, and q by the joints' names."""
    told = stubs.robot.GetRobot(robot_pb2.GetRobotRequest(name=robot))
    positions = dict(zip(told.chain_joints, q.tolist(), strict=True))
    answer = stubs.robot.SolveForward(robot_pb2.SolveForwardRequest(robot=robot, joint_positions=positions))
    return matrix(answer.world_t_tcp), positions


def set_kinematics(stubs: Stubs, robot: str, settings: dict[str, Any]) -> robot_pb2.SetKinematicsResponse:
    message = struct_pb2.Struct()
    message.update(settings)
    command = robot_pb2.KinematicsChoice(robot=robot, kinematics="dh", settings=message)
    return stubs.robot.SetKinematics(robot_pb2.SetKinematicsRequest(choice=command))


def test_the_paper_s_arm_is_where_its_closed_form_says(stepped: Stubs, rng: np.random.Generator) -> None:
    """The corrected formulas of the paper's section 2.2, which tests/unit/plugins/test_dh_paper.py derives."""
    load_scene(stepped, PAPER)
    told = stepped.robot.GetRobot(robot_pb2.GetRobotRequest(name="ar_manipulator"))
    assert (told.kinematics, told.flange) == ("dh", "ar_manipulator.flange")
    assert [joint.name for joint in told.joints] == [f"joint_{i}" for i in range(1, 7)]
    lower, upper = (np.array([getattr(joint.limits, end) for joint in told.joints]) for end in ("lower", "upper"))
    for _ in range(5):
        q = rng.uniform(lower, upper)
        reached, _ = forward(stepped, "ar_manipulator", q)
        expected = closed_form(q, LENGTHS)
        np.testing.assert_allclose(reached, expected, atol=1e-12)
        answer = stepped.robot.SolveInverse(
            robot_pb2.SolveInverseRequest(robot="ar_manipulator", reference_t_tcp=pose(expected))
        )
        found = values(answer.solutions)[0]
        np.testing.assert_allclose(closed_form(found, LENGTHS), expected, atol=1e-7)


def test_a_pose_outside_limits_is_told_apart_from_one_out_of_reach(stepped: Stubs) -> None:
    """Of one joint about z and a link of 0.5 m the flange is at 0.5 (cos q, sin q), turned by q."""
    joint = {"a_meters": 0.5, "limits": {"lower": -0.5, "upper": 0.5}}
    stepped.scene.ImportModel(request([joint], name="arm"))

    def target_at(angle: float, radius: float) -> np.ndarray:
        target = np.eye(4)
        cos, sin = math.cos(angle), math.sin(angle)
        target[:2, :2], target[:2, 3] = [[cos, -sin], [sin, cos]], [radius * cos, radius * sin]
        return target

    def status(angle: float, radius: float) -> robot_pb2.InverseStatus:
        asked = robot_pb2.SolveInverseRequest(robot="arm", reference_t_tcp=pose(target_at(angle, radius)))
        return stepped.robot.SolveInverse(asked).status

    def refused(angle: float, radius: float) -> str:
        moves = [to_pose("arm", target_at(angle, radius))]
        asked = motion_pb2.PlanMotionRequest(spec=motion_pb2.MotionSpec(moves=moves))
        return refusal(lambda: stepped.motion.PlanMotion(asked)).reason

    assert status(0.4, 0.5) == robot_pb2.INVERSE_STATUS_SOLVED
    assert status(1.0, 0.5) == robot_pb2.INVERSE_STATUS_OUTSIDE_LIMITS
    assert status(0.4, 0.6) == robot_pb2.INVERSE_STATUS_UNREACHABLE
    assert (refused(1.0, 0.5), refused(0.4, 0.6)) == ("LIMIT_EXCEEDED", "UNREACHABLE")


def test_frames_of_the_table_are_nodes(stepped: Stubs) -> None:
    """At zero: T_0^1 = Tz(d1) Tx(a1) Rx(90), and T_0^2 is a2 further along x."""
    load_scene(stepped, PAPER.partition("robot_states:")[0])
    names = ["ar_manipulator.frame_0", "ar_manipulator.frame_1", "ar_manipulator.frame_2"]
    places = matrices(stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=names)).world_t_node)
    np.testing.assert_allclose(places[0], np.eye(4), atol=1e-15)
    np.testing.assert_allclose(places[1, :3], [[1, 0, 0, 0.05], [0, 0, -1, 0], [0, 1, 0, 0.28]], atol=1e-15)
    np.testing.assert_allclose(places[2, :3, 3], [0.25, 0.0, 0.28], atol=1e-15)


def test_a_saved_table_is_the_same_robot(stepped: Stubs) -> None:
    load_scene(stepped, PAPER)
    saved = stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    assert "kinematics: dh" in saved
    load_scene(stepped, saved)
    assert stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text == saved
    reached, _ = forward(stepped, "ar_manipulator", np.zeros(6))
    np.testing.assert_allclose(reached, closed_form(np.zeros(6), LENGTHS), atol=1e-12)


def test_a_scara_of_modified_rows_with_names_and_a_stroke(stepped: Stubs) -> None:
    """Craig's convention: x = l1 c1 + l2 c12, z = -d3; on a floating base in a frame of its own."""
    rows = [
        {"name": "shoulder", "d_meters": 0.4},
        {"name": "elbow", "a_meters": 0.3, "limits": {"lower": -2.5, "upper": 2.5}},
        {
            "name": "quill",
            "type": "JOINT_TYPE_PRISMATIC",
            "a_meters": 0.25,
            "alpha_radians": math.pi,
            "limits": {"lower": 0, "upper": 0.2},
        },
        {"name": "wrist"},
    ]
    given = request(rows, "MODIFIED", name="scara", base_joint="JOINT_TYPE_FLOATING")
    created = stepped.scene.ImportModel(given).created
    assert (created[0].name, created[1].name, created[2].name) == ("scara", "scara.base_link", "scara.link_1")
    reached, positions = forward(stepped, "scara", np.array([0.3, 0.7, 0.15, 0.2]))
    assert list(positions) == ["shoulder", "elbow", "quill", "wrist"]
    x = 0.3 * math.cos(0.3) + 0.25 * math.cos(1.0)
    y = 0.3 * math.sin(0.3) + 0.25 * math.sin(1.0)
    np.testing.assert_allclose(reached[:3, 3], [x, y, 0.4 - 0.15], atol=1e-12)
    np.testing.assert_allclose(reached[:3, 2], [0.0, 0.0, -1.0], atol=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"uri": "arm.urdf"}, "uri belongs to a model that is read from a file, and denavit_hartenberg is given too"),
        ({"as_part": True}, "as_part belongs to a model that is read from a file"),
        ({"srdf_uri": "arm.srdf"}, "srdf_uri belongs to a model that is read from a file"),
        ({"base_joint": "JOINT_TYPE_REVOLUTE"}, "the base joint cannot be revolute"),
    ],
)
def test_a_table_and_a_file_exclude_each_other(stepped: Stubs, given: dict[str, Any], message: str) -> None:
    said = refusal(lambda: stepped.scene.ImportModel(request([{}], **given)))
    assert said.code is grpc.StatusCode.INVALID_ARGUMENT
    assert said.message.startswith(message)


def test_neither_a_table_nor_a_file(stepped: Stubs) -> None:
    said = refusal(lambda: load(stepped, ""))
    assert "uri must name the model's main file, or denavit_hartenberg hold a table" in said.message


def test_a_bad_row_of_a_scene_file_is_found(stepped: Stubs) -> None:
    text = PAPER.replace("d_meters: 0.18", "d_meters: 1.0e300")
    said = refusal(lambda: load_scene(stepped, text, "cell.yaml"))
    assert said.message.startswith("cell.yaml: models[0]: denavit_hartenberg.rows[3].d_meters is 1e+300")
    text = PAPER.replace("d_meters: 0.18", "d: 0.18")
    said = refusal(lambda: load_scene(stepped, text, "cell.yaml"))
    line = text[: text.index("d: 0.18")].count("\n") + 1
    assert f"cell.yaml:{line}: models[0].denavit_hartenberg.rows[3]: there is no field 'd'" in said.message


def test_a_published_table_against_a_urdf(stepped: Stubs) -> None:
    """The kernel says by how much a table misses the robot: 1.3 mm with the forearm of Armstrong et al. 1986."""
    load(stepped, str(MODELS / "puma560.urdf"), "puma")
    check = set_kinematics(stepped, "puma", PUMA).check
    assert max(check.forward_position_error_meters, check.inverse_position_error_meters) < 1e-6
    assert stepped.robot.GetRobot(robot_pb2.GetRobotRequest(name="puma")).kinematics == "dh"
    longer = {**PUMA, "rows": [*PUMA["rows"][:3], {**PUMA["rows"][3], "d_meters": 0.4331}, *PUMA["rows"][4:]]}
    said = refusal(lambda: set_kinematics(stepped, "puma", longer))
    assert "forward puts the tip 0.0013 m and" in said.message
    assert said.reason == "PLUGIN_FAILED"
    said = refusal(lambda: set_kinematics(stepped, "puma", {**PUMA, "rows": PUMA["rows"][:5]}))
    assert "the table has 5 rows, but the robot has 6 joints from its base to its flange: joint1" in said.message
    said = refusal(lambda: set_kinematics(stepped, "puma", {**PUMA, "convention": "paul"}))
    assert "setting 'convention' is 'paul'; it must be one of" in said.message
    kept = stepped.robot.GetRobot(robot_pb2.GetRobotRequest(name="puma"))
    assert [dict(row) for row in kept.kinematics_settings["rows"]] == PUMA["rows"], "the last good table"


def test_a_table_is_there_to_look_at(stepped: Stubs) -> None:
    """Every link has figures that are seen and collide."""
    load_scene(stepped, PAPER)
    nodes = stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes
    links = [node for node in nodes if node.WhichOneof("kind") == "link"]
    assert len(links) == 8
    both = {nodes_pb2.FIGURE_ROLE_VISUAL, nodes_pb2.FIGURE_ROLE_COLLISION}
    assert all(set(figure.roles) in (set(), both) for node in links for figure in node.figures)
    assert all(node.figures for node in links)


def test_a_table_goes_on_as_urdf(stepped: Stubs, rng: np.random.Generator) -> None:
    """Exported and read again by name, joint by joint, the arm has its tip where the paper's closed form has it."""
    load_scene(stepped, PAPER)
    files = stepped.scene.ExportModel(scene_pb2.ExportModelRequest(node="ar_manipulator", format=".urdf")).files
    again = scene_pb2.ImportModelRequest(model=scene_pb2.ModelSource(uri=files[0].uri, files=files, name="copy"))
    stepped.scene.ImportModel(again)
    q = rng.uniform(0.0, 1.5, 6)
    reached, positions = forward(stepped, "copy", q)
    assert list(positions) == [f"joint_{i}" for i in range(1, 7)]
    np.testing.assert_allclose(reached, closed_form(q, LENGTHS), atol=1e-9)
