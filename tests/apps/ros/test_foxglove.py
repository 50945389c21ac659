"""The bridge as a Foxglove server, with a bare WebSocket that speaks Foxglove's protocol, and rosbags for the bytes."""

from __future__ import annotations

import json
import struct
from typing import Any

import virtualrobot
from rosbags.typesys import Stores, get_typestore
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.foxglove_server import FoxgloveServer
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, bridge

PROTOCOL = Subprotocol("foxglove.sdk.v1")


def test_channels_tell_the_bytes_of_ros_and_what_is_latched(client: Client) -> None:
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    arm.set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    server = FoxgloveServer(port=0)
    store = get_typestore(Stores.ROS2_JAZZY)
    with bridge(client, more=[server]) as (_, said):
        assert f"Foxglove at ws://127.0.0.1:{server.port}" in said
        for _ in range(2):
            with connect(f"ws://127.0.0.1:{server.port}", subprotocols=[PROTOCOL], max_size=None) as one:
                channels: dict[str, dict[str, Any]] = {}
                while not {"/arm/joint_states", "/tf_static"} <= channels.keys():
                    data = one.recv(timeout=GUARD)
                    told = json.loads(data) if isinstance(data, str) else {}
                    channels |= {channel["topic"]: channel for channel in told.get("channels", ())}
                joints = channels["/arm/joint_states"]
                assert (joints["encoding"], joints["schemaName"]) == ("cdr", "sensor_msgs/msg/JointState")
                assert joints["schemaEncoding"] == "ros2msg" and "float64[] position" in joints["schema"]
                wanted = {1: "/arm/joint_states", 2: "/tf_static"}
                asked = [{"id": number, "channelId": channels[topic]["id"]} for number, topic in wanted.items()]
                one.send(json.dumps({"op": "subscribe", "subscriptions": asked}))
                found: dict[int, Any] = {}
                while found.keys() != wanted.keys():
                    data = one.recv(timeout=GUARD)
                    if isinstance(data, bytes) and data[0] == 1:  # a message: subscription, time (ns), bytes
                        number, time = struct.unpack_from("<IQ", data, 1)
                        found[number] = time, store.deserialize_cdr(data[13:], channels[wanted[number]]["schemaName"])
            time, state = found[1]
            assert state.name == arm.joint_names and state.position.tolist() == arm.positions.tolist()
            assert time == state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
            assert {"world"} <= {one.header.frame_id for one in found[2][1].transforms}
