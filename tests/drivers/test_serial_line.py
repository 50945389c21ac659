"""The driver `serial_line` against the board of its page."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_plugins.drivers.serial_line import SerialLine, SerialLineSettings
from virtualrobot_sdk.drivers import DriverFault, Mode, Pace, Reading, Safety

from tests.drivers.boards import Board
from tests.drivers.cables import Cable

PATIENT = 20.0
"""Silence (s) that tests bear where silence is not what they are about."""
GREETING = "JOINTS 2 RATE 20 UNIT DEG PACE HOST"
HOME = np.zeros(6)


Boards = Callable[..., SerialLine]


@pytest.fixture
def board(cable: Cable, tmp_path: Path) -> Iterator[Boards]:
    """Yield a function that starts the board of the page, with other constants, and returns a driver of it."""
    running: list[Board] = []
    drivers: list[SerialLine] = []

    def start(**constants: object) -> SerialLine:
        running.append(Board(cable, tmp_path, **constants))
        drivers.append(SerialLine(SerialLineSettings(str(cable.path), silence_seconds=PATIENT)))
        return drivers[-1]

    yield start
    for driver in drivers:
        driver.close()
    for board in running:
        board.close()


def wait_until(driver: SerialLine, there: Callable[[Reading], bool]) -> Reading:
    """Return the first reading of which `there` is true; the test's own timeout ends what never comes."""
    while not there(reading := driver.read()):
        pass
    return reading


def test_the_board_of_the_page_says_what_it_is(board: Boards) -> None:
    about = board().connect()
    assert (about.joints, about.rate, about.pace) == (6, 20.0, Pace.HOST)
    assert about.units == math.radians(1.0)
    assert (about.watchdog, about.model, about.version) == (0.5, "six-servos", "1")
    assert (about.inputs, about.outputs) == (1, 1)


def test_the_board_of_the_page_follows_setpoints(board: Boards) -> None:
    driver = board(WATCHDOG_MS=60_000)
    driver.connect()
    first = driver.read()
    assert (first.mode, first.safety) == (Mode.READY, Safety.NORMAL)
    driver.begin(HOME)
    goal = np.array([10.0, -20.0, 30.0, 0.5, -0.25, 5.0])
    driver.send(goal, HOME, 1)
    there = wait_until(driver, lambda reading: bool(np.abs(reading.positions - goal).max() < 0.001))
    assert there.mode is Mode.RUNNING
    assert there.stamp > first.stamp
    driver.end()
    assert driver.read().mode is Mode.READY


def test_the_clock_of_the_board_may_start_again(board: Boards) -> None:
    """It does, half a second after the program has begun."""
    driver = board()
    driver.connect()
    stamps = [driver.read().stamp]
    while stamps[-1] < stamps[0] + 1.0:
        stamps.append(driver.read().stamp)
    assert (np.diff(stamps) >= 0.0).all()
    assert stamps[-1] < 1000.0


def test_the_board_of_the_page_goes_to_points_and_stops(board: Boards) -> None:
    driver = board(JOBS=True, WATCHDOG_MS=60_000, SPEED=360.0)
    assert driver.connect().pace is Pace.JOBS
    driver.begin(HOME)
    points = [np.full(6, value) for value in (4.0, 8.0, 2.0, 6.0, 1.0, 3.0)]
    driver.run(points, [1.0] * 6, 0)
    assert wait_until(driver, lambda reading: reading.done == 6).positions == pytest.approx(points[-1], abs=0.001)
    driver.run([np.full(6, 80.0), np.zeros(6)], [0.05, 1.0], 0)
    wait_until(driver, lambda reading: reading.positions[0] > 5.0)
    driver.stop()
    rest = driver.read()
    assert rest.positions[0] < 80.0
    assert driver.read().positions == pytest.approx(rest.positions)
    assert rest.mode is Mode.READY
    driver.begin(rest.positions)
    driver.run([np.zeros(6)], [1.0], 0)
    assert wait_until(driver, lambda reading: reading.done == 1).positions == pytest.approx(np.zeros(6), abs=0.001)


def test_the_board_of_the_page_stops_when_nobody_speaks(board: Boards) -> None:
    driver = board(WATCHDOG_MS=100, SPEED=10.0)
    driver.connect()
    driver.begin(HOME)
    driver.send(np.full(6, 80.0), HOME, 0)
    # It would take 8 s.
    time.sleep(0.5)
    rest = driver.read()
    assert rest.mode is Mode.READY
    assert rest.positions[0] < 80.0
    assert driver.read().positions == pytest.approx(rest.positions)
    driver.send(HOME, HOME, 0)
    with pytest.raises(DriverFault, match="2: it does not follow: ON comes first"):
        wait_until(driver, lambda reading: False)


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        (np.full(6, 91.0), "4: joint 1 to 91: it goes from -90 to 90"),
        (np.full(6, math.nan), "4: joint 1 to nan: it goes from -90 to 90"),
        (np.zeros(5), "3: 6 joints, not 5"),
    ],
)
def test_the_board_of_the_page_refuses_in_words(board: Boards, goal: np.ndarray, said: str) -> None:
    driver = board()
    driver.connect()
    driver.begin(HOME)
    driver.send(goal, HOME, 0)
    with pytest.raises(DriverFault) as fault:
        wait_until(driver, lambda reading: False)
    assert str(fault.value) == said
    assert fault.value.clears


def test_damaged_lines_cost_nothing_but_another_try(board: Boards) -> None:
    driver = board()
    driver.connect()
    driver.begin(HOME)
    # What comes to the board is damaged: two bits flipped, half a line, nothing but noise, a line without end.
    for noise in (b"GO 9 9 9 9 9 9*0000\n", b"REA", b"\xff\xfe\x00\n", b"x" * 3000, b"\n\n"):
        driver._open().write(noise)
        assert driver.read().positions == pytest.approx(HOME)
    driver.stop()
    driver.end()
