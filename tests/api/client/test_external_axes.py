"""An arm on a rail and an arm with a positioner, through the client in stepped time: what the world really does."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Motion, Robot

pytestmark = pytest.mark.long

READY = {"lbr_iiwa_joint_2": 0.6, "lbr_iiwa_joint_4": -1.4, "lbr_iiwa_joint_6": 1.1}


def traced(client: Client, robot: Robot, motion: Motion, reference: str) -> np.ndarray:
    """Step through a motion; return reference_t_tcp (n, 4, 4) of the robot at each tick."""
    node = client.scene.node(reference)
    poses = [np.linalg.inv(node.pose) @ robot.tcp]
    while phase(client, motion) not in ("SUCCEEDED", "CANCELLED", "ABORTED"):
        client.clock.step()
        poses.append(np.linalg.inv(client.scene.node(reference).pose) @ robot.tcp)
    return np.array(poses)


def phase(client: Client, motion: Motion) -> str:
    """Return the phase as it is now; the motion itself hears of it a little later."""
    return next(one.phase.name for one in client.motions(running_only=False) if one.id == motion.id)


def check_line(poses: np.ndarray, start: np.ndarray, goal: np.ndarray) -> None:
    """All poses are on the line to 0.01 mm, and the last one is the goal."""
    way = goal[:3, 3] - start[:3, 3]
    share = (poses[:, :3, 3] - start[:3, 3]) @ way / (way @ way)
    np.testing.assert_allclose(poses[:, :3, 3], start[:3, 3] + share[:, None] * way, atol=1e-5)
    np.testing.assert_allclose(poses[-1], goal, atol=1e-6)


@pytest.fixture
def stepped(client: Client) -> Client:
    client.clock.set_stepped()
    return client


def test_an_arm_on_a_rail(stepped: Client, rng: np.random.Generator) -> None:
    rail = stepped.load_robot("model://rail", name="rail")
    arm = stepped.load_robot("model://iiwa", name="arm", parent="rail.carriage")
    arm.set_positions(READY)
    start = arm.tcp
    goal = virtualrobot.pose(*rng.uniform(-0.05, 0.05, 3)) @ virtualrobot.pose(y=1.2) @ start
    moves = [arm.linear(goal, velocity=1.0, acceleration=3.0), rail.ptp({"slide": 1.2})]
    motion = stepped.move_together(moves, wait=False)
    assert set(motion.robots) == {"arm", "rail"}
    check_line(traced(stepped, arm, motion, "world"), start, goal)
    assert rail.positions == pytest.approx([1.2])
    with pytest.raises(virtualrobot.VirtualRobotError):
        arm.move_linear(virtualrobot.pose(y=-1.2) @ arm.tcp)  # without the rail


def test_a_line_on_a_positioner_and_its_speed_there(stepped: Client, rng: np.random.Generator) -> None:
    table = stepped.load_robot("model://positioner", name="table", pose=virtualrobot.pose(0.55, 0.0, 0.2))
    arm = stepped.load_robot("model://iiwa", name="arm")
    arm.set_positions(READY)
    start = np.linalg.inv(stepped.scene.node("table.plate").pose) @ arm.tcp
    goal = virtualrobot.pose(*rng.uniform(-0.05, 0.05, 3)) @ start
    turn = table.ptp({"turn": float(rng.uniform(0.2, 0.5)), "tilt": float(rng.uniform(-0.1, 0.1))})
    line = arm.linear(goal, reference="table.plate", velocity=0.05, moving=True)
    poses = traced(stepped, arm, stepped.move_together([turn, line], wait=False), "table.plate")
    check_line(poses, start, goal)
    speeds = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / 0.004
    assert speeds.max() <= 0.05 * 1.0001


def test_a_pause_and_a_cancel_keep_arm_and_positioner_together(stepped: Client) -> None:
    table = stepped.load_robot("model://positioner", name="table", pose=virtualrobot.pose(0.55, 0.0, 0.2))
    arm = stepped.load_robot("model://iiwa", name="arm")
    arm.set_positions(READY)
    start = np.linalg.inv(stepped.scene.node("table.plate").pose) @ arm.tcp
    goal = virtualrobot.pose(x=0.1) @ start
    moves = [table.ptp({"turn": 0.5}), arm.linear(goal, reference="table.plate", velocity=0.1, moving=True)]
    motion = stepped.move_together(moves, wait=False)
    stepped.clock.step(100)
    motion.pause()
    stepped.clock.step(200)
    assert phase(stepped, motion) == "PAUSED"
    motion.resume()
    stepped.clock.step(50)
    motion.cancel()
    poses = traced(stepped, arm, motion, "table.plate")
    assert phase(stepped, motion) == "CANCELLED"
    way = goal[:3, 3] - start[:3, 3]
    share = (poses[:, :3, 3] - start[:3, 3]) @ way / (way @ way)
    np.testing.assert_allclose(poses[:, :3, 3], start[:3, 3] + share[:, None] * way, atol=1e-5)
    assert 0.01 < share[-1] < 0.99
