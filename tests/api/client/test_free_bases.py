"""Planar and floating bases through the client: their coordinates by name, in rows, in order, in programs and plans."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.api.client.conftest import IIWA, Run

TURNED = [0.0, 0.0, np.sin(0.3), np.cos(0.3)]


@pytest.fixture
def agv(client: Client) -> Robot:
    """Return an arm on a base that drives."""
    return client.load_robot(IIWA, name="agv", base="planar")


@pytest.fixture
def craft(client: Client) -> Robot:
    """Return an arm on a base that flies."""
    return client.load_robot(IIWA, name="craft", base="floating")


def test_an_arm_of_our_own_drives(client: Client) -> None:
    arm = client.load_robot("model://ur5e", name="arm", base="planar")
    arm.move_joints({"base": [0.3, -0.2, 0.4], "joint_1": 0.5})
    np.testing.assert_array_equal(arm.positions[:4], [0.3, -0.2, 0.4, 0.5])


def test_a_base_moves_to_its_coordinates_together_with_other_joints(agv: Robot) -> None:
    agv.move_joints({"base": [0.3, -0.2, 0.4], "lbr_iiwa_joint_1": 0.5})
    np.testing.assert_array_equal(agv.positions[:4], [0.3, -0.2, 0.4, 0.5])
    agv.move_joints({"base/theta": 0.0})
    np.testing.assert_array_equal(agv.positions[:4], [0.3, -0.2, 0.0, 0.5])
    agv.set_positions({"base": (1.0, 2.0, 3.0)})
    assert agv.positions[:3].tolist() == [1.0, 2.0, 3.0]
    everything = np.concatenate([[1.1, 2.1, 3.1], np.full(7, 0.1)])
    agv.move_joints(everything)
    np.testing.assert_array_equal(agv.positions, everything)


def test_a_floating_base_turns_to_a_quaternion(craft: Robot) -> None:
    craft.move_joints({"base": [0.1, 0.2, 0.3, *TURNED]})
    np.testing.assert_allclose(craft.positions[:7], [0.1, 0.2, 0.3, *TURNED], atol=1e-12)
    there = craft.solve_forward({"base": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]}).world_t_tcp
    craft.set_positions({"base": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]})
    np.testing.assert_allclose(craft.tcp, there, atol=1e-12)


def test_a_plan_tells_the_columns_of_a_base(client: Client, craft: Robot) -> None:
    plan = client.plan([craft.ptp({"base": [0.1, 0.2, 0.3, *TURNED]})])
    told = plan.robots["craft"]
    assert told.joint_names == tuple(f"base/{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz", "qw"))
    assert not told.velocities[:, 6].any() and not told.efforts.any()
    # A turn about z alone: its rate is that of twice the half angle.
    angles = 2.0 * np.unwrap(np.arctan2(told.positions[:, 5], told.positions[:, 6]))
    rate = np.gradient(angles, plan.times)
    np.testing.assert_allclose(told.velocities[2:-2, 5], rate[2:-2], atol=1e-2)


def test_a_program_drives_and_works(client: Client, agv: Robot) -> None:
    program = client.program().move(agv.ptp({"base": [0.2, 0.0, 0.0]})).move(agv.ptp({"lbr_iiwa_joint_1": 0.3}))
    assert program.check().ok
    program.start()
    np.testing.assert_array_equal(agv.positions[:4], [0.2, 0.0, 0.0, 0.3])


def test_a_base_follows_times_and_jogs(client: Client, agv: Robot, craft: Robot) -> None:
    agv.start(agv.trajectory([0.0, 0.5, 1.0], [[0.0, 0.0, 0.0], [0.1, 0.0, 0.1], [0.1, 0.1, 0.2]], joints=["base"]))
    np.testing.assert_allclose(agv.positions[:3], [0.1, 0.1, 0.2], atol=1e-12)
    agv.jog_joint("base/x", 0.5, 0.2, wait=True)
    np.testing.assert_allclose(agv.positions[:3], [0.3, 0.1, 0.2], atol=1e-9)
    here = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    craft.start(craft.trajectory([0.0, 1.0], [here, [0.0, 0.0, 0.2, *TURNED]], joints=["base"]))
    np.testing.assert_allclose(craft.positions[:7], [0.0, 0.0, 0.2, *TURNED], atol=1e-9)


def test_setpoints_lead_a_base(client: Client, agv: Robot, craft: Robot) -> None:
    client.clock.set_stepped()
    with agv.stream("velocity", ["base"], timeout=1e6) as stream:
        assert stream.joint_names == ("base/x", "base/y", "base/theta")
        stream.send({"base/x": 0.1, "base/theta": 0.2}, wait=True)
        client.clock.step(200)
        np.testing.assert_allclose(agv.state.velocities[:3], [0.1, 0.0, 0.2], atol=1e-12)
        client.clock.set_realtime()
    client.clock.set_stepped()
    goal = [0.01, 0.0, 0.0, 0.0, 0.0, np.sin(0.01), np.cos(0.01)]
    with craft.stream(timeout=1e6) as stream:
        assert len(stream.joint_names) == 7 + 7 and stream.joint_names[6] == "base/qw"
        stream.send(np.concatenate([goal, np.zeros(7)]), wait=True)
        client.clock.set_realtime()
    np.testing.assert_allclose(craft.positions[:7], goal, atol=1e-8)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="name all of"):
        craft.stream(joints=["base/qx"])


@pytest.mark.long
def test_a_base_on_the_command_line(agv: Robot, craft: Robot, run: Run) -> None:
    run("move", "agv", "--joints", "base/x=0.2,base/theta=90", "--degrees")
    np.testing.assert_allclose(agv.positions[:3], [0.2, 0.0, np.pi / 2.0])
    run("jog", "agv", "base/theta", "--velocity", "-45", "--distance", "90", "--degrees")
    np.testing.assert_allclose(agv.positions[:3], [0.2, 0.0, 0.0], atol=1e-9)
    turn = ",".join(f"base/q{axis}={value}" for axis, value in zip("xyzw", TURNED, strict=True))
    shown = [line.split() for line in run("plan", "craft", "--joints", turn, "--degrees").splitlines()]
    (row,) = [line for line in shown if line[:1] == ["base/qz"]]
    assert row[1:3] == ["0.0000", f"{np.sin(0.3):.4f}"]
    # 0.6 rad by the kernel's defaults for joints that tell no limits: 2 rad/s, 8 rad/s², 80 rad/s³.
    assert 0.0 < float(row[3].split("(")[0]) < np.degrees(2.0)


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ({"base": [1.0, 2.0]}, r"the joint 'base' of 'agv' has 3 values \(base/x, base/y, base/theta\)"),
        ({"lbr_iiwa_joint_1": [1.0, 2.0]}, "the joint 'lbr_iiwa_joint_1' of 'agv' has 1 values"),
        ({"base": 1.0}, "is planar and has several coordinates; name 'base/x', 'base/y', 'base/theta'"),
        ([1.0, 2.0], r"2 values for the robot 'agv': it has 10 coordinates \(base/x, base/y, base/theta, lbr_"),
        ({"base": [0.0, 0.0, 0.0], "base/x": 1.0}, "'base/x' of 'agv' is given twice, by itself and in the row of its"),
        ({"base/theta": 1.0, "base": [0.0, 0.0, 0.0]}, "'base/theta' of 'agv' is given twice"),
        ({"base/x": 1.0, "base": [0.0, 0.0]}, "has 3 values"),
    ],
)
def test_values_that_are_no_coordinates_are_refused(agv: Robot, goal: object, words: str) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match=words):
        agv.move_joints(goal)  # pyright: ignore[reportArgumentType]


def test_a_quaternion_of_another_length_is_refused(client: Client, craft: Robot) -> None:
    for change in (craft.move_joints, craft.set_positions, craft.solve_forward):
        with pytest.raises(virtualrobot.InvalidArgumentError, match=r"of length 2; it must have length 1, to 0\.001"):
            change({"base": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0]})
    names = [f"base/q{axis}" for axis in "xyzw"]
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"positions\[1\] of 'craft' has the quaternion .* 2"):
        client.collisions.check_configurations("craft", [[0, 0, 0, 1], [0, 0, 0, 2]], joint_names=names)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="name all of"):
        client.collisions.check_configurations("craft", [[1.0]], joint_names=names[:1])
