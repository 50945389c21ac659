"""The bridge as a node of a ROS 2 by its own rclpy, with a program on rclpy, each in a process of its own.

A ROS 2 is none of the packages of this project: VIRTUALROBOT_ROS_PYTHON names a Python that has rclpy and this project.
The wheels ros-jazzy-rclpy[fastrtps], ros-sensor-msgs, ros-std-srvs and ros-test-msgs==2.0.3 give one, which needs an
environment of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest
import roslibpy
import virtualrobot
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.hub import CANCELED, SUCCEEDED

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, roslibpy_client, told
from tests.kernels import KernelProcess
from tests.waiting import until

pytestmark = pytest.mark.long

PYTHON = os.environ.get("VIRTUALROBOT_ROS_PYTHON", "")
FOLDER = Path(__file__).parent
needs_rclpy = pytest.mark.skipif(not PYTHON, reason="no ROS 2: VIRTUALROBOT_ROS_PYTHON names a Python with rclpy")
ENVIRONMENT = {
    **os.environ,
    "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
}


def found_by(program: str) -> Any:  # noqa: ANN401 JSON
    """Return what a program on rclpy prints; one that fails fails the test with its words."""
    command = [PYTHON, str(FOLDER / program), str(GUARD)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=2 * GUARD, env=ENVIRONMENT)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@needs_rclpy
def test_a_program_on_rclpy_hears_tells_and_calls(client: Client, kernel: KernelProcess) -> None:
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    arm.set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    client.signals.create("lamp", False)
    command = [PYTHON, "-m", "virtualrobot", "--address", kernel.address, "ros", "--port", "0", "--rclpy"]

    def switch(request: Any, response: Any) -> bool:  # noqa: ANN401
        response["success"], response["message"] = True, f"on: {request['data']}"
        return bool(request["data"])

    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT
    ) as process:
        try:
            assert process.stdout is not None
            said = [process.stdout.readline()]
            while said[-1] and not said[-1].startswith("rclpy: node /virtualrobot, on rmw_"):
                said.append(process.stdout.readline())
            assert said[-1], "".join(said)
            url = next(line.split()[-1] for line in said if line.startswith("rosbridge at"))
            with roslibpy_client(url) as ros:
                roslibpy.Service(ros, "/switch", "std_srvs/SetBool").advertise(switch)
                until(lambda: "/switch" in told(ros.get_services()))
                found = found_by("rclpy_peer.py")
        finally:
            process.terminate()
    assert '<link name="lbr_iiwa_link_7"' in found["description"]
    assert len(found["states"]) == 20
    assert all(one[1:] == [arm.joint_names, arm.positions.tolist()] for one in found["states"])
    assert found["switched"][0] == [True, "on: True"]
    assert found["switched"][1][0] is False and found["switched"][1][1]  # a refusal in words
    assert found["topics"]["/arm/joint_states"] == ["sensor_msgs/msg/JointState"]
    assert "virtualrobot" in found["nodes"]


@needs_rclpy
def test_its_client_of_actions_gets_feedback_and_result_and_cancels() -> None:
    with subprocess.Popen(
        [PYTHON, str(FOLDER / "rclpy_fibonacci.py")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=ENVIRONMENT
    ) as process:
        try:
            assert process.stdout is not None and process.stdout.readline().startswith(b"rclpy: node /counter")
            found = found_by("rclpy_action_peer.py")
            process.communicate(timeout=GUARD)
        finally:
            process.kill()
    assert process.returncode == 0
    assert found["accepted"] == [True, True] and found["cancelled"] == 1
    assert found["statuses"] == [SUCCEEDED, CANCELED]
    assert found["sequence"] == [0, 1, 1, 2, 3, 5, 8]
    assert found["feedback"] == [found["sequence"][:count] for count in range(3, 8)]
