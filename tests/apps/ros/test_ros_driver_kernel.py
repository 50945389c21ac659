"""A robot that is known by ROS alone, here one of another kernel behind its bridge, follows its twin."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.asking import IIWA
from tests.apps.ros.bridges import bridge
from tests.kernels import StartKernel
from tests.waiting import until

pytestmark = pytest.mark.long


def test_a_robot_of_ros_is_read_and_does_what_its_twin_does(client: Client, start_kernel: StartKernel) -> None:
    real = client.load_robot(IIWA, name="real")
    real.set_positions(np.full(7, 0.1))
    goal = np.array([0.3, -0.2, 0.1, -0.4, 0.0, 0.5, -0.1])
    with bridge(client) as (url, _), virtualrobot.connect(start_kernel().address) as other:
        arm = other.load_robot(IIWA, name="arm")
        other.collisions.set("guard")
        settings = {
            "url": url,
            "joint_states": "/real/joint_states",
            "action": "/real/follow_joint_trajectory",
            "joints": list(arm.joint_names),
            "speed": 1.0,
            "silence": 10.0,
        }
        status = other.drivers.connect("arm", "ros_trajectory", settings)
        assert status.controller.joint_count == 7
        with arm.lease():
            other.drivers.set_mode("arm", "monitor")
            until(lambda: bool(np.allclose(arm.positions, 0.1, atol=1e-9)))
            other.drivers.set_mode("arm", "execute")
            until(lambda: other.drivers["arm"].state == "active")
            arm.move_joints(goal)
            until(lambda: bool(np.abs(real.positions - goal).max() < 1e-3))
            until(lambda: bool(np.abs(np.array(other.drivers["arm"].positions) - goal).max() < 1e-3))
            other.drivers.set_mode("arm", "simulated")
        other.drivers.disconnect("arm")
