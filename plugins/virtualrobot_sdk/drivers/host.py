"""Host of a driver: the loop that reads, plays and sends, and the states of the connection.

It runs in a process of its own, in a thread that alone calls the driver; requests of the kernel come between two
cycles. What the driver raises, a controller that is silent, readings that are no numbers and setpoints that may not go
out all end in ERROR, with the cell stopped: the robot isn't moved any more, and the others come to rest with it.
"""

from __future__ import annotations

import contextlib
import queue
import sys
import threading
import time
import traceback
from collections.abc import Callable
from collections.abc import Mapping as Settings
from concurrent.futures import Future
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np

from virtualrobot_sdk.drivers import realtime
from virtualrobot_sdk.drivers.driver import About, Driver, DriverFault, Mode, Pace, Reading, Safety, Words, finite
from virtualrobot_sdk.drivers.jobs import Jobs
from virtualrobot_sdk.drivers.player import SLACK_SECONDS, Play, Player, Setpoint
from virtualrobot_sdk.drivers.robot_side import MOST_OUTPUTS, Gate, Mapping, RobotSide, check_fits
from virtualrobot_sdk.drivers.shared import NEVER, CellBlock, Floats, Report, State, TickRing
from virtualrobot_sdk.errors import ArgumentError, PluginError
from virtualrobot_sdk.registration import ComponentKind

SILENT_SECONDS = 0.1
"""Time (s) for which the controller's own clock may stand still; three cycles where they are longer."""

BEGIN_SECONDS = 10.0
"""Longest time (s) for a controller to let its robot follow."""

ORPHAN_SECONDS = 10.0
"""Time (s) that the process has for its robot to come to rest when the kernel's process has gone."""

STOP_WATCH_NS = 5_000_000
"""Time (ns) between two looks at whether the cell was stopped, while a robot goes to points by itself."""

STOPPED_ON_ITS_WAY = "{} while the robot went to its points: it was stopped on its way"

LATEST_NS = 20_000_000
"""Time (ns) since the setpoint before, or three longer cycles, up to which the next may go on from it."""

STALE_NS = 1_000_000_000
"""Time (ns) for which the newest tick may be over when a robot begins; one that is older is of another time."""

REST_SPEED = 0.05
"""Measured speed (rad/s, m/s) of each joint below which a robot is at rest: what is measured is never quite still."""

REST_NS = 1_000_000_000
"""Longest time (ns) that a robot is given to be at rest after its last setpoint."""

OK = (Safety.NORMAL, Safety.REDUCED)


def make_host(
    entry_point: tuple[str, str, str],
    component: str,
    settings: Settings[str, Any],
    side: RobotSide,
    ring: Path,
    cell: Path,
) -> Host:
    """Make the host of a plugin's driver, in the process of a worker; connected to nothing yet.

    Raises ArgumentError for settings that the driver refuses, and PluginError where the plugin has no such driver.
    """
    from virtualrobot_sdk.loading import load
    from virtualrobot_sdk.worker import child
    from virtualrobot_sdk.worker.host import factory_of

    child.ORPHAN_SECONDS = ORPHAN_SECONDS
    _, registrations, _ = load(EntryPoint(*entry_point))
    driver = factory_of(registrations, entry_point[0], ComponentKind.ROBOT_DRIVER, component, settings)()
    if not isinstance(driver, Driver):
        name = type(driver).__name__
        raise PluginError(f"{component!r} made a {name}; a driver is a virtualrobot_sdk.drivers.Driver")
    host = Host(driver, side, TickRing.attach(ring, len(side.joints)), CellBlock.attach(cell))
    host.start()
    return host


