"""Robots whose joints hang together, through the contract: the palletizer with its rods, and the parallel gripper."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

COLUMN, UPPER_ARM, FOREARM, FLANGE = (0.26, 0.742), 0.945, 1.025, (0.22, -0.25)
"""The sizes in palletizer.yaml, m: (out, up) of the shoulder, lengths, (out, down) from the wrist to the flange."""


@pytest.fixture
def palletizer(client: Client) -> Robot:
    return client.load_robot("model://palletizer", name="palletizer")


def flange(q: np.ndarray) -> np.ndarray:
    """Return world_t_flange of the palletizer by its geometry: the forearm dips by q2 + q3, and the flange is level."""
    turn, lean, dip, yaw = q[0], q[1], q[1] + q[2], q[3]
    out = COLUMN[0] + UPPER_ARM * np.sin(lean) + FOREARM * np.cos(dip) + FLANGE[0]
    up = COLUMN[1] + UPPER_ARM * np.cos(lean) - FOREARM * np.sin(dip) + FLANGE[1]
    # The flange looks down: half a turn about x; its own z turns against the column's.
    angle = turn - yaw
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:2, :2] = [[np.cos(angle), np.sin(angle)], [np.sin(angle), -np.cos(angle)]]
    pose[:3, 3] = out * np.cos(turn), out * np.sin(turn), up
    return pose


def drawn(rng: np.random.Generator) -> np.ndarray:
    """Return joints within the limits of joints and motors."""
    while True:
        q = rng.uniform([-2.8, -0.6, -1.0, -3.0], [2.8, 1.4, 1.5, 3.0])
        if np.deg2rad(-20.0) < q[1] + q[2] < np.deg2rad(110.0):
            return q


def test_the_rods_keep_the_flange_level(palletizer: Robot, rng: np.random.Generator) -> None:
    assert palletizer.chain_joint_names == palletizer.joint_names == ["joint_1", "joint_2", "joint_3", "joint_4"]
    for _ in range(20):
        q = drawn(rng)
        np.testing.assert_allclose(palletizer.solve_forward(q).world_t_tcp, flange(q), atol=1e-12)


def test_poses_that_four_axes_reach_are_solved_and_others_are_not(palletizer: Robot, rng: np.random.Generator) -> None:
    for _ in range(20):
        goal = flange(drawn(rng))
        found = palletizer.solve_inverse(goal)
        np.testing.assert_allclose(flange(found.best), goal, atol=1e-8)
    assert not palletizer.solve_inverse(goal @ virtualrobot.pose(roll=0.3)).solved


def test_motors_and_joints(palletizer: Robot, rng: np.random.Generator) -> None:
    """The forearm's motor stands on the column: it is at 150 (q2 + q3)."""
    q = drawn(rng)
    palletizer.set_positions(q)
    state = palletizer.state
    np.testing.assert_allclose(
        state.actuator_positions, [120 * q[0], 150 * q[1], 150 * (q[1] + q[2]), 50 * q[3]], rtol=1e-12
    )
    motors = {one.name: one for one in palletizer.actuators}
    assert motors["motor_3"].ratios == {"joint_2": 150.0, "joint_3": 150.0}
    assert motors["motor_3"].upper == pytest.approx(150 * np.deg2rad(110.0))
    assert motors["motor_1"].upper == np.inf
    goal = drawn(rng)
    palletizer.move_actuators({"motor_3": 150 * (goal[1] + goal[2]), "motor_2": 150 * goal[1]})
    np.testing.assert_allclose(palletizer.positions[1:3], goal[1:3], atol=1e-9)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="do not say where all of joint_2, joint_3 are"):
        palletizer.move_actuators({"motor_3": 0.0})


def test_the_motor_of_the_forearm_has_limits_of_its_own(palletizer: Robot) -> None:
    """Joints 2 and 3 are within their limits at 80 and 60 degrees; the forearm would dip by 140 instead of 110."""
    there = {"joint_2": np.deg2rad(80.0), "joint_3": np.deg2rad(60.0)}
    with pytest.raises(virtualrobot.LimitError, match="the actuator 'motor_3' of 'palletizer'") as refused:
        palletizer.move_joints(there)
    assert float(refused.value.metadata["value"]) == pytest.approx(150 * np.deg2rad(140.0), rel=1e-4)
    with pytest.raises(virtualrobot.LimitError, match="motor_3"):
        palletizer.set_positions(there)


def test_a_line_keeps_the_flange_level(palletizer: Robot) -> None:
    before = palletizer.tcp
    palletizer.move_linear(before @ virtualrobot.pose(0.2, 0.1, 0.3), velocity=1.0, acceleration=3.0)
    np.testing.assert_allclose(palletizer.tcp, before @ virtualrobot.pose(0.2, 0.1, 0.3), atol=1e-8)


def test_both_fingers_of_the_gripper_follow_one_motor(client: Client) -> None:
    """A pinion of 10 mm radius: 100 rad for a meter of each finger."""
    gripper = client.load_robot("model://parallel_gripper", name="parallel_gripper")
    gripper.move_actuators({"motor": 3.0})
    assert gripper.positions == pytest.approx([0.03])
    assert gripper.state.actuator_positions == pytest.approx([3.0])
    links = gripper.solve_forward().world_t_link
    apart = links["parallel_gripper.left_finger"][1, 3] - links["parallel_gripper.right_finger"][1, 3]
    assert apart == pytest.approx(0.06, abs=1e-12)


def test_actuators_stand_in_scene_files(client: Client, palletizer: Robot, tmp_path: Path) -> None:
    before = palletizer.actuators
    client.scene.save(tmp_path / "cell.yaml")
    client.scene.clear()
    client.scene.load_scene(tmp_path / "cell.yaml")
    assert client.robot("palletizer").actuators == before


def test_the_forearms_motor_ends_how_far_a_conveyor_is_followed(client: Client, palletizer: Robot) -> None:
    """A belt that runs down leads the motor beyond its limits long before a joint."""
    palletizer.set_positions([0.2, 0.3, 1.2, 0.1])
    x, y, z = palletizer.tcp[:3, 3]
    client.load_robot("model://conveyor", name="lift", pose=virtualrobot.pose(x, y, z, pitch=np.pi / 2))
    still = palletizer.linear(palletizer.tcp @ virtualrobot.pose(x=0.01))
    with pytest.raises(virtualrobot.LimitError, match="the actuator 'motor_3' of 'palletizer'") as refused:
        client.move_together([still], tracking=virtualrobot.Tracking("lift.belt", window=0.6, max_velocity=0.1))
    assert refused.value.metadata["actuator"] == "motor_3"
    kept = 0.9 * float(refused.value.metadata["displacement"])
    client.move_together([still], tracking=virtualrobot.Tracking("lift.belt", window=kept, max_velocity=0.1))
