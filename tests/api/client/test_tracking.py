"""Conveyor tracking through the client."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, LimitError, Robot, Tracking, UnreachableError, pose

from tests.kernels import KernelProcess


@pytest.fixture
def arm(client: Client) -> Robot:
    """Return an arm whose tool looks down on a conveyor."""
    arm = client.load_robot("model://iiwa", name="arm", pose=pose(z=0.65))
    arm.set_positions([-0.6, 0.6, 0.0, -1.4, 0.0, np.pi - 2.0, 0.0])
    x, y, _ = arm.tcp[:3, 3]
    client.load_robot("model://conveyor", name="conveyor", pose=pose(x, y - 0.7, 0.0, yaw=np.pi / 2))
    return arm


def belt_t(client: Client, world_t: np.ndarray) -> np.ndarray:
    return np.linalg.inv(client.scene.node("conveyor.belt").pose) @ world_t


def test_a_move_goes_along_while_another_program_has_the_belt(
    client: Client, kernel: KernelProcess, arm: Robot
) -> None:
    goal = belt_t(client, arm.tcp @ pose(z=0.05))
    with (
        client.robot("conveyor").lease(),
        virtualrobot.connect(kernel.address) as other,
    ):
        follower = other.robot("arm")
        client.robot("conveyor").move_joints({"belt": 50.0}, speed_factor=0.2, wait=False)
        # Reading the belt needs no lease.
        motion = follower.move_linear(
            goal, reference="conveyor.belt", tracking=Tracking("conveyor.belt", 0.6, 0.12), wait=False
        )
        motion.wait()
    assert motion.progress == 1.0
    np.testing.assert_allclose(belt_t(client, arm.tcp)[2, 3], goal[2, 3], atol=1e-5)


def test_what_it_would_do_and_whether_it_can(client: Client, arm: Robot) -> None:
    move = arm.linear(belt_t(client, arm.tcp @ pose(z=0.05)), reference="conveyor.belt")
    alone, along = client.plan([move]), client.plan([move], tracking=Tracking("conveyor.belt", 0.6, 0.2))
    assert along.duration >= alone.duration
    assert client.check([move], tracking=Tracking("conveyor.belt", 0.6, 0.2)).first_violation is None
    violation = client.check([move], tracking=Tracking("conveyor.belt", 5.0, 0.2)).first_violation
    assert violation is not None
    assert "the arm cannot go along at" in violation.message
    with pytest.raises(UnreachableError, match="the arm cannot go along at"):
        arm.start(move, tracking=Tracking("conveyor.belt", 5.0, 0.2))


def test_a_belt_at_its_end(client: Client, arm: Robot) -> None:
    conveyor = client.robot("conveyor")
    goal = arm.tcp @ pose(z=0.05)
    conveyor.set_positions([1000.0])
    with pytest.raises(LimitError, match=r"stands at its limit, 1000 m, and cannot move by 0\.5 m"):
        arm.move_linear(goal, tracking=Tracking("conveyor.belt", 0.5))
