"""The bridge by DDS, with a program on Cyclone's own types and coder in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import virtualrobot
from virtualrobot import Client

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
PEER = Path(__file__).parent / "dds_peer.py"


def test_joints_and_twists_cross_and_late_readers_get_what_is_latched(client: Client, kernel: KernelProcess) -> None:
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    client.load_robot("model://ugv", base="planar")
    arm.set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    domain = str(1 + os.getpid() % 200)
    environment = {**os.environ, "CYCLONEDDS_URI": LOOPBACK, "VIRTUALROBOT_ADDRESS": kernel.address}
    command = [sys.executable, "-m", "virtualrobot", "ros", "--port", "0", "--dds", "--domain", domain]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as bridge:
        assert bridge.stdout is not None
        try:
            said = [bridge.stdout.readline() for _ in range(2)]
            assert f"DDS domain {domain}: node /virtualrobot\n" in said
            peer = [sys.executable, str(PEER), domain, str(GUARD)]
            with subprocess.Popen(peer, stdout=subprocess.PIPE, text=True, env=environment) as other:
                until(lambda: client.robot("ugv").state.motion_ids)
                told = json.loads(other.communicate(timeout=2 * GUARD)[0].splitlines()[-1])
        finally:
            bridge.terminate()
    assert len(told["states"]) > 20
    for _, names, positions in told["states"]:
        assert names == arm.joint_names and positions == arm.positions.tolist()
    times = [time for time, *_ in told["states"]]
    assert times == sorted(times)
    assert '<link name="lbr_iiwa_link_7"' in told["description"]
