"""Drivers by the client library and the command line, with the computed controller `loopback` in its own process."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.drivers import DriverJoint
from virtualrobot.errors import InvalidArgumentError, UnknownNameError, VirtualRobotError, WrongStateError

from tests.api.client.conftest import IIWA, Run
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until


@pytest.fixture
def client(kernel: KernelProcess, stubs: Stubs) -> Iterator[Client]:
    """Return a client with a guarded arm; its drivers end with the test."""
    with virtualrobot.connect(kernel.address) as client:
        client.load_robot(IIWA, name="arm")
        client.collisions.set("guard")
        yield client
        for status in client.drivers.list():
            client.drivers.disconnect(status.robot)
        if client.cell.stopped:
            client.cell.release()


def test_a_robot_does_what_its_twin_does(client: Client) -> None:
    for _ in range(20):
        try:
            return follow(client)
        except (VirtualRobotError, AssertionError):
            # The machine was so busy that the kernel was later than the lead.
            if "older than the lead" not in str(client.cell.stopped):
                raise
        client.drivers.disconnect("arm")
        client.cell.release()
    raise AssertionError("the machine is too busy for a lead of 0.4 s")


def follow(client: Client) -> None:
    arm, drivers = client.robots["arm"], client.drivers
    status = drivers.connect("arm", "loopback", {"joints": 7}, lead=0.4, following_limit=1.0)
    assert (status.mode, status.state, status.controller.joint_count) == ("simulated", "inactive", 7)
    assert status.joint_names == tuple(arm.joint_names)
    with pytest.raises(WrongStateError, match="lease"):
        drivers.set_mode("arm", "execute")
    with arm.lease():
        assert drivers.set_mode("arm", "execute").mode == "execute"
        until(lambda: drivers["arm"].state == "active")
        arm.move_joints([0.2, 0.1, 0, -0.3, 0, 0.2, 0], speed_factor=0.3)
        until(lambda: np.allclose(drivers["arm"].positions, arm.positions, atol=1e-3))
        client.cell.stop("coffee")
        assert (stop := client.cell.stopped) is not None and stop.reason == "coffee"
        until(lambda: drivers["arm"].state == "inactive")
    client.cell.release()
    assert client.cell.stopped is None
    drivers.disconnect("arm")
    with pytest.raises(UnknownNameError, match="'arm' has no driver"):
        drivers["arm"]


def test_the_commands(client: Client, run: Run) -> None:
    assert run("driver", "list") == "no robot has a driver\n"
    said = run("driver", "connect", "arm", "loopback", "--set", "joints=7", "--set", "rate=50")
    assert said.startswith("arm is connected: loopback") and "7 joints, 50 Hz" in said
    assert run("driver", "list") == "arm  loopback  simulated  inactive\n"
    assert "already" in run("driver", "connect", "arm", "loopback", code=1)
    assert run("driver", "mode", "arm", "monitor") == "arm  loopback  monitor  inactive\n"
    assert "lease" in run("driver", "mode", "arm", "execute", code=1)
    assert run("estop", "tea").startswith("the cell is stopped")
    assert re.match(r"the cell is stopped by .*, since .*: tea\n", run("driver", "list"))
    assert run("estop", "--release") == "the stop has ended\n"
    assert run("driver", "disconnect", "arm") == "arm has no driver any more\n"


def test_what_is_wrong_is_said(client: Client) -> None:
    drivers = client.drivers
    for robot, component, settings, error, said in (
        ("arms", "loopback", {}, UnknownNameError, "arms"),
        ("arm", "loopbak", {}, UnknownNameError, "loopbak"),
        ("arm", "loopback", {"joins": 7}, InvalidArgumentError, "joins"),
        ("arm", "loopback", {"joints": 6}, InvalidArgumentError, "6 joints"),
    ):
        with pytest.raises(error, match=said):
            drivers.connect(robot, component, settings)
    with pytest.raises(UnknownNameError, match="elbow"):
        drivers.connect("arm", "loopback", {"joints": 1}, joints=[DriverJoint("elbow")])
    with pytest.raises(InvalidArgumentError, match="simulated, monitor, execute"):
        drivers.set_mode("arm", "drive")
    assert drivers.list() == []
