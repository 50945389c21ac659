"""The bridge on zenoh, with a program on zenoh_ros2_sdk, which speaks rmw_zenoh's keys, in a process of its own."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import roslibpy
import virtualrobot
import zenoh
from rosbags.typesys import get_types_from_msg
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.messages import types
from virtualrobot_apps.bridges.ros.messages.types import hash_of_service
from virtualrobot_apps.bridges.ros.zenoh_node import ZenohNode, key_of

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, bridge, roslibpy_client, told
from tests.waiting import until

pytestmark = pytest.mark.long

PEER = Path(__file__).parent / "zenoh_peer.py"
DOMAIN = 7


def test_joints_signals_descriptions_and_services_cross(client: Client) -> None:
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    arm.set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    client.signals.create("lamp", False)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    config = zenoh.Config()
    for key, value in {
        "mode": '"router"',
        "listen/endpoints": f'["tcp/127.0.0.1:{port}"]',
        "scouting/multicast/enabled": "false",
    }.items():
        config.insert_json5(key, value)

    def switch(request: Any, response: Any) -> bool:  # noqa: ANN401
        response["success"], response["message"] = True, f"on: {request['data']}"
        return bool(request["data"])

    node = ZenohNode(f"tcp/127.0.0.1:{port}", DOMAIN)
    with zenoh.open(config), bridge(client, more=[node]) as (url, said), roslibpy_client(url) as ros:
        assert f"zenoh domain {DOMAIN}: node /virtualrobot, router tcp/127.0.0.1:{port}" in said
        roslibpy.Service(ros, "/switch", "std_srvs/SetBool").advertise(switch)
        until(lambda: "/switch" in told(ros.get_services()))
        peer = [sys.executable, str(PEER), str(port), str(DOMAIN)]
        done = subprocess.run(peer, capture_output=True, text=True, timeout=GUARD)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert '<link name="lbr_iiwa_link_7"' in found["description"]
    assert len(found["states"]) == 20
    for _, names, positions in found["states"]:
        assert names == arm.joint_names and positions == arm.positions.tolist()
    assert found["numbers"] == [*range(found["numbers"][0], found["numbers"][0] + 20)]  # nothing is lost on the way
    assert found["lamp"] is True
    assert found["switched"][0] == [True, "on: True"]
    assert found["switched"][1][0] is False and found["switched"][1][1]  # a refusal in words
    assert found["bare"] == ["a request has behind it its number, a time and who asks: 33 bytes"]
    kinds = {token.split("/")[5] for token in found["tokens"]}
    assert kinds == {"NN", "MP", "MS", "SS"}
    assert any("%arm%follow_joint_trajectory%_action%send_goal/" in token for token in found["tokens"])


def test_keys_are_those_of_rmw_zenoh() -> None:
    # Source: rmw_zenoh_cpp, docs/design.md.
    assert key_of(0, "/robot1/chatter", "std_msgs/msg/String") == (
        "0/robot1/chatter/std_msgs::msg::dds_::String_/"
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    )


def test_the_hash_of_a_service_is_that_of_ros_2s_generator(monkeypatch: pytest.MonkeyPatch) -> None:
    # Source: rmw_zenoh_cpp, docs/design.md.
    name = "example_interfaces/srv/AddTwoInts"
    for part, text in (("Request", "int64 a\nint64 b"), ("Response", "int64 sum")):
        for key, one in get_types_from_msg(text, f"{name}_{part}").items():
            monkeypatch.setitem(types.STORE.fielddefs, key.replace("/srv/msg/", "/srv/"), one)
    assert hash_of_service(name) == "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
