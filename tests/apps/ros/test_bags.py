"""Recordings of ROS 1 and ROS 2, read by others, and played: what a craft was told moves it the same way again."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import roslibpy
from rosbags.highlevel import AnyReader
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.player import Player
from virtualrobot_apps.bridges.ros.recorder import Recorder
from virtualrobot_apps.bridges.ros.transport import TransportError

from tests.apps.ros.bridges import Heard, bridge, roslibpy_client, stamp_of
from tests.waiting import repeated, until

TWIST = {"linear": {"x": 0.25}, "angular": {"z": 0.5}}


@pytest.fixture
def steps(client: Client) -> Client:
    """Return a client of a stepped world with a craft."""
    client.clock.set_stepped()
    client.load_robot("model://ugv", name="ugv", base="planar")
    return client


def _drive(client: Client, file: Path) -> list[dict[str, Any]]:
    """Drive by one twist, until its watchdog has stopped the craft; return the odometry that roslibpy has heard."""
    with bridge(client, more=[Recorder(file)]) as (url, _), roslibpy_client(url) as ros:
        odometry = Heard(ros, "/ugv/odom", "nav_msgs/Odometry")
        wheels = roslibpy.Topic(ros, "/ugv/cmd_vel", "geometry_msgs/Twist")
        with repeated(lambda: client.clock.step(1), 0.0):
            odometry.next()
            wheels.publish(TWIST)
            until(lambda: client.robot("ugv").state.motion_ids)
            until(lambda: not client.robot("ugv").state.motion_ids)
        end = round(client.clock.simulation_time * 1e9)
        return odometry.until(lambda one: stamp_of(one) >= end - 20_000_000)


@pytest.mark.parametrize("name", ["run.bag", "run", "run.mcap"])
def test_what_was_recorded_is_read_by_others_and_played(steps: Client, tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    told = _drive(steps, file)
    way = steps.robot("ugv").tcp[:2, 3]
    assert np.hypot(*way) > 0.05
    with AnyReader([file]) as reader:  # which takes the types from the file
        read = {one.topic: one for one in reader.connections}
        assert {"/clock", "/tf", "/tf_static", "/ugv/odom", "/ugv/cmd_vel", "/ugv/joint_states"} <= {*read}
        found: list[Any] = [
            reader.deserialize(data, one.msgtype) for one, _, data in reader.messages(connections=[read["/ugv/odom"]])
        ]
    places = {one.header.stamp.sec * 10**9 + one.header.stamp.nanosec: one.pose.pose.position.x for one in found}
    assert all(places[stamp_of(one)] == one["pose"]["pose"]["position"]["x"] for one in told)

    steps.scene.clear()
    steps.load_robot("model://ugv", name="ugv", base="planar")
    player = Player(file, (said := []).append)
    with bridge(steps, more=[player]) as (_, lines):
        assert any(one.startswith("playing ") for one in lines)
        with repeated(lambda: steps.clock.step(1), 0.0):
            until(lambda: steps.robot("ugv").state.motion_ids)
            until(lambda: not steps.robot("ugv").state.motion_ids)
            until(lambda: f"1 messages of {file} are played" in said)
    assert np.hypot(*steps.robot("ugv").tcp[:2, 3]) == pytest.approx(np.hypot(*way), abs=0.25 * 0.1)


@pytest.mark.skipif(shutil.which("rosbag") is None, reason="no ROS 1: install the packages rosbag and python3-rosbag")
def test_debians_rosbag_tells_what_is_in_a_bag(steps: Client, tmp_path: Path) -> None:
    told = _drive(steps, tmp_path / "run.bag")
    done = subprocess.run(["rosbag", "info", tmp_path / "run.bag"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    lines = {one.split()[0]: one.split() for one in done.stdout.replace("topics:", "").splitlines() if "msg" in one}
    assert lines["/ugv/odom"][-1] == "nav_msgs/Odometry" and int(lines["/ugv/odom"][1]) >= len(told)


def test_files_that_can_not_be_written_or_read_are_told(client: Client, tmp_path: Path) -> None:
    (tmp_path / "none.bag").write_text("no bag")
    for transport, words in (
        (Recorder(tmp_path / "run.txt"), "run.txt ends with .mcap, or with .bag for ROS 1; a folder of ROS 2 has no"),
        (Recorder(tmp_path), "can't be written: File exists"),
        (Player(tmp_path / "none.bag"), "none.bag can't be read as a bag"),
    ):
        with pytest.raises(AssertionError, match=words) as failed:
            with bridge(client, more=[transport]):
                pass
        assert TransportError.__name__ in str(failed.value)
