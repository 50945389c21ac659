"""Coming to rest: twin and robot wait for each other, then the driver ends what it plays."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from virtualrobot_sdk.drivers import DriverFault, Words
from virtualrobot_sdk.drivers.host import REST_SPEED
from virtualrobot_sdk.drivers.shared import State

from virtualrobot_kernel.drivers.cell import Cell
from virtualrobot_kernel.drivers.conditions import name_of
from virtualrobot_kernel.drivers.link import UNTOLD, Link, LinkMode
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.commands import SetMeasuredJoints, StopRobots
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot
from virtualrobot_kernel.world.store import World

REST_SECONDS = 10.0
"""Longest time (s) that a robot is given to come to rest before its driver is ended all the same."""

LOOK_SECONDS = 0.01
"""Period (s) at which it is looked whether a robot is at rest."""

log = logging.getLogger(__name__)


class Settling:
    """Ends what robots play once they rest, in its own threads or in those of calls, and holds the clock until then."""

    def __init__(self, world: World, cell: Cell) -> None:
        """Begin with nothing to wait for."""
        self._world, self._cell = world, cell
        self._holding: frozenset[int] = frozenset()
        self._workers = ThreadPoolExecutor(4, thread_name_prefix="drivers")

    def leave(self, link: Link, why: str) -> None:
        """Bring a robot to rest that is played, or let its twin be measured no more; then it is INACTIVE."""
        now, uid = self._world.snapshot, link.twin.uid
        if link.state is State.ACTIVE:
            link.state = State.STOPPING
            stop = StopRobots((uid,), Cancellation(EndCause.STOP, why))
            self._world.submit([stop], author_of(now, link)).result()
        if link.state is State.STOPPING:
            self._settle(link)
        self.measure_no_more(link)

    def measure_no_more(self, link: Link) -> None:
        """Have a robot SIMULATED, and its twin's joints commanded again, from where they were measured.

        Raises KernelError (ROBOT_BUSY), and leaves all as it is, while a motion moves a twin that is measured.
        """
        was, link.mode = link.mode, LinkMode.SIMULATED  # first: no reading comes after that
        now = self._world.snapshot
        if link.twin.uid not in now.structure.robots:
            return
        if was is LinkMode.MONITOR or link.twin.uid in now.state.commanded:
            try:
                self._world.submit([SetMeasuredJoints(link.twin.uid, None)], author_of(now, link)).result()
            except KernelError:
                link.mode = was
                raise

    def later(self, link: Link) -> None:
        """Have a robot that stops come to rest, and its driver end, in a thread of its own."""
        self.aside(self._settle, link)

    def aside(self, work: Callable[[Link], None], link: Link) -> None:
        """Have something done for a link in a thread of its own, unless the kernel is ending."""
        if not self._cell.closed:
            self._workers.submit(work, link)

    def close(self) -> None:
        """Begin nothing more."""
        self._workers.shutdown(wait=False, cancel_futures=True)

    def blame(self, now: Snapshot, link: Link, words: Words) -> str:
        """Return why a link stops the cell, by its words, and have the cell tell that unless it was stopped before."""
        cell, why = self._cell, f"the real robot of {name_of(now, link)!r} has stopped: {words.text}"
        if not cell.reason:
            cell.by, cell.reason = author_of(now, link), why
        return why

    def _settle(self, link: Link) -> None:
        """Wait until a robot and its twin are at rest, then end what is played; the words stay."""
        if link.state is State.ERROR and (link.is_silent or link.process.fault is not None):
            link.process.kill()  # where it hangs, maybe as it is asked to end, the controller's own watchdog acts
        with link.settling:
            self._settled(link)

    def _settled(self, link: Link) -> None:
        try:
            until = time.monotonic() + REST_SECONDS
            while not self._cell.closed and time.monotonic() < until and not self._rests(link):
                time.sleep(LOOK_SECONDS)
            self.note(self._world.snapshot, link)
            if link.words is UNTOLD:
                link.words = link.process.words()
            if link.state is State.STOPPING:
                link.process.end()
                link.state = State.INACTIVE
        except DriverFault as error:
            if link.state is not State.ERROR or link.words is UNTOLD:
                if self._cell.is_stopped:
                    self.blame(self._world.snapshot, link, error.words)  # its host has stopped it
                link.halt(error.words, State.ERROR)
        except KernelError as error:
            log.warning("%s", error)
        except Exception:
            log.exception("a driver could not be ended")
            link.halt(Words("the driver could not be ended; the log tells why"), State.ERROR)
        finally:
            link.mode = LinkMode.SIMULATED
            self.hold_clock(link, False)

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

    def hold_clock(self, link: Link, holds: bool) -> None:
        """Refuse that the clock changes while any robot is played, and keep up with it as far as their leads reach."""
        with self._cell.changing:
            uid = link.twin.uid
            self._holding = self._holding | {uid} if holds else self._holding - {uid}
            leads = [one.asked.lead for one in self._cell.links.values() if one.twin.uid in self._holding]
            held = self._world.hold_clock("a real robot is played by this clock" if leads else "")
            self._world.catch_up(max(leads, default=0.0))
        if holds:
            held.result()

    def note(self, now: Snapshot, link: Link) -> None:
        """Tell the journal what was played since it was told last."""
        if (played := link.played) is None:
            return
        played.reached(link.ring.played)
        if ranges := played.take():
            self._world.submit(ranges, author_of(now, link))


def author_of(now: Snapshot, link: Link) -> str:
    """Return as whose the journal has what is done for a link."""
    return f"driver {link.asked.component} of {name_of(now, link)}"
