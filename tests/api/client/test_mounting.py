"""Grippers and tools mounted on arms in one call: what the arm has then, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.api.client.conftest import Run
from tests.tiers import every_fifth
from tests.unit.formats.models import MODELS

READY = [0.0, -1.2, 1.6, -1.9, -1.5, 0.3]

NO_TOOL = {"wsg50", "egk40"}
"""Grippers of packages whose files tell no tool, and of which no table of ours does."""

GRIPPERS = [
    name for name, model in MODELS.items() if model.kind == "gripper" and model.installed and name not in NO_TOOL
]
PADS = {"robotiq_2f_85_meshes": ("left_inner_finger_pad", "right_inner_finger_pad", 0.00635)}
"""Links whose distance is the width, and by how much more; of others the fingers' own frames are where they meet."""


@pytest.fixture
def arm(client: Client) -> Robot:
    robot = client.load_robot("model://ur5", name="arm", pose=virtualrobot.pose(z=0.5))
    robot.set_positions(READY)
    return robot


def gap(client: Client, gripper: str, model: str) -> float:
    """Return how far the fingers are apart by forward kinematics, in meters."""
    left, right, less = PADS.get(model, ("left_finger", "right_finger", 0.0))
    poses = client.scene.poses([f"{gripper}.{left}", f"{gripper}.{right}"])
    between = np.subtract(*(pose[:3, 3] for pose in poses.values()))
    return float(np.linalg.norm(between)) - less


@pytest.mark.parametrize("model", every_fifth(GRIPPERS))
def test_each_gripper_is_a_tool_in_one_call(client: Client, arm: Robot, model: str, rng: np.random.Generator) -> None:
    pose = virtualrobot.pose(z=0.01, yaw=0.5)
    tool = arm.mount(f"model://{model}", name="hand", pose=pose)
    assert arm.tools == [tool.name] == [arm.tool("hand").name]
    assert (arm.state.tool, arm.state.tool_center_point) == (tool.name, "tcp")
    flange, body = client.scene.pose(arm.flange), client.scene.pose("hand")
    np.testing.assert_allclose(body, flange @ pose, atol=1e-9)
    point = client.scene.pose(tool.name) @ tool.tool_center_points["tcp"]
    np.testing.assert_allclose(arm.tcp, point, atol=1e-9)
    assert not client.collisions.check().pairs
    for state in reversed(tool.states):
        tool.set(state).wait()
        assert tool.state == state
    if not tool.widths:
        assert MODELS[model].axes == 0, "cups and magnets do not open"
        with pytest.raises(virtualrobot.InvalidArgumentError, match="no widths"):
            tool.move_to_width(0.01)
        return
    least, most = min(tool.widths), max(tool.widths)
    for width in (most, *rng.uniform(least, most, 3), least):
        tool.move_to_width(width).wait()
        assert gap(client, "hand", model) == pytest.approx(width, abs=1e-4), "a tenth of a millimeter"
        assert tool.width == pytest.approx(width, abs=1e-4)
    assert tool.state == "closed", "the least width is that of a state"
    with pytest.raises(virtualrobot.LimitError, match="cannot open to"):
        tool.move_to_width(most + 0.01)


def test_an_arm_works_with_what_it_grips(client: Client, arm: Robot) -> None:
    hand = arm.mount("model://parallel_gripper", name="hand")
    hand.move_to_width(0.06).wait()
    client.scene.add_part("box", virtualrobot.box(0.02, 0.03, 0.02), pose=arm.tcp, mass=0.5)
    assert not client.collisions.check().pairs
    assert arm.pick("box") == "box"
    hand.move_to_width(0.0299).wait()
    assert not client.collisions.check().pairs, "fingers may touch what they hold"
    grip = np.linalg.inv(arm.tcp) @ client.scene.pose("box")
    lifted = virtualrobot.pose(z=0.05) @ arm.tcp
    arm.move_linear(lifted).wait()
    np.testing.assert_allclose(arm.tcp, lifted, atol=1e-6)
    np.testing.assert_allclose(np.linalg.inv(arm.tcp) @ client.scene.pose("box"), grip, atol=1e-9)
    arm.place("box")
    hand.open().wait()
    assert not client.collisions.check().pairs