class Host:
    """Host of one driver; its public methods are what the kernel asks for, each answered after the cycle under way."""

    def __init__(self, driver: Driver, side: RobotSide, ring: TickRing, cell: CellBlock) -> None:
        """Host a driver that is connected to nothing yet."""
        self._driver, self._side, self._ring, self._cell = driver, side, ring, cell
        self._gate = Gate(side)
        self._requests: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="driver")  # no daemon: a robot that moves comes to rest
        self._over = False
        self._words, self._words_number = Words(), 0
        self._refused = ""
        self._rest_ns = 0
        self.state = State.DISCONNECTED
        self._about = About(len(side.joints), 100.0)
        self._mapping: Mapping | None = None
        self._player: Player | None = None
        self._jobs: Jobs | None = None
        self._reading: Reading | None = None
        self._q = self._v = self._error = np.zeros(len(side.joints))
        self._sent: tuple[int, Floats] | None = None
        self._stamp, self._stamp_ns = 0.0, 0
        self._begun_ns = 0
        self._cycles = self._skipped = self._lateness = 0
        self._due = 0

    def start(self) -> None:
        """Start the loop's thread."""
        self._thread.start()

    # Requests of the kernel.

    def connect(self) -> About | Words:
        """Connect to the controller; return what it is, or in its words why not. DISCONNECTED or ERROR -> INACTIVE."""
        return self._asked(self._connect)

    def begin(self) -> Words:
        """Let the robot follow its twin; return why not, or words without text. INACTIVE -> BEGINNING -> ACTIVE."""
        return self._asked(self._begin)

    def end(self) -> Words:
        """Let the robot, which is at rest, no longer follow: ACTIVE -> INACTIVE."""
        return self._asked(self._end)

    def reset(self) -> Words:
        """Have the controller clear its fault; return why it couldn't, or words without text."""
        return self._asked(self._reset)

    def set_tool(self, mass: float, center: Floats, flange_t_tcp: Floats) -> Words:
        """Tell the controller of the tool; return why it couldn't, or words without text."""
        return self._asked(lambda: self._told(lambda: self._driver.set_tool(mass, center, flange_t_tcp)))

    def words(self) -> Words:
        """Return the newest words."""
        return self._words

    def close(self) -> None:
        """Bring the robot to rest and end; the process ends after that."""
        self._cell_stop_if_moving()
        self._over = True
        self._thread.join(ORPHAN_SECONDS)

    # The loop.

    def _run(self) -> None:
        realtime.calm()
        orphan = threading.main_thread()
        while True:
            self._do_requests()
            if (self._over or not orphan.is_alive()) and self._may_end():
                break
            if self.state in (State.DISCONNECTED, State.ERROR):
                self._say(time.monotonic_ns())
                self._do_requests(0.05)
                continue
            try:
                self._cycle()
            except BaseException as error:
                self._fail(error)
        with contextlib.suppress(BaseException):
            self._driver.close()

    def _may_end(self) -> bool:
        """Return whether the robot isn't moved, and bring it to rest where it is."""
        if self.state not in (State.ACTIVE, State.STOPPING):
            return True
        if self._over:
            self._cell.stop()
        return self._player is not None and self._player.state is Play.WAITING

    def _cycle(self) -> None:
        """Read; play and send what is due; report."""
        period = int(1e9 / self._about.rate)
        if self._about.pace is Pace.CONTROLLER:
            reading = self._driver.read()
            ns = time.monotonic_ns()
            self._due += period
            # Packets come with the network's jitter; the robot's clock has none, and is followed slowly.
            off = ns - self._due
            self._due = ns if abs(off) > 2 * period else self._due + max(-period // 100, min(period // 100, off))
        else:
            self._due += period
            now = time.monotonic_ns()
            if self._due < now - period:
                # Cycles that are over are left out, not made up for.
                missed = (now - self._due) // period
                self._skipped += missed if self._cycles else 0
                self._due += missed * period
            self._await_due()
            reading = self._driver.read()
        now = time.monotonic_ns()
        self._lateness = now - self._due
        self._take(reading, now)
        if self.state is State.BEGINNING:
            self._await_running(reading, now)
        if self.state in (State.BEGINNING, State.ACTIVE, State.STOPPING):
            self._move(self._due)
        self._cycles += 1
        self._say(now)

    def _await_due(self) -> None:
        """Sleep until the next cycle; a robot that goes to its points is stopped meanwhile: cycles may be long."""
        while self._jobs is not None and not self._jobs.done and time.monotonic_ns() < self._due:
            if self._cell.stop_ns <= time.monotonic_ns():
                raise DriverFault(STOPPED_ON_ITS_WAY.format("the cell was stopped"))
            realtime.sleep_until(min(self._due, time.monotonic_ns() + STOP_WATCH_NS))
        realtime.sleep_until(self._due)

    def _take(self, reading: Reading, now: int) -> None:
        """Take a reading; raise DriverFault for one that is no number, or old, or tells of a stop."""
        assert self._mapping is not None
        if wrong := finite(reading, self._about.joints):
            raise DriverFault(f"the controller sent nonsense: {wrong}")
        if reading.stamp != self._stamp:
            self._stamp, self._stamp_ns = reading.stamp, now
        silent = (now - self._stamp_ns) * 1e-9
        if silent > max(SILENT_SECONDS, 3.0 / self._about.rate):
            raise DriverFault(f"the controller's own time has stood still for {silent:.2f} s; it hangs, or is gone")
        q, v = self._mapping.joints(reading)
        seconds = max((now - self._due) * 1e-9, 0.0) + 1.0 / self._about.rate
        self._v = v if v is not None else (q - self._q) / seconds if self._reading is not None else np.zeros_like(q)
        self._q, self._reading = q, reading
        played = self._jobs.nearest(q) if self._jobs is not None else self._sent[1] if self._sent is not None else q
        self._error = q - played
        if self.state in (State.ACTIVE, State.STOPPING):
            if reading.safety not in OK:
                raise DriverFault(reading.text or f"the controller's safety system says {reading.safety.value}")
            if reading.mode is not Mode.RUNNING:
                raise DriverFault(
                    f"the controller no longer lets the robot follow, it is {reading.mode.value}"
                    + (f": {reading.text}" if reading.text else "")
                )

    def _await_running(self, reading: Reading, now: int) -> None:
        if reading.mode is Mode.RUNNING and reading.safety in OK:
            self.state = State.ACTIVE
        elif now - self._begun_ns > BEGIN_SECONDS * 1e9:
            raise DriverFault(
                f"the controller does not let the robot follow after {BEGIN_SECONDS:g} s: it is {reading.mode.value}, "
                f"its safety {reading.safety.value}" + (f": {reading.text}" if reading.text else "")
            )

    def _move(self, ns: int) -> None:
        """Send what is due: the place where it was held until the controller runs, then what the twin did."""
        assert self._mapping is not None and self._sent is not None
        held = Setpoint(self._sent[1], np.zeros_like(self._q), 0)
        if self.state is State.BEGINNING:
            if self._about.pace is not Pace.JOBS:
                self._send(held)
            return
        player = self._player
        assert player is not None
        if self._jobs is not None:
            self._jobs.step(ns, player, self._reading)
            self._sent = (ns, self._jobs.held)
        else:
            due = player.step(ns, self._reading.speed_scaling if self._reading is not None else 1.0)
            setpoint = held if due is None else self._passed(due, player, ns)
            self._sent = (ns, setpoint.q)
            self._send(setpoint)
        self._follow(player)

    def _send(self, setpoint: Setpoint) -> None:
        assert self._mapping is not None
        self._driver.send(*self._mapping.raw(setpoint.q, setpoint.v), setpoint.outputs)

    def _passed(self, setpoint: Setpoint, player: Player, ns: int) -> Setpoint:
        """Return a setpoint that may go out, or the brake's from the one before; raise DriverFault for neither."""
        assert self._sent is not None
        before_ns, before = self._sent
        # However late this is: who was silent for longer must not go on as if nothing had been.
        longest = max(LATEST_NS, round(3e9 / self._about.rate))
        seconds = min(ns - before_ns, longest) * 1e-9
        fault = self._gate.fault(setpoint.q, before, seconds)
        if not fault and player.late:
            fault = f"the controller goes slower than it was told, and is over {SLACK_SECONDS:g} s late"
        if fault and not self._refused:
            self._refused = f"{fault}; it was not sent, and the robot braked before it"
            braked = player.halt()
            self._cell.stop()
            braking = player.step(ns) if braked else None
            if braking is None or (fault := self._gate.fault(braking.q, before, seconds)):
                raise DriverFault(f"{fault}; nothing was sent")
            return braking
        if fault and not player.late:
            raise DriverFault(f"{fault}; nothing was sent")
        return setpoint

    def _follow(self, player: Player) -> None:
        """Go on to STOPPING when the play clock slows or ticks are missing, and to INACTIVE when the robot rests."""
        # A brake that is shorter than a cycle is over at once.
        if player.state in (Play.STOPPING, Play.STARVED, Play.RESTS) and self.state is State.ACTIVE:
            starved = self._cell.stop_ns == NEVER
            self._cell.stop()
            why = "no newer tick came in time" if starved else "the cell was stopped"
            if self._jobs is not None and not self._jobs.done:
                # Its controller goes on by itself, whatever the play clock does.
                raise DriverFault(STOPPED_ON_ITS_WAY.format(why))
            self.state = State.STOPPING
            self._tell(self._refused or (f"{why}: the robot brakes on its path" if starved else why))
        if player.state is Play.RESTS and self._refused:
            raise DriverFault(self._refused)
        if player.state is Play.RESTS and self.state is State.STOPPING and self._stands():
            self._driver.end()
            self._let_go(State.INACTIVE)

    def _stands(self) -> bool:
        """Return whether the robot has come to rest, too, after its setpoints: a real one lags, and must get there."""
        self._rest_ns = self._rest_ns or self._due
        still = self._due > self._rest_ns and float(np.abs(self._v).max()) <= REST_SPEED
        return still or self._due - self._rest_ns > REST_NS

    def _fail(self, error: BaseException) -> None:
        """Come to ERROR: stop the cell, let the controller stop, and keep the words."""
        moving = self.state in (State.BEGINNING, State.ACTIVE, State.STOPPING)
        if moving:
            self._cell.stop()
            with contextlib.suppress(BaseException):
                self._driver.stop()
        with contextlib.suppress(BaseException):
            self._driver.close()
        self._let_go(State.ERROR)
        self._tell(*_said(error))
        self._say(time.monotonic_ns())

    def _let_go(self, state: State) -> None:
        """Play nothing any more, in this state."""
        self._player = self._jobs = self._sent = None
        self.state = state

    def _say(self, ns: int) -> None:
        reading, player = self._reading, self._player
        self._ring.report(
            Report(
                ns=ns,
                state=self.state,
                cycles=self._cycles,
                skipped=self._skipped,
                lateness_ns=self._lateness,
                tick=int(player.tick) if player is not None else -1,
                on_brake=player is not None and player.on_brake,
                mode=reading.mode if reading is not None else Mode.OFF,
                safety=reading.safety if reading is not None else Safety.NORMAL,
                inputs=reading.inputs & (2**MOST_OUTPUTS - 1) if reading is not None else 0,
                words=self._words_number,
                rate=player.rate if player is not None else 1.0,
                speed_scaling=reading.speed_scaling if reading is not None else 1.0,
                q=self._q,
                v=self._v,
                error=self._error,
                is_faulty=bool(self._refused) and self.state is not State.ERROR,
            )
        )

    # What requests do, in the loop's thread.

    def _connect(self) -> About | Words:
        if self.state not in (State.DISCONNECTED, State.ERROR):
            raise ArgumentError(f"the driver is connected already, it is {self.state.name}")
        self.state, self._reading, self._refused = State.CONNECTING, None, ""
        self._say(time.monotonic_ns())
        try:
            about = self._driver.connect()
            if not isinstance(about, About):
                raise PluginError(f"`connect` returned {about!r}; it must return an About")
            self._check(about)
            self._mapping, self._about = Mapping(self._side, about), about
        except ArgumentError:
            self.state = State.DISCONNECTED
            self._driver.close()
            raise
        except BaseException as error:
            self._fail(error)
            return self._words
        now = time.monotonic_ns()
        self._due, self._stamp, self._stamp_ns, self._cycles = now, float("nan"), now, 0
        self.state = State.INACTIVE
        return about

    def _check(self, about: About) -> None:
        if not (0.1 <= about.rate <= 10_000.0 and 0 <= min(about.inputs, about.outputs)):
            raise PluginError(f"the driver says {about}; rates are 0.1 to 10,000 Hz, and no number is below 0")
        if max(about.inputs, about.outputs) > MOST_OUTPUTS:
            raise PluginError(f"the driver says {about}; inputs and outputs are at most {MOST_OUTPUTS}")
        check_fits(self._side, about)

    def _begin(self) -> Words:
        if self.state is not State.INACTIVE:
            return self._tell(f"the driver is {self.state.name}; only from INACTIVE a robot begins to follow")
        if self._reading is None:
            return self._tell("nothing was read yet; ask again in a moment")
        newest = self._cell.newest_braked
        record = self._ring.get(newest) if newest >= 0 else None
        if record is None or record.play_ns < time.monotonic_ns() - STALE_NS:
            return self._tell("the twin tells no ticks")
        off = np.abs(record.q - self._q)
        if off.max() > self._side.begin_tolerance:
            joint = int(off.argmax())
            return self._tell(
                f"the twin's {self._side.names[joint]!r} is at {record.q[joint]:.6g}, and the robot's at "
                f"{self._q[joint]:.6g}; they may be {self._side.begin_tolerance:g} apart"
            )
        held = record.q
        try:
            assert self._mapping is not None
            self._driver.begin(self._mapping.raw(held, np.zeros_like(held))[0])
        except BaseException as error:
            self._fail(error)
            return self._words
        now = time.monotonic_ns()
        self._player = Player(self._ring, self._cell, self._side.tick_ns)
        if self._about.pace is Pace.JOBS:
            self._jobs = Jobs(self._driver, self._mapping, self._side, held)
        self._sent, self._begun_ns, self._due, self._refused, self._rest_ns = (now, held), now, now, "", 0
        self.state = State.BEGINNING
        return Words()

    def _end(self) -> Words:
        if self.state in (State.INACTIVE, State.DISCONNECTED, State.ERROR):
            return Words()
        if np.abs(self._v).max(initial=0.0) > REST_SPEED:
            return self._tell("the robot moves; stop its twin first")
        try:
            self._driver.end()
        except BaseException as error:
            self._fail(error)
            return self._words
        self._let_go(State.INACTIVE)
        return Words()

    def _reset(self) -> Words:
        """Have the controller clear its fault; one that ended the connection has it open for that alone."""
        if self.state is not State.ERROR:
            return self._told(self._driver.reset)

        def connected() -> None:
            self._driver.connect()
            self._driver.reset()

        try:
            return self._told(connected)
        finally:
            with contextlib.suppress(BaseException):
                self._driver.close()

    def _told(self, work: Callable[[], None]) -> Words:
        try:
            work()
        except BaseException as error:
            return self._tell(*_said(error))
        return Words()

    def _tell(self, text: str, code: str = "", clears: bool = False) -> Words:
        self._words, self._words_number = Words(text, code, clears), self._words_number + 1
        return self._words

    def _cell_stop_if_moving(self) -> None:
        if self.state in (State.ACTIVE, State.STOPPING, State.BEGINNING):
            self._cell.stop()

    def _asked(self, work: Callable[[], Any]) -> Any:  # noqa: ANN401 what the work returns
        """Have the loop's thread do some work; return what it returns."""
        done: Future[Any] = Future()
        self._requests.put((work, done))
        return done.result()

    def _do_requests(self, seconds: float = 0.0) -> None:
        while True:
            try:
                work, done = self._requests.get(timeout=seconds) if seconds else self._requests.get_nowait()
            except queue.Empty:
                return
            seconds = 0.0
            try:
                done.set_result(work())
            except BaseException as error:
                done.set_exception(error)


def _said(error: BaseException) -> tuple[str, str, bool]:
    """Return the words of an error, its code, and whether `reset` may help."""
    if isinstance(error, DriverFault):
        return error.text, error.code, error.clears
    sys.stderr.write("".join(traceback.format_exception(error)))
    return f"the driver raised {type(error).__name__}: {error}", "", False
