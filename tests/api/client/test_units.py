"""Numbers in degrees and millimetres are refused with the question that helps."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.api.client.conftest import Run

HOME = [0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0]


def refused(said: str) -> pytest.RaisesExc[virtualrobot.VirtualRobotError]:
    return pytest.raises(virtualrobot.VirtualRobotError, match=re.escape(said))


def test_angles_in_degrees(iiwa: Robot, run: Run) -> None:
    with refused("-90 rad, its limits are -2.0944 to 2.0944 rad; -90 rad is 14.3 turns: degrees? use `math.radians`"):
        iiwa.move_joints({"lbr_iiwa_joint_2": -90.0})
    with refused("; 45 rad is 7.16 turns: degrees?"):
        iiwa.set_positions({"lbr_iiwa_joint_2": 45.0})
    with refused("roll=180 is 28.6 turns: degrees? use math.radians(180)"):
        virtualrobot.pose(0.5, 0.0, 0.3, roll=180.0)
    with refused("of what has turned so far give math.remainder(-20, math.tau)"):
        virtualrobot.pose(yaw=-20.0)
    with refused("3 rad, its limits"):  # three radians are meant, and refused for what they are
        iiwa.move_joints({"lbr_iiwa_joint_2": 3.0})
    assert "degrees? use `math.radians` or `--degrees`" in run("move", "iiwa", "--joints", "0,90,0,0,0,0,0", code=1)
    assert np.allclose(iiwa.positions, 0.0)


@pytest.mark.long
def test_a_joint_without_limits_turns_as_far_as_anybody_means(client: Client) -> None:
    """Two turns at once, from wherever it is; a jog goes on."""
    wheel = client.load_denavit_hartenberg([(0.0, 0.0, 0.1, 0.0)], convention="standard", name="wheel")
    wheel.set_positions([500.0])
    wheel.move_joints([500.0 + 4.0 * np.pi])
    with refused("would turn by 90 rad at once"):
        wheel.move_joints([wheel.positions[0] + 90.0])
    assert wheel.plan(wheel.ptp([0.0]), sample_time=1.0).duration > 0.0  # back to where it began


def test_angles_of_a_table_in_degrees(client: Client) -> None:
    with refused("denavit_hartenberg.rows[0].alpha_radians is 90; 90 rad is 14.3 turns: degrees?"):
        client.load_denavit_hartenberg([(0.0, 90.0, 0.1, 0.0)], convention="standard")


def test_sliding_joints_and_lengths_in_millimetres(client: Client) -> None:
    rail = client.load_denavit_hartenberg(
        [{"type": "prismatic", "limits": (0.0, 2.0), "name": "axis"}], convention="standard", name="rail"
    )
    with refused("800 m, its limits are 0 to 2 m; 800 m: millimetres? lengths are in meters"):
        rail.move_joints([800.0])
    for figure in (virtualrobot.box(800, 600, 40), virtualrobot.sphere(150), virtualrobot.cylinder(0.1, 1000)):
        with refused("millimetres? lengths are in meters; a mesh may be larger"):
            client.scene.add_object("table", figure)
    client.scene.add_object("hall", virtualrobot.box(100, 100, 0.1))


def test_what_a_file_says_may_be_large_and_is_saved_and_loaded(client: Client, tmp_path: Path) -> None:
    field = tmp_path / "field.urdf"
    box = '<geometry><box size="400 400 1"/></geometry>'
    field.write_text(f'<robot name="field"><link name="base"><collision>{box}</collision></link></robot>')
    client.load_robot(field, name="field")
    client.scene.save(tmp_path / "cell.yaml")
    client.scene.load_scene(tmp_path / "cell.yaml")
    with refused("figures[0]: a length must be at most 100 m; 101 m: millimetres?"):
        client.scene.set_figures("field.base", virtualrobot.box(1, 1, 101))


def test_poses_and_speeds_in_millimetres(iiwa: Robot) -> None:
    iiwa.set_positions(HOME)
    with refused("millimetres? lengths are in meters"):
        iiwa.move_pose(virtualrobot.pose(500, 0, 300))
    with refused("at most 50 m/s, not 250: millimetres?"):
        iiwa.move_linear(iiwa.tcp @ virtualrobot.pose(z=-0.05), velocity=250)
    with refused("times its limit: degrees or millimetres?"):
        iiwa.start(iiwa.joint_jog("lbr_iiwa_joint_1", 250.0))
    with pytest.raises(virtualrobot.VirtualRobotError, match=r"not 20$"):
        iiwa.start(iiwa.joint_jog("lbr_iiwa_joint_1", 20.0))


def test_a_part_that_is_far_away_is_not_grasped(client: Client, iiwa: Robot) -> None:
    client.scene.add_tool("hand", iiwa.flange)
    client.scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(4.0))
    with refused("farther than 1 m; move there, or give the distance that will do"):
        iiwa.pick("box")
    assert iiwa.pick("box", max_distance=10.0) == "box"


def test_words_lead_to_what_would_be_right(client: Client, iiwa: Robot) -> None:
    with refused("did you mean 'model://ur5"):
        client.load_robot("ur5")
    with refused("move there by joints (point to point), or begin in another posture"):
        iiwa.move_linear(iiwa.tcp @ virtualrobot.pose(x=0.1))
    with pytest.raises(TypeError, match="did you mean 'speed_factor'"):
        iiwa.move_joints(HOME, speed=0.5)  # pyright: ignore[reportCallIssue]
    with refused("leave http:// away, as in 'localhost:50500'"):
        virtualrobot.connect("http://localhost:50500/")
