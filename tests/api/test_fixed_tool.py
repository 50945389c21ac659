"""Moves along a tool that stands apart, by the contract: where it is on the workpiece, tick by tick, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot.errors import VirtualRobotError

from tests.unit.formats.models import ROBOTS

READY = [0.3, 0.6, -0.2, -1.4, 0.1, 0.9, 0.2]


@pytest.fixture
def arm(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an arm that holds a workpiece in front of a spindle, in a world that is stepped."""
    client.clock.set_stepped()
    arm = client.load_robot(ROBOTS["iiwa"], name="arm")
    arm.set_positions(dict(zip(arm.joint_names, READY, strict=True)))
    client.scene.add_frame("work", parent=arm.flange, pose=virtualrobot.pose(z=0.1, roll=0.3))
    client.scene.add_frame("spindle", pose=arm.tcp @ virtualrobot.pose(x=0.05, z=0.15, pitch=0.4))
    return arm


def on_work(client: virtualrobot.Client) -> np.ndarray:
    """Return where the spindle is on the workpiece (4, 4)."""
    poses = client.scene.poses(["work", "spindle"])
    return np.linalg.inv(poses["work"]) @ poses["spindle"]


def test_a_program_grinds_the_edges_of_a_workpiece(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    """A square of 4 cm, of which each edge is straight on the workpiece, and a corner that is rounded off."""
    start = on_work(client)
    corners = []
    for x, y in ((0.04, 0.0), (0.04, 0.04), (0.0, 0.04), (0.0, 0.0)):
        corner = start.copy()
        corner[:3, 3] += [x, y, 0.0]
        corners.append(corner)
    program = client.program()
    for number, corner in enumerate(corners):
        line = arm.linear(corner, reference="work", fixed_tool="spindle", velocity=0.05, angular_velocity=1.0)
        program.move(line, zone=0.005 if number == 1 else None)
    motion = program.start(wait=False)
    places = [on_work(client)[:3, 3]]
    while not motion.phase.ended:
        client.clock.step(5)
        places.append(on_work(client)[:3, 3])
    off = np.array(places) - start[:3, 3]
    assert np.abs(off[:, 2]).max() < 1e-5
    edges = np.stack([np.abs(off[:, 1]), np.abs(off[:, 0] - 0.04), np.abs(off[:, 1] - 0.04), np.abs(off[:, 0])])
    rounded = np.linalg.norm(off[:, :2] - [0.04, 0.04], axis=1) < 0.005
    assert edges.min(axis=0)[~rounded].max() < 1e-5 and rounded.any()
    assert np.linalg.norm(off[-1]) < 1e-6
    assert np.linalg.norm(arm.tcp[:3, 3] - client.scene.pose("spindle")[:3, 3]) > 0.1, "the flange is elsewhere"


def test_what_was_shown_is_started_as_it_is_and_not_when_the_tool_stands_elsewhere(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    goal = on_work(client)
    goal[:3, 3] += [0.03, 0.0, 0.0]
    line = arm.linear(goal, reference="work", fixed_tool="spindle")
    shown = [arm.plan(line) for _ in range(2)]
    client.clock.run(client.start_plan(shown[0], wait=False))
    np.testing.assert_allclose(on_work(client), goal, atol=1e-6)
    arm.set_positions(dict(zip(arm.joint_names, READY, strict=True)))
    client.scene.set_pose("spindle", client.scene.pose("spindle") @ virtualrobot.pose(z=0.01))
    with pytest.raises(VirtualRobotError, match="spindle"):
        client.start_plan(shown[1], wait=False)


def test_what_leads_no_tool_takes_none_that_stands_apart(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    with pytest.raises(VirtualRobotError, match=r"fixed_tool is for moves to poses, lines, arcs and splines"):
        arm.start(arm.ptp(dict.fromkeys(arm.joint_names, 0.1), fixed_tool="spindle"), wait=False)
    with pytest.raises(VirtualRobotError, match="leave out moving"):
        arm.start(arm.linear(on_work(client), reference="work", fixed_tool="spindle", moving=True), wait=False)
    with pytest.raises(VirtualRobotError, match="'arm' moves 'world' along the tool 'spindle', and must carry it"):
        arm.move_linear(on_work(client), fixed_tool="spindle", wait=False)
