"""Faults of robots that are played: each stops all, in its own words, and nothing begins again by itself."""

from __future__ import annotations

import signal
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest
from virtualrobot.v1 import driver_pb2, motion_pb2, robot_pb2
from virtualrobot_sdk.drivers.host import REST_SPEED
from virtualrobot_sdk.drivers.shared import CELL, RING, CellBlock, Report, State, TickRing

from tests.api.asking import joints, refusal
from tests.drivers.test_modes import (
    ACTIVE,
    ERROR,
    EXECUTE,
    FIRST,
    INACTIVE,
    MONITOR,
    SIMULATED,
    Cell,
    ended_with,
    patiently,
)
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.waiting import until

pytestmark = pytest.mark.long

AT_REST = 1e-3
JOINTS = 7
FOURTH = "lbr_iiwa_joint_4"
GOAL = {FIRST: 2.0, FOURTH: -1.0}

FAULTS = {
    "silent": "has been silent for",
    "raises": "the driver Loopback raised in read RuntimeError: loopback raises",
    "hangs": "it hangs in read",
    "dies": "its process ended with exit code 1",
    "nan 0 5": "the controller sent nonsense",
    "protective_stop": "protective stop: joint 0 met something",
    "safeguard_stop": "safeguard stop: the door is open",
    "emergency_stop": "emergency stop: the button is pressed",
    "power": "the connection to loopback is lost",
    "stuck 0": "from where it should be",
    "displaced 0 0.5": "from where it should be",
    "late 0 0.25": "the driver came",
    "slow": "the controller goes slower than it was told",
    "hand_guided": "somebody guides the robot by hand",
    "local": "the key is turned to the pendant",
}
"""Words that each fault is told in, by what the controller is asked for; docs/drivers.md has them, too."""

AT_END = {
    "raises_at_end": "the driver Loopback raised in end RuntimeError: loopback raises as it ends",
    "hangs_at_end": "it hangs in end",
}
"""Words of faults that come as a robot is to follow no more, likewise."""

HARMLESS = ("floods", "slow 0.95")
"""Faults that are borne."""

READ = ("silent", "raises", "hangs", "dies", "nan 0 5", "power")
"""Faults by which a connection is lost over which a robot is only read."""


@pytest.fixture
def two(kernel: KernelProcess, stubs: Stubs) -> Iterator[Cell]:
    """Give a cell of two arms that stand apart, both played."""
    cell = Cell(kernel, stubs, "arm", "other")
    yield cell
    ended_with(cell)


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_stops_both_robots_and_is_told(two: Cell, fault: str) -> None:
    patiently(two, lambda: fail(two, fault))


def fail(two: Cell, fault: str) -> None:
    for robot in ("arm", "other"):
        # Its watchdog bears what its lead does; who is late, and not silent, is told before it acts.
        watchdog = 2.0 if fault.startswith("late") else 0.4
        two.connect(robot, following_limit=0.1, following_warning=0.05, watchdog=watchdog)
        assert two.mode(EXECUTE, robot).driver.state == ACTIVE
    # So fast that a brake is longer than a fault is waited for: it is told before the robot rests.
    speed = 0.1 if fault == "slow" else 0.01
    ids = [two.holder.start(joints(robot, speed, **{FIRST: 2.5})) for robot in ("arm", "other")]
    until(lambda: two.status("other").positions[0] > 0.02)
    two.ask(fault)
    for id in ids:
        ended = two.await_end(id)
        assert (ended.phase, ended.end_cause) == (motion_pb2.MOTION_PHASE_ABORTED, motion_pb2.END_CAUSE_DRIVER), ended
        assert "'arm'" in ended.end_reason
        assert ended.progress < 1.0
    until(lambda: two.status("arm").mode == two.status("other").mode == SIMULATED)
    until(lambda: two.status("other").state == INACTIVE)
    assert two.status("arm").state == ERROR
    # That a process has died is known when it is asked for its words.
    until(lambda: FAULTS[fault] in two.status("arm").text)
    where = np.array(two.status("other").positions)
    # Nothing moves in a stopped cell, and in one that was released no twin alone: the one is refused in its
    # controller's words, the other since it was stopped with it.
    refused = refusal(lambda: two.holder.start(joints("other", 0.1, **{FIRST: 0.0})))
    assert (refused.metadata["aspect"], "'arm'" in refused.message) == ("cell", True), refused
    assert refusal(lambda: two.mode(EXECUTE, "other")).metadata["aspect"] == "cell"
    two.alone.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
    refused = refusal(lambda: two.holder.start(joints("arm", 0.1, **{FIRST: 0.0})))
    assert (refused.reason, FAULTS[fault] in refused.message) == ("DRIVER_FAULT", True), refused
    refused = refusal(lambda: two.holder.start(joints("other", 0.1, **{FIRST: 0.0})))
    assert (refused.reason, refused.metadata["aspect"], "'arm'" in refused.message) == ("WRONG_STATE", "mode", True)
    assert refusal(lambda: two.mode(EXECUTE, "arm")).metadata["aspect"] == "state"
    # The one that is well goes on from where it stands, once somebody wants it to.
    moved = two.mode(EXECUTE, "other")
    assert moved.driver.state == ACTIVE
    np.testing.assert_allclose(moved.driver.positions, where, atol=AT_REST)
    # The other one is connected anew, and its twin is put to where it stands.
    two.connect("arm")
    assert two.status("arm").state == INACTIVE
    assert refusal(lambda: two.holder.start(joints("arm", 0.1, **{FIRST: 0.0}))).metadata["aspect"] == "mode"
    assert two.mode(EXECUTE, "arm").driver.state == ACTIVE


