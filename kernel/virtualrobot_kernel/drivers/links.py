"""Links of all robots: who is connected, what is played, and what stops it.

The world thread writes each tick into the rings and, before each tick, looks at what came back; whatever takes its time
(to connect, begin, end) is done by the threads of those who ask, one robot at a time.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import numpy as np
from virtualrobot_sdk.drivers import DriverFault, Words
from virtualrobot_sdk.drivers.host import REST_SPEED
from virtualrobot_sdk.drivers.shared import NEVER, CellBlock, Report, State, TickRing

from virtualrobot_kernel.drivers.admission import check
from virtualrobot_kernel.drivers.conditions import check_conditions, name_of, refused
from virtualrobot_kernel.drivers.far_side import Process, Site
from virtualrobot_kernel.drivers.link import Link, LinkMode, Status
from virtualrobot_kernel.drivers.signals import bits_of, commands_for, inputs_changed, removals
from virtualrobot_kernel.drivers.twin import AT_REST, Asked, Floats, twin_of
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.inputs.mailbox import Mailbox
from virtualrobot_kernel.world.braking import braking_of, going
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.commands import Command, SetJointPositions, SetMeasuredJoints, StopRobots
from virtualrobot_kernel.world.past_world import PastWorld, is_past
from virtualrobot_kernel.world.state import Cancellation, EndCause, Signal, Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.tick_inputs import TickInput

REST_SECONDS = 10.0
"""Longest time (s) that a robot is given to come to rest before its driver is ended all the same."""

BEGIN_SECONDS = 12.0
"""Longest time (s) that a controller is given to let its robot follow; its host gives up before."""

READING_SECONDS = 10.0
"""Longest time (s) for the first reading of a controller that has been connected to."""

FAULT_SECONDS = 0.05
"""Time (s) for which it is waited whether a cell that was stopped by nobody known was stopped by a host's fault."""

LOOK_SECONDS = 0.01
"""Period (s) at which it is looked whether a robot is at rest."""

NOTE_SECONDS = 1.0
"""Period (s) of simulation time at which the journal is told what was played."""

UNWATCHED = (State.ERROR, State.CONNECTING, State.DISCONNECTED)
"""States in which a link has no fault that is new."""

log = logging.getLogger(__name__)