@pytest.mark.long
def test_the_gripper_counts_where_the_arm_goes(client: Client, arm: Robot) -> None:
    """A rod that only the gripper would meet: checks, paths and the guard see it."""
    turned = {arm.joint_names[0]: 0.6}
    arm.set_positions(turned)
    rod = arm.tcp @ virtualrobot.pose(z=0.06)
    arm.set_positions({arm.joint_names[0]: 0.0})
    client.scene.add_object("rod", virtualrobot.sphere(0.005), pose=rod)
    assert not client.collisions.check({"arm": turned}).pairs
    hand = arm.mount("model://robotiq_2f_85", name="hand")
    touching = client.collisions.check({"arm": turned}, robots=["arm"]).pairs
    assert {(pair.first.split(".")[0], pair.second.split(".")[0]) for pair in touching} <= {("rod", "hand")}
    assert touching
    with pytest.raises(virtualrobot.CollisionError, match="hand"):
        client.paths.find("arm", turned)
    beyond = {arm.joint_names[0]: 1.2}
    assert not client.collisions.check({"arm": beyond}).pairs
    found = client.paths.find("arm", beyond)
    assert not found.straight, "the rod is in the way of the gripper"
    client.collisions.set(robots={"arm": "guard"})
    with pytest.raises(virtualrobot.MotionAbortedError, match="'hand"):
        arm.move_joints(turned).wait()
    assert not client.collisions.check().pairs
    hand.close().wait()
    assert hand.width == 0.0


def test_the_wrist_holds_the_weight_of_the_gripper(client: Client, arm: Robot) -> None:
    """The work of a weight: each joint's torque is m g times how much the centre of mass rises with it."""
    bare = arm.gravity_torques()
    flange = client.scene.pose(arm.flange)
    arm.mount("model://robotiq_2f_85", name="hand")
    held = arm.gravity_torques()
    # 80 % of 0.925 kg in the middle of a body of 94 mm, the rest in fingers of 65 mm on it, by the model's table.
    tcp_t_centre = np.linalg.inv(arm.tcp) @ flange @ [0.0, 0.0, 0.8 * 0.047 + 0.2 * (0.094 + 0.0325), 1.0]
    now, step = dict(zip(arm.joint_names, READY, strict=True)), 1e-4
    for joint, value in now.items():
        up, down = (
            (arm.solve_forward({**now, joint: value + change}).world_t_tcp @ tcp_t_centre)[2]
            for change in (step, -step)
        )
        assert held[joint] - bare[joint] == pytest.approx(0.925 * 9.81 * (up - down) / (2.0 * step), abs=1e-5)


def test_tools_are_changed_at_a_rack(client: Client, arm: Robot) -> None:
    rack = client.scene.add_object("rack", pose=virtualrobot.pose(1.0))
    hand = arm.mount("model://wsg50_110", name="hand")
    arm.unmount(to="rack", pose=virtualrobot.pose(z=0.2))
    assert (arm.tools, arm.state.tool) == ([], "")
    np.testing.assert_allclose(client.scene.pose("hand"), client.scene.pose(rack.name) @ virtualrobot.pose(z=0.2))
    client.scene.load("model://vacuum_gripper", name="cups", parent="rack")
    cups = arm.change_tool("cups", tcp="cup_2")
    assert (cups.name, arm.state.tool_center_point) == ("cups", "cup_2")
    again = arm.change_tool(hand, rack="rack", rack_pose=virtualrobot.pose(y=0.3))
    assert (again.name, arm.tools, client.scene.node("cups").parent) == ("hand.tool", ["hand.tool"], "rack")
    arm.unmount(client.scene.node("hand"))
    plate = client.scene.add_adapter("plate", arm.flange, pose=virtualrobot.pose(z=0.02))
    arm.mount(client.robot("hand"), adapter=plate, pose=virtualrobot.pose(z=0.01))
    np.testing.assert_allclose(
        client.scene.pose("hand"), client.scene.pose(arm.flange) @ virtualrobot.pose(z=0.03), atol=1e-9
    )


