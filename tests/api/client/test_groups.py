"""Groups of a branched robot through the client: two Pandas on one table, solved, moved and planned by themselves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, JointGroup, Robot, pose

from tests.api.client.conftest import Run
from tests.kernels import KernelProcess

DUAL = "package://rtbdata/xacro/qut_frankie_description/robots/dual_panda_example.urdf.xacro"
ENDS = {side: ("base", f"panda_{number}_link8") for side, number in (("right", 1), ("left", 2))}
POSTURE = np.array([0.1, -0.4, 0.2, -1.8, 0.1, 1.5, 0.6])


@pytest.fixture
def pandas(client: Client) -> Robot:
    """Return a robot with the arms `left` and `right` and the hand `fingers`, bent."""
    robot = client.load_robot(DUAL, name="pandas")
    groups = [JointGroup(name, base_link=base, tip_link=tip) for name, (base, tip) in ENDS.items()]
    robot.set_groups([*groups, JointGroup("both", tuple(f"panda_{n}_joint{i}" for n in (1, 2) for i in range(1, 8)))])
    for name in ENDS:
        robot.group(name).set_positions(POSTURE)
    return robot


def test_the_whole_robot_has_no_chain_and_says_which_groups_it_has(pandas: Robot) -> None:
    with pytest.raises(virtualrobot.WrongStateError, match=r"one of its groups \('right', 'left', 'both'\)"):
        pandas.solve_inverse(pose())
    assert list(pandas.groups) == ["right", "left", "both"]
    assert pandas.groups["left"].joint_names == tuple(f"panda_2_joint{i}" for i in range(1, 8))


def test_the_tcp_of_the_whole_robot_is_where_it_branches(client: Client, pandas: Robot) -> None:
    """Without a tool that is its flange, the last link before the arms; never the world."""
    assert pandas.flange == f"{pandas.name}.base"
    client.scene.set_pose(pandas.name, pose(1.0, -2.0, 0.5, yaw=0.3))
    for told in (pandas.tcp, pandas.state.world_t_tcp, pandas.solve_forward().world_t_tcp):
        np.testing.assert_allclose(told, client.scene.node(pandas.flange).pose, atol=1e-12)
    assert np.linalg.norm(pandas.tcp[:3, 3]) > 2.0
    assert not np.allclose(pandas.group("left").tcp, pandas.tcp)


def test_each_arm_is_solved_where_it_stands(pandas: Robot, rng: np.random.Generator) -> None:
    """Both arms are alike, 1 m apart along y: so are their poses; what is solved is put back into the forward pass."""
    left, right = pandas.group("left"), pandas.group("right")
    apart = pose(y=1.0)
    np.testing.assert_allclose(left.tcp, apart @ right.tcp, atol=1e-12)
    lower = np.array([limits.lower for limits in left.limits.values()])
    upper = np.array([limits.upper for limits in left.limits.values()])
    for _ in range(20):
        q = rng.uniform(lower, upper)
        there = left.solve_forward(q).world_t_tcp
        np.testing.assert_allclose(right.solve_forward(q).world_t_tcp, pose(y=-1.0) @ there, atol=1e-12)
        found = left.solve_inverse(there)
        assert found.joint_names == tuple(left.joint_names)
        np.testing.assert_allclose(left.solve_forward(found.by_name()).world_t_tcp, there, atol=1e-3)
        jacobian = left.solve_jacobian(q)
        assert jacobian.joint_names == tuple(left.joint_names)
        step = np.zeros(7)
        step[3] = 1e-6
        moved = left.solve_forward(q + step).world_t_tcp[:3, 3] - left.solve_forward(q - step).world_t_tcp[:3, 3]
        np.testing.assert_allclose(jacobian.tcp[:3, 3], moved / 2e-6, atol=1e-6)


def test_a_chain_by_its_links_is_the_group_of_these_links(pandas: Robot) -> None:
    base, tip = ENDS["left"]
    named, linked = pandas.group("left"), pandas.group(base=base, tip=tip)
    assert (linked.joint_names, linked.tip) == (named.joint_names, named.tip)
    np.testing.assert_array_equal(linked.tcp, named.tcp)
    forearm = pandas.group(base="panda_2_link4", tip=tip)
    assert forearm.joint_names == [f"panda_2_joint{i}" for i in (5, 6, 7)]


def test_two_arms_move_in_one_motion_and_in_two(client: Client, pandas: Robot) -> None:
    left, right = pandas.group("left"), pandas.group("right")
    goals = left.tcp @ pose(z=-0.1), right.tcp @ pose(x=0.05, z=-0.1)
    client.move_together([left.linear(goals[0]), right.linear(goals[1])])
    np.testing.assert_allclose(left.tcp, goals[0], atol=1e-6)
    np.testing.assert_allclose(right.tcp, goals[1], atol=1e-6)
    first = left.move_joints(POSTURE, wait=False, speed_factor=0.2)
    second = right.move_joints(POSTURE, wait=False, speed_factor=0.2)
    with pytest.raises(virtualrobot.RobotBusyError):
        left.move_joints(POSTURE + 0.1)
    first.wait()
    second.wait()
    for arm in (left, right):
        np.testing.assert_allclose(arm.positions, POSTURE, atol=1e-9)


@pytest.mark.long
def test_a_program_of_both_arms_rounds_the_corners_of_each(client: Client, pandas: Robot) -> None:
    left, right = pandas.group("left"), pandas.group("right")
    program, before = client.program(), right.positions
    for place in (left.tcp @ pose(z=-0.1), left.tcp @ pose(y=0.1, z=-0.1), left.tcp @ pose(y=0.1)):
        program.move(left.linear(place, velocity=0.1), zone=0.02)
    plan = program.plan()
    told = plan.robots["pandas"].groups["left"]
    assert plan.notes == [] or all(note.step == 2 for note in plan.notes)
    # Line, corner, line: in the corners the tool centre point does not stop.
    assert told.tcp_speeds[10:-10].max() <= 0.1 + 1e-6
    corner = plan.times[np.argmin(np.abs(np.diff(plan.steps) - 1))]
    assert told.tcp_speeds[np.searchsorted(plan.times, corner)] > 0.02
    program.start().wait()
    np.testing.assert_allclose(left.tcp[:3, 3], told.world_t_tcp[-1, :3, 3], atol=1e-9)
    np.testing.assert_array_equal(right.positions, before)


@pytest.mark.long
def test_check_path_and_jog_of_a_group(client: Client, pandas: Robot) -> None:
    left = pandas.group("left")
    checked = left.check(left.linear(left.tcp @ pose(x=0.05)), collisions=False)
    assert checked.ok and checked.min_singular_value
    far = left.check(left.linear(left.tcp @ pose(z=-2.0)), collisions=False)
    assert not far.ok
    before = left.tcp
    left.jog([0, 0, 1], frame="tool", distance=0.02, wait=True)
    np.testing.assert_allclose(left.tcp, before @ pose(z=0.02), atol=1e-6)
    # The model's coarse shapes overlap; those of two arms do not.
    found = client.collisions.allowed.find("pandas", samples=100)
    overlapping = [pair for pair in found if {"panda_1", "panda_2"} - {pair.first[7:14], pair.second[7:14]}]
    client.collisions.allowed.change(allow=[(pair.first, pair.second, "shapes overlap") for pair in overlapping])
    path = client.paths.find("pandas", dict(zip(left.joint_names, POSTURE + 0.2, strict=True)), group="left")
    assert path.joint_names == tuple(left.joint_names)
    path.start()
    np.testing.assert_allclose(left.positions, POSTURE + 0.2, atol=1e-6)


def test_the_tool_of_a_group_is_the_one_at_its_end(client: Client, pandas: Robot) -> None:
    for side, (_, tip) in ENDS.items():
        link = f"pandas.{tip}"
        client.scene.add_tool(f"{side}_gripper", parent=link, tool_center_points={"tip": pose(z=0.1)})
    for side, (_, tip) in ENDS.items():
        arm = pandas.group(side)
        flange = arm.solve_forward().world_t_link[f"pandas.{tip}"]
        np.testing.assert_allclose(arm.tcp, flange @ pose(z=0.1), atol=1e-12)


def test_each_group_has_its_component(client: Client, pandas: Robot) -> None:
    left = pandas.group("left")
    check = left.set_kinematics("chain")
    assert check.inverse_position_error < 1e-3
    assert {name: group.kinematics for name, group in pandas.groups.items()} == {
        "right": "",
        "left": "chain",
        "both": "",
    }
    (component,) = [one for one in client.plugins.components("kinematics") if one.name == "chain"]
    assert ("pandas", "left") in {(use.robot, use.group) for use in component.uses}
    with pytest.raises(virtualrobot.UnknownNameError, match="chain"):
        left.set_kinematics("chian")


@pytest.mark.long
def test_a_guarded_arm_stops_before_its_twin_which_goes_on(client: Client, pandas: Robot) -> None:
    left, right = pandas.group("left"), pandas.group("right")
    across = [-1.5, 1.2, 0.0, -0.6, 0.0, 1.5, 0.6]  # stretched out over the table, to the other arm

    def touching() -> set[tuple[str, str]]:
        return {(pair.first, pair.second) for pair in client.collisions.check().pairs}

    before = touching()  # the model's arms touch the table that they stand on
    client.collisions.set(robots={"pandas": "guard"})
    toward = left.move_joints(across, wait=False)
    with pytest.raises(virtualrobot.MotionAbortedError, match="would touch") as error:
        toward.wait()
    assert "pandas" in str(error.value)
    assert touching() == before
    lift = POSTURE.copy()
    lift[0] -= 0.5  # away from it
    right.move_joints(lift)
    np.testing.assert_allclose(right.positions, lift)


def test_a_lease_of_the_robot_is_one_of_all_its_groups(client: Client, kernel: KernelProcess, pandas: Robot) -> None:
    with virtualrobot.connect(kernel.address) as other, pandas.lease():
        for name in ENDS:
            with pytest.raises(virtualrobot.LeasedError, match="'pandas'"):
                other.robot("pandas").group(name).move_joints(POSTURE + 0.1)
            group = pandas.group(name)
            group.move_joints(POSTURE + 0.05)
            np.testing.assert_allclose(group.positions, POSTURE + 0.05)
    other_way = pandas.group("left")
    other_way.move_joints(POSTURE)
    assert other_way.positions[0] == POSTURE[0]


def test_one_arm_goes_along_with_a_belt_while_the_other_works(client: Client, pandas: Robot) -> None:
    left, right = pandas.group("left"), pandas.group("right")
    x, y, _ = left.tcp[:3, 3]
    client.load_robot("model://conveyor", name="conveyor", pose=pose(x, y - 0.7, 0.0, yaw=np.pi / 2))
    belt = client.robot("conveyor")
    goal = np.linalg.inv(client.scene.node("conveyor.belt").pose) @ left.tcp @ pose(z=0.05)
    belt.move_joints({"belt": 50.0}, speed_factor=0.04, wait=False)
    along = virtualrobot.Tracking("conveyor.belt", 0.25, 0.06)
    motion = left.move_linear(goal, reference="conveyor.belt", tracking=along, wait=False)
    right.move_joints(POSTURE + 0.1)
    motion.wait()
    assert motion.progress == 1.0
    height = (np.linalg.inv(client.scene.node("conveyor.belt").pose) @ left.tcp)[2, 3]
    np.testing.assert_allclose(height, goal[2, 3], atol=1e-5)
    np.testing.assert_allclose(right.positions, POSTURE + 0.1)
    belt.stop()


def test_wrong_groups_are_refused_with_the_right_ones(pandas: Robot) -> None:
    with pytest.raises(virtualrobot.UnknownNameError, match=r"no group of 'pandas' named 'lefd'; did you mean 'left'"):
        pandas.group("lefd")
    with pytest.raises(virtualrobot.UnknownNameError, match="panda_2_link8"):
        pandas.group(base="base", tip="panda_2_link_8")
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"not below .*panda_1_link3.*; above it are 'base'"):
        pandas.group(base="panda_1_link3", tip="panda_2_link8")
    with pytest.raises(virtualrobot.UnknownNameError, match="panda_1_joint1"):
        pandas.group("right").move_joints({"panda_2_joint1": 0.0})
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"not below 'pandas.panda_1_link3'"):
        pandas.set_groups([JointGroup("crossed", base_link="panda_1_link3", tip_link="panda_2_link8")])
    assert list(pandas.groups) == ["right", "left", "both"]


def test_joints_that_are_no_chain_move_and_are_not_solved(pandas: Robot) -> None:
    both = pandas.group("both")
    assert both.tip == "" and len(both.joint_names) == 14
    with pytest.raises(virtualrobot.WrongStateError, match=r"group 'both' .* is no chain: .* does not lead to"):
        both.solve_inverse(pose())
    goal = np.concatenate([POSTURE, POSTURE]) + 0.1
    both.move_joints(goal)
    np.testing.assert_allclose(both.positions, goal, atol=1e-9)


def test_a_saved_scene_keeps_the_groups(client: Client, pandas: Robot, tmp_path: Path) -> None:
    pandas.group("left").set_kinematics("chain")
    client.scene.save(tmp_path / "cell.yaml")
    client.scene.load_scene(tmp_path / "cell.yaml")
    again = client.robot("pandas")
    assert again.groups["left"].kinematics == "chain"
    np.testing.assert_allclose(again.group("left").positions, POSTURE, atol=1e-12)


def test_groups_on_the_command_line(client: Client, pandas: Robot, run: Run) -> None:
    goal = ",".join(f"{value:g}" for value in POSTURE + 0.1)
    assert "reached its goal" in run("move", "pandas", "--group", "left", "--joints", goal)
    np.testing.assert_allclose(pandas.group("left").positions, POSTURE + 0.1, atol=1e-6)
    assert "groups  right, left, both" in run("state", "pandas")
    base, tip = ENDS["right"]
    assert "reached" in run("jog", "pandas", "--base", base, "--tip", tip, "--along", "0,0,1", "--distance", "0.01")
    assert "did you mean 'left'" in run("move", "pandas", "--group", "lefd", "--joints", goal, code=1)
