"""The bridge by DDS, with a program on Cyclone's own types and coder in a process of its own."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.dds.services import header_of
from virtualrobot_apps.bridges.ros.messages.message import Message

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD
from tests.kernels import KernelProcess
from tests.waiting import until

LOOPBACK = (
    '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    '<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)
"""Settings of a domain that does not leave this machine."""
PEER, SERVICE_PEER = (Path(__file__).parent / one for one in ("dds_peer.py", "dds_service_peer.py"))


@contextmanager
def node(kernel: KernelProcess, *options: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Give the domain of a bridge that is a node, and the environment of others on it."""
    domain = str(1 + os.getpid() % 200)
    environment = {**os.environ, "CYCLONEDDS_URI": LOOPBACK, "VIRTUALROBOT_ADDRESS": kernel.address}
    command = [sys.executable, "-m", "virtualrobot", "ros", "--port", "0", "--dds", "--domain", domain, *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as bridge:
        assert bridge.stdout is not None
        try:
            said = [bridge.stdout.readline() for _ in range(2)]
            assert f"DDS domain {domain}: node /virtualrobot\n" in said
            yield domain, environment
        finally:
            bridge.terminate()


def test_joints_and_twists_cross_and_late_readers_get_what_is_latched(client: Client, kernel: KernelProcess) -> None:
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    client.load_robot("model://ugv", base="planar")
    arm.set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    with node(kernel) as (domain, environment):
        peer = [sys.executable, str(PEER), domain, str(GUARD)]
        with subprocess.Popen(peer, stdout=subprocess.PIPE, text=True, env=environment) as other:
            until(lambda: client.robot("ugv").state.motion_ids)
            told = json.loads(other.communicate(timeout=2 * GUARD)[0].splitlines()[-1])
    assert len(told["states"]) > 20
    for _, names, positions in told["states"]:
        assert names == arm.joint_names and positions == arm.positions.tolist()
    times = [time for time, *_ in told["states"]]
    assert times == sorted(times)
    assert '<link name="lbr_iiwa_link_7"' in told["description"]


@pytest.mark.long
def test_services_and_an_action_are_called_as_rmw_cyclonedds_does(client: Client, kernel: KernelProcess) -> None:
    client.clock.set_stepped()
    before = client.clock.read().stamp.tick
    try:
        with node(kernel, "--rmw", "cyclonedds") as (domain, environment):
            peer = [sys.executable, str(SERVICE_PEER), domain]
            ended = subprocess.run(peer, capture_output=True, text=True, env=environment, timeout=GUARD, check=True)
    finally:
        client.clock.set_realtime()
    told = json.loads(ended.stdout)
    assert told["state"] == 2  # simulation_interfaces/SimulationState.STATE_PAUSED
    assert told["accepted"] and told["first"] == [4, 1, ""]  # GoalStatus.STATUS_SUCCEEDED, Result.RESULT_OK
    assert told["steps"] == [1, 2, 3]
    assert told["canceling"] == [[2] * 16] and told["second"] == 5  # GoalStatus.STATUS_CANCELED
    assert told["unknown"] == 2  # CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
    assert client.clock.read().stamp.tick > before + 3


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_header_is_told_apart_from_a_request_in_both_orders_of_bytes(order: str) -> None:
    # 4 bytes of CDR's encapsulation, the client's number and the call's, and a bool.
    request = bytes([0, order == "<", 0, 0]) + struct.pack(f"{order}Qq?", 7, 9, True)
    header, body = header_of(request)
    assert header == struct.pack("<Qq", 7, 9)
    assert Message.from_cdr("std_srvs/srv/SetBool_Request", body).json == '{"data":true}'


def test_a_request_without_a_header_is_refused() -> None:
    with pytest.raises(ValueError, match="header of 16 bytes"):
        header_of(bytes(19))
