"""Host of a driver: the loop that reads, plays and sends, and the states of the connection.

It runs in a process of its own, in a thread that alone calls the driver; requests of the kernel come between two
cycles. What the driver raises, a controller that is silent, readings that are no numbers and setpoints that may not go
out all end in ERROR, with the cell stopped: the robot isn't moved any more, and the others come to rest with it.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np

from virtualrobot_sdk.drivers import realtime
from virtualrobot_sdk.drivers.asked import Requests
from virtualrobot_sdk.drivers.cadence import Cadence, wait_until
from virtualrobot_sdk.drivers.driver import About, Driver, DriverFault, Mode, Pace, Reading, Safety, Words
from virtualrobot_sdk.drivers.jobs import Jobs
from virtualrobot_sdk.drivers.measured import Measured
from virtualrobot_sdk.drivers.outgoing import Outgoing
from virtualrobot_sdk.drivers.player import Play, Player
from virtualrobot_sdk.drivers.robot_side import MOST_OUTPUTS, Mapping, RobotSide, check_fits, wrong_about
from virtualrobot_sdk.drivers.shared import NEVER, CellBlock, Floats, Report, State, TickRing
from virtualrobot_sdk.errors import ArgumentError, PluginError
from virtualrobot_sdk.worker.blame import describe_error, package_of

BEGIN_SECONDS = 10.0
"""Longest time (s) for a controller to let its robot follow."""

ORPHAN_SECONDS = 10.0
"""Time (s) that the process has for its robot to come to rest when the kernel's process has gone."""

STOP_WATCH_NS = 5_000_000
"""Time (ns) between two looks at whether the cell was stopped, while a robot goes to points by itself."""

STOPPED_ON_ITS_WAY = "{} while the robot went to its points: it was stopped on its way"

STALE_NS = 1_000_000_000
"""Time (ns) for which the newest tick may be over when a robot begins; one that is older is of another time."""

REST_SPEED = 0.05
"""Measured speed (rad/s, m/s) of each joint below which a robot is at rest: what is measured is never quite still."""

REST_NS = 1_000_000_000
"""Longest time (ns) that a robot is given to be at rest after its last setpoint."""

OK = (Safety.NORMAL, Safety.REDUCED)


