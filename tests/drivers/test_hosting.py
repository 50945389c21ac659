"""Hosts with a driver of the test: what goes wrong at the controller, in the ring or in the driver ends at rest.

The controller does what it is sent in the same cycle. Leads are long; where a busy machine is later still, so that a
robot brakes that should not, the test is tried again with new robots.
"""

from __future__ import annotations

import functools
import re
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from virtualrobot_sdk.drivers import About, Driver, DriverFault, Mode, Pace, Reading, Safety, Words, realtime
from virtualrobot_sdk.drivers.host import Host
from virtualrobot_sdk.drivers.robot_side import JointSide, RobotSide
from virtualrobot_sdk.drivers.shared import CELL, NEVER, CellBlock, Report, State, TickRing

from tests.drivers.twin import PERIOD, TICK_NS, Twin

RATE = 100.0
LEAD_NS = 400_000_000
AMPLITUDES = np.array([0.3, -0.2])
TEXT: Any = "fast"
STARVED_SECONDS = 3.0
"""Time (s) after which a robot that has braked for want of ticks is not waited for any more."""

SIDE = RobotSide(tuple(JointSide(name, i, -3.0, 3.0, 2.0) for i, name in enumerate(("hip", "knee"))), TICK_NS)


class Controller(Driver):
    """Controller of two joints in degrees, the second of which counts the other way; tests change what it says."""

    def __init__(self, pace: Pace = Pace.HOST) -> None:
        """Stand at zero."""
        self.pace = pace
        self.at = np.zeros(2)
        self.sent: list[np.ndarray] = []
        self.calls: list[str] = []
        self.mode, self.safety, self.text, self.scaling = Mode.READY, Safety.NORMAL, "", 1.0
        self.silent, self.raises = False, ""
        self.refuses = ""
        self._stamp = 0.0
        self._due = 0.0

    def connect(self) -> About:
        """Connect."""
        self.calls.append("connect")
        self.mode = Mode.READY
        return About(2, RATE, self.pace, units=np.pi / 180.0, watchdog=0.1, speed_scaling=True)

    def read(self) -> Reading:
        """Say where it is; of CONTROLLER, when its next cycle comes."""
        if self.raises:
            raise RuntimeError(self.raises)
        if self.pace is Pace.CONTROLLER:
            self._due = max(self._due + 1.0 / RATE, time.monotonic())
            time.sleep(max(0.0, self._due - time.monotonic()))
        if not self.silent:
            self._stamp += 1.0 / RATE
        return Reading(
            self._stamp, self.at, None, None, self.mode, self.safety, speed_scaling=self.scaling, text=self.text
        )

    def begin(self, held: np.ndarray) -> None:
        """Follow."""
        self.calls.append("begin")
        if self.refuses:
            raise DriverFault(self.refuses, "C12", clears=True)
        self.mode = Mode.RUNNING

    def send(self, positions: np.ndarray, velocities: np.ndarray, outputs: int) -> None:
        """Be there."""
        self.at = np.array(positions)
        self.sent.append(self.at)

    def stop(self) -> None:
        """Stay."""
        self.calls.append("stop")

    def end(self) -> None:
        """Follow no more."""
        self.calls.append("end")
        self.mode = Mode.READY


class Rig:
    """One robot: its controller, host and ring."""

    def __init__(self, folder: Path, cell: CellBlock, name: str, pace: Pace = Pace.HOST) -> None:
        """Make the host, which is connected to nothing yet; the controller's second joint counts the other way."""
        knee = JointSide("knee", 1, -3.0, 3.0, 2.0, sign=-1.0, offset=0.0)
        self.ring = TickRing.create(folder / name, 2)
        self.controller = Controller(pace)
        self.host = Host(self.controller, RobotSide((SIDE.joints[0], knee), TICK_NS, lead_ns=LEAD_NS), self.ring, cell)
        self.is_late = False
        """True once it was seen in ERROR because its thread was not let run."""
        self.host.start()

    def until(self, there: Callable[[Report], bool]) -> Report:
        """Return the first report of which `there` is true; the test's own timeout ends what never comes."""
        starved_at = 0.0
        while (report := self.ring.reported()) is None or not there(report):
            if report is not None and report.state is State.ERROR:
                words = self.host.words().text
                self.is_late = self.is_late or "had no cycle for" in words or "late to its cycle" in words
                pytest.fail(f"it is in ERROR: {self.host.words()}")
            if self.is_starved:
                starved_at = starved_at or time.monotonic()
                assert time.monotonic() - starved_at < STARVED_SECONDS, "it has braked for want of ticks"
            time.sleep(0.002)
        return report

    @property
    def is_starved(self) -> bool:
        """True once it has braked for want of ticks."""
        return "no newer tick" in self.host.words().text

    def until_state(self, state: State) -> Report:
        """Return the first report of a state, after a cycle."""
        return self.until(lambda report: report.state is state and (state is State.ERROR or report.cycles > 1))

    def joints_sent(self) -> np.ndarray:
        """Return what was sent (n, k), in the kernel's units."""
        return np.radians(np.array(self.controller.sent)) * [1.0, -1.0]


