"""Robots through the client: state, kinematics, tools, parts."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot, pose

from tests.api.client.conftest import PANDA


def test_what_an_arm_says_of_itself(client: Client, iiwa: Robot) -> None:
    assert len(iiwa.joint_names) == 7
    assert iiwa.chain_joint_names == iiwa.joint_names
    assert iiwa.flange == iiwa.links[-1]
    # The limits that the model file states for its first joint.
    limits = iiwa.limits["lbr_iiwa_joint_1"]
    assert (limits.lower, limits.upper, limits.velocity) == (-2.96705972839, 2.96705972839, 10)
    assert [robot.name for robot in client.robots()] == ["iiwa"]
    assert "lbr_iiwa_joint_7" in iiwa._repr_html_()
    with pytest.raises(virtualrobot.UnknownNameError, match="did you mean 'iiwa'"):
        client.robot("iwa")


def test_positions_by_name_and_in_order(client: Client, iiwa: Robot, rng: np.random.Generator) -> None:
    goal = rng.uniform(-1.5, 1.5, 7)
    iiwa.set_positions(goal)
    np.testing.assert_array_equal(iiwa.positions, goal)
    iiwa.set_positions({"lbr_iiwa_joint_2": 0.25})
    goal[1] = 0.25
    np.testing.assert_array_equal(iiwa.positions, goal)
    np.testing.assert_array_equal(iiwa.state.velocities, np.zeros(7))


def test_forward_and_inverse_agree(iiwa: Robot, rng: np.random.Generator) -> None:
    for _ in range(10):
        goal = rng.uniform(-1.5, 1.5, 7)
        there = iiwa.solve_forward(goal)
        np.testing.assert_allclose(there.world_t_link[iiwa.flange], there.world_t_tcp, atol=1e-12)
        solution = iiwa.solve_inverse(there.world_t_tcp)
        assert solution.solved
        assert solution.joint_names == tuple(iiwa.joint_names)
        again = iiwa.solve_forward(solution.by_name()).world_t_tcp
        np.testing.assert_allclose(again[:3, 3], there.world_t_tcp[:3, 3], atol=1e-3)
    np.testing.assert_allclose(iiwa.solve_forward().world_t_tcp, iiwa.tcp, atol=1e-12)


def test_a_pose_out_of_reach_is_an_answer(iiwa: Robot) -> None:
    solution = iiwa.solve_inverse(pose(x=10))
    assert not solution.solved
    # From its shoulder the arm reaches less than 1.3 m, so the best attempt is more than 8 m off.
    assert 8 < solution.position_error < 10
    with pytest.raises(virtualrobot.UnreachableError):
        _ = solution.best
    with pytest.raises(virtualrobot.UnreachableError):
        iiwa.move_pose(pose(x=10))


def test_values_that_fit_no_joints_are_refused(iiwa: Robot) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="3 values for the robot 'iiwa': it has 7 joints"):
        iiwa.move_joints([1, 2, 3])
    with pytest.raises(virtualrobot.InvalidArgumentError, match="one row of numbers"):
        iiwa.move_joints(np.zeros((2, 7)))
    with pytest.raises(virtualrobot.LimitError, match="lbr_iiwa_joint_1"):
        iiwa.move_joints({"lbr_iiwa_joint_1": 4})
    with pytest.raises(virtualrobot.UnknownNameError, match="lbr_iiwa_joint_8"):
        iiwa.move_joints({"lbr_iiwa_joint_8": 0})


def test_a_gripper_opens_closes_picks_and_places(client: Client) -> None:
    panda = client.load_robot(PANDA, name="panda")
    fingers = ("panda_finger_joint1", "panda_finger_joint2")
    fingers = tuple(name for name in panda.joint_names if name in fingers)
    client.scene.add_tool(
        "hand",
        "panda.panda_hand",
        tool_center_points={"grip": pose(z=0.105), "palm": np.eye(4)},
        states={"open": dict.fromkeys(fingers, 0.04), "closed": dict.fromkeys(fingers, 0.0)},
    )
    panda.set_positions({"panda_joint4": -1.5, **dict.fromkeys(fingers, 0.04)})
    assert panda.tools == ["hand"]
    hand = panda.tool("hand").select()
    assert panda.tool().name == "hand"
    assert hand.states["open"] == dict.fromkeys(fingers, 0.04)
    np.testing.assert_allclose(panda.tcp, client.scene.pose("panda.panda_hand") @ pose(z=0.105), atol=1e-12)
    hand.select("palm")
    assert panda.state.tool_center_point == "palm"
    np.testing.assert_allclose(panda.tcp, client.scene.pose("panda.panda_hand"), atol=1e-12)
    np.testing.assert_allclose(hand.tool_center_points["grip"], pose(z=0.105), atol=1e-12)

    box = client.scene.add_part("box", virtualrobot.box(0.05, 0.05, 0.05), pose=panda.tcp)
    hand.close()
    assert hand.state == "closed"
    state = dict(zip(panda.joint_names, panda.positions, strict=True))
    assert all(abs(state[name]) < 1e-9 for name in fingers)
    panda.pick()
    assert box.parent == "hand"
    tcp_t_box = np.linalg.inv(panda.tcp) @ box.pose
    panda.move_joints({"panda_joint1": 0.5})
    np.testing.assert_allclose(np.linalg.inv(panda.tcp) @ box.pose, tcp_t_box, atol=1e-9)
    before = box.pose
    panda.place()
    hand.open()
    assert box.parent == "world"
    np.testing.assert_allclose(box.pose, before, atol=1e-9)

    with pytest.raises(virtualrobot.UnknownNameError, match="its tools are 'hand'"):
        panda.tool("hnad")
    with pytest.raises(virtualrobot.UnknownNameError):
        hand.set("ajar")


def test_no_tool(iiwa: Robot) -> None:
    with pytest.raises(virtualrobot.WrongStateError, match="it has none"):
        iiwa.tool()
