"""The command `virtualrobot ros` as a process: nodes of ROS 1 and of rmw_zenoh by its options, until Ctrl-C."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import xmlrpc.client
from pathlib import Path

import pytest
import virtualrobot
import zenoh
from rosbags.highlevel import AnyReader
from virtualrobot import Client

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD
from tests.kernels import KernelProcess
from tests.waiting import until

pytestmark = pytest.mark.long

DOMAIN = 11


def router() -> tuple[zenoh.Config, str]:
    """Return the settings of a router of zenoh, and its address."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        place = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", f'["{place}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    return config, place


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM that a program hears")
def test_a_recording_is_whole_when_the_bridge_is_terminated(
    client: Client, kernel: KernelProcess, tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "virtualrobot", "--address", kernel.address, "ros", "--port", "0"]
    command += ["--record", str(tmp_path / "run")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            assert process.stdout is not None
            while not process.stdout.readline().startswith("recording to"):
                continue
            begin = client.clock.simulation_time
            until(lambda: client.clock.simulation_time > begin + 0.1)
            for _ in range(2):  # as `timeout` does
                process.send_signal(signal.SIGTERM)
            rest, _ = process.communicate(timeout=GUARD)
            assert process.returncode == 130 and "Traceback" not in rest, rest
        finally:
            process.kill()
    with AnyReader([tmp_path / "run"]) as reader:
        assert reader.topics["/clock"].msgcount > 1


def test_options_make_it_a_node_of_ros_1_and_of_zenoh(client: Client, kernel: KernelProcess) -> None:
    client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    config, place = router()
    command = [sys.executable, "-m", "virtualrobot", "--address", kernel.address, "ros", "--port", "0"]
    command += ["--ros1", "--master", "http://127.0.0.1:0", "--zenoh", "--zenoh-router", place, "--domain", str(DOMAIN)]
    with (
        zenoh.open(config) as session,
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process,
    ):
        try:
            assert process.stdout is not None
            said = "".join(process.stdout.readline() for _ in range(3))
            assert "rosbridge at ws://127.0.0.1:" in said
            assert f"zenoh domain {DOMAIN}: node /virtualrobot, router {place}\n" in said
            found = re.search(r"ROS 1: node /virtualrobot at .*(http://127\.0\.0\.1:\d+)", said)
            assert found, said
            with xmlrpc.client.ServerProxy(found[1], allow_none=True) as master:

                def topics() -> set[str]:
                    told: list = master.getPublishedTopics("/test", "")  # pyright: ignore[reportAssignmentType]
                    return {name for name, _ in told[2]}

                until(lambda: {"/clock", "/arm/joint_states", "/tf"} <= topics())

            def tokens() -> str:
                told = session.liveliness().get(f"@ros2_lv/{DOMAIN}/**")
                return "\n".join(str(one.ok.key_expr) for one in told if one.ok is not None)

            until(lambda: "/virtualrobot/%arm%joint_states/" in tokens())
            process.send_signal(signal.SIGINT)
            rest, _ = process.communicate(timeout=GUARD)
            assert process.returncode == 130 and "Traceback" not in rest, rest
            until(lambda: not tokens())
        finally:
            process.kill()