class Cell:
    """Cell of robots, and the thread that writes their ticks while it is not frozen."""

    def __init__(self, folder: Path) -> None:
        """Have no robots yet."""
        self.folder, self.block = folder, CellBlock.create(folder / CELL)
        self.rigs: list[Rig] = []
        self.twin: Twin | None = None
        self._frozen = threading.Event()
        self._thread: threading.Thread | None = None

    def robot(self, pace: Pace = Pace.HOST) -> Rig:
        """Add one and connect it."""
        rig = Rig(self.folder, self.block, f"ring-{len(self.rigs)}", pace)
        self.rigs.append(rig)
        assert isinstance(rig.host.connect(), About)
        rig.until_state(State.INACTIVE)
        return rig

    def write(self, swings: bool = True) -> Twin:
        """Write ticks from now on, of twins that swing or stand."""
        self.twin = Twin({rig.ring: AMPLITUDES for rig in self.rigs}, self.block, time.monotonic_ns(), LEAD_NS)
        self.twin.swings = swings
        self.twin.write(0)
        self._thread = threading.Thread(target=self._write)
        self._thread.start()
        return self.twin

    def _write(self) -> None:
        twin = self.twin
        assert twin is not None
        while not self._frozen.wait(0.004):
            twin.write((time.monotonic_ns() - twin.begin_ns) // TICK_NS)

    def freeze(self) -> None:
        """Write no more."""
        self._frozen.set()
        if self._thread is not None:
            self._thread.join()

    def follow(self, swings: bool = True) -> Twin:
        """Let all robots follow twins that stand, and then swing; return them once their robots move."""
        twin = self.write(swings=False)
        for rig in self.rigs:
            assert not rig.host.begin().text
            rig.until(lambda report: report.state is State.ACTIVE)
        if swings:
            twin.from_tick = twin.tick + 10
            twin.swings = True
            for rig in self.rigs:
                rig.until(lambda report: report.tick > twin.from_tick + 30)
        return twin

    def close(self) -> None:
        """End all."""
        for rig in self.rigs:
            rig.host.close()
        self.freeze()
        for rig in self.rigs:
            rig.ring.close()
        self.block.close()


@pytest.fixture
def cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cell]:
    # Hosts are threads of this process here, which goes on as it was.
    monkeypatch.setattr(realtime, "calm", lambda: "ordinary")
    cell = Cell(tmp_path)
    yield cell
    cell.close()


def patiently(test: Callable[..., None]) -> Callable[..., None]:
    """Return a test that is tried again, with new robots, where the machine was so busy that one braked by itself."""

    @functools.wraps(test)
    def tried(*own: object, cell: Cell, **given: object) -> None:
        for attempt in range(20):
            one = cell
            if attempt:
                folder = cell.folder / str(attempt)
                folder.mkdir()
                one = Cell(folder)
            try:
                return test(*own, cell=one, **given)
            except (AssertionError, pytest.fail.Exception):
                if not any(rig.is_starved or rig.is_late for rig in one.rigs):
                    raise
            finally:
                if one is not cell:
                    one.close()
        pytest.fail("the machine is too busy for a lead of 0.4 s")

    return tried


