"""SolveInverseDynamics over the wire, and masses of tools and parts that survive saving."""

from __future__ import annotations

from collections.abc import Callable

import grpc
import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from google.protobuf import json_format
from virtualrobot.v1 import geometry_pb2, nodes_pb2, robot_pb2, scene_pb2

from tests.api.asking import IIWA, MODELS, apply, create, load, refusal
from tests.api.reading import array, values
from tests.api.test_export import content
from tests.kernels import Stubs

REQUEST = robot_pb2.SolveInverseDynamicsRequest
LAST = "arm.lbr_iiwa_link_7"


def weight(mass: float, *centre: float, moment: float = 0.0) -> nodes_pb2.Inertial:
    x, y, z = centre
    place = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x, y=y, z=z))
    diagonal = geometry_pb2.Vector3(x=moment, y=moment, z=moment)
    return nodes_pb2.Inertial(mass_kilograms=mass, link_t_inertial=place, diagonal=diagonal)


def test_a_robot_that_lifts_too_much(stepped: Stubs) -> None:
    """The file's limit is 300 N m at the shoulder; 100 kg a meter above an elbow bent level are far more."""
    load(stepped, IIWA, "arm")
    level = {"robot": "arm", "joint_names": ["lbr_iiwa_joint_2"], "positions": array(np.array([[0.0], [1.5]]))}
    assert not stepped.robot.SolveInverseDynamics(REQUEST(**level)).HasField("first_violation")
    apply(stepped, create(nodes_pb2.Node(name="tool", parent=LAST, tool=nodes_pb2.Tool(inertial=weight(100, 0, 0, 0)))))
    told = stepped.robot.SolveInverseDynamics(REQUEST(**level))
    first = told.first_violation
    assert (first.joint, first.sample, first.limit) == ("lbr_iiwa_joint_2", 1, 300.0)
    assert first.effort == values(told.efforts)[1, 0]
    assert values(told.efforts).shape == (2, 1)


def test_a_floating_robot_is_asked_for_its_scalar_joints(stepped: Stubs) -> None:
    load(stepped, str(MODELS / "r2d2.urdf"), "droid", base_joint=nodes_pb2.JOINT_TYPE_FLOATING)
    told = stepped.robot.SolveInverseDynamics(REQUEST(robot="droid"))
    assert (len(told.joint_names), values(told.efforts).shape) == (8, (1, 8))


def test_masses_of_tools_and_parts_are_saved(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    tool = nodes_pb2.Tool(inertial=weight(0.7, 0.0, 0.0, 0.1, moment=0.02))
    part = nodes_pb2.Part(inertial=weight(1.2, 0.01, 0.0, 0.0))
    apply(
        stepped,
        create(nodes_pb2.Node(name="tool", parent=LAST, tool=tool)),
        create(nodes_pb2.Node(name="part", part=part)),
    )

    def told(name: str) -> nodes_pb2.Node:
        return stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=[name])).nodes[0]

    before = told("tool"), told("part")
    assert before[1].part.mass_kilograms == 1.2, "the inertial's"
    text = stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text))
    for old, new in zip(before, (told("tool"), told("part")), strict=True):
        kind = old.WhichOneof("kind")
        assert kind
        assert json_format.MessageToDict(getattr(old, kind)) == json_format.MessageToDict(getattr(new, kind))


