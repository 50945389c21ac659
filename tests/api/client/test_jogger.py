"""Splines and jogs through the client and the command line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Phase, Robot, pose

from tests.api.client.conftest import IIWA, Run

BENT = np.array([0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0])


@pytest.fixture
def bent(iiwa: Robot) -> Robot:
    iiwa.move_joints(BENT)
    return iiwa


@pytest.mark.long
def test_a_spline_through_poses_in_frames_of_several_nodes(client: Client, bent: Robot) -> None:
    client.scene.add_object("table", pose=pose(0.3, 0.2, 0.1, yaw=0.5))
    here = bent.tcp
    poses = np.array([here @ pose(x=0.04 * k, y=0.02 * (-1) ** k) for k in (1, 2, 3)])
    bent.move_spline(poses, velocity=0.5)
    np.testing.assert_allclose(bent.tcp, poses[-1], atol=1e-8)
    back = [np.linalg.inv(pose(0.3, 0.2, 0.1, yaw=0.5)) @ poses[1], here]
    other = client.load_robot(IIWA, name="other", pose=pose(x=2))
    curve = bent.spline(back, references=["table", "world"], velocity=0.5, lock=["lbr_iiwa_joint_3"])
    client.move_together([curve, other.ptp({"lbr_iiwa_joint_1": 0.1})])
    np.testing.assert_allclose(bent.tcp, here, atol=1e-8)
    np.testing.assert_allclose(other.positions[0], 0.1, atol=1e-9)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="2 poses need as many references, not 3"):
        bent.spline(back, references=["world", "world", "table"])


def test_jogs_return_at_once_and_stop_when_they_are_cancelled(bent: Robot) -> None:
    motion = bent.jog_joint("lbr_iiwa_joint_1", -0.1)
    assert not motion.phase.ended
    motion.cancel()
    with pytest.raises(virtualrobot.MotionCancelledError):
        motion.wait()
    assert -2.0 < bent.positions[0] <= 0.0  # its limit is at -2.97
    assert bent.jog_joint("lbr_iiwa_joint_1", 0.5, 0.2, wait=True).phase is Phase.SUCCEEDED
    here = bent.tcp
    bent.jog([0, 0, 2], frame="tool", velocity=0.2, distance=0.02, wait=True)
    np.testing.assert_allclose(bent.tcp, here @ pose(z=0.02), atol=1e-8)
    bent.jog(rotation=[0, 0, -1], node=bent.flange, velocity=1.0, distance=0.3, wait=True)
    np.testing.assert_allclose(bent.tcp, here @ pose(z=0.02, yaw=-0.3), atol=1e-8)
    now = bent.tcp
    bent.jog([1, 0, 0], frame="world", distance=0.01, wait=True)
    np.testing.assert_allclose(bent.tcp, pose(x=0.01) @ now, atol=1e-8)


def test_what_is_no_jog_is_refused_before_it_is_sent(bent: Robot) -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({}, "give either translation or rotation"),
        ({"translation": [0, 0, 1], "rotation": [0, 0, 1]}, "give either translation or rotation"),
        ({"translation": [0, 1]}, "3 finite numbers"),
        ({"translation": [0, 0, 1], "frame": "flange"}, "'base', 'tool' or 'world'"),
        ({"translation": [0, 0, 1], "frame": "tool", "node": "world"}, "with the node 'world'"),
    ]
    for bad, words in cases:
        with pytest.raises(virtualrobot.InvalidArgumentError, match=words):
            bent.jog(**bad)
    with pytest.raises(virtualrobot.LimitError):
        bent.jog_joint("lbr_iiwa_joint_1", 99.0)


@pytest.mark.long
def test_the_command_line_jogs(run: Run, bent: Robot) -> None:
    words = ["--velocity", "-40", "--distance", "9", "--degrees"]
    assert "reached its goal" in run("jog", "iiwa", "lbr_iiwa_joint_1", *words)
    np.testing.assert_allclose(bent.positions[0], np.radians(-9.0), atol=1e-9)
    here = bent.tcp
    run("jog", "iiwa", "--along", "0,0,1", "--frame", "tool", "--distance", "0.01")
    np.testing.assert_allclose(bent.tcp, here @ pose(z=0.01), atol=1e-8)
    run("jog", "iiwa", "--about", "0,0,1", "--node", "iiwa", "--velocity", "30", "--distance", "6", "--degrees")
    np.testing.assert_allclose(bent.tcp[:3, :3], (pose(yaw=np.radians(6.0)) @ here)[:3, :3], atol=1e-8)
    told = run("jog", "iiwa", "--about", "1,0,0", "--frame", "tool", "--velocity", "1", warns=1)
    assert "reached its end" in told, "a whole turn about the tool's x axis meets a joint's end before"
    assert "no joint" in run("jog", "iiwa", "elbow", "--velocity", "1", code=1)
    for wrong in (["iiwa"], ["iiwa", "j", "--along", "0,0,1"], ["iiwa", "lbr_iiwa_joint_1"]):
        run("jog", *wrong, code=2)


def test_rods_end_the_jogs_of_a_palletizer(client: Client) -> None:
    """Its forearm's motor stands on the column and turns by the sum of two joints: its limit ends what they don't."""
    client.clock.set_stepped()
    palletizer = client.load_robot("model://palletizer", name="palletizer")
    limits = np.array([[one.lower, one.upper] for one in palletizer.actuators])

    def at_ends() -> list[int]:
        client.clock.step(4000)
        assert not client.motions()
        positions = palletizer.state.actuator_positions
        assert np.all((positions >= limits[:, 0] - 1e-3) & (positions <= limits[:, 1] + 1e-3))
        # The motor turns by 150 rad for a radian of the joints.
        room = np.minimum(positions - limits[:, 0], limits[:, 1] - positions)
        return np.flatnonzero(room < 0.02).tolist()

    palletizer.set_positions([0.2, 1.0, 0.2, 0.1])
    palletizer.jog_joint("joint_3", 0.5)
    assert at_ends() == [2]
    with pytest.raises(virtualrobot.LimitError, match="it is at its end"):
        palletizer.jog_joint("joint_3", 0.5)
    palletizer.set_positions([0.2, 0.3, 1.2, 0.1])
    motion = palletizer.jog([0, 0, -1], velocity=0.3)
    (note,) = motion.notes
    assert "actuator" in note.message
    assert at_ends() == [2]
    with pytest.raises(virtualrobot.LimitError, match="the jog cannot move"):
        palletizer.jog([0, 0, -1])
    before = palletizer.tcp
    assert not palletizer.jog([0, 0, 1], distance=0.05, velocity=0.3).notes
    client.clock.step(1000)
    np.testing.assert_allclose(palletizer.tcp, pose(z=0.05) @ before, atol=1e-8)