@patiently
def test_a_robot_goes_where_its_twin_went(cell: Cell) -> None:
    rig = cell.robot()
    twin = cell.follow()
    report = rig.until(lambda report: report.tick > twin.from_tick + 60)
    assert report.rate == 1.0 and report.mode is Mode.RUNNING
    # Readings are a cycle old, in which a joint goes at most its greatest speed.
    went = np.abs(AMPLITUDES) * np.pi / 2.0 / RATE
    assert (np.abs(report.error) <= 1.5 * went + 0.01).all()
    sent = rig.joints_sent()
    np.testing.assert_allclose(sent[:, 1] * AMPLITUDES[0], sent[:, 0] * AMPLITUDES[1], atol=1e-12)
    assert twin.tick > report.tick


@pytest.mark.parametrize("pace", [Pace.CONTROLLER])
@patiently
def test_packets_of_the_controller_set_the_pace(cell: Cell, pace: Pace) -> None:
    rig = cell.robot(pace)
    cell.follow()
    cell.block.stop()
    rig.until(lambda report: report.state is State.INACTIVE)
    assert np.abs(np.diff(rig.joints_sent(), axis=0)).max() <= 1.1 * 2.0 * 0.03


class TestBeginning:
    def test_a_twin_that_is_elsewhere_is_told_with_the_joint_and_the_numbers(self, cell: Cell) -> None:
        rig = cell.robot()
        rig.controller.at = np.degrees([0.0, -0.002])
        rig.until(lambda report: bool(report.q[1] > 0.001))
        cell.write(swings=False)
        words = rig.host.begin()
        assert "'knee'" in words.text and "0.002" in words.text
        assert rig.host.state is State.INACTIVE and "begin" not in rig.controller.calls and not rig.controller.sent

    def test_without_ticks_it_is_refused(self, cell: Cell) -> None:
        rig = cell.robot()
        assert "no tick" in rig.host.begin().text
        assert rig.host.state is State.INACTIVE

    def test_what_the_controller_refuses_is_told_in_its_words(self, cell: Cell) -> None:
        rig = cell.robot()
        cell.write(swings=False)
        rig.controller.refuses = "the program does not run"
        words = rig.host.begin()
        assert (words.text, words.code, words.clears) == ("the program does not run", "C12", True)
        assert rig.host.state is State.ERROR


def test_words_are_told_on_one_line_without_control_characters(cell: Cell) -> None:
    rig = Rig(cell.folder, cell.block, "ring")
    cell.rigs.append(rig)

    def refuse() -> About:
        raise DriverFault("axis 2\r\n\x1b[31mis hot\x07", "C\n1")

    rig.controller.connect = refuse
    words = rig.host.connect()
    assert isinstance(words, Words) and (words.text, words.code) == ("axis 2 [31mis hot", "C 1")


def test_who_does_not_say_how_it_ends_stops() -> None:
    calls: list[str] = []

    class Plain(Driver):
        def stop(self) -> None:
            calls.append("stop")

    Plain().end()
    assert calls == ["stop"]


def test_units_of_joints_are_compared_as_a_whole_however_they_come() -> None:
    assert About(2, RATE, units=np.array([0.1, 0.2])) == About(2, RATE, units=(0.1, 0.2))  # pyright: ignore


@pytest.mark.parametrize(
    ("name", "becomes", "words"),
    [
        ("calls", None, "raised in connect AttributeError: 'NoneType' object has no attribute 'append' (test"),
        ("connect", lambda: None, ": `connect` returned None; it must return an About"),
        ("connect", lambda: About(2, TEXT), ": rate of its About is 'fast'; it must be a number"),
        ("connect", lambda: About(2, 0.0), ": rate of its About is 0; it must be 0.1 to 10000"),
        ("connect", lambda: About(2, RATE, units=(1.0, 1.0, 1.0)), ": units of its About have shape (3,)"),
        ("connect", lambda: About(2, RATE, Pace.JOBS), ": its pace is JOBS, and it has no method `run`"),
        ("raises", "the cable is out", "raised in read RuntimeError: the cable is out (test_hosting.py:"),
        ("read", lambda: None, ": `read` returned None; it must return a Reading"),
        ("mode", "READY", ": mode of its Reading is 'READY'; it must be a Mode"),
        ("at", ["a", "b"], "positions are ['a', 'b']; they must be numbers"),
    ],
)
def test_what_its_author_did_wrong_is_told(cell: Cell, name: str, becomes: object, words: str) -> None:
    """With the driver, its method, and what would be right; the host goes on, and connects again."""
    rig = Rig(cell.folder, cell.block, "ring")
    cell.rigs.append(rig)
    before = getattr(rig.controller, name)
    if name == "mode":
        rig.controller.connect = lambda: About(2, RATE, watchdog=0.1)  # it sets the mode
    setattr(rig.controller, name, becomes)
    rig.host.connect()
    rig.until_state(State.ERROR)
    assert words in rig.host.words().text
    assert rig.host.words().text.startswith("the driver Controller") or name == "at"
    setattr(rig.controller, name, before)
    assert isinstance(rig.host.connect(), About)
    rig.until_state(State.INACTIVE)


