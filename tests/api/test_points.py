"""SolvePoints over the wire."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot._wire.messages import array_message
from virtualrobot.v1 import robot_pb2

from tests.api.asking import load, refusal
from tests.kernels import KernelProcess, Stubs

REQUEST = robot_pb2.SolvePointsRequest


def test_points_in_the_frame_of_a_node_are_reached(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        client.load_robot("model://hexapod", name="walker", base="floating", pose=virtualrobot.pose(0.5, yaw=0.3))
        leg = client.robot("walker.right_rear")
        points = np.array([[-0.2, -0.14, -0.09], [-0.21, -0.15, -0.08]])
        found = leg.solve_points(points, reference="walker.body")
        assert found.solved and found.all.shape == (2, 3)
        for point, joints in zip(points, found.all, strict=True):
            there = leg.solve_forward(joints).world_t_tcp
            body_t_foot = np.linalg.inv(client.scene.pose("walker.body")) @ there
            np.testing.assert_allclose(body_t_foot[:3, 3], point, atol=1e-9)
        far = leg.solve_points([[0.5, 0.0, 0.0]], reference="walker.body")
        assert not far.solved and far.position_error > 0.1
        with pytest.raises(virtualrobot.UnreachableError, match="the point 0 is not reached"):
            far.all  # noqa: B018 it raises
        with pytest.raises(virtualrobot.InvalidArgumentError, match=r"points have the shape \(n, 3\), not \(3,\)"):
            leg.solve_points([0.1, 0.2, 0.3])


def test_a_row_of_near_points_gives_the_smooth_path_of_the_closed_form(kernel: KernelProcess, stubs: Stubs) -> None:
    """A leg of coxa, femur and tibia: the first by the direction, the others by the law of cosines."""
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    x, y, z = 0.13 + 0.02 * np.cos(turn), 0.03 * np.sin(turn), -0.10 + 0.015 * np.sin(2.0 * turn)
    with virtualrobot.connect(kernel.address) as client:
        client.load_robot("model://hexapod", name="walker")
        leg = client.robot("walker.left_middle")
        seed = {"coxa": 0.0, "femur": 0.6, "tibia": -2.0}
        found = leg.solve_points(np.column_stack([x, y, z]), seed, reference=leg.name)
        assert found.joint_names == ("coxa", "femur", "tibia")
        out = np.hypot(x, y) - 0.052
        tibia = -np.arccos((out**2 + z**2 - 0.066**2 - 0.133**2) / (2 * 0.066 * 0.133))
        femur = np.arctan2(z, out) - np.arctan2(0.133 * np.sin(tibia), 0.066 + 0.133 * np.cos(tibia))
        np.testing.assert_allclose(found.all, np.column_stack([np.arctan2(y, x), femur, tibia]), atol=1e-8)


def test_the_first_point_out_of_reach_is_named(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        client.load_robot("model://hexapod", name="walker")
        leg = client.robot("walker.left_middle")
        far = leg.solve_points([[0.15, 0.0, -0.1], [0.3, 0.0, 0.0]], reference=leg.name)
        assert not far.solved and not far.outside_limits and far.positions.shape == (1, 3)
        # Stretched it reaches 52 + 66 + 133 mm.
        assert far.position_error == pytest.approx(0.3 - 0.251, abs=1e-4)
        assert "the point 1 is not reached" in far.explanation
        behind = leg.solve_points([[-0.15, 0.0, -0.1]], reference=leg.name)
        assert behind.outside_limits and behind.positions.shape == (0, 3)
        assert "outside limits it is reached, for instance with 'coxa' at" in behind.explanation
        with pytest.raises(virtualrobot.LimitError, match="the point 0 is not reached"):
            behind.all  # noqa: B018 it raises
        assert leg.solve_points(np.empty((0, 3)), reference=leg.name).all.shape == (0, 3)


@pytest.mark.parametrize(
    ("given", "reason", "said"),
    [
        ({"robot": "nobody"}, "UNKNOWN_NAME", "nobody"),
        ({"reference": "thin air"}, "UNKNOWN_NAME", "thin air"),
        ({"seed": {"elbow": 0.0}}, "UNKNOWN_NAME", "elbow"),
        ({"seed": {"femur": 9.0}}, "LIMIT_EXCEEDED", "9"),
        ({"points": array_message(np.zeros((2, 2)))}, "INVALID_ARGUMENT", "points must have the shape (n, 3)"),
        ({"points": array_message(np.full((2, 3), np.nan))}, "INVALID_ARGUMENT", "not finite"),
        ({"points": array_message(np.zeros((100_001, 3)))}, "TOO_LARGE", "100001 points"),
        ({"robot": "walker"}, "WRONG_STATE", "no joint of 'walker' moves its flange"),
    ],
)
def test_what_is_wrong_is_refused(stepped: Stubs, given: dict, reason: str, said: str) -> None:
    load(stepped, "model://hexapod", "walker")
    request = REQUEST(**{"robot": "walker.left_front", "points": array_message(np.zeros((1, 3))), **given})
    error = refusal(lambda: stepped.robot.SolvePoints(request))
    assert error.reason == reason and said in error.message