class Host:
    """Host of one driver; its public methods are what the kernel asks for, each answered after the cycle under way."""

    def __init__(self, driver: Driver, side: RobotSide, ring: TickRing, cell: CellBlock) -> None:
        """Host a driver that is connected to nothing yet."""
        self._driver, self._side, self._ring, self._cell = driver, side, ring, cell
        self._out = Outgoing(driver, side, self._refuse)
        self._requests, self._cadence = Requests(), Cadence()
        self._thread = threading.Thread(target=self._run, name="driver")  # no daemon: a robot that moves comes to rest
        self._over = False
        self._words, self._words_number = Words(), 0
        self._rest_ns = 0
        self._starved = False
        self.state = State.DISCONNECTED
        self._about = About(len(side.joints), 100.0)
        self._mapping: Mapping | None = None
        self._player: Player | None = None
        self._jobs: Jobs | None = None
        self._measured = Measured(len(side.joints))
        self._error = np.zeros(len(side.joints))
        self._begun_ns = 0

    def start(self) -> None:
        """Start the loop's thread."""
        self._thread.start()

    # Requests of the kernel.

    def connect(self) -> About | Words:
        """Connect to the controller; return what it is, or in its words why not. DISCONNECTED or ERROR -> INACTIVE."""
        return self._requests.ask(self._connect)

    def begin(self) -> Words:
        """Let the robot follow its twin; return why not, or words without text. INACTIVE -> BEGINNING -> ACTIVE."""
        return self._requests.ask(self._begin)

    def end(self) -> Words:
        """Let the robot, which is at rest, no longer follow: ACTIVE -> INACTIVE."""
        return self._requests.ask(self._end)

    def reset(self) -> Words:
        """Have the controller clear its fault; return why it couldn't, or words without text."""
        return self._requests.ask(self._reset)

    def set_tool(self, mass: float, center: Floats, flange_t_tcp: Floats) -> Words:
        """Tell the controller of the tool; return why it couldn't, or words without text."""
        return self._requests.ask(lambda: self._told(lambda: self._driver.set_tool(mass, center, flange_t_tcp)))

    def words(self) -> Words:
        """Return the newest words."""
        return self._words

    def where(self) -> Words:
        """Return in which of its methods the driver is just now; without text in none. The loop isn't waited for."""
        frame, found = sys._current_frames().get(self._thread.ident or 0), ""
        while frame is not None:
            if _is_method(frame, self._driver):
                found = f"it hangs in {frame.f_code.co_name} ({Path(frame.f_code.co_filename).name}:{frame.f_lineno})"
            frame = frame.f_back
        return Words(found)

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
            self._requests.do()
            if (self._over or not orphan.is_alive()) and self._may_end():
                break
            if self.state in (State.DISCONNECTED, State.ERROR):
                self._say(time.monotonic_ns())
                self._requests.do(0.05)
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
        cadence = self._cadence
        reading = cadence.read(self._driver, self._about, self._await)
        now = time.monotonic_ns()
        cadence.lateness = now - cadence.due
        self._take(reading, now)
        if self.state is State.BEGINNING:
            self._await_running(reading, now)
        if self.state in (State.BEGINNING, State.ACTIVE, State.STOPPING):
            self._move(cadence.due)
        cadence.cycles += 1
        self._say(now)

    def _await(self, ns: int) -> None:
        """Sleep until a time (ns); a robot that goes to its points is stopped meanwhile: cycles may be long."""

        def goes() -> bool:
            if self._jobs is None or self._jobs.done:
                return False
            if self._cell.stop_ns <= time.monotonic_ns():
                raise DriverFault(STOPPED_ON_ITS_WAY.format("the cell was stopped"))
            return True

        wait_until(ns, goes, STOP_WATCH_NS)

    def _take(self, reading: Reading, now: int) -> None:
        """Take a reading; raise DriverFault for one that is no number, or old, or tells of a stop."""
        assert self._mapping is not None
        measured = self._measured
        measured.take(reading, now, now - self._cadence.due, self._about, self._mapping)
        q = measured.q
        sent = self._out.sent
        played = self._jobs.nearest(q) if self._jobs is not None else sent[1] if sent is not None else q
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
        assert self._mapping is not None
        out, held = self._out, self._out.held
        if self.state is State.BEGINNING:
            if self._about.pace is not Pace.JOBS:
                self._driver.send(*self._mapping.raw(held.q, held.v), held.outputs)
            return
        player = self._player
        assert player is not None
        if self._jobs is not None:
            self._jobs.step(ns, player, self._measured.reading)
            out.sent = (ns, self._jobs.held)
        else:
            reading = self._measured.reading
            due = player.step(ns, reading.speed_scaling if reading is not None else 1.0)
            late_ns, rate = self._cadence.lateness, self._about.rate
            setpoint = held if due is None else out.passed(due, player, ns, late_ns, rate)
            out.send(setpoint, ns, self._mapping)
        self._follow(player)

    def _follow(self, player: Player) -> None:
        """Go on to STOPPING when the play clock slows or ticks are missing, and to INACTIVE when the robot rests."""
        # A brake that is shorter than a cycle is over at once.
        if player.state in (Play.STOPPING, Play.STARVED, Play.RESTS) and self.state is State.ACTIVE:
            starved = self._cell.stop_ns == NEVER
            why = "no newer tick came in time" if starved else "the cell was stopped"
            if self._jobs is not None and not self._jobs.done:
                # Its controller goes on by itself, whatever the play clock does.
                raise DriverFault(STOPPED_ON_ITS_WAY.format(why))
            if starved:
                self._stop()
            self.state = State.STOPPING
            if not self._out.refused:
                self._tell(f"{why}: the robot brakes on its path" if starved else why)
        if player.state is Play.RESTS and self._out.refused:
            raise DriverFault(self._out.refused)
        if player.state is Play.RESTS and self.state is State.STOPPING and self._stands():
            self._driver.end()
            self._let_go(State.INACTIVE)

    def _stands(self) -> bool:
        """Return whether the robot has come to rest, too, after its setpoints: a real one lags, and must get there."""
        due = self._cadence.due
        self._rest_ns = self._rest_ns or due
        still = due > self._rest_ns and float(np.abs(self._measured.v).max()) <= REST_SPEED
        return still or due - self._rest_ns > REST_NS

    def _fail(self, error: BaseException) -> None:
        """Come to ERROR: stop the cell, let the controller stop, and keep the words."""
        self._tell(*_said(error, self._driver))
        moving = self.state in (State.BEGINNING, State.ACTIVE, State.STOPPING)
        if moving:
            self._out.refused = self._words.text
            self._stop()
            with contextlib.suppress(BaseException):
                self._driver.stop()
        with contextlib.suppress(BaseException):
            self._driver.close()
        self._let_go(State.ERROR)
        self._say(time.monotonic_ns())

    def _refuse(self, why: str) -> None:
        """Tell why a setpoint is not sent, and stop the cell."""
        self._tell(why)
        self._stop()

    def _stop(self) -> None:
        """Stop the cell, once reports tell what is known of the reason: nobody else is taken for it then."""
        self._say(time.monotonic_ns())
        self._cell.stop()

    def _let_go(self, state: State) -> None:
        """Play nothing any more, in this state."""
        self._starved = self._player is not None and self._player.on_brake
        self._player = self._jobs = self._out.sent = None
        self.state = state

    def _say(self, ns: int) -> None:
        measured, cadence, player = self._measured, self._cadence, self._player
        reading = measured.reading
        self._ring.report(
            Report(
                ns=ns,
                state=self.state,
                cycles=cadence.cycles,
                skipped=cadence.skipped,
                lateness_ns=cadence.lateness,
                tick=int(player.tick) if player is not None else -1,
                on_brake=player.on_brake if player is not None else self._starved,
                mode=reading.mode if reading is not None else Mode.OFF,
                safety=reading.safety if reading is not None else Safety.NORMAL,
                inputs=reading.inputs & (2**MOST_OUTPUTS - 1) if reading is not None else 0,
                words=self._words_number,
                rate=player.rate if player is not None else 1.0,
                speed_scaling=reading.speed_scaling if reading is not None else 1.0,
                q=measured.q,
                v=measured.v,
                error=self._error,
                is_faulty=bool(self._out.refused) and self.state is not State.ERROR,
            )
        )

    # What requests do, in the loop's thread.

    def _connect(self) -> About | Words:
        if self.state not in (State.DISCONNECTED, State.ERROR):
            raise ArgumentError(f"the driver is connected already, it is {self.state.name}")
        self.state, self._measured.reading, self._out.refused = State.CONNECTING, None, ""
        self._say(time.monotonic_ns())
        try:
            about = self._driver.connect()
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
        self._measured.begin(now)
        self._cadence.due, self._cadence.cycles = now, 0
        self.state = State.INACTIVE
        return about

    def _check(self, about: About) -> None:
        if wrong := wrong_about(about) or self._lacks(about.pace):
            raise PluginError(wrong)
        check_fits(self._side, about)

    def _lacks(self, pace: Pace) -> str:
        """Return which method of its pace the driver's class has not written; empty when it has."""
        name = "run" if pace is Pace.JOBS else "send"
        lacks = getattr(type(self._driver), name) is getattr(Driver, name)
        return f"its pace is {pace.name}, and it has no method `{name}`" if lacks else ""

    def _begin(self) -> Words:
        if self.state is not State.INACTIVE:
            return self._tell(f"the driver is {self.state.name}; only from INACTIVE a robot begins to follow")
        if self._measured.reading is None:
            return self._tell("nothing was read yet; ask again in a moment")
        newest = self._cell.newest_braked
        record = self._ring.get(newest) if newest >= 0 else None
        if record is None or record.play_ns < time.monotonic_ns() - STALE_NS:
            return self._tell("the twin tells no ticks")
        off = np.abs(record.q - self._measured.q)
        if off.max() > self._side.begin_tolerance:
            joint = int(off.argmax())
            return self._tell(
                f"the twin's {self._side.names[joint]!r} is at {record.q[joint]:.6g}, and the robot's at "
                f"{self._measured.q[joint]:.6g}; they may be {self._side.begin_tolerance:g} apart"
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
        self._out.sent, self._out.refused = (now, held), ""
        self._begun_ns, self._rest_ns = now, 0
        self._cadence.due = now
        self.state = State.BEGINNING
        return Words()

    def _end(self) -> Words:
        if self.state in (State.INACTIVE, State.DISCONNECTED, State.ERROR):
            return Words()
        if np.abs(self._measured.v).max(initial=0.0) > REST_SPEED:
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
            return self._tell(*_said(error, self._driver))
        return Words()

    def _tell(self, text: str, code: str = "", clears: bool = False) -> Words:
        """Keep words on one line: what a controller says ends up in terminals, which would do what its bytes say."""
        text, code = (" ".join("".join(c if c.isprintable() else " " for c in one).split()) for one in (text, code))
        self._words, self._words_number = Words(text, code, clears), self._words_number + 1
        return self._words

    def _cell_stop_if_moving(self) -> None:
        if self.state in (State.ACTIVE, State.STOPPING, State.BEGINNING):
            self._cell.stop()


def _said(error: BaseException, driver: Driver) -> tuple[str, str, bool]:
    """Return the words of an error, its code, and whether `reset` may help."""
    name = f"the driver {type(driver).__name__}"
    if isinstance(error, DriverFault):
        return error.text or f"{name} tells a fault without words", error.code, error.clears
    if isinstance(error, PluginError):
        return f"{name}: {error}", "", False
    sys.stderr.write("".join(traceback.format_exception(error)))
    method = _method(error, driver)
    raised = f"raised in {method}" if method else "failed:"
    return f"{name} {raised} {describe_error(error, package_of(type(driver).__module__))}", "", False


def _method(error: BaseException, driver: Driver) -> str:
    """Return the method of a driver that was called and has raised; empty where none was."""
    trace = error.__traceback__
    while trace is not None:
        if _is_method(trace.tb_frame, driver):
            return trace.tb_frame.f_code.co_name
        trace = trace.tb_next
    return ""


def _is_method(frame: FrameType, driver: Driver) -> bool:
    return frame.f_code.co_argcount > 0 and frame.f_locals.get(frame.f_code.co_varnames[0]) is driver
