"""Streams of twists and poses of a tool on a real kernel: where the tool goes, in which frame, and what stops it."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Phase, Robot
from virtualrobot.errors import InvalidArgumentError, LimitError, UnknownNameError, WrongStateError

from tests.api.client.conftest import Run
from tests.api.client.test_setpoints import ended

BENT = [0.2, 0.5, -0.3, -1.3, 0.4, 1.2, 0.1]
"""A posture of an iiwa far from its limits and singularities."""
LONG = 1e6


@pytest.fixture
def arm(client: Client, iiwa: Robot) -> Robot:
    """Return an arm that is bent, with time that stands still."""
    client.clock.set_stepped()
    iiwa.set_positions(BENT)
    return iiwa


def world_t_tcp(arm: Robot) -> np.ndarray:
    return np.array(arm.state.world_t_tcp)


def test_a_twist_leads_the_tool_along_a_line_in_each_frame(client: Client, arm: Robot) -> None:
    client.scene.add_frame("table", pose=virtualrobot.pose(0.4, 0.1, 0.2, yaw=0.5))
    for frame, node in ((None, None), ("tool", None), (None, "table")):
        begin = world_t_tcp(arm)
        axes = {"tool": begin[:3, :3], None: np.eye(3)}[frame]
        if node:
            axes = client.scene.node(node).pose[:3, :3]
        stream = arm.stream_tool("twist", frame=frame, node=node, timeout=LONG)
        stream.send([0.06, 0.0, -0.08, 0.0, 0.0, 0.0], wait=True)
        client.clock.step(150)
        way = (world_t_tcp(arm) - begin)[:3, 3] @ axes
        # A ramp of 1 m/s² and 10 m/s³ to 0.1 m/s lasts 2 sqrt(v/j), and takes half of its way.
        length = 0.1 * (150 * client.clock.read().tick_length - np.sqrt(0.1 / 10.0))
        assert np.allclose(way, length * np.array([0.6, 0.0, -0.8]), atol=1e-8)
        assert np.allclose(world_t_tcp(arm)[:3, :3], begin[:3, :3], atol=1e-8)
        assert np.allclose(stream.state.velocities, [0.06, 0.0, -0.08, 0.0, 0.0, 0.0], atol=1e-8)
        stream.cancel()
        client.clock.step(200)
        assert ended(stream) is Phase.CANCELLED


def test_a_pose_is_reached_in_the_frame_of_a_node(client: Client, arm: Robot) -> None:
    client.scene.add_frame("table", pose=virtualrobot.pose(0.4, 0.1, 0.2, yaw=0.5))
    table_t_world = np.linalg.inv(client.scene.node("table").pose)
    goal = world_t_tcp(arm) @ virtualrobot.pose(0.05, -0.05, -0.1, roll=0.2, yaw=0.3)
    stream = arm.stream_tool("pose", node="table", timeout=LONG)
    assert np.allclose(stream.state.pose, table_t_world @ world_t_tcp(arm), atol=1e-9)
    stream.send(table_t_world @ goal, wait=True)
    client.clock.step(500)
    assert np.allclose(world_t_tcp(arm), goal, atol=1e-8)
    assert np.allclose(stream.state.pose, table_t_world @ goal, atol=1e-8)
    assert not stream.state.velocities.any() and not stream.state.held_by
    client.clock.set_realtime()
    stream.close()
    assert stream.motion.phase is Phase.SUCCEEDED


def test_a_program_that_sends_nothing_any_more_loses_the_robot(client: Client, arm: Robot) -> None:
    stream = arm.stream_tool(timeout=0.2)
    stream.send([0.0, 0.1, 0.0, 0.0, 0.0, 0.0], wait=True)
    client.clock.step(51)
    assert stream.motion.phase is Phase.STOPPING
    client.clock.step(100)
    assert ended(stream) is Phase.ABORTED
    assert stream.motion.state.end_cause == "setpoint_timeout"
    assert not arm.state.velocities.any()


def test_the_guard_stops_a_tool_that_is_led_into_something(client: Client, arm: Robot) -> None:
    place = world_t_tcp(arm)[:3, 3]
    wall = virtualrobot.box(0.02, 1.0, 1.0)
    client.scene.add_object("wall", wall, pose=virtualrobot.pose(place[0] + 0.15, place[1], place[2]))
    client.collisions.set("guard")
    stream = arm.stream_tool(timeout=LONG)
    stream.send([0.2, 0.0, 0.0, 0.0, 0.0, 0.0], wait=True)
    client.clock.step(600)
    assert ended(stream) is Phase.ABORTED
    assert stream.motion.state.end_cause == "collision"
    assert not client.collisions.check()


def test_what_cannot_be_is_refused_in_words(client: Client, arm: Robot) -> None:
    with pytest.raises(InvalidArgumentError, match="not 'position'"):
        arm.stream_tool("position")
    with pytest.raises(InvalidArgumentError, match="cannot be in the frame TOOL"):
        arm.stream_tool("pose", frame="tool")
    with pytest.raises(UnknownNameError, match="'tabel'"):
        arm.stream_tool(node="tabel")
    with pytest.raises(LimitError, match="millimetres"):
        arm.stream_tool(max_velocity=250.0)
    box = client.load_robot("model://ugv", base="planar")
    with pytest.raises(WrongStateError, match="ugv"):
        box.stream_tool()
    stream = arm.stream_tool()
    with pytest.raises(LimitError, match=r"max_velocity_meters_per_second is 0.25"):
        stream.send([100.0, 0.0, 0.0, 0.0, 0.0, 0.0], wait=True)
    client.clock.step(10)
    assert ended(stream) is Phase.ABORTED


def test_twists_are_published_under_their_stream_and_told_in_the_table(client: Client, arm: Robot, run: Run) -> None:
    client.clock.set_realtime()
    begin = world_t_tcp(arm)
    with client.streams.publisher("/robots/iiwa/command/tool_twist", timeout=10.0) as twist:
        for _ in range(3):
            twist.send([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
    way = (world_t_tcp(arm) - begin)[:3, 3]
    assert way[2] > 0.0 and np.abs(way[:2]).max() < 1e-8
    assert "tool_pose" in run("topic", "list", "/robots/iiwa/command/*")