def test_a_driver_that_is_killed_is_told_as_that(two: Cell) -> None:
    patiently(two, lambda: kill(two))


def kill(two: Cell) -> None:
    two.connect("arm")
    two.mode(EXECUTE, "arm")
    id = two.holder.start(joints("arm", 0.01, **{FIRST: 2.5}))
    until(lambda: two.status("arm").positions[0] > 0.02)
    psutil.Process(two.status("arm").process_id).kill()
    assert "its process ended with SIGKILL" in two.await_end(id).end_reason
    cell = two.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell
    assert cell.reason == "the real robot of 'arm' has stopped: its process ended with SIGKILL"
    until(lambda: two.status("arm").process_id == 0)
    assert two.status("arm").text == "its process ended with SIGKILL"


@pytest.mark.parametrize("fault", AT_END)
def test_a_fault_as_a_robot_is_to_follow_no_more_is_told(two: Cell, fault: str) -> None:
    patiently(two, lambda: fail_at_end(two, fault))


def fail_at_end(two: Cell, fault: str) -> None:
    two.connect("arm")
    two.connect("other")
    two.mode(EXECUTE, "arm")
    two.mode(EXECUTE, "other")
    two.tell(fault, "arm")
    status = two.mode(SIMULATED, "arm").driver
    assert (status.state, AT_END[fault] in status.text) == (ERROR, True), status
    cell = two.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell
    assert (cell.stopped_by, AT_END[fault] in cell.reason) == ("driver loopback of arm", True), cell
    until(lambda: two.status("other").state == INACTIVE)


@pytest.mark.parametrize("fault", AT_END)
def test_a_cell_that_was_released_is_not_stopped_anew_by_a_driver_that_is_gone(two: Cell, fault: str) -> None:
    patiently(two, lambda: fail_at_stop(two, fault))


def fail_at_stop(two: Cell, fault: str) -> None:
    two.connect("arm")
    two.mode(EXECUTE, "arm")
    two.tell(fault, "arm")
    two.alone.driver.StopCell(driver_pb2.StopCellRequest(reason="a cat"))
    until(lambda: two.status("arm").state == ERROR)
    until(lambda: two.status("arm").mode == SIMULATED)
    assert AT_END[fault] in two.status("arm").text
    asked = driver_pb2.GetDriversRequest()
    assert two.alone.driver.GetDrivers(asked).cell.reason == "a cat"
    two.alone.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
    two.call("DisconnectDriver", robot="arm")
    assert not two.alone.driver.GetDrivers(asked).cell.stopped


def test_robots_of_a_cell_have_one_lead(two: Cell) -> None:
    """With two leads they would be elsewhere relative to each other than the guard has looked at."""
    patiently(two, lambda: lead_differently(two))


