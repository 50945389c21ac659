"""Links of all robots: who is connected, in which mode, and what is asked of them.

What calls ask for is done in their own threads, one call at a time for each robot: it is connected here, begins to
follow in `beginning.py` and comes to rest in `settling.py`. The world thread plays it in `supervision.py`.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress

import numpy as np
from virtualrobot_sdk.drivers import DriverFault
from virtualrobot_sdk.drivers.shared import State, TickRing

from virtualrobot_kernel.drivers.beginning import Beginning, reported
from virtualrobot_kernel.drivers.cell import Cell
from virtualrobot_kernel.drivers.conditions import refused
from virtualrobot_kernel.drivers.far_side import Process, Site
from virtualrobot_kernel.drivers.faults import told
from virtualrobot_kernel.drivers.link import Link, LinkMode, Status
from virtualrobot_kernel.drivers.settling import Settling
from virtualrobot_kernel.drivers.signals import commands_for, removals
from virtualrobot_kernel.drivers.supervision import Supervision
from virtualrobot_kernel.drivers.twin import Asked, Floats, twin_of
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.inputs.mailbox import Mailbox
from virtualrobot_kernel.world.apply_cell import refuse_braking
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.past_world import PastWorld, is_past
from virtualrobot_kernel.world.state import CellStop, Snapshot
from virtualrobot_kernel.world.store import World

READING_SECONDS = 10.0
"""Longest time (s) for the first reading of a controller that has been connected to."""

TICK_SECONDS = 10.0
"""Longest time (s) that is waited for the tick that is being made."""

log = logging.getLogger(__name__)


class Links:
    """Links of all robots, for the calls that ask about them and change them."""

    supervised_by: type[Supervision] = Supervision

    def __init__(
        self, world: World, mailbox: Mailbox, forward: Forward, site: Site, leased: Callable[[int], bool]
    ) -> None:
        """Begin with none; `site` makes the far side, `leased` tells whether somebody has leased a robot (a uid)."""
        self._world, self._site = world, site
        self._cell = Cell()
        self._settling = Settling(world, self._cell)
        self._beginning = Beginning(world, self._cell, self._settling, leased)
        self.supervision = self.supervised_by(
            world, mailbox, forward, self._cell, self._settling, leased, self._end_with_robot
        )
        self._busy: dict[int, threading.Lock] = {}
        self._connecting: dict[int, Asked] = {}
        self._end_listening: Callable[[], None] = lambda: None

    @property
    def stop(self) -> CellStop | None:
        """Stop of the cell; None: it is not stopped. One from outside the kernel is told before the world has it."""
        known = self._world.snapshot.state.stop
        if known is None and self._cell.is_stopped:
            return self.supervision.stop_of_cell()
        return known

    @property
    def stopper(self) -> tuple[str, str]:
        """Address and key of the stopper; empty while no driver is connected."""
        return self._site.stopper if self._cell.links else ("", "")

    def statuses(self, snapshot: Snapshot) -> list[Status]:
        """Return all links as they are, by the names of their robots."""
        nodes = snapshot.structure.nodes
        found = [Status(nodes[uid].name, link, link.newest()) for uid, link in self._cell.links.items() if uid in nodes]
        return sorted(found, key=lambda status: status.robot)

    def measured(self, snapshot: Snapshot) -> dict[int, Floats]:
        """Return where real robots are that the world doesn't have there: all coordinates (nq,) by the robot's uid.

        Of one that is monitored the world has the readings itself; of one in ERROR nobody knows any more.
        """
        found = {}
        for uid, link in self._cell.links.items():
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
        link = self._cell.links.get(node.uid)
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
        with self._alone(twin.uid, robot), self._alone_at(twin.uid, robot, asked):
            link = self._cell.links.get(twin.uid)
            if link is not None and link.state is not State.ERROR:
                raise KernelError(
                    f"the driver {link.asked.component!r} is connected to {robot!r} already; disconnect it first",
                    reason=Reason.WRONG_STATE,
                    robot=robot,
                    component=link.asked.component,
                )
            signals: tuple[str, ...] = ()
            halted = False
            if link is not None:
                signals, halted = link.signals, link.halted
                self._settling.measure_no_more(link)
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
            self._cell.add(twin.uid, Link(twin, asked, process, ring, about, signals, halted=halted))
            return self.status(robot)

    def disconnect(self, robot: str) -> Status:
        """Bring a robot to rest, and end its driver."""
        status = self.status(robot)
        with self._alone(status.link.twin.uid, robot):
            self._settling.leave(status.link, "its driver is disconnected")
            last = self.status(robot)
            self._forget(status.link)
            self._remove_signals(status.link.twin.uid, status.link.signals)
            status.link.state, status.link.mode = State.DISCONNECTED, LinkMode.SIMULATED
            return last

    def set_mode(self, robot: str, mode: LinkMode) -> tuple[Status, Floats | None]:
        """Choose how a robot and its twin go together; return the link, and how far the twin was put, (k,) or None."""
        link = self.status(robot).link
        with self._alone(link.twin.uid, robot):
            if link.state is State.ERROR and mode is LinkMode.SIMULATED:
                self._settling.measure_no_more(link)
                link.halted = False  # the twin alone is what is wanted
                return self.status(robot), None
            _refuse_in_error(robot, link)
            if mode is link.mode and not link.halted:
                return self.status(robot), None
            self._settling.leave(link, f"its mode becomes {mode.name}")
            if mode is LinkMode.EXECUTE:
                moved = self._beginning.execute(robot, link)
                return self.status(robot), moved
            if mode is LinkMode.MONITOR:
                _refuse_in_error(robot, link)
                reported(robot, link)
                link.mode = LinkMode.MONITOR
            link.take_orders()
            return self.status(robot), None

    def reset(self, robot: str) -> Status:
        """Clear the fault at a controller, where that may help, and connect again."""
        status = self.status(robot)
        link = status.link
        with self._alone(link.twin.uid, robot), self._alone_at(link.twin.uid, robot, link.asked):
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

    def stop_real(self, stop: CellStop) -> None:
        """Bring all robots that drivers move to rest together, without the world; nothing waits for anything."""
        self._cell.stop(stop.reason, stop.by)

    def release(self, now: Snapshot, _: object = None) -> None:
        """Let drivers' robots go on, right before the world does; raise KernelError (WRONG_STATE) while one moves.

        For the world thread (a `Permit`), so that no tick comes between the two.
        """
        refuse_braking(now.state)
        for status in self.statuses(now):
            if status.link.is_played:
                raise refused(status.robot, "rest", "it is not at rest yet")
        self._cell.release()

    def close(self) -> None:
        """Stop all robots and end all drivers."""
        self._cell.closed = True
        links = self._cell.links.values()
        if any(link.is_played for link in links):
            self._cell.stop("the kernel is ending", "the kernel")
        self._world.unsupervise(self.supervision)
        self._end_listening()
        self._await_listeners()
        for link in links:
            with suppress(DriverFault, OSError):
                link.process.close()
                link.ring.close()
        self._settling.close()
        self._site.close()

    def is_executing(self, robots: Iterable[int]) -> bool:
        """Return whether one of some robots (uids) is played by a real one."""
        links = self._cell.links
        return any(uid in links and links[uid].is_played for uid in robots)

    def _await_listeners(self) -> None:
        """Wait until the world thread looks at no link any more that is gone."""
        with suppress(KernelError, TimeoutError):  # the world has ended
            self._world.between_ticks().result(TICK_SECONDS)

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
        """Have a block, and the world supervised and listened to from now on."""
        with self._cell.changing:
            if self._cell.closed:
                raise KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)
            if self._cell.block is None:
                self._cell.block = self._site.cell()
                self._world.supervise(self.supervision)
                self._end_listening = self._world.listen_ticks(self.supervision.ticked)

    def _end_with_robot(self, link: Link) -> None:
        """End the driver of a robot that was removed; its signals go, too."""
        self._forget(link)
        self._remove_signals(0, link.signals)  # nobody owns what a robot has owned that is no more

    def _forget(self, link: Link) -> None:
        """End a driver and forget its link."""
        self._cell.remove(link)
        self._await_listeners()
        link.process.close()
        link.ring.close()
        self._rest_if_none()

    def _rest_if_none(self) -> None:
        """Ask nothing more of the world where no robot is connected, unless the cell is stopped."""
        with self._cell.changing:
            if not self._cell.links and self._cell.block is not None and not self._cell.is_stopped:
                self._world.unsupervise(self.supervision)
                self._end_listening()
                self._cell.block = None

    def _alone(self, uid: int, robot: str) -> _Alone:
        """Return a context in which nobody else changes a robot's link; raise KernelError where somebody does."""
        with self._cell.changing:
            return _Alone(self._busy.setdefault(uid, threading.Lock()), robot)

    @contextmanager
    def _alone_at(self, uid: int, robot: str, asked: Asked) -> Iterator[None]:
        """Have the lines that a connection names for this robot alone while it is made.

        Of a device server in the network nobody keeps a second driver; of a serial port the system does, and doesn't
        say whose it is. Raises KernelError (WRONG_STATE) where another robot has one, or is about to have it.
        """
        with self._cell.changing:
            there = {other: link.asked for other, link in self._cell.links.items() if link.state is not State.ERROR}
            for other, has in (there | self._connecting).items():
                if other != uid and (shared := asked.lines & has.lines):
                    node = self._world.snapshot.structure.nodes.get(other)
                    whose = f"of {node.name!r}" if node else "of a robot that is gone"
                    said = f"{min(shared)} is the line of the driver {has.component!r} {whose} already"
                    raise refused(robot, "driver", f"{said}; disconnect that first, or name another line")
            self._connecting[uid] = asked
        try:
            yield
        finally:
            with self._cell.changing:
                del self._connecting[uid]


class _Alone:
    """Lock that is had at once or not at all."""

    def __init__(self, lock: threading.Lock, robot: str) -> None:
        self._lock, self._robot = lock, robot

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise refused(self._robot, "driver", "another call changes its driver now; wait for its answer")

    def __exit__(self, *_: object) -> None:
        self._lock.release()


def _refuse_in_error(robot: str, link: Link) -> None:
    """Raise KernelError (WRONG_STATE) where a connection is in ERROR."""
    if link.state is State.ERROR:
        said = f"its connection is in ERROR ({link.words.text}); reset or connect it, or choose SIMULATED"
        raise refused(robot, "state", said)


def _await_reading(process: Process, ring: TickRing) -> None:
    """Wait for the first reading of a controller; raise DriverFault, in the host's words, where there is none."""
    until = time.monotonic() + READING_SECONDS
    while (report := ring.reported()) is None or report.state is not State.INACTIVE or not report.cycles:
        if report is not None and report.state is State.ERROR and (said := process.words()).text:
            raise DriverFault(said.text, said.code, said.clears)
        if time.monotonic() > until:
            raise DriverFault("the controller was connected to, and told nothing")
        time.sleep(0.002)