def test_masses_of_a_table_are_told_in_its_rows_frames(stepped: Stubs) -> None:
    """A level rod of 2 kg and 0.8 m, told at the far end of a standard row: 2 * 9.81 * 0.4 N m."""
    row = scene_pb2.DenavitHartenbergRow(a_meters=0.8, inertial=weight(2.0, -0.4, 0.0, 0.0))
    kind = scene_pb2.DENAVIT_HARTENBERG_CONVENTION_STANDARD
    upright = geometry_pb2.Pose(orientation=geometry_pb2.Quaternion(x=np.sqrt(0.5), w=np.sqrt(0.5)))
    table = scene_pb2.DenavitHartenberg(convention=kind, rows=[row], base_t_first=upright)
    stepped.scene.ImportModel(
        scene_pb2.ImportModelRequest(model=scene_pb2.ModelSource(name="rod", denavit_hartenberg=table))
    )
    told = stepped.robot.SolveInverseDynamics(REQUEST(robot="rod"))
    assert values(told.efforts)[0, 0] == pytest.approx(2.0 * 9.81 * 0.4, rel=1e-12)
    modified = scene_pb2.DENAVIT_HARTENBERG_CONVENTION_MODIFIED
    row = scene_pb2.DenavitHartenbergRow(inertial=weight(2.0, 0.4, 0.0, 0.0))
    table = scene_pb2.DenavitHartenberg(convention=modified, rows=[row], base_t_first=upright)
    stepped.scene.ImportModel(
        scene_pb2.ImportModelRequest(model=scene_pb2.ModelSource(name="same", denavit_hartenberg=table))
    )
    told = stepped.robot.SolveInverseDynamics(REQUEST(robot="same"))
    assert values(told.efforts)[0, 0] == pytest.approx(2.0 * 9.81 * 0.4, rel=1e-12)
    row.inertial.mass_kilograms = -1.0
    table.rows[0].CopyFrom(row)
    wrong = scene_pb2.ImportModelRequest(model=scene_pb2.ModelSource(denavit_hartenberg=table))
    assert (
        "denavit_hartenberg.rows[0].inertial.mass_kilograms must be 0 or above"
        in refusal(lambda: stepped.scene.ImportModel(wrong)).message
    )


def test_the_paper_s_cosine_trajectory_against_pinocchio(stepped: Stubs) -> None:
    """The example of docs/dynamics.md; pinocchio reads the arm from its export as URDF."""
    load(stepped, "model://ar_manipulator", "arm")
    main = stepped.scene.ExportModel(scene_pb2.ExportModelRequest(node="arm", format=".urdf")).files[0]
    model = pinocchio.buildModelFromXML(content(stepped, main).decode())
    data = model.createData()
    times, rate, half = np.linspace(0.0, 2.0, 201), np.pi / 2, np.radians(30.0)
    columns = (
        half * (1 - np.cos(rate * times)),
        half * rate * np.sin(rate * times),
        half * rate**2 * np.cos(rate * times),
    )
    q, v, a = (np.outer(column, np.ones(6)) for column in columns)
    told = stepped.robot.SolveInverseDynamics(
        REQUEST(robot="arm", positions=array(q), velocities=array(v), accelerations=array(a))
    )
    theirs = [pinocchio.rnea(model, data, *sample) for sample in zip(q, v, a, strict=True)]
    np.testing.assert_allclose(values(told.efforts), theirs, rtol=1e-9, atol=1e-9)
    # By hand: the upper arm of 0.5 kg lies level, its middle at 0.1 m, and 0.9 kg hang from its end at 0.2 m.
    assert values(told.gravity_efforts)[0, 1] == pytest.approx((0.5 * 0.1 + 0.9 * 0.2) * 9.81, rel=1e-12)
    assert not told.HasField("first_violation")


def test_what_is_wrong_is_named(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")

    def ask(**fields: object) -> Callable[[], object]:
        return lambda: stepped.robot.SolveInverseDynamics(REQUEST(**{"robot": "arm", **fields}))  # pyright: ignore[reportArgumentType]

    nan = np.zeros((2, 7))
    nan[1, 2] = np.nan
    invalid, missing = grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.NOT_FOUND
    cases = [
        (ask(robot="amr"), missing, "UNKNOWN_NAME", "did you mean 'arm'"),
        (ask(joint_names=["lbr_iiwa_joint_8"]), missing, "UNKNOWN_NAME", "lbr_iiwa_joint_8"),
        (ask(positions=array(nan)), invalid, "INVALID_ARGUMENT", "positions holds a number that is not finite"),
        (ask(velocities=array(np.zeros(7))), invalid, "INVALID_ARGUMENT", "velocities must have the shape (n, 7)"),
        (ask(velocities=array(np.zeros((2, 6)))), invalid, "INVALID_ARGUMENT", "must have the shape (n, 7)"),
    ]
    for call, code, reason, message in cases:
        refused = refusal(call)
        assert (refused.code, refused.reason) == (code, reason)
        assert message in refused.message
    outside = refusal(ask(positions=array(np.full((1, 7), 3.0))))
    assert (outside.reason, "lbr_iiwa_joint_1" in outside.message) == ("LIMIT_EXCEEDED", True)
    part = nodes_pb2.Part(mass_kilograms=2.0, inertial=weight(3.0, 0, 0, 0))
    two = refusal(lambda: apply(stepped, create(nodes_pb2.Node(name="part", part=part))))
    assert "part.part.mass_kilograms is 2 and that of its inertial 3; give one or the same" in two.message