def test_a_saved_cell_has_its_gripper_and_how_wide_it_is(client: Client, arm: Robot, tmp_path: Path) -> None:
    hand = arm.mount("model://parallel_gripper", name="hand", pose=virtualrobot.pose(z=0.01))
    hand.move_to_width(0.0234).wait()
    file = tmp_path / "cell.yaml"
    client.scene.save(file)
    place = arm.tcp
    client.scene.load_scene(file)
    arm, hand = client.robot("arm"), client.robot("arm").tool()
    assert (hand.name, hand.state, arm.tools) == ("hand.tool", "open", ["hand.tool"])
    assert hand.width == pytest.approx(0.0234, abs=1e-9)
    np.testing.assert_allclose(arm.tcp, place, atol=1e-9)
    hand.close().wait()


def test_a_scene_file_mounts_its_models(client: Client, tmp_path: Path) -> None:
    file = tmp_path / "cell.yaml"
    file.write_text(
        "schema_version: 1\n"
        "nodes:\n"
        "- {name: plate, parent: arm.flange, adapter: {}, parent_t_node: {position: {z: 0.01}}}\n"
        "models:\n"
        "- {uri: 'model://ur5', name: arm}\n"
        "- {uri: 'model://vacuum_gripper', name: cups, mount_on: arm, parent: plate, tool_center_point: cup_3}\n"
    )
    client.scene.load_scene(file)
    arm = client.robot("arm")
    assert (arm.tools, arm.state.tool_center_point, client.scene.node("cups").parent) == (["cups"], "cup_3", "plate")


def test_a_model_without_a_tool_becomes_one_with_a_point(client: Client, arm: Robot) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="brings none"):
        arm.mount("model://wsg50", name="hand")
    with pytest.raises(virtualrobot.UnknownNameError):
        client.scene.node("hand")
    tool = arm.mount("model://egk40", name="hand", tcp=virtualrobot.pose(z=0.15))
    assert (tool.name, arm.tools) == ("hand.tcp", ["hand.tcp"])
    np.testing.assert_allclose(arm.tcp, client.scene.pose(arm.flange) @ virtualrobot.pose(z=0.15), atol=1e-9)
    arm.unmount()
    with pytest.raises(virtualrobot.UnknownNameError, match="plate"):
        arm.mount("model://egk40", name="second", adapter="plate", tcp=virtualrobot.pose(z=0.15))
    with pytest.raises(virtualrobot.UnknownNameError):
        client.scene.node("second")


def test_what_cannot_be_mounted_is_refused_and_changes_nothing(client: Client, arm: Robot) -> None:
    other = client.load_robot("model://ur3", name="other", pose=virtualrobot.pose(2.0))
    hand = other.mount("model://wsg50_110", name="hand")
    client.scene.add_object("table")
    names = {node.name for node in client.scene.nodes()}
    for wrong, error, words in (
        (lambda: arm.mount("hand"), virtualrobot.WrongStateError, "mounted on 'other' already"),
        (lambda: other.mount("model://vacuum_cup"), virtualrobot.WrongStateError, "'hand.tool' hangs at"),
        (lambda: arm.mount("table"), virtualrobot.InvalidArgumentError, "brings none"),
        (lambda: arm.mount("arm"), virtualrobot.InvalidArgumentError, "is no tool|hangs below"),
        (lambda: arm.mount("nothing"), virtualrobot.UnknownNameError, "nothing"),
        (lambda: arm.mount("model://vacuum_cup", tcp="tip"), virtualrobot.UnknownNameError, "tip"),
        (
            lambda: arm.mount("model://vacuum_cup", adapter="table"),
            virtualrobot.InvalidArgumentError,
            "no tool of 'arm'",
        ),
        (lambda: arm.unmount("hand"), virtualrobot.WrongStateError, "taken off 'arm'"),
        (lambda: arm.unmount(), virtualrobot.WrongStateError, "works with no tool"),
        (lambda: other.unmount(to="nowhere"), virtualrobot.UnknownNameError, "nowhere"),
        (lambda: other.unmount(to=other.flange), virtualrobot.InvalidArgumentError, "would be still"),
    ):
        with pytest.raises(error, match=words):
            wrong()
    assert {node.name for node in client.scene.nodes()} == names
    assert (arm.tools, other.tools) == ([], [hand.name])
    stale = client.scene.revision
    client.scene.add_object("later")
    with pytest.raises(virtualrobot.StaleRevisionError), client.scene.batch(stale) as batch:
        batch.unmount_tool("other")
        batch.mount_tool("arm", "hand")
    assert (arm.tools, other.tools) == ([], [hand.name])
    motion = other.move_joints([0.2] * 6, speed_factor=0.01, wait=False)
    for wrong in (other.unmount, lambda: other.change_tool("hand")):
        with pytest.raises(virtualrobot.RobotBusyError, match=r"'other' moves"):
            wrong()
    motion.cancel()


