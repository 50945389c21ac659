"""CalibrationService by the client: a robot that differs from its model is told how, from what it would measure.

The real robot is planted: the model's forward kinematics with other joints, at another place, with another tip.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, InvalidArgumentError, UnknownNameError
from virtualrobot.robots.robot import Robot

from tests.api.asking import IIWA
from tests.kernels import KernelProcess, Stubs

JOINTS = 7


@pytest.fixture
def client(kernel: KernelProcess, stubs: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(kernel.address) as client:
        yield client


@pytest.fixture
def arm(client: Client) -> Robot:
    """Return an arm with a pointer, whose tip is 5 cm from where the model has it: no joint's axis goes through it."""
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(0.2, -0.1, 0.5, yaw=0.3))
    tip = virtualrobot.pose(0.05, 0.02, 0.12)
    client.scene.add_tool("pointer", arm.flange, tool_center_points={"tip": tip})
    return arm


def tips(arm: Robot, postures: np.ndarray) -> np.ndarray:
    """Return where the tool centre point is in postures (n, 3)."""
    return np.array([arm.solve_forward(posture).world_t_tcp[:3, 3] for posture in postures])


def drawn(rng: np.random.Generator, count: int) -> np.ndarray:
    return rng.uniform(-1.2, 1.2, (count, JOINTS))


def test_the_tip_that_touched_one_point(arm: Robot) -> None:
    """Four postures of the model in which its own tip is at the same point, turned differently."""
    point = np.array([0.75, 0.15, 0.7])
    postures = [
        arm.solve_inverse(
            virtualrobot.pose(*point, roll=np.pi + roll, pitch=pitch), seed=[0, 0.5, 0, -1.2, 0, 0.8, 0]
        ).best
        for roll, pitch in ((0.0, 0.0), (0.4, 0.0), (-0.3, 0.3), (0.0, -0.4))
    ]
    found = arm.calibration.tool(postures)
    np.testing.assert_allclose(found.tip, [0.05, 0.02, 0.12], atol=1e-5)
    np.testing.assert_allclose(found.point, point, atol=1e-5)
    assert found.residuals.shape == (4,) and found.residuals.max() < 1e-5


def test_the_place_of_the_base(arm: Robot, client: Client, rng: np.random.Generator) -> None:
    postures = drawn(rng, 5)
    client.scene.set_pose("arm", virtualrobot.pose(1.0, 2.0, 0.3, yaw=-0.7, roll=0.1))
    measured = tips(arm, postures)
    client.scene.set_pose("arm", virtualrobot.pose(0.0))
    found = arm.calibration.base(postures, measured)
    np.testing.assert_allclose(found.world_t_base, virtualrobot.pose(1.0, 2.0, 0.3, yaw=-0.7, roll=0.1), atol=1e-12)
    client.scene.set_pose("arm", found.world_t_base)
    np.testing.assert_allclose(tips(arm, postures), measured, atol=1e-12)


def test_offsets_of_joints_with_base_and_tip(arm: Robot, client: Client, rng: np.random.Generator) -> None:
    postures, planted = drawn(rng, 40), rng.uniform(-0.02, 0.02, JOINTS)
    first, last = arm.chain_joint_names[0], arm.chain_joint_names[-1]
    measured = tips(arm, postures + planted)
    found = arm.calibration.joints(postures, measured)
    np.testing.assert_allclose(list(found.offsets.values()), planted, atol=1e-9)
    assert found.residuals_before.max() > 1e-3 and found.residuals.max() < 1e-9
    planted[[0, -1]] = 0.0
    measured = tips(arm, postures + planted)
    turn, shift = virtualrobot.pose(0.004, -0.003, 0.002, yaw=0.01, pitch=0.02), [0.2, -0.1, 0.5]
    moved = (measured - shift) @ turn[:3, :3].T + turn[:3, 3] + shift
    found = arm.calibration.joints(postures, moved, fixed=[first, last], with_base=True, with_tip=True)
    np.testing.assert_allclose(list(found.offsets.values()), planted[1:-1], atol=1e-7)
    np.testing.assert_allclose(found.tip, [0.05, 0.02, 0.12], atol=1e-7)
    expected = virtualrobot.pose(0.2, -0.1, 0.5, yaw=0.3)
    expected[:3, :3] = turn[:3, :3] @ expected[:3, :3]
    expected[:3, 3] += turn[:3, 3]
    np.testing.assert_allclose(found.world_t_base, expected, atol=1e-7)


def test_noise_leaves_offsets_within_their_errors(arm: Robot, rng: np.random.Generator) -> None:
    """With 0.1 mm of noise all are within five standard errors, which chance alone breaks once in 250,000 runs."""
    postures, planted = drawn(rng, 60), rng.uniform(-0.02, 0.02, JOINTS)
    measured = tips(arm, postures + planted) + rng.normal(scale=1e-4, size=(60, 3))
    found = arm.calibration.joints(postures, measured)
    off = np.array(list(found.offsets.values())) - planted
    assert np.all(np.abs(off) < 5.0 * np.array(list(found.errors.values())))
    assert 0.5e-4 < np.sqrt(np.mean(found.residuals**2) / 3.0) < 1.5e-4


def test_what_can_not_be_told_is_refused_by_name(arm: Robot, client: Client, rng: np.random.Generator) -> None:
    postures = drawn(rng, 30)
    measured = tips(arm, postures)
    first = arm.chain_joint_names[0]
    with pytest.raises(InvalidArgumentError, match=f"doesn't determine {first}, yaw") as refused:
        arm.calibration.joints(postures, measured, with_base=True)
    assert refused.value.metadata["undetermined"].split(",") == [first, "yaw"]
    with pytest.raises(InvalidArgumentError, match="give at least 4"):
        arm.calibration.tool(postures[:3])
    one_axis = np.tile(postures[0], (5, 1))
    one_axis[:, 6] = np.linspace(-1.0, 1.0, 5)
    with pytest.raises(InvalidArgumentError, match="doesn't determine tip z"):
        arm.calibration.tool(one_axis)
    with pytest.raises(InvalidArgumentError, match="on a line"):
        arm.calibration.base(postures[:3], np.outer([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]))
    with pytest.raises(InvalidArgumentError, match="points"):
        arm.calibration.base(postures[:3], measured[:2])
    measured[1, 1] = np.nan
    with pytest.raises(InvalidArgumentError, match="points holds a number that is not finite: nan in row 1"):
        arm.calibration.base(postures[:3], measured[:3])
    with pytest.raises(UnknownNameError, match="joint of 'arm'"):
        arm.calibration.tool([{"elbow": 0.1}] * 4)
    client.load_robot("model://conveyor", name="belt")
    with pytest.raises(UnknownNameError):
        client.robots["belt"].calibration.tool([{"elbow": 0.1}] * 4)