def lead_differently(two: Cell) -> None:
    two.connect("arm")
    two.connect("other", lead=0.3)
    two.mode(EXECUTE, "arm")
    refused = refusal(lambda: two.mode(EXECUTE, "other"))
    assert (refused.reason, refused.metadata["aspect"]) == ("WRONG_STATE", "lead"), refused
    assert "its lead is 0.3 s, and that of 'arm' 0.4 s" in refused.message
    two.mode(SIMULATED, "arm")
    assert two.mode(EXECUTE, "other").driver.state == ACTIVE


def test_a_controller_that_does_not_fit_is_not_connected(two: Cell) -> None:
    refused = refusal(lambda: two.connect("arm", joints=6))
    assert (refused.reason, refused.metadata["field"]) == ("INVALID_ARGUMENT", "joints")
    assert "has 6 joints, and its twin 7" in refused.message and "say in `joints` which joint" in refused.message
    refused = refusal(lambda: two.connect("arm", watchdog=0.0))
    assert (refused.reason, refused.metadata["field"]) == ("INVALID_ARGUMENT", "without_watchdog")
    assert not two.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).drivers


def test_the_stopper_stops_robots_beside_the_kernel(two: Cell) -> None:
    patiently(two, lambda: stop_beside(two))


def stop_beside(two: Cell) -> None:
    two.connect("arm")
    two.mode(EXECUTE, "arm")
    id = two.holder.start(joints("arm", 0.01, **{FIRST: 2.0}))
    until(lambda: two.status("arm").positions[0] > 0.02)
    told = two.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell
    host, _, port = told.stopper_address.partition(":")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as button:
        button.settimeout(30.0)
        button.sendto(told.stopper_key.encode(), (host, int(port)))
        assert button.recv(100) == b"stopped"
    ended = two.await_end(id)
    assert (ended.end_cause, ended.end_reason) == (motion_pb2.END_CAUSE_CELL_STOPPED, "stopped from outside the kernel")
    until(lambda: two.status("arm").state == INACTIVE)


@pytest.mark.parametrize("fault", HARMLESS)
def test_what_is_borne_costs_nobody_anything(two: Cell, fault: str) -> None:
    patiently(two, lambda: bear(two, fault))


def bear(two: Cell, fault: str) -> None:
    for robot in ("arm", "other"):
        two.connect(robot)
        two.mode(EXECUTE, robot)
    ids = [two.holder.start(joints(robot, 0.01, **{FIRST: 0.06})) for robot in ("arm", "other")]
    until(lambda: two.status("other").positions[0] > 0.02)
    two.ask(fault)
    for id in ids:
        assert two.await_end(id).phase == motion_pb2.MOTION_PHASE_SUCCEEDED, two.motion(id)
    for robot in ("arm", "other"):
        until(lambda robot=robot: bool(abs(two.real(robot)[0] - 0.06) < AT_REST))
        assert two.status(robot).state == ACTIVE


def test_a_robot_that_is_only_read_stops_no_other(two: Cell) -> None:
    patiently(two, lambda: lose(two))


def lose(two: Cell) -> None:
    """Lose the connection to a robot that is monitored in each way, while another one is played."""
    two.connect("other")
    two.mode(EXECUTE, "other")
    id = two.holder.start(joints("other", 0.01, **{FIRST: 2.0}))
    for fault in READ:
        two.connect("arm")
        two.mode(MONITOR, "arm")
        two.ask(fault)
        until(lambda: two.status("arm").state == ERROR)
        until(lambda fault=fault: FAULTS[fault] in two.status("arm").text)
        until(lambda: two.status("arm").mode == SIMULATED)
    assert two.motion(id).phase == motion_pb2.MOTION_PHASE_RUNNING, two.motion(id)
    assert two.status("other").state == ACTIVE
    assert not two.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell.stopped