def test_a_lease_of_an_arm_keeps_others_from_its_gripper(client: Client, arm: Robot) -> None:
    arm.mount("model://parallel_gripper", name="hand")
    with virtualrobot.connect(client.address) as stranger, arm.lease():
        for wrong in (
            stranger.robot("arm").tool().close,
            stranger.robot("arm").unmount,
            lambda: stranger.robot("hand").move_joints([0.01]),
            lambda: stranger.robot("hand").set_positions([0.01]),
        ):
            with pytest.raises(virtualrobot.LeasedError, match="'arm'"):
                wrong()
        arm.tool().close().wait()
    arm.speed_factor = 0.01
    stop = arm.tool().open(wait=False)
    assert set(stop.robots) == {"hand", "arm"}
    assert [motion.id for motion in arm.stop()] == [stop.id], "who stops an arm stops its gripper"


def test_ghosts_and_files_show_the_gripper(client: Client, arm: Robot, tmp_path: Path) -> None:
    arm.mount("model://parallel_gripper", name="hand").close().wait()
    export = client.scene.export("arm", tmp_path / "arm.urdf")
    assert not any("left out" in warning for warning in export.warnings)
    before = {name: np.linalg.inv(client.scene.pose("arm")) @ pose for name, pose in client.scene.poses().items()}
    read = client.load_robot(tmp_path / "arm.urdf", name="copy", pose=virtualrobot.pose(3.0))
    assert set(arm.joint_names) < set(read.joint_names)
    assert len(read.joint_names) == 7, "the motor of the gripper is a joint"
    read.set_positions({**dict(zip(arm.joint_names, READY, strict=True))})
    base = np.linalg.inv(client.scene.pose("copy"))
    for link in ("hand.body", "hand.left_finger", "hand.right_finger"):
        np.testing.assert_allclose(base @ client.scene.pose(f"copy.{link}"), before[link], atol=1e-6)


def test_ghosts_carry_the_gripper_as_it_is(client: Client, arm: Robot) -> None:
    """A ghost is drawn as the arm is that stands there."""
    arm.mount("model://robotiq_2f_140", name="hand").close().wait()
    upright = [0.0, -1.5708, 0.0, -1.5708, 0.0, 0.0]
    arm.set_positions(upright)
    camera = (0.0, -2.5, 1.2), (0.0, 0.0, 1.2)

    def picture() -> np.ndarray:
        return client.view.capture(camera, size=(320, 240), format="raw").pixels.astype(int)

    standing = picture()
    client.scene.hide("hand")
    bare = picture()
    client.scene.hide("hand", False)
    hand = np.abs(standing - bare).max(axis=2) > 0
    assert hand.sum() > 30, "the gripper is seen"
    arm.set_positions([0.0] * 6)
    away = picture()
    client.view.ghosts = {"goal": ("arm", upright)}
    ghost = np.abs(picture() - away).max(axis=2) > 0
    assert (ghost & hand).sum() > 0.9 * hand.sum()


