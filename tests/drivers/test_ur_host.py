"""The driver `ur_rtde` in its host's process, and an emulated controller in another: what a twin does, the robot does.

Faults in mid-motion end in ERROR with the controller's words, the cell stopped, and nothing moves unasked afterwards.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_sdk.drivers import DriverFault, Safety
from virtualrobot_sdk.drivers.shared import NEVER, Report, State

from tests.drivers import ur_controllers
from tests.drivers.test_serial_hosts import Hosted
from tests.drivers.ur_controllers import BUSY, ControllerProcess, host

pytestmark = pytest.mark.long


class Cell:
    """A controller, and the driver in its host."""

    def __init__(self, folder: Path) -> None:
        """Connect."""
        self.controller = ControllerProcess(host=host(1))
        settings = {"host": self.controller.host, "rate": 125, "watchdog": BUSY, "silence": BUSY}
        self.robot = Hosted(folder, "ur_rtde", settings, 6, 2.0, ur_controllers.__name__)

    def under_way(self) -> np.ndarray:
        """Begin, and return where the robot goes to, once it is on its way."""
        self.robot.begin()
        start = self.robot.goal
        goal = self.robot.go(0.5)
        self.robot.until(lambda report: bool((report.q - start).min() > 0.05))
        return goal

    def failed(self) -> Report:
        """Return the report of ERROR."""
        while (report := self.robot.ring.reported()) is None or report.state is not State.ERROR:
            time.sleep(0.005)
        assert self.robot.cell.stop_ns < NEVER
        return report

    def connected_again(self) -> Report:
        """Connect again, and return a report; the robot must come to rest, though the twin's goal is elsewhere."""
        self.robot.process.connect()
        first = self.robot.until(
            lambda report: report.state is State.INACTIVE and report.cycles > 0 and bool(np.abs(report.v).max() < 1e-6)
        )
        later = self.robot.until(lambda report: report.cycles > first.cycles + 50)
        np.testing.assert_allclose(later.q, first.q, atol=1e-4)
        return later

    def close(self) -> None:
        self.robot.close()
        self.controller.kill()


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[Cell]:
    made = Cell(tmp_path)
    yield made
    made.close()


def test_the_robot_follows_its_twin_and_stops_with_the_cell(cell: Cell) -> None:
    robot = cell.robot
    robot.begin()
    goal = robot.go(0.3)
    robot.until(lambda report: bool(np.abs(report.q - goal).max() < 1e-3))
    robot.cell.stop()
    rest = robot.until(lambda report: report.state is State.INACTIVE)
    np.testing.assert_allclose(rest.q, goal, atol=1e-3)


def test_a_kernel_that_freezes_in_motion_means_a_stop_on_the_path(cell: Cell) -> None:
    cell.under_way()
    cell.robot.freeze()
    rest = cell.robot.until(lambda report: report.state is State.INACTIVE)
    # All joints have gone the same way: it is still on the path.
    way = rest.q - cell.robot.start
    np.testing.assert_allclose(way, way[0], atol=2e-3)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (ControllerProcess.freeze, "silent|stood still"),
        (ControllerProcess.kill, "has closed the connection|is lost"),
        (lambda one: one.order("protective stop"), "C153A0: Position deviates from path: Shoulder"),
        (lambda one: one.order("emergency stop"), "emergency stop of the robot"),
        (lambda one: one.order("power off"), "no longer lets the robot follow, it is OFF"),
    ],
    ids=["frozen", "killed", "protective stop", "emergency stop", "power off"],
)
def test_a_fault_in_motion_is_told(cell: Cell, fault: Callable[[ControllerProcess], None], words: str) -> None:
    cell.under_way()
    fault(cell.controller)
    cell.failed()
    assert re.search(words, cell.robot.process.words().text), cell.robot.process.words()
    cell.controller.mend()
    report = cell.connected_again()
    if "C153" in words:
        assert report.safety is Safety.PROTECTIVE_STOP
        with pytest.raises(DriverFault, match=r"C153A0|apart"):
            cell.robot.process.begin()
        cell.robot.process.reset()
        cell.robot.until(lambda report: report.safety is Safety.NORMAL)
