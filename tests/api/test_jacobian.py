"""SolveJacobian over the wire."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, nodes_pb2, robot_pb2, scene_pb2

from tests.api.asking import IIWA, apply, create, load, refusal
from tests.api.reading import pose, random_matrix, values
from tests.kernels import Stubs

REQUEST = robot_pb2.SolveJacobianRequest
LAST = "arm.lbr_iiwa_link_7"


def point(node: str, place: np.ndarray, reference: str = "") -> robot_pb2.RobotPoint:
    x, y, z = place
    return robot_pb2.RobotPoint(node=node, point=geometry_pb2.Vector3(x=x, y=y, z=z), reference=reference)


def test_tool_and_part_move_as_solve_forward_says(stepped: Stubs, rng: np.random.Generator) -> None:
    """Differences of where SolveForward has the tool centre point; a held part is fixed to the tool's link."""
    load(stepped, IIWA, "arm", parent_t_node=pose(random_matrix(rng)))
    centers = [nodes_pb2.ToolCenterPoint(name="tip", tool_t_tcp=pose(random_matrix(rng)))]
    tool = nodes_pb2.Node(name="tool", parent=LAST, tool=nodes_pb2.Tool(tool_center_points=centers))
    part = nodes_pb2.Node(name="part", parent="tool", part=nodes_pb2.Part())
    select = scene_pb2.SelectTool(robot="arm", tool="tool", tool_center_point="tip")
    apply(stepped, create(tool), create(part), scene_pb2.Command(select_tool=select))
    names = [f"lbr_iiwa_joint_{i}" for i in range(1, 8)]
    q = rng.uniform(-1.5, 1.5, 7)

    def place(at: np.ndarray) -> np.ndarray:
        told = stepped.robot.SolveForward(robot_pb2.SolveForwardRequest(robot="arm", joint_positions=named(at)))
        position = told.world_t_tcp.position
        return np.array([position.x, position.y, position.z])

    def named(at: np.ndarray) -> dict[str, float]:
        return dict(zip(names, at.tolist(), strict=True))

    there = point("part", place(q))
    told = stepped.robot.SolveJacobian(REQUEST(robot="arm", joint_positions=named(q), points=[there]))
    assert list(told.joint_names) == names
    tcp, points = values(told.tcp_jacobian), values(told.point_jacobians)
    assert tcp.shape == (6, 7) and points.shape == (1, 6, 7)
    differences = [(place(q + step) - place(q - step)) / 2e-5 for step in 1e-5 * np.eye(7)]
    np.testing.assert_allclose(tcp[:3].T, differences, atol=1e-8)
    np.testing.assert_allclose(points[0], tcp, atol=1e-12)


def test_points_may_be_none_and_frames_any(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    told = stepped.robot.SolveJacobian(REQUEST(robot="arm"))
    assert values(told.point_jacobians).shape == (0, 6, 7)
    told = stepped.robot.SolveJacobian(REQUEST(robot="arm", points=[point(LAST, np.zeros(3), reference=LAST)]))
    np.testing.assert_allclose(values(told.point_jacobians)[0], values(told.tcp_jacobian), atol=1e-12)


@pytest.mark.parametrize(
    ("given", "reason", "said"),
    [
        ({"robot": "nobody"}, "UNKNOWN_NAME", "nobody"),
        ({"robot": "arm", "joint_positions": {"elbow": 0.0}}, "UNKNOWN_NAME", "elbow"),
        ({"robot": "arm", "joint_positions": {"lbr_iiwa_joint_1": 9.0}}, "LIMIT_EXCEEDED", "9"),
        ({"robot": "arm", "joint_positions": {"lbr_iiwa_joint_1": float("nan")}}, "INVALID_ARGUMENT", "finite"),
        ({"robot": "arm", "points": [point("thin air", np.zeros(3))]}, "UNKNOWN_NAME", "thin air"),
        ({"robot": "arm", "points": [point("table", np.zeros(3))]}, "INVALID_ARGUMENT", "does not carry 'table'"),
        ({"robot": "arm", "points": [point("arm", np.zeros(3))]}, "INVALID_ARGUMENT", "does not carry 'arm'"),
        ({"robot": "arm", "points": [point(LAST, np.full(3, np.inf))]}, "INVALID_ARGUMENT", "points[0].point"),
        ({"robot": "arm", "points": [point(LAST, np.zeros(3))] * 10_001}, "TOO_LARGE", "10001 points"),
    ],
)
def test_what_is_wrong_is_refused(stepped: Stubs, given: dict, reason: str, said: str) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, create(nodes_pb2.Node(name="table", object=nodes_pb2.SceneObject())))
    error = refusal(lambda: stepped.robot.SolveJacobian(REQUEST(**given)))
    assert error.reason == reason and said in error.message