def test_a_program_grips_by_width_and_the_command_line_mounts(
    run: Run, client: Client, arm: Robot, tmp_path: Path
) -> None:
    assert run("mount", "arm", "model://parallel_gripper", "--name", "hand", "--at", "0,0,0.01") == (
        "arm works with hand.tool\n"
    )
    assert run("tool", "arm", "--width", "0.02") == "hand.tool is 20.0 mm wide\n"
    assert run("tool", "arm") == "* hand.tool  open  of: open, closed  20.0 mm\n"
    program = client.program().tool_width("arm", 0.05).tool_state("arm", "closed").tool_width("arm", 0.03)
    program.start().wait()
    assert arm.tool().width == pytest.approx(0.03, abs=1e-9)
    client.scene.add_object("rack", pose=virtualrobot.pose(0.5))
    assert run("unmount", "arm", "--to", "rack", "--at", "0,0,0.1") == "arm has let its tool go\n"
    assert client.scene.node("hand").parent == "rack"
    assert "nothing" in run("mount", "arm", "nothing", code=1)


def test_what_touches_as_it_is_mounted_may_until_it_is_taken_off(client: Client, iiwa: Robot) -> None:
    """A gripper that reaches back over the last link, loaded elsewhere and then mounted."""
    client.load_robot("model://robotiq_2f_85", name="hand", pose=virtualrobot.pose(2.0))

    def built() -> list[set[str]]:
        pairs = client.collisions.allowed.list("hand")
        return [{pair.first, pair.second} for pair in pairs if pair.reason.startswith("mounted on")]

    iiwa.mount("hand", pose=virtualrobot.pose(z=-0.03))
    assert not client.collisions.check().pairs
    assert built() == [{"iiwa.lbr_iiwa_link_6", "hand.body"}]
    tried = client.collisions.allowed.find("iiwa", samples=100)
    assert any("hand.left_finger" in (pair.first, pair.second) for pair in tried), "the gripper belongs to the arm"
    iiwa.unmount(pose=virtualrobot.pose(2.0))
    assert built() == []


def test_a_check_tells_what_is_too_heavy_from_where_it_is_gripped(client: Client, tmp_path: Path) -> None:
    """A UR5e may carry 5 kg (Universal Robots, UR5e Technical Specifications): 2 kg of a tool, and a part of 3.5."""
    arm = client.load_robot("model://ur5e", name="arm")
    assert arm.rated_payload == 5.0
    arm.set_positions([0.0, -1.2, 1.5, -1.8, -1.6, 0.0])
    tip = {"tip": virtualrobot.pose(z=0.15)}
    client.scene.add_tool("tongs", arm.flange, inertial=virtualrobot.inertial(2.0), tool_center_points=tip)
    client.scene.add_part("stone", virtualrobot.box(0.02, 0.02, 0.02), pose=arm.tcp, mass=3.5)
    lifted = virtualrobot.pose(z=0.05) @ arm.tcp
    near = arm.linear(arm.tcp @ virtualrobot.pose(z=-0.01))
    carried = client.program().move(near).pick(arm, "stone", max_distance=0.1)
    found = carried.move(arm.linear(lifted)).check().first_violation
    assert found is not None and found.kind is virtualrobot.ViolationKind.PAYLOAD, found
    assert (found.robot, found.joint, found.step) == ("arm", "", 2) and (found.value, found.limit) == (5.5, 5.0)
    assert "'arm' would carry 5.5 kg at its flange" in found.message and "may carry 5 kg" in found.message
    client.scene["stone"].remove()
    client.scene.add_part("stone", virtualrobot.box(0.02, 0.02, 0.02), pose=arm.tcp, mass=2.9)
    assert carried.check().ok
    client.scene.save(tmp_path / "cell.yaml")
    assert "payload_kilograms: 5" in (tmp_path / "cell.yaml").read_text("utf-8")