class Shared:
    """What the kernel and the host of a robot say to each other, read by a process that is neither."""

    def __init__(self, cell: Cell, robot: str) -> None:
        """Map the files that the host has mapped; they stay while they are, whoever takes them away."""
        self.pid = cell.status(robot).process_id
        mapped = {Path(one.path).name: Path(one.path) for one in psutil.Process(self.pid).memory_maps()}
        (ring,) = (path for name, path in mapped.items() if name.startswith(RING.format("")))
        self.folder = ring.parent
        self.block, self.ring = CellBlock.attach(self.folder / CELL), TickRing.attach(ring, JOINTS)

    @property
    def report(self) -> Report:
        """What the host has said last."""
        while (report := self.ring.reported()) is None:
            time.sleep(0.001)
        return report

    def assert_on_path(self, report: Report) -> None:
        """Assert that the robot is on the straight line in joint space that it was told to go."""
        q = np.array(report.q)
        assert 0.0 <= q[0] < GOAL[FIRST] and abs(q[3] - q[0] * GOAL[FOURTH] / GOAL[FIRST]) < AT_REST, q
        np.testing.assert_allclose(q[[1, 2, 4, 5, 6]], 0.0, atol=1e-9)

    def await_rest(self) -> Report:
        """Return the first report after the robot has been braked; until then it is on its path."""

        def rests() -> bool:
            report = self.report
            assert report.state in (State.ACTIVE, State.STOPPING, State.INACTIVE), report
            self.assert_on_path(report)
            return report.state is State.INACTIVE

        until(rests)
        return self.report

    def assert_braked(self) -> None:
        """Assert that the robot rests where the brake of the newest tick ends, which it had been given before."""
        report = self.await_rest()
        self.assert_on_path(report)
        newest = self.ring.get(self.block.newest_braked)
        assert newest is not None and newest.brake is not None
        assert newest.v[0] > 0.0, "it was at rest already"
        np.testing.assert_allclose(report.q, newest.brake[-1], atol=AT_REST)
        assert np.abs(report.v).max() < REST_SPEED


def two_on_their_way(cell: Cell) -> tuple[list[Shared], list[str]]:
    """Return the memory of two robots that are played in motion, and the names of their motions."""
    return patiently(cell, lambda: send_both(cell))


def send_both(cell: Cell) -> tuple[list[Shared], list[str]]:
    for robot in ("arm", "other"):
        cell.connect(robot)
        cell.mode(EXECUTE, robot)
    ids = [cell.holder.start(joints(robot, 0.02, **GOAL)) for robot in ("arm", "other")]
    shared = [Shared(cell, robot) for robot in ("arm", "other")]
    for one in shared:
        until(lambda one=one: one.report.q[0] > 0.05)
    return shared, ids


def test_a_kernel_that_is_killed_is_the_brake_and_leaves_nothing(start_kernel: StartKernel) -> None:
    """Robots brake on their paths, and hosts and stopper end, each by itself."""
    kernel = start_kernel()
    cell = Cell(kernel, kernel.stubs(), "arm", "other")
    shared, _ = two_on_their_way(cell)
    children = psutil.Process(kernel.process.pid).children(recursive=True)
    assert {one.pid for one in shared} < {child.pid for child in children}
    kernel.process.kill()
    for one in shared:
        one.assert_braked()
    for child in children:
        until(lambda child=child: not child.is_running() or child.status() == psutil.STATUS_ZOMBIE)
    assert not shared[0].folder.exists()


def test_a_kernel_that_is_frozen_is_the_brake_and_goes_on_with_their_leave(two: Cell, kernel: KernelProcess) -> None:
    """Robots brake on their paths; once the kernel is back, its twins stand where the robots do, and nothing moves."""
    shared, ids = two_on_their_way(two)
    kernel.process.send_signal(signal.SIGSTOP)
    try:
        for one in shared:
            one.assert_braked()
        ends = [one.report.q for one in shared]
    finally:
        kernel.process.send_signal(signal.SIGCONT)
    for id in ids:
        ended = two.await_end(id)
        assert (ended.phase, ended.end_cause) == (motion_pb2.MOTION_PHASE_ABORTED, motion_pb2.END_CAUSE_DRIVER), ended
        assert "older than the lead" in ended.end_reason
    for robot, end in zip(("arm", "other"), ends, strict=True):
        until(lambda robot=robot: two.status(robot).mode == SIMULATED)
        assert two.status(robot).state == INACTIVE
        np.testing.assert_allclose(two.real(robot), end, atol=AT_REST)
        (twin,) = two.alone.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=[robot])).robots
        np.testing.assert_allclose(list(twin.positions), end, atol=AT_REST)
    assert refusal(lambda: two.mode(EXECUTE, "arm")).metadata["aspect"] == "cell"
    two.alone.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
    assert two.mode(EXECUTE, "arm").driver.state == ACTIVE
