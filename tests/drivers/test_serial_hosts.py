"""Drivers of robots on serial ports in their host's process: what a twin does, the robot does."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_sdk.drivers.process import DriverProcess
from virtualrobot_sdk.drivers.robot_side import JointSide, RobotSide
from virtualrobot_sdk.drivers.shared import CellBlock, Report, State, TickRing

from tests.drivers import robots_on_cables

TICK_NS = 20_000_000
LEAD_NS = 2_000_000_000
"""Time (ns) by which ticks are played later, since a busy machine writes them late: 100 ticks, and a ring has 128."""
WAY_TICKS = 50
SPEED = math.radians(4.0)
"""Greatest speed (rad/s) of the robots that plan by themselves."""


class Hosted:
    """A driver in its process, and a thread that writes what its twin does: it rests, or goes to a goal and rests."""

    def __init__(
        self,
        folder: Path,
        component: str,
        settings: dict[str, object],
        joints: int,
        speed: float,
        plugin: str = robots_on_cables.__name__,
    ) -> None:
        """Connect, and put the twin where the robot is."""
        self.ring = TickRing.create(folder / "ring", joints)
        self.cell = CellBlock.create(folder / "cell")
        self.process = DriverProcess(component)
        side = RobotSide(tuple(JointSide(f"joint{i}", i, -3.0, 3.0, speed) for i in range(joints)), TICK_NS)
        entry = EntryPoint("robots", plugin, "virtualrobot.plugins")
        self.process.make(entry, component, settings, side, folder / "ring", folder / "cell")
        self.process.connect()
        first = self.until(lambda report: report.state is State.INACTIVE and report.cycles > 0)
        self.start = self.goal = np.array(first.q)
        self.from_tick = 0
        self.began = time.monotonic_ns()
        self.tick = -1
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._write)
        self._thread.start()

    def until(self, there: Callable[[Report], bool]) -> Report:
        """Return the first report of which `there` is true; the test's own timeout ends what never comes."""
        while (report := self.ring.reported()) is None or not there(report):
            if report is not None and report.state is State.ERROR:
                pytest.fail(f"it is in ERROR: {self.process.words()}")
            time.sleep(0.005)
        return report

    def begin(self) -> None:
        """Let the robot follow, once the twin has told a tick."""
        while self.cell.newest_braked < 0:
            time.sleep(0.005)
        self.process.begin()
        self.until(lambda report: report.state is State.ACTIVE)

    def go(self, way: float) -> np.ndarray:
        """Have the twin go by a way (rad) in each joint; return where to."""
        self.start, self.goal, self.from_tick = self.goal, self.goal + way, self.tick + 10
        return self.goal

    def _state(self, tick: int) -> tuple[np.ndarray, np.ndarray]:
        s = min(max((tick - self.from_tick) / WAY_TICKS, 0.0), 1.0)
        way = self.goal - self.start
        rate = 30.0 * s**2 * (1.0 - s) ** 2 / (WAY_TICKS * TICK_NS * 1e-9)
        return self.start + way * s**3 * (10.0 - 15.0 * s + 6.0 * s**2), way * rate

    def _write(self) -> None:
        while not self._over.wait(0.01):
            until = (time.monotonic_ns() - self.began) // TICK_NS
            for tick in range(self.tick + 1, until + 1):
                q, v = self._state(tick)
                # The brake by 8 rad/s^2, of all joints together.
                fastest = float(np.abs(v).max())
                times = np.append(np.arange(0.0, fastest / 8.0, TICK_NS * 1e-9), fastest / 8.0)
                share = 1.0 - 4.0 * times / fastest if fastest else np.zeros(len(times))
                played = self.began + tick * TICK_NS + LEAD_NS
                self.ring.put(tick, played, q, v, 0, q + (times * share)[:, None] * v)
                self.cell.complete(tick, True)
                self.tick = tick

    def freeze(self) -> None:
        """Write no more ticks."""
        self._over.set()
        self._thread.join()

    def close(self) -> None:
        """End all."""
        self.process.close()
        self.freeze()
        self.ring.close()
        self.cell.close()