class Links:
    """Links by robot, a supervisor of the world (`world/supervisor.py`) while there are any.

    `site` makes the far side; `leased` tells whether somebody has leased a robot (a uid).
    """

    author = "drivers"

    def __init__(
        self, world: World, mailbox: Mailbox, forward: Forward, site: Site, leased: Callable[[int], bool]
    ) -> None:
        """Begin with none."""
        self._world, self._mailbox, self._forward, self._site, self._leased = world, mailbox, forward, site, leased
        self._links: Mapping[int, Link] = {}
        self._changing = threading.RLock()
        self._busy: dict[int, threading.Lock] = {}
        self._cell: CellBlock | None = None
        self._end_listening: Callable[[], None] = lambda: None
        self._reason = ""
        self._stopped_ns = 0
        self._signals: Mapping[str, Signal] | None = None
        self._holding: frozenset[int] = frozenset()
        self._workers = ThreadPoolExecutor(4, thread_name_prefix="drivers")
        self._closed = False

    # Those who ask, in threads of their own.

    @property
    def stopped(self) -> str:
        """Reason for which the cell is stopped; empty: it is not."""
        return (self._reason or "stopped from outside the kernel") if self._is_stopped else ""

    @property
    def _is_stopped(self) -> bool:
        cell = self._cell
        return cell is not None and cell.stop_ns != NEVER

    @property
    def stopper(self) -> tuple[str, str]:
        """Address and key of the stopper; empty while no driver is connected."""
        return self._site.stopper if self._links else ("", "")

    def statuses(self, snapshot: Snapshot) -> list[Status]:
        """Return all links as they are, by the names of their robots."""
        nodes = snapshot.structure.nodes
        found = [Status(nodes[uid].name, link, link.newest()) for uid, link in self._links.items() if uid in nodes]
        return sorted(found, key=lambda status: status.robot)

    def measured(self, snapshot: Snapshot) -> dict[int, Floats]:
        """Return where real robots are that the world doesn't have there: all coordinates (nq,) by the robot's uid.

        Of one that is monitored the world has the readings itself; of one in ERROR nobody knows any more.
        """
        found = {}
        for uid, link in self._links.items():
            report = link.newest()
            if link.mode is LinkMode.MONITOR or link.state is State.ERROR or report is None or not report.cycles:
                continue
            if uid in snapshot.structure.robots and np.isfinite(report.q).all():
                q = snapshot.state.q.copy()
                q[link.places(snapshot.structure)[0]] = report.q
                found[uid] = q[snapshot.structure.robots[uid].q_slice]
        return found

    def status(self, robot: str) -> Status:
        """Return the link of a robot; raise KernelError (WRONG_STATE) when it has none."""
        snapshot = self._world.snapshot
        node, _ = snapshot.structure.robot(robot)
        link = self._links.get(node.uid)
        if link is None:
            raise KernelError(
                f"no driver is connected to {robot!r}; connect one first", reason=Reason.WRONG_STATE, robot=robot
            )
        return Status(node.name, link, link.newest())

    def connect(self, robot: str, asked: Asked) -> Status:
        """Start a driver and connect it; see ConnectDriver in the contract."""
        snapshot = self._world.snapshot
        if isinstance(self._world, PastWorld):
            raise is_past()
        twin = twin_of(snapshot.structure, robot, asked.joints)
        with self._alone(twin.uid, robot):
            link = self._links.get(twin.uid)
            if link is not None and link.state is not State.ERROR:
                raise KernelError(
                    f"the driver {link.asked.component!r} is connected to {robot!r} already; disconnect it first",
                    reason=Reason.WRONG_STATE,
                    robot=robot,
                    component=link.asked.component,
                )
            signals: tuple[str, ...] = ()
            if link is not None:
                signals = link.signals
                self._forget(link)
            self._open()
            process, ring = self._site.connection(twin, asked, round(snapshot.tick_seconds * 1e9))
            try:
                about = process.connect()
                _await_reading(process, ring)
                signals += self._create_signals(robot, about.inputs, about.outputs)
            except BaseException as error:
                process.close()
                ring.close()
                self._remove_signals(twin.uid, signals)
                self._rest_if_none()
                raise told(error, robot) from error
            with self._changing:
                self._links = {**self._links, twin.uid: Link(twin, asked, process, ring, about, signals)}
            return self.status(robot)

    def disconnect(self, robot: str) -> Status:
        """Bring a robot to rest, and end its driver."""
        status = self.status(robot)
        with self._alone(status.link.twin.uid, robot):
            self._leave(status.link, "its driver is disconnected")
            last = self.status(robot)
            self._forget(status.link)
            self._remove_signals(status.link.twin.uid, status.link.signals)
            status.link.state, status.link.mode = State.DISCONNECTED, LinkMode.SIMULATED
            return last

    def set_mode(self, robot: str, mode: LinkMode) -> tuple[Status, Floats | None]:
        """Choose how a robot and its twin go together; return the link, and how far the twin was put, (k,) or None."""
        link = self.status(robot).link
        with self._alone(link.twin.uid, robot):
            if link.state is State.ERROR:
                raise refused(robot, "state", f"its connection is in ERROR ({link.words.text}); reset or connect it")
            if mode is link.mode:
                return self.status(robot), None
            self._leave(link, f"its mode becomes {mode.name}")
            moved = self._execute(robot, link) if mode is LinkMode.EXECUTE else None
            if mode is LinkMode.MONITOR:
                self._report(robot, link)
                link.mode = LinkMode.MONITOR
            return self.status(robot), moved

    def reset(self, robot: str) -> Status:
        """Clear the fault at a controller, where that may help, and connect again."""
        status = self.status(robot)
        link = status.link
        with self._alone(link.twin.uid, robot):
            if link.state is not State.ERROR:
                raise refused(robot, "state", f"its connection is {link.state.name}, and there is no fault to clear")
            if link.words.text and not link.words.clears:
                raise KernelError(
                    f"a reset does not help: {link.words.text}; what it says is to be mended at the controller, then "
                    "connect the driver again",
                    reason=Reason.DRIVER_FAULT,
                    robot=robot,
                    code=link.words.code,
                    clears=False,
                )
            try:
                link.process.reset()
                link.about = link.process.connect()
                _await_reading(link.process, link.ring)
            except DriverFault as error:
                link.words = error.words
                raise told(error, robot) from error
            link.forget_faults()
            link.state = State.INACTIVE
            return self.status(robot)

    def stop_cell(self, reason: str) -> None:
        """Bring all robots to rest together; nothing waits for anything."""
        cell = self._cell
        if cell is not None:
            self._reason = reason or "stopped"
            cell.stop()

    def release_cell(self) -> None:
        """End a stop; raise KernelError (WRONG_STATE) while a robot is not at rest."""
        with self._changing:
            for status in self.statuses(self._world.snapshot):
                if status.link.is_played:
                    raise refused(status.robot, "rest", "it is not at rest yet")
            if self._cell is not None:
                self._reason, self._stopped_ns = "", 0
                self._cell.release()

    def close(self) -> None:
        """Stop all robots and end all drivers."""
        self._closed = True
        if any(link.is_played for link in self._links.values()):
            self.stop_cell("the kernel is ending")
        self._world.unsupervise(self)
        self._end_listening()
        self._await_listeners()
        for link in self._links.values():
            with suppress(DriverFault, OSError):
                link.process.close()
                link.ring.close()
        self._workers.shutdown(wait=False, cancel_futures=True)
        self._site.close()

    def is_executing(self, robots: Iterable[int]) -> bool:
        """Return whether one of some robots (uids) is played by a real one."""
        links = self._links
        return any(uid in links and links[uid].is_played for uid in robots)

    # The supervisor, in the world thread.

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Refuse what would put a twin elsewhere that its robot follows."""
        played = [uid for uid, link in self._links.items() if link.is_played and uid in before.structure.robots]
        if played:
            cell = self._cell
            may_begin = cell is not None and cell.stop_ns == NEVER
            ready = [uid for uid in played if may_begin and self._links[uid].state is State.ACTIVE]
            check(before, after, batch, played, ready)

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Stop the twins of robots that do not follow any more, and of all others that move with them."""
        now_ns, cell = time.monotonic_ns(), self._cell
        if cell is None:
            return ()
        played: list[Link] = []
        failed: list[tuple[Link, Words]] = []
        awaits, stopped = False, cell.stop_ns != NEVER
        for link in self._links.values():
            is_played = link.is_played
            words = self._look_at(link, now_ns, stopped)
            if is_played:
                played.append(link)
                awaits = awaits or link.awaits_words
                if words is not None:
                    failed.append((link, words))
        if not played or (awaits and not failed):
            return ()
        if failed:
            name = name_of(now, failed[0][0])
            cause, why = EndCause.DRIVER, f"the real robot of {name!r} has stopped: {failed[0][1].text}"
            if cell.stop_ns == NEVER:
                self._reason = why
                cell.stop()
        elif cell.stop_ns != NEVER:
            cause, why = EndCause.CELL_STOPPED, self.stopped
            if not self._reason and (late := self._late(played, now_ns)):
                cause, why = EndCause.DRIVER, late
                self._reason = why
            elif not self._reason:
                # A host that meets a fault stops the cell before it can say so.
                self._stopped_ns = self._stopped_ns or now_ns
                if now_ns - self._stopped_ns < FAULT_SECONDS * 1e9:
                    return ()
        else:
            return self._stop_unleased(played, now)
        for link in played:
            if link.state is State.ACTIVE:
                link.words = link.words if link.words.text else Words(why)
                link.state = State.STOPPING
                self._later(link)
        return _stop(played, now, cause, why)

    def _late(self, played: Sequence[Link], now_ns: int) -> str:
        """Return that robots have braked because no newer tick came, in words; empty where that was not so."""
        late = (now_ns - self._world.due_nanoseconds) * 1e-9
        if any(_is_starved(link) for link in played) or late > min(link.asked.lead for link in played):
            return f"the newest tick was {late:.2f} s old, older than the lead: the real robots brake on their paths"
        return ""

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Want nothing."""
        return ()

    def _look_at(self, link: Link, now_ns: int, stopped: bool) -> Words | None:
        """Return the new fault of a link, which is in ERROR from then on."""
        if link.state in UNWATCHED:
            return None
        awaited = link.awaits_words
        words = link.fault(now_ns, stopped)
        if link.awaits_words and not awaited and not self._closed:
            self._workers.submit(self._ask_words, link)
        if words is None:
            return None
        link.words, link.state = words, State.ERROR
        self._later(link)
        return words

    def _ask_words(self, link: Link) -> None:
        with suppress(DriverFault, KernelError):
            link.told = link.process.words()

    def _stop_unleased(self, played: Sequence[Link], now: Snapshot) -> Sequence[Command]:
        """Stop robots that nobody has leased any more."""
        free = [link for link in played if link.state is State.ACTIVE and not self._leased(link.twin.uid)]
        for link in free:
            link.words, link.state = Words("nobody has leased the robot any more"), State.STOPPING
            self._later(link)
        return _stop(free, now, EndCause.LEASE_EXPIRED, "nobody has leased the robot any more") if free else ()

    def ticked(self, now: Snapshot) -> None:
        """Write a tick into the rings, and take what was measured for the next one."""
        cell, links = self._cell, self._links
        if cell is None:
            return
        played = [link for link in links.values() if link.is_played or link.mode is LinkMode.EXECUTE]
        if played:
            brake = self._brake(now, {link.twin.uid for link in played})
            due = self._world.due_nanoseconds
            kept = [link.write(now, due + link.lead_ns, brake) for link in played]
            cell.complete(now.state.tick, all(kept))
        signals_changed = now.state.signals is not self._signals
        self._signals = now.state.signals
        for link in links.values():
            if link.about.outputs and signals_changed:
                link.outputs = bits_of(now, link.twin.uid, link.about.outputs)
            if link.mode is LinkMode.MONITOR or link.about.inputs:
                self._read(now, link)
        for link in played:
            self._watch(now, link)

    def _brake(self, now: Snapshot, robots: set[int]) -> Floats | None:
        """Return the coordinates (m, nq) of some robots, a tick apart, if all braked now; None: it takes too long."""
        if not now.state.motions:
            return now.state.q[None]
        way = braking_of(robots, now.structure, now.state, now.tick_seconds, self._forward)
        return way.positions if way.ends else None

    def _read(self, now: Snapshot, link: Link) -> None:
        report = link.report
        if report is None or link.twin.uid not in now.structure.robots:
            return
        bits, signals = link.inputs_known
        if link.about.inputs and (report.inputs != bits or now.state.signals is not signals):
            if changed := inputs_changed(now, link.twin.uid, link.about.inputs, report.inputs):
                self._world.submit(changed, self._author(now, link))
            else:
                link.inputs_known = report.inputs, now.state.signals
        if link.mode is not LinkMode.MONITOR or link.state is not State.INACTIVE:
            return
        at_q, at_v = link.places(now.structure)
        robot = now.structure.robots[link.twin.uid]
        q, v = now.state.q.copy(), np.zeros_like(now.state.v)
        q[at_q], v[at_v] = report.q, report.v
        command = SetMeasuredJoints(link.twin.uid, q[robot.q_slice], v[robot.v_slice])

        def refused_input(error: KernelError) -> None:
            if link.mode is LinkMode.MONITOR:
                log.warning("a reading of %s was refused: %s", name_of(now, link), error)

        def permit(*_: object) -> None:
            if link.mode is not LinkMode.MONITOR:
                raise KernelError("it is not monitored any more")

        with suppress(KernelError):  # too many others wait: the next tick has a newer one
            self._mailbox.put(link.twin.uid, TickInput(command, self._author(now, link), refused_input, permit))

    def _watch(self, now: Snapshot, link: Link) -> None:
        """Keep what a robot plays, and tell the journal now and then."""
        if (played := link.played) is None:
            return
        played.twin_at(now.state)
        if link.report is not None and link.is_played:
            played.reached(link.report.tick)
        if link.state is State.ACTIVE and played.waiting * now.tick_seconds >= NOTE_SECONDS:
            self._note(now, link)

    def _note(self, now: Snapshot, link: Link) -> None:
        """Tell the journal what was played since it was told last."""
        if link.played is not None and (ranges := link.played.take()):
            self._world.submit(ranges, self._author(now, link))

    def _author(self, now: Snapshot, link: Link) -> str:
        return f"driver {link.asked.component} of {name_of(now, link)}"

    # What takes its time.

    def _execute(self, robot: str, link: Link) -> Floats | None:
        """Let a robot do what its twin does; see SetDriverMode in the contract."""
        self._hold_clock(link, True)
        try:
            report = self._report(robot, link)
            self._check_conditions(robot, link, report)
            moved = self._put_twin(robot, link, report)
            link.state = State.BEGINNING
            link.begin_anew(self._world.snapshot.state.tick)
            self._await_tick()
            self._check_conditions(robot, link, self._report(robot, link))
            link.mode = LinkMode.EXECUTE
            try:
                link.process.begin()
                self._await_active(link)
            except DriverFault as error:
                if link.state is State.BEGINNING:
                    report = link.newest()
                    in_error = report is None or report.state is State.ERROR
                    link.words, link.state = error.words, State.ERROR if in_error else State.INACTIVE
                raise told(error, robot) from error
            return moved
        except BaseException:
            link.mode = LinkMode.SIMULATED
            if link.state is State.BEGINNING:
                link.state = State.INACTIVE
            self._hold_clock(link, False)
            raise

    def _await_active(self, link: Link) -> None:
        """Wait until a robot follows; raise DriverFault with the words where it does not."""
        until = time.monotonic() + BEGIN_SECONDS
        while link.state is State.BEGINNING:
            report = link.newest()
            if report is not None and report.state is State.ACTIVE:
                link.state = State.ACTIVE
                return
            if report is not None and report.state is State.INACTIVE and self.stopped:
                link.state = State.INACTIVE
                raise DriverFault(f"the cell was stopped as it began: {self.stopped}")
            if time.monotonic() > until or self._closed:
                raise DriverFault(f"the controller does not let the robot follow after {BEGIN_SECONDS:g} s")
            time.sleep(0.002)
        raise DriverFault(link.words.text, link.words.code, link.words.clears)

    def _check_conditions(self, robot: str, link: Link, report: Report) -> None:
        """Raise KernelError (WRONG_STATE) that names the first condition of EXECUTE that does not hold."""
        played = [one for one in self._links.values() if one is not link and one.is_played]
        leased = self._leased(link.twin.uid)
        check_conditions(self._world.snapshot, self._world.clock, robot, link, report, played, self.stopped, leased)

    def _put_twin(self, robot: str, link: Link, report: Report) -> Floats | None:
        """Put a twin to where its robot stands; return how far that was, (k,), None where it stands there."""
        now = self._world.snapshot
        at_q, _ = link.places(now.structure)
        away = report.q - now.state.q[at_q]
        if np.abs(away).max() <= AT_REST / 10.0:
            return None
        goal = np.clip(report.q, link.twin.lower, link.twin.upper)
        positions = dict(zip(link.twin.names, goal.tolist(), strict=True))
        self._world.submit([SetJointPositions(robot, positions)], self._author(now, link)).result()
        return away

    def _leave(self, link: Link, why: str) -> None:
        """Bring a robot to rest that is played, or let its twin be measured no more; then it is INACTIVE."""
        now, uid = self._world.snapshot, link.twin.uid
        if link.state is State.ACTIVE:
            link.state = State.STOPPING
            stop = StopRobots((uid,), Cancellation(EndCause.STOP, why))
            self._world.submit([stop], self._author(now, link)).result()
        if link.state is State.STOPPING:
            self._settle(link)
        was, link.mode = link.mode, LinkMode.SIMULATED
        if was is LinkMode.MONITOR:
            self._measure_no_more(link)

    def _measure_no_more(self, link: Link) -> None:
        """Let a twin's joints be commanded again, from where they were measured; refused while it moves."""
        now = self._world.snapshot
        if link.twin.uid in now.state.commanded:
            self._world.submit([SetMeasuredJoints(link.twin.uid, None)], self._author(now, link)).result()

    def _later(self, link: Link) -> None:
        """Have a robot that stops come to rest, and its driver end, in a thread of its own."""
        if not self._closed:
            self._workers.submit(self._settle, link)

    def _settle(self, link: Link) -> None:
        """Wait until a robot and its twin are at rest, then end what is played; the words stay."""
        with link.settling:
            self._settled(link)

    def _settled(self, link: Link) -> None:
        try:
            until = time.monotonic() + REST_SECONDS
            while not self._closed and time.monotonic() < until and not self._rests(link):
                time.sleep(LOOK_SECONDS)
            if link.played is not None and (last := link.newest()) is not None:
                link.played.reached(last.tick)
            self._note(self._world.snapshot, link)
            if link.state is State.ERROR and link.is_silent:
                try:
                    link.process.words()  # where it has died, its fault says how
                finally:
                    link.process.kill()  # where it hangs, the controller's own watchdog acts
            if link.state is State.STOPPING:
                link.process.end()
                link.state = State.INACTIVE
        except DriverFault as error:
            link.words, link.state = error.words, State.ERROR
            if link.mode is LinkMode.MONITOR:
                link.mode = LinkMode.SIMULATED
                self._measure_no_more(link)
        except KernelError as error:
            log.warning("%s", error)
        except Exception:
            log.exception("a driver could not be ended")
            link.words, link.state = Words("the driver could not be ended; the log tells why"), State.ERROR
        finally:
            link.mode = LinkMode.SIMULATED
            self._hold_clock(link, False)

    def _rests(self, link: Link) -> bool:
        """Return whether neither a twin nor its robot moves any more."""
        now = self._world.snapshot
        if any(link.twin.uid in motion.robots for motion in now.state.motions):
            return False
        report = link.newest()
        if link.state is State.ERROR or report is None or report.state is not State.ACTIVE:
            return report is None or report.state is not State.STOPPING
        at_q, _ = link.places(now.structure)
        there = bool(np.abs(report.q - now.state.q[at_q]).max() <= link.asked.following_warning)
        return there and bool(np.abs(report.v).max() <= REST_SPEED)

    def _hold_clock(self, link: Link, holds: bool) -> None:
        """Refuse that the clock changes while any robot is played, and keep up with it as far as their leads reach."""
        with self._changing:
            uid = link.twin.uid
            self._holding = self._holding | {uid} if holds else self._holding - {uid}
            leads = [one.asked.lead for one in self._links.values() if one.twin.uid in self._holding]
            held = self._world.hold_clock("a real robot is played by this clock" if leads else "")
            self._world.catch_up(max(leads, default=0.0))
        if holds:
            held.result()

    def _report(self, robot: str, link: Link) -> Report:
        """Return the newest report; raise KernelError (DRIVER_FAULT) where there is none, or it is no number."""
        report = link.newest()
        if report is None or not np.isfinite(report.q).all():
            said = f"the controller of {robot!r} has not told where its joints are"
            raise KernelError(said, reason=Reason.DRIVER_FAULT, robot=robot)
        return report

    def _await_tick(self) -> None:
        """Wait for two ticks: what was decided before them is in the rings then."""
        first = self._world.snapshot.state.tick
        until = time.monotonic() + REST_SECONDS
        while self._world.snapshot.state.tick < first + 2 and time.monotonic() < until and not self._closed:
            if self._world.clock.mode is not Mode.REALTIME:
                return
            time.sleep(0.001)

    def _await_listeners(self) -> None:
        """Wait until the world thread looks at no link any more that is gone."""
        with suppress(KernelError, TimeoutError):  # the world has ended
            self._world.between_ticks().result(REST_SECONDS)

    def _create_signals(self, robot: str, inputs: int, outputs: int) -> tuple[str, ...]:
        """Make the signals of a controller that are not there yet; return their names."""
        if commands := commands_for(self._world.snapshot, robot, inputs, outputs):
            self._world.submit(commands, f"driver of {robot}").result()
        return tuple(command.signal.name for command in commands)

    def _remove_signals(self, uid: int, names: Sequence[str]) -> None:
        """Take away signals that were made for a controller which is gone."""
        try:
            if commands := removals(self._world.snapshot, uid, names):
                self._world.submit(commands, "drivers").result()
        except KernelError as error:  # a program that names one has just begun
            log.warning("signals of a driver that is gone stay: %s", error)

    def _open(self) -> None:
        """Have a cell, and the world supervised and listened to from now on."""
        with self._changing:
            if self._closed:
                raise KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)
            if self._cell is None:
                self._cell = self._site.cell()
                self._world.supervise(self)
                self._end_listening = self._world.listen_ticks(self.ticked)

    def _forget(self, link: Link) -> None:
        """End a driver and forget its link."""
        with self._changing:
            self._links = {uid: one for uid, one in self._links.items() if one is not link}
        self._await_listeners()
        link.process.close()
        link.ring.close()
        self._rest_if_none()

    def _rest_if_none(self) -> None:
        """Ask nothing more of the world where no robot is connected, unless the cell is stopped."""
        with self._changing:
            if not self._links and self._cell is not None and self._cell.stop_ns == NEVER:
                self._world.unsupervise(self)
                self._end_listening()
                self._cell = None

    def _alone(self, uid: int, robot: str) -> _Alone:
        """Return a context in which nobody else changes a robot's link; raise KernelError where somebody does."""
        with self._changing:
            return _Alone(self._busy.setdefault(uid, threading.Lock()), robot)


