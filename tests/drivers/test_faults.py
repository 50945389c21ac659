"""Faults of robots that are played: each stops all, in its own words, and nothing begins again by itself."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot.v1 import driver_pb2, motion_pb2

from tests.api.asking import joints, refusal
from tests.drivers.test_modes import (
    ACTIVE,
    ERROR,
    EXECUTE,
    FIRST,
    INACTIVE,
    SIMULATED,
    Cell,
    ended_with,
    patiently,
)
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = pytest.mark.long

AT_REST = 1e-3

FAULTS = {
    "silent": "silen",
    "raises": "raised",
    "hangs": "silent",
    "dies": "ended",
    "nan 0 5": "finite",
    "protective_stop": "protective",
    "safeguard_stop": "safeguard",
    "emergency_stop": "emergency",
    "displaced 0 0.5": "from where it should be",
    "hand_guided": "hand",
    "local": "local",
}
"""Words that each fault is told in, by what the controller is asked for."""


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
        two.connect(robot)
        assert two.mode(EXECUTE, robot).driver.state == ACTIVE
    ids = [two.holder.start(joints(robot, 0.01, **{FIRST: 2.0})) for robot in ("arm", "other")]
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
    until(lambda: FAULTS[fault] in two.status("arm").text.lower())
    where = np.array(two.status("other").positions)
    assert refusal(lambda: two.mode(EXECUTE, "other")).metadata["aspect"] == "cell"
    two.alone.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
    assert refusal(lambda: two.mode(EXECUTE, "arm")).metadata["aspect"] == "state"
    # The one that is well goes on from where it stands, once somebody wants it to.
    moved = two.mode(EXECUTE, "other")
    assert moved.driver.state == ACTIVE
    np.testing.assert_allclose(moved.driver.positions, where, atol=AT_REST)
    # The other one is connected anew, and its twin is put to where it stands.
    two.connect("arm")
    assert two.status("arm").state == INACTIVE
    assert two.mode(EXECUTE, "arm").driver.state == ACTIVE


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