Hosts = Callable[..., Hosted]


@pytest.fixture
def hosted(tmp_path: Path) -> Iterator[Hosts]:
    """Yield a function that connects a driver."""
    made: list[Hosted] = []

    def make(component: str, joints: int, speed: float = 2.0, **settings: object) -> Hosted:
        made.append(Hosted(tmp_path, component, {"port": "cable", **settings}, joints, speed))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.mark.long
def test_a_board_follows_its_twin(hosted: Hosts) -> None:
    robot = hosted("board", 6)
    robot.begin()
    goal = robot.go(0.3)
    robot.until(lambda report: bool(np.abs(report.q - goal).max() < 1e-3))
    robot.cell.stop()
    rest = robot.until(lambda report: report.state is State.INACTIVE)
    assert rest.q == pytest.approx(goal, abs=1e-3)


@pytest.mark.long
def test_servos_follow_their_twin(hosted: Hosts) -> None:
    robot = hosted("servos", 2, ids=[1, 2], baud=1_000_000, rate=50)
    robot.begin()
    goal = robot.go(0.3)
    robot.until(lambda report: bool(np.abs(report.q - goal).max() < 2e-3))


@pytest.mark.long
@pytest.mark.parametrize(("component", "settings"), [("jobs", {}), ("arm", {"baud": 115200})])
def test_what_plans_by_itself_goes_the_way_of_its_twin(
    hosted: Hosts, component: str, settings: dict[str, object]
) -> None:
    robot = hosted(component, 6, SPEED, **settings)
    robot.begin()
    for way in (0.05, -0.03):
        goal = robot.go(way)
        robot.until(lambda report, goal=goal: bool(np.abs(report.q - goal).max() < 1e-3))


@pytest.mark.long
@pytest.mark.parametrize(("by", "said"), [("stop", "the cell was stopped"), ("frozen", "no newer tick came in time")])
@pytest.mark.parametrize(("component", "settings"), [("jobs", {}), ("arm", {"baud": 19200})])
def test_what_plans_by_itself_is_stopped_on_its_way(
    hosted: Hosts, component: str, settings: dict[str, object], by: str, said: str
) -> None:
    robot = hosted(component, 6, SPEED, **settings)
    robot.begin()
    begun = robot.goal.copy()
    goal = robot.go(0.5)
    robot.until(lambda report: bool(np.abs(report.q - begun).max() > 0.01))
    if by == "stop":
        robot.cell.stop()
    else:
        robot.freeze()
    stopped = robot.until(lambda report: report.state in (State.ERROR, State.INACTIVE))
    assert np.abs(stopped.q - goal).min() > 0.1
    assert robot.process.words().text == f"{said} while the robot went to its points: it was stopped on its way"
    robot.process.connect()
    again = robot.until(lambda report: report.state is State.INACTIVE and report.cycles > 3)
    assert again.q == pytest.approx(stopped.q, abs=0.02)
    assert robot.until(lambda report: report.cycles > 10).q == pytest.approx(again.q, abs=1e-3)


@pytest.mark.long
@pytest.mark.parametrize(("by", "said"), [("stop", "the cell was stopped"), ("frozen", "no newer tick came in time")])
def test_what_stands_as_the_cell_stops_does_not_begin_to_move(hosted: Hosts, by: str, said: str) -> None:
    """The twin is on its way by then, and the robot would be given that way."""
    robot = hosted("jobs", 6, SPEED)
    robot.begin()
    begun = robot.goal.copy()
    robot.go(0.05)
    far = robot.from_tick + WAY_TICKS // 2
    if by == "stop":
        robot.until(lambda report: report.tick > far)
        robot.cell.stop()
    else:
        while robot.tick < far:
            time.sleep(0.005)
        robot.freeze()
    rest = robot.until(lambda report: report.state is State.INACTIVE)
    assert said in robot.process.words().text
    assert rest.q == pytest.approx(begun, abs=1e-3)
    later = robot.until(lambda report: report.cycles > rest.cycles + 10)
    assert later.q == pytest.approx(begun, abs=1e-3)
