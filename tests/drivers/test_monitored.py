"""Robots that are monitored, with the driver `loopback` in its own process: until when, and what is guarded."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from virtualrobot.v1 import driver_pb2, motion_pb2, robot_pb2

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
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

SUCCEEDED = motion_pb2.MOTION_PHASE_SUCCEEDED


@pytest.fixture
def cell(kernel: KernelProcess, stubs: Stubs) -> Iterator[Cell]:
    """Give a cell of one arm."""
    made = Cell(kernel, stubs, "arm")
    yield made
    ended_with(made)


def twin(of: Cell) -> robot_pb2.RobotState:
    """Return the state of the arm; its commanded positions are told while its joints are measured."""
    return of.alone.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=["arm"])).robots[0]


def monitor_and_lose(of: Cell, fault: str) -> None:
    of.connect()
    of.mode(MONITOR)
    until(lambda: len(twin(of).commanded_positions) > 0)
    of.ask(fault)
    until(lambda: of.status().state == ERROR)


def move(of: Cell, first: float, speed: float = 1.0) -> motion_pb2.Motion:
    return of.await_end(of.holder.start(joints("arm", speed, **{FIRST: first})))


@pytest.mark.parametrize("fault", ["silent", "raises", pytest.param("dies", marks=pytest.mark.long)])
def test_a_robot_that_was_lost_while_it_was_monitored_follows_again_and_blocks_nobody(cell: Cell, fault: str) -> None:
    def scenario() -> None:
        monitor_and_lose(cell, fault)
        cell.connect()
        assert cell.mode(EXECUTE).driver.state == ACTIVE
        assert not twin(cell).commanded_positions
        assert move(cell, 0.2, 0.5).phase == SUCCEEDED
        cell.alone.driver.StopCell(driver_pb2.StopCellRequest(reason="a cat"))
        until(lambda: cell.status().state == INACTIVE)
        cell.alone.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())

    patiently(cell, scenario)


@pytest.mark.long
@pytest.mark.parametrize("choice", ["simulated", "disconnected"])
def test_a_twin_moves_alone_once_that_is_chosen_after_its_robot_was_lost(cell: Cell, choice: str) -> None:
    monitor_and_lose(cell, "silent")
    if choice == "simulated":
        cell.mode(SIMULATED)
    else:
        cell.call("DisconnectDriver", robot="arm")
    assert move(cell, 0.2).phase == SUCCEEDED
    assert twin(cell).positions[0] == pytest.approx(0.2, abs=1e-6)


@pytest.mark.long
def test_a_twin_is_measured_until_its_motion_has_ended(cell: Cell) -> None:
    """Its commanded joints are elsewhere: they can be put to where it was measured at rest only."""
    cell.connect()
    cell.mode(MONITOR)
    id = cell.holder.start(joints("arm", 0.05, **{FIRST: 1.0}))
    until(lambda: len(twin(cell).commanded_positions) > 0 and twin(cell).commanded_positions[0] > 0.01)
    refused = refusal(lambda: cell.mode(SIMULATED))
    assert (refused.reason, id in refused.message) == ("ROBOT_BUSY", True), refused
    assert cell.status().mode == MONITOR
    cell.ask("silent")
    until(lambda: cell.status().state == ERROR)
    assert id in refusal(lambda: cell.mode(SIMULATED)).message
    assert cell.motion(id).phase == motion_pb2.MOTION_PHASE_RUNNING
    cell.alone.motion.Stop(motion_pb2.StopRequest())
    cell.await_end(id)
    until(lambda: not twin(cell).commanded_positions)
    assert twin(cell).positions[0] == 0.0
    cell.mode(SIMULATED)
    assert move(cell, 0.2).phase == SUCCEEDED


def test_a_guarded_robot_that_is_elsewhere_moves_as_it_is_commanded(cell: Cell) -> None:
    """The real one stands at 0 all the while: from there to what is commanded nothing goes, and nothing is checked."""
    cell.connect()
    cell.mode(MONITOR)
    for first in (1.0, -1.0, 0.5):
        ended = move(cell, first)
        assert ended.phase == SUCCEEDED, ended.end_reason
    assert twin(cell).positions[0] == 0.0