class _Alone:
    """Lock that is had at once or not at all."""

    def __init__(self, lock: threading.Lock, robot: str) -> None:
        self._lock, self._robot = lock, robot

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise refused(self._robot, "driver", "another call changes its driver now; wait for its answer")

    def __exit__(self, *_: object) -> None:
        self._lock.release()


def told(error: BaseException, robot: str) -> BaseException:
    """Return the error that tells of a driver's fault in its own words; any other as it is."""
    if not isinstance(error, DriverFault):
        return error
    said = f"the driver of {robot!r}: {error}"
    return KernelError(said, reason=Reason.DRIVER_FAULT, robot=robot, code=error.code, clears=error.clears)


def _stop(links: Sequence[Link], now: Snapshot, cause: EndCause, why: str) -> Sequence[Command]:
    """Return the command that stops those of some robots that do not brake yet."""
    robots = going(now.state).intersection(link.twin.uid for link in links)
    return [StopRobots(tuple(sorted(robots)), Cancellation(cause, why))] if robots else ()


def _await_reading(process: Process, ring: TickRing) -> None:
    """Wait for the first reading of a controller; raise DriverFault, in the host's words, where there is none."""
    until = time.monotonic() + READING_SECONDS
    while (report := ring.reported()) is None or report.state is not State.INACTIVE or not report.cycles:
        if report is not None and report.state is State.ERROR and (said := process.words()).text:
            raise DriverFault(said.text, said.code, said.clears)
        if time.monotonic() > until:
            raise DriverFault("the controller was connected to, and told nothing")
        time.sleep(0.002)


def _is_starved(link: Link) -> bool:
    """Return whether a robot goes on by its brake, or has, though nobody has slowed its clock."""
    report = link.report
    return report is not None and report.on_brake and report.rate == 1.0