@pytest.mark.long
class TestFaultsInMotion:
    @pytest.mark.parametrize(
        ("cause", "value", "words"),
        [
            ("at", np.array([np.nan, 0.0]), "finite"),
            ("silent", True, "stood still"),
            ("raises", "the cable is out", "the driver Controller raised in read RuntimeError: the cable is out (test"),
            ("safety", Safety.PROTECTIVE_STOP, "PROTECTIVE_STOP"),
            ("safety", Safety.EMERGENCY_STOP, "EMERGENCY_STOP"),
            ("mode", Mode.LOCAL, "LOCAL"),
            ("mode", Mode.OFF, "OFF"),
        ],
    )
    @patiently
    def test_the_cell_stops_and_nothing_more_is_sent(self, cell: Cell, cause: str, value: object, words: str) -> None:
        """And the other robot of the cell comes to rest; then the first is connected again, and stands where it is."""
        rig, other = cell.robot(), cell.robot()
        cell.follow()
        if cause == "at":
            rig.controller.send = lambda *_: None  # type: ignore[method-assign]
        setattr(rig.controller, cause, value)
        rig.until_state(State.ERROR)
        count = len(rig.controller.sent)
        assert words in rig.host.words().text
        assert cell.block.stop_ns != NEVER and "stop" in rig.controller.calls
        report = other.until(lambda report: report.state is State.INACTIVE)
        assert np.isfinite(report.q).all()
        assert len(rig.controller.sent) == count
        rig.controller.at, rig.controller.silent, rig.controller.raises = np.degrees([0.1, 0.2]), False, ""
        rig.controller.safety = Safety.NORMAL
        assert isinstance(rig.host.connect(), About)
        report = rig.until_state(State.INACTIVE)
        np.testing.assert_allclose(report.q, [0.1, -0.2], atol=1e-12)
        assert len(rig.controller.sent) == count, "nothing moves unasked"

    @patiently
    def test_a_fault_is_told_before_its_controller_has_stopped(self, cell: Cell) -> None:
        """A `stop` may take as long as a line is silent: who sees the cell stopped has the reason already."""
        rig = cell.robot()
        cell.follow()
        stopped = threading.Event()
        rig.controller.stop = lambda: stopped.wait() and None  # type: ignore[method-assign]
        rig.controller.raises = "the cable is out"
        try:
            while cell.block.stop_ns == NEVER:
                time.sleep(0.001)
            report = rig.ring.reported()
            assert report is not None and report.is_faulty and report.state is not State.ERROR
            assert "the cable is out" in rig.host.words().text
        finally:
            stopped.set()
        rig.until_state(State.ERROR)

    @patiently
    def test_a_setpoint_that_jumps_is_never_sent_but_the_brake_before_it(self, cell: Cell) -> None:
        rig = cell.robot()
        twin = cell.follow()
        told = _told_at_stops(cell, rig)
        cell.freeze()
        twin.starts[rig.ring] = np.array([0.5, 0.0])
        last = twin.tick
        twin.write(last + 40)
        rig.until_state(State.ERROR)
        assert "'hip'" in rig.host.words().text and "not sent" in rig.host.words().text
        assert told[0].is_faulty, "a stop is told with its reason, or somebody else is taken for it"
        sent = rig.joints_sent()
        assert np.abs(np.diff(sent, axis=0)).max() < 0.1
        assert cell.block.stop_ns != NEVER
        # It stands where the brake of the newest good tick ends, or of the one before.
        ends = [
            twin.brake(*state)[-1]
            for state in (
                (q - twin.starts[rig.ring], v) for q, v in (twin.state(rig.ring, tick) for tick in (last - 1, last))
            )
        ]
        assert min(np.abs(sent[-1] - end).max() for end in ends) < 5e-3

    @patiently
    def test_a_host_that_is_late_in_motion_brakes_on_its_path(self, cell: Cell) -> None:
        """Its driver takes 0.3 s once, of a lead of 0.4."""
        rig, other = cell.robot(), cell.robot()
        cell.follow()
        _late_once(rig)
        rig.until_state(State.ERROR)
        words = rig.host.words().text
        late = re.match("the driver came ([0-9]+) ms late to its cycle", words)
        assert late and 299 <= int(late[1]) and "braked before it" in words, words
        other.until(lambda report: report.state is State.INACTIVE)
        # It never went faster than its twin does, came to rest, and was on the twin's line (both joints in proportion).
        sent = rig.joints_sent()
        steps = np.abs(np.diff(sent[:, 0]))
        assert steps.max() <= 1.05 * AMPLITUDES[0] * np.pi / PERIOD / RATE and steps[-1] < 1e-3
        np.testing.assert_allclose(sent[:, 1] * AMPLITUDES[0], sent[:, 0] * AMPLITUDES[1], atol=1e-9)

    @patiently
    def test_a_host_that_is_late_at_rest_goes_on(self, cell: Cell) -> None:
        rig = cell.robot()
        cell.follow(swings=False)
        _late_once(rig)
        cycles = rig.until(lambda report: report.cycles > 0).cycles
        assert rig.until(lambda report: report.cycles > cycles + 10).state is State.ACTIVE

    @patiently
    def test_a_controller_that_stays_slow_is_stopped(self, cell: Cell) -> None:
        rig = cell.robot()
        cell.follow()
        rig.controller.scaling = 0.5
        rig.until_state(State.ERROR)
        assert "slower" in rig.host.words().text


