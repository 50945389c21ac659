"""Targets and postures that robots are taught: saved in the world, and moved to by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot, pose
from virtualrobot.cli.options import Session, Target
from virtualrobot.cli.shell import completions

from tests.api.client.conftest import IIWA, PANDA, Run

TAUGHT = np.array([0.4, 0.6, -0.3, -1.4, 0.5, 1.0, 0.2])
OTHER_BRANCH = np.array([-2.6, -0.7, 2.5, 1.2, -2.4, -0.9, 2.8])
"""A posture with shoulder, elbow and wrist bent the other way."""


def goal_of(arm: Robot, move: virtualrobot.Move) -> np.ndarray:
    """Return where a move leads the joints; nothing moves."""
    return arm.plan(move).robots[arm.name].positions[-1]


@pytest.fixture
def taught(client: Client, iiwa: Robot) -> Robot:
    """Return an arm that was taught `pick 1` below a table, and then moved to another branch."""
    client.scene.add_object("table", virtualrobot.box(0.2, 0.2, 0.05), pose=pose(0.4, 0.5, 0.1, yaw=0.3))
    iiwa.set_positions(TAUGHT)
    iiwa.teach("pick 1", "table")
    iiwa.set_positions(OTHER_BRANCH)
    return iiwa


def test_a_target_is_where_the_tool_centre_point_was(client: Client, taught: Robot) -> None:
    there = taught.solve_forward(TAUGHT).world_t_tcp
    target = client.targets["pick 1"]
    np.testing.assert_allclose(target.pose, there, atol=1e-12)
    assert (target.kind, target.parent, target.robot, target.tool) == ("target", "table", "iiwa", "")
    np.testing.assert_array_equal([target.joint_positions[name] for name in taught.joint_names], TAUGHT)
    assert repr(target) == "<Target 'pick 1' in 'table', taught with 'iiwa'>"
    # It moves along with what it is fixed to.
    client.scene.set_pose("table", pose(0.4, 0.5, 0.3, yaw=0.3))
    np.testing.assert_allclose(target.pose, pose(z=0.2) @ there, atol=1e-12)
    assert list(taught.targets) == ["pick 1"]
    assert "pick 1 (target)" in client.scene.tree()


def test_a_move_to_a_target_takes_the_posture_in_which_it_was_taught(client: Client, taught: Robot) -> None:
    np.testing.assert_allclose(goal_of(taught, taught.ptp("pick 1")), TAUGHT, atol=1e-6)
    # Without what was taught, the posture nearest to the present one is another.
    by_pose = goal_of(taught, taught.ptp(client.targets["pick 1"].pose))
    assert np.abs(by_pose - TAUGHT).max() > 0.5
    above = goal_of(taught, taught.ptp("pick 1", above=0.1))
    assert np.abs(above - TAUGHT).max() < 0.5
    np.testing.assert_allclose(
        taught.solve_forward(above).world_t_tcp, client.targets["pick 1"].pose @ pose(z=-0.1), atol=1e-5
    )


@pytest.mark.long
def test_of_all_branches_the_taught_one_is_taken(client: Client) -> None:
    """An arm of six axes has eight postures for this pose; whichever it is in, it goes to that of the target."""
    arm = client.load_robot("model://ur5e", name="arm")
    arm.set_positions([0.3, -1.1, 1.4, -0.9, -1.2, 0.5])
    taught, place = arm.positions, arm.teach("pick 1").pose
    found = arm.solve_inverse(place)
    assert len({tuple(np.round(np.remainder(q, 2 * np.pi), 6)) for q in found.solutions}) == 8
    others = [q for q in found.solutions if np.abs(q - taught).max() > 1e-6]
    for branch in others:
        arm.set_positions(branch)
        np.testing.assert_allclose(goal_of(arm, arm.ptp("pick 1")), taught, atol=1e-6)
    # Who names a configuration gets that.
    arm.set_positions(taught)
    wanted = found.configurations[-1]
    chosen = goal_of(arm, arm.ptp("pick 1", configuration=wanted))
    assert np.abs(chosen - taught).max() > 0.1
    np.testing.assert_allclose(arm.solve_forward(chosen).world_t_tcp, place, atol=1e-6)


def test_an_arm_that_is_carried_there_takes_the_taught_posture(client: Client) -> None:
    rail = client.load_denavit_hartenberg(
        [{"type": "prismatic", "limits": (0.0, 2.0), "name": "axis"}], convention="standard", name="rail"
    )
    arm = client.load_robot("model://ur5e", name="arm", parent=rail.flange)
    rail.set_positions([0.5])
    arm.set_positions([0.3, -1.1, 1.4, -0.9, -1.2, 0.5])
    taught = arm.positions
    place = arm.teach("pick 1").pose
    arm.set_positions(arm.solve_inverse(place).solutions[-1])
    assert np.abs(arm.positions - taught).max() > 0.1
    rail.set_positions([0.0])
    plan = client.plan([rail.ptp([0.5]), arm.ptp("pick 1")])
    np.testing.assert_allclose(plan.robots["arm"].positions[-1], taught, atol=1e-6)


def test_a_path_is_found_to_a_target(client: Client, taught: Robot) -> None:
    taught.set_positions(TAUGHT + 0.2)
    path = client.paths.find("iiwa", "pick 1")
    np.testing.assert_allclose(path.waypoints[-1], TAUGHT, atol=1e-6)


def test_lines_and_splines_lead_to_targets(client: Client, taught: Robot) -> None:
    taught.set_positions(TAUGHT)
    before = taught.tcp
    taught.set_positions(goal_of(taught, taught.ptp("pick 1", above=0.1)))
    line = taught.plan(taught.linear("pick 1")).robots["iiwa"].world_t_tcp[-1]
    np.testing.assert_allclose(line, before, atol=1e-5)
    curve = taught.plan(taught.spline([before @ pose(x=0.02, z=-0.05), "pick 1"])).robots["iiwa"].world_t_tcp[-1]
    np.testing.assert_allclose(curve, before, atol=1e-5)


def test_the_arm_goes_there(client: Client, iiwa: Robot) -> None:
    iiwa.set_positions(TAUGHT)
    there = iiwa.tcp
    iiwa.teach("pick 1")
    iiwa.set_positions(TAUGHT + 0.1)
    iiwa.move_to("pick 1", above=0.05)
    np.testing.assert_allclose(iiwa.tcp, there @ pose(z=-0.05), atol=1e-5)
    iiwa.move_linear("pick 1", velocity=0.5)
    np.testing.assert_allclose(iiwa.tcp, there, atol=1e-5)


def test_targets_and_postures_are_saved_with_the_scene(client: Client, taught: Robot, tmp_path: Path) -> None:
    taught.postures.add("folded", {"lbr_iiwa_joint_4": -1.5})
    client.scene.add_frame("fixture", parent="table", pose=pose(z=0.1), size=0.2)
    before = client.targets["pick 1"]
    where, joints = before.pose, before.joint_positions
    client.scene.save(tmp_path / "cell.yaml")
    text = (tmp_path / "cell.yaml").read_text()
    assert "target:" in text and "folded" in text
    client.scene.load_scene(tmp_path / "cell.yaml")
    after = client.targets["pick 1"]
    np.testing.assert_allclose(after.pose, where, atol=1e-12)
    assert (after.joint_positions, after.robot, after.parent) == (joints, "iiwa", "table")
    assert client.robot("iiwa").postures == {"folded": {"lbr_iiwa_joint_4": -1.5}}
    assert client.scene.node("fixture").kind == "object"
    client.scene.save(tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_text() == text


def test_a_scene_file_with_models_has_targets_of_their_robots(client: Client, tmp_path: Path) -> None:
    file = tmp_path / "cell.yaml"
    file.write_text(
        f"""
