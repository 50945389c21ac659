"""Recordings in the form of ROS 2, read by mcap-ros2-support, whose reader takes types from the file alone."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
import virtualrobot
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.recorder import Recorder
from virtualrobot_apps.bridges.ros.transport import TransportError

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import Heard, bridge, roslibpy_client, stamp_of


def test_a_recording_has_each_tick_as_it_was(client: Client, tmp_path: Path) -> None:
    client.clock.set_stepped()
    arm = client.load_robot(IIWA, name="arm")
    client.scene.add_camera("eye", virtualrobot.camera(32, 24, rate=20.0))
    file = tmp_path / "run.mcap"
    with bridge(client, more=[Recorder(file)]) as (url, said), roslibpy_client(url) as ros:
        heard = Heard(ros, "/arm/joint_states", "sensor_msgs/JointState")
        ros.get_nodes()  # it is subscribed to
        arm.move_joints({"lbr_iiwa_joint_2": 0.7}, wait=False)
        pictures = Heard(ros, "/eye/image_raw", "sensor_msgs/Image")
        while not pictures.is_there():
            client.clock.step(10)
        end = round(client.clock.simulation_time * 1e9)
        live = heard.until(lambda message: stamp_of(message) >= end - 20_000_000)
        # What is made by calls of its own may come late.
        Heard(ros, "/arm/robot_description", "std_msgs/String").next()
    client.clock.set_realtime()
    assert f"recording to {file}" in said
    found: defaultdict[str, list[Any]] = defaultdict(list)
    with file.open("rb") as stream:
        for _, channel, message, value in make_reader(
            stream, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            found[channel.topic].append((message.log_time, value))
    recorded = dict(found["/arm/joint_states"])
    for message in live:
        same = recorded[stamp_of(message)]
        assert (list(same.name), list(same.position)) == (message["name"], message["position"])
        assert same.header.stamp.sec * 10**9 + same.header.stamp.nanosec == stamp_of(message)
    assert {"/clock", "/tf", "/tf_static", "/arm/robot_description", "/eye/image_raw", "/eye/camera_info"} <= {*found}
    _, picture = found["/eye/image_raw"][0]
    assert (picture.height, picture.width, picture.encoding, len(picture.data)) == (24, 32, "rgb8", 24 * 32 * 3)


def test_a_file_that_is_there_stays(client: Client, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    file.write_text("mine")
    with pytest.raises(AssertionError, match=r"run\.mcap can't be written: File exists") as failed:
        with bridge(client, more=[Recorder(file)]):
            pass
    assert TransportError.__name__ in str(failed.value) and file.read_text() == "mine"