def _told_at_stops(cell: Cell, rig: Rig) -> list[Report]:
    """Return the list of what a robot had told whenever somebody stopped the cell from now on."""
    told: list[Report] = []
    stop = cell.block.stop

    def noted(at_ns: int | None = None) -> None:
        report = rig.ring.reported()
        assert report is not None
        told.append(report)
        stop(at_ns)

    cell.block.stop = noted  # type: ignore[method-assign]
    return told


def _late_once(rig: Rig) -> None:
    """Have a robot's driver take 0.3 s for its next cycle."""
    read = rig.controller.read

    def late() -> Reading:
        rig.controller.read = read
        time.sleep(0.3)
        return read()

    rig.controller.read = late


class TestStops:
    @patiently
    def test_a_kernel_that_is_gone_is_the_brake(self, cell: Cell) -> None:
        rig = cell.robot()
        twin = cell.follow()
        told = _told_at_stops(cell, rig)
        cell.freeze()
        # A kernel that comes back after that is told why, too.
        assert rig.until(lambda report: report.state is State.INACTIVE).on_brake
        assert "no newer tick" in rig.host.words().text and cell.block.stop_ns != NEVER
        assert told[0].on_brake
        rest = twin.brake(*twin.state(rig.ring, twin.tick))[-1]
        np.testing.assert_allclose(rig.joints_sent()[-1], rest, atol=1e-12)
        assert rig.controller.calls[-1] == "end"

    @patiently
    def test_robots_stop_together(self, cell: Cell) -> None:
        rigs = [cell.robot(), cell.robot()]
        cell.follow()
        cell.block.stop()
        for rig in rigs:
            assert not rig.until(lambda report: report.state is State.INACTIVE).on_brake
        one, other = (rig.joints_sent()[-1] for rig in rigs)
        np.testing.assert_allclose(one, other, atol=1e-9)

    @patiently
    def test_a_robot_at_rest_is_stopped_too(self, cell: Cell) -> None:
        rig = cell.robot()
        cell.follow(swings=False)
        cell.block.stop()
        rig.until(lambda report: report.state is State.INACTIVE)
        assert "stopped" in rig.host.words().text

    @patiently
    def test_a_host_that_is_closed_in_motion_brings_its_robot_to_rest(self, cell: Cell) -> None:
        rig = cell.robot()
        cell.follow()
        rig.host.close()
        sent = rig.joints_sent()
        assert cell.block.stop_ns != NEVER
        assert np.abs(sent[-1] - sent[-2]).max() < np.abs(np.diff(sent, axis=0)).max()