schema_version: 1
nodes:
- name: pick 1
  parent_t_node: {{position: {{x: 0.5, z: 0.4}}}}
  target: {{robot: arm, joint_positions: {{lbr_iiwa_joint_4: -1.2}}}}
models:
- {{uri: "{IIWA}", name: arm}}
"""
    )
    client.scene.load_scene(file)
    assert client.targets["pick 1"].joint_positions == {"lbr_iiwa_joint_4": -1.2}


def test_programs_go_to_targets_by_name_in_files_too(client: Client, taught: Robot, tmp_path: Path) -> None:
    file = tmp_path / "pick.yaml"
    file.write_text(
        """
schema_version: 1
steps:
- move: {moves: [{robot: iiwa, point_to_point: {pose: {reference: pick 1, reference_t_tcp: {position: {z: -0.1}}}}}]}
- move: {moves: [{robot: iiwa, linear: {goal: {reference: pick 1}}}]}
"""
    )
    plan = client.read_program(file).plan()
    np.testing.assert_allclose(plan.robots["iiwa"].world_t_tcp[-1], client.targets["pick 1"].pose, atol=1e-5)
    # The line moves the joints that the pose leaves free a little.
    np.testing.assert_allclose(plan.robots["iiwa"].positions[-1], TAUGHT, atol=0.05)


def test_a_target_that_is_taught_anew_leaves_what_runs(client: Client, iiwa: Robot) -> None:
    iiwa.set_positions(TAUGHT)
    iiwa.teach("pick 1")
    old = client.targets["pick 1"].pose
    iiwa.set_positions(TAUGHT + 0.3)
    motion = iiwa.move_to("pick 1", wait=False)
    client.targets["pick 1"].parent_t_node = old @ pose(x=0.1)
    motion.wait()
    np.testing.assert_allclose(iiwa.tcp, old, atol=1e-6)
    iiwa.move_to("pick 1")
    np.testing.assert_allclose(iiwa.tcp, old @ pose(x=0.1), atol=1e-5)
    with pytest.raises(virtualrobot.NameTakenError, match="replace=True teaches it anew"):
        iiwa.teach("pick 1")
    client.scene.add_object("table", pose=pose(1.0))
    iiwa.set_positions(TAUGHT)
    again = iiwa.teach("pick 1", "table", replace=True)
    assert again.uid == client.targets["pick 1"].uid
    np.testing.assert_allclose(again.pose, old, atol=1e-12)
    assert again.parent == "table"


def test_names_follow_and_what_is_gone_is_forgotten(client: Client, taught: Robot) -> None:
    client.scene.rename("iiwa", "left")
    left = client.robot("left")
    assert client.targets["pick 1"].robot == "left"
    np.testing.assert_allclose(goal_of(left, left.ptp("pick 1")), TAUGHT, atol=1e-6)
    client.targets["pick 1"].rename("pick 2")
    np.testing.assert_allclose(goal_of(left, left.ptp("pick 2")), TAUGHT, atol=1e-6)
    client.scene.remove("left")
    target = client.targets["pick 2"]
    assert (target.robot, target.joint_positions) == ("", {})
    client.scene.remove("table")
    assert client.targets == {}


def test_a_tool_is_told_and_another_arm_goes_there_too(client: Client, iiwa: Robot) -> None:
    client.scene.add_tool("drill", iiwa.flange, pose=pose(z=0.1), tool_center_points={"bit": pose(z=0.15)})
    iiwa.set_positions(TAUGHT)
    target = iiwa.teach("hole")
    assert (target.tool, target.tool_center_point) == ("drill", "bit")
    np.testing.assert_allclose(target.pose, iiwa.tcp, atol=1e-12)
    client.scene.rename("drill", "borer")
    assert target.tool == "borer"
    client.scene.remove("borer")
    assert (target.tool, target.tool_center_point, target.robot) == ("", "", "iiwa")
    other = client.load_robot(IIWA, name="other")
    other.set_positions(0.9 * TAUGHT)
    goal = goal_of(other, other.ptp("hole", above=0.25))
    np.testing.assert_allclose(other.solve_forward(goal).world_t_tcp, target.pose @ pose(z=-0.25), atol=1e-5)


def test_wrong_names_are_refused_with_the_right_ones(client: Client, taught: Robot) -> None:
    taught.postures.add("home")
    with pytest.raises(virtualrobot.UnknownNameError, match="did you mean 'pick 1'") as unknown:
        taught.move_to("pikc 1")
    assert unknown.value.metadata["valid"] == "home\npick 1"
    with pytest.raises(virtualrobot.UnknownNameError, match="there are 'home', 'pick 1'"):
        taught.move_linear("xyz")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="only point-to-point moves go to postures"):
        taught.linear("home")
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"above 0\.1 is for a goal that is a pose or target"):
        taught.ptp("home", above=0.1)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="leave out the reference 'table'"):
        taught.ptp("pick 1", reference="table")
    for name, kind in (("home", "posture"), ("table", r"node \(object\)")):
        with pytest.raises(virtualrobot.NameTakenError, match=kind):
            taught.teach(name)
    with pytest.raises(virtualrobot.NameTakenError, match="is a target"):
        taught.postures.add("pick 1")
    with pytest.raises(virtualrobot.UnknownNameError, match="'tabel'"):
        taught.teach("pick 2", "tabel")
    assert list(client.targets) == ["pick 1"]
    # Scene files and other clients may use a name twice; then nobody guesses.
    client.scene.set_postures("iiwa", {"pick 1": {"lbr_iiwa_joint_1": 0.0}})
    with pytest.raises(virtualrobot.InvalidArgumentError, match="is a posture of 'iiwa' and a target"):
        taught.move_to("pick 1")


def test_targets_that_cannot_be_are_refused(client: Client, taught: Robot) -> None:
    scene = client.scene
    bad = [
        ({"robot": "iwa"}, "the target 'pick 2': there is no robot named 'iwa'; did you mean 'iiwa'"),
        ({"robot": "iiwa", "joint_positions": {"panda_joint1": 0.0}}, "named 'panda_joint1'"),
        ({"joint_positions": {"lbr_iiwa_joint_1": 0.0}}, "joint positions are those of a robot"),
        ({"robot": "table"}, "no robot named 'table'"),
    ]
    for options, message in bad:
        with pytest.raises(virtualrobot.VirtualRobotError, match=message):
            scene.add_target("pick 2", **options)
    scene.add_target("far", pose=pose(5.0), robot="iiwa")
    with pytest.raises(virtualrobot.UnreachableError):
        taught.move_to("far")


def test_a_robot_that_moves_no_tool_centre_point_saves_postures(client: Client) -> None:
    husky = client.load_robot("package://pybullet_data/husky/husky.urdf", name="husky")
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"postures\.add saves its joints"):
        husky.teach("here")
    husky.postures.add("parked")
    assert list(husky.postures["parked"]) == husky.joint_names


def test_a_group_is_taught_with_its_own_joints(client: Client) -> None:
    panda = client.load_robot(PANDA, name="panda")
    arm = panda.group(tip="panda_link8")
    panda.set_positions({"panda_joint2": -0.4, "panda_joint4": -2.0, "panda_joint6": 1.8})
    there = arm.tcp
    target = arm.teach("here")
    np.testing.assert_allclose(target.pose, there, atol=1e-12)
    assert target.joint_positions.keys() == set(arm.joint_names)


def test_postures_are_added_replaced_and_removed(client: Client, iiwa: Robot) -> None:
    iiwa.set_positions(TAUGHT)
    iiwa.postures.add("ready")
    assert list(iiwa.postures["ready"].values()) == TAUGHT.tolist()
    iiwa.postures.add("low", np.zeros(7))
    assert list(iiwa.postures) == ["ready", "low"]
    assert repr(iiwa.postures) == "<Postures of 'iiwa': 'ready', 'low'>"
    with pytest.raises(virtualrobot.NameTakenError, match="replace=True"):
        iiwa.postures.add("low")
    iiwa.postures.add("low", {"lbr_iiwa_joint_2": 0.5}, replace=True)
    assert iiwa.postures["low"] == {"lbr_iiwa_joint_2": 0.5}
    np.testing.assert_allclose(goal_of(iiwa, iiwa.ptp("low")), [0.5])
    # A client that knew an older world learns of it when it is asked for.
    with virtualrobot.connect(client.address) as other:
        other.robot("iiwa").postures.add("new", {"lbr_iiwa_joint_1": 0.1})
    iiwa.ptp("new")
    iiwa.postures.remove("low")
    with pytest.raises(virtualrobot.UnknownNameError, match="did you mean 'new'"):
        _ = iiwa.postures["nwe"]
    with pytest.raises(virtualrobot.UnknownNameError, match="no posture of 'iiwa' named 'low'"):
        iiwa.postures.remove("low")
    with pytest.raises(TypeError, match=r"postures\.add\('home', positions\)"):
        iiwa.postures["home"] = {}
    with pytest.raises(TypeError, match=r"postures\.remove\('new'\)"):
        del iiwa.postures["new"]
    with pytest.raises(virtualrobot.LimitError, match="posture 'high'"):
        iiwa.postures.add("high", {"lbr_iiwa_joint_2": 3.0})
    with pytest.raises(virtualrobot.InvalidArgumentError, match="name is ''; it must be a text that is not empty"):
        iiwa.postures.add("")
    assert set(iiwa.postures) == {"ready", "new"}


def test_a_posture_is_added_while_the_robot_moves(client: Client, iiwa: Robot) -> None:
    motion = iiwa.jog_joint("lbr_iiwa_joint_1", 0.1)
    iiwa.postures.add("on the way")
    target = iiwa.teach("somewhere")
    assert not motion.phase.ended
    motion.cancel()
    assert target.robot == "iiwa"


def test_a_leased_robot_is_taught_by_its_owner_alone(client: Client, iiwa: Robot) -> None:
    with virtualrobot.connect(client.address) as other, other.lease("iiwa"):
        for teach in (lambda: iiwa.teach("pick 1"), lambda: iiwa.postures.add("home")):
            with pytest.raises(virtualrobot.LeasedError):
                teach()
        other.robot("iiwa").teach("pick 1")
    # A place in the world is nobody's robot.
    client.targets["pick 1"].rename("pick 2")


def test_people_see_a_target_and_nothing_else_does(client: Client, taught: Robot) -> None:
    client.scene.add_target("here", pose=pose(x=1.0, z=0.5))
    client.scene.set_figures("here", virtualrobot.box(0.2, 0.2, 0.2))
    assert client.rays.cast([1.0, 0.0, 2.0], [[0.0, 0.0, -1.0]]).nodes == [""]
    client.scene.set_pose("here", taught.tcp)
    assert not client.collisions.check()


def test_the_command_line_teaches_and_goes_there(client: Client, iiwa: Robot, run: Run) -> None:
    client.scene.add_frame("fixture", pose=pose(0.2))
    iiwa.set_positions(TAUGHT)
    there = iiwa.tcp
    assert run("teach", "iiwa", "pick 1", "--parent", "fixture") == "taught pick 1 in fixture\n"
    assert run("teach", "iiwa", "ready", "--posture") == "iiwa has the posture ready\n"
    assert "replace=True" in run("teach", "iiwa", "pick 1", code=1)
    run("teach", "iiwa", "pick 1", "--parent", "fixture", "--replace")
    assert run("teach", "iiwa") == "posture ready\ntarget pick 1 in fixture, taught with iiwa\n"
    run("move", "iiwa", "--to", "pick 1", "--above", "0.02")
    np.testing.assert_allclose(iiwa.tcp, there @ pose(z=-0.02), atol=1e-5)
    run("move", "iiwa", "--to", "pick 1", "--linear", "--velocity", "1")
    np.testing.assert_allclose(iiwa.tcp, there, atol=1e-5)
    run("move", "iiwa", "--to", "ready")
    np.testing.assert_allclose(iiwa.positions, TAUGHT, atol=1e-9)
    assert "did you mean 'ready'" in run("move", "iiwa", "--to", "raedy", code=1)
    assert "--above goes with --to" in run("move", "iiwa", "--pose", "1,0,0", "--above", "1", code=2)
    with virtualrobot.connect(client.address) as other:
        inside = Target(session=Session(other))
        assert [word for word, _ in completions(inside, ["move", "iiwa", "--to"], "p")] == ["pick 1"]
