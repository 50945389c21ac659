"""Supervision of robots that are played, in the world thread.

Each tick goes into their rings, and before each tick it is looked at what came back. What takes its time is done
elsewhere (`settling.py`).
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from virtualrobot_sdk.drivers import DriverFault, Words
from virtualrobot_sdk.drivers.shared import NEVER, CellBlock, State

from virtualrobot_kernel.drivers.admission import check, check_orders
from virtualrobot_kernel.drivers.cell import Cell
from virtualrobot_kernel.drivers.conditions import halted_error, name_of
from virtualrobot_kernel.drivers.link import ROUNDING_NS, Link, LinkMode
from virtualrobot_kernel.drivers.settling import Settling, author_of
from virtualrobot_kernel.drivers.signals import bits_of, inputs_changed
from virtualrobot_kernel.drivers.ticks import Ticks
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.inputs.mailbox import Mailbox
from virtualrobot_kernel.world.braking import going
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.commands import Command, SetMeasuredJoints, StopCell, StopRobots
from virtualrobot_kernel.world.state import Cancellation, CellStop, EndCause, Signal, Snapshot
from virtualrobot_kernel.world.state import State as WorldState
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tick_inputs import TickInput

NOTE_SECONDS = 1.0
"""Period (s) of simulation time at which the journal is told what was played."""

REST_LOOK_NS = 10_000_000
"""Time (ns) between two looks at what came back while nothing moves and no twin is measured: none is to be stopped."""

UNWATCHED = (State.ERROR, State.CONNECTING, State.DISCONNECTED)
"""States in which a link has no fault that is new."""

OUTSIDE = "somebody outside the kernel"
"""Whoever has stopped the cell without a call, as by the stopper."""

log = logging.getLogger(__name__)


class Supervision:
    """Supervisor of the world (`world/supervisor.py`) while any robot is connected; it listens to ticks, too.

    `leased` tells whether somebody has leased a robot (a uid), `removed` ends the driver of one that is no more.
    """

    author = "drivers"

    def __init__(
        self,
        world: World,
        mailbox: Mailbox,
        forward: Forward,
        cell: Cell,
        settling: Settling,
        leased: Callable[[int], bool],
        removed: Callable[[Link], None],
    ) -> None:
        """Begin with nothing seen."""
        self._world, self._mailbox, self._leased, self._removed = world, mailbox, leased, removed
        self._cell, self._settling = cell, settling
        self._ticks = Ticks(forward)
        self._stands: _Standing | None = None
        self._looked = True
        self._looked_ns = 0
        self._monitors = False
        self._signals: Mapping[str, Signal] | None = None

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Refuse what would put a twin elsewhere that its robot follows, and what would move one alone unasked."""
        cell, links = self._cell, self._cell.links
        there = before.structure.robots
        if halted := {uid: link for uid, link in links.items() if link.halted and uid in there}:
            check_orders(
                before, after, {uid: halted_error(name_of(before, link), link) for uid, link in halted.items()}
            )
        played = [uid for uid, link in links.items() if link.is_played and uid in before.structure.robots]
        if played:
            may_begin = cell.block is not None and not cell.is_stopped
            ready = [uid for uid in played if may_begin and links[uid].state is State.ACTIVE]
            check(before, after, batch, played, ready)

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Stop the twins of robots that do not follow any more, and of all others that move with them."""
        now_ns, cell, block = time.monotonic_ns(), self._cell, self._cell.block
        if block is None:
            return ()
        if now.state.stop is not None and block.stop_ns == NEVER:
            cell.stop(now.state.stop.reason, now.state.stop.by)
        stopped = block.stop_ns != NEVER  # before reports: a host tells why it stops the cell, and stops it then
        stands = not now.state.motions and not self._monitors and stopped == (now.state.stop is not None)
        self._looked = not (stands and now_ns - self._looked_ns < REST_LOOK_NS)
        if not self._looked:
            return ()
        self._looked_ns = now_ns
        if freed := self._measured_no_more(now):
            return freed
        played: list[Link] = []
        failed: list[tuple[Link, Words]] = []
        awaits = False
        for link in self._cell.links.values():
            is_played = link.is_played
            words = self._look_at(link, now_ns, block)
            if is_played:
                played.append(link)
                awaits = awaits or link.awaits_words or link.is_unread
                if link.is_silent:
                    block.stop()  # at once; why is told a moment later
                if words is not None:
                    failed.append((link, words))
        is_known = now.state.stop is not None or cell.closed
        if (awaits and not failed) or not (played or stopped) or (is_known and not played):
            return ()
        if failed:
            cause, why = EndCause.DRIVER, self._settling.blame(now, *failed[0])
            block.stop()
        elif stopped:
            cause, why = EndCause.CELL_STOPPED, cell.stopped
            if played and not cell.reason and (late := self._late(played, now_ns)):
                cause, why = EndCause.DRIVER, late
                cell.by, cell.reason = self.author, why
        else:
            return self._stop_unleased(played, now)
        for link in played:
            if link.state is State.ACTIVE:
                link.halt(link.words if link.words.text else Words(why), State.STOPPING)
                self._settling.later(link)
        stop = _stop(played, now, cause, why)
        return stop if is_known else (*stop, StopCell(self.stop_of_cell()))

    def _measured_no_more(self, now: Snapshot) -> Sequence[Command]:
        """Return the commands that end the measuring of twins whose robots were lost, once nothing moves them."""
        if not now.state.commanded:
            return ()
        moved = {uid for motion in now.state.motions for uid in motion.robots}
        return [
            SetMeasuredJoints(uid, None)
            for uid, link in self._cell.links.items()
            if uid in now.state.commanded and uid not in moved and not link.is_monitored
        ]

    def stop_of_cell(self) -> CellStop:
        """Return the stop that the drivers' robots have met, as the world will have it."""
        cell, block = self._cell, self._cell.block
        ago = 0.0 if block is None else max(time.monotonic_ns() - block.stop_ns, 0) * 1e-9
        return CellStop(cell.by or OUTSIDE, cell.stopped, time.time() - ago)

    def _late(self, played: Sequence[Link], now_ns: int) -> str:
        """Return that robots have braked because no newer tick came, in words; empty where that was not so."""
        late, lead = (now_ns - self._world.due_nanoseconds) * 1e-9, min(link.asked.lead for link in played)
        if late > lead or any(link.report is not None and link.report.on_brake for link in played):
            return f"the newest tick was older than the lead of {lead:g} s: the real robots brake on their paths"
        return ""

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Want nothing."""
        return ()

    def _look_at(self, link: Link, now_ns: int, block: CellBlock) -> Words | None:
        """Return the new fault of a link, which is in ERROR from then on."""
        if link.state in UNWATCHED:
            return None
        awaited = link.awaits_words
        words = link.fault(now_ns, block)
        if link.awaits_words and not awaited:
            self._settling.aside(_ask_words, link)
        if words is None:
            return None
        link.halt(words, State.ERROR)
        self._settling.later(link)
        return words

    def _stop_unleased(self, played: Sequence[Link], now: Snapshot) -> Sequence[Command]:
        """Stop robots that nobody has leased any more."""
        free = [link for link in played if link.state is State.ACTIVE and not self._leased(link.twin.uid)]
        for link in free:
            link.halt(Words("nobody has leased the robot any more"), State.STOPPING)
            self._settling.later(link)
        return _stop(free, now, EndCause.LEASE_EXPIRED, "nobody has leased the robot any more") if free else ()

    def ticked(self, now: Snapshot) -> None:
        """Write a tick into the rings, and take what was measured for the next one."""
        cell, state, due = self._cell, now.state, self._world.due_nanoseconds
        block, links = cell.block, cell.links
        if block is None:
            return
        if (stands := self._stands) is not None:
            if not self._looked and stands.goes_on(now, due, links):
                block.complete(state.tick, True)
                return
            self._stands = None
        played = [link for link in links.values() if link.is_played or link.mode is LinkMode.EXECUTE]
        if played and state.motions:
            block.complete(state.tick, self._ticks.write(now, due, played))
        elif played:
            told = [link.write_rest(now, due) for link in played]
            block.complete(state.tick, True)
            if all(told) and state.signals is self._signals:
                self._stands = _Standing(now.structure, state, due, round(now.tick_seconds * 1e9), links)
        signals_changed = state.signals is not self._signals
        self._signals = state.signals
        self._monitors = False
        for link in links.values():
            if link.twin.uid not in now.structure.robots:
                if link.state is not State.DISCONNECTED:
                    link.state = State.DISCONNECTED
                    self._settling.aside(self._removed, link)
                continue
            if link.about.outputs and signals_changed:
                link.outputs = bits_of(now, link.twin.uid, link.about.outputs)
            monitors = link.mode is LinkMode.MONITOR
            self._monitors = self._monitors or monitors
            if monitors or link.about.inputs:
                self._read(now, link)
        for link in played:
            self._watch(now, link)

    def _read(self, now: Snapshot, link: Link) -> None:
        report = link.report
        if report is None:
            return
        bits, signals = link.inputs_known
        if link.about.inputs and (report.inputs != bits or now.state.signals is not signals):
            if changed := inputs_changed(now, link.twin.uid, link.about.inputs, report.inputs):
                self._world.submit(changed, author_of(now, link))
            else:
                link.inputs_known = report.inputs, now.state.signals
        if not link.is_monitored:
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
            if not link.is_monitored:
                raise KernelError("it is not monitored any more")

        with suppress(KernelError):  # too many others wait: the next tick has a newer one
            self._mailbox.put(link.twin.uid, TickInput(command, author_of(now, link), refused_input, permit))

    def _watch(self, now: Snapshot, link: Link) -> None:
        """Keep what a robot plays, and tell the journal now and then."""
        if (played := link.played) is None:
            return
        played.twin_at(now.state)
        if link.state is State.ACTIVE and (now.state.tick - played.noted) * now.tick_seconds >= NOTE_SECONDS:
            played.noted = now.state.tick
            self._settling.note(now, link)


@dataclass(frozen=True, slots=True, eq=False)
class _Standing:
    """World in which nothing moves, at a tick from which on all rings tell those that come: due_ns, period_ns (ns)."""

    structure: Structure
    state: WorldState
    due_ns: int
    period_ns: int
    links: Mapping[int, Link]

    def goes_on(self, now: Snapshot, due_ns: int, links: Mapping[int, Link]) -> bool:
        """Return whether nothing is new in a tick but that time has gone on evenly."""
        was, state = self.state, now.state
        if state.motions or state.q is not was.q or state.v is not was.v or state.signals is not was.signals:
            return False
        off = due_ns - self.due_ns - (state.tick - was.tick) * self.period_ns
        return links is self.links and now.structure is self.structure and -ROUNDING_NS < off < ROUNDING_NS


def _ask_words(link: Link) -> None:
    """Ask a host for the words of the fault that it has met, of one that is silent where it hangs."""
    try:
        told = link.process.where() if link.is_silent else link.process.words()
    except DriverFault as error:
        told = error.words  # it has died meanwhile
    except KernelError:
        return
    if told.text or not link.is_silent:
        link.told = told


def _stop(links: Sequence[Link], now: Snapshot, cause: EndCause, why: str) -> Sequence[Command]:
    """Return the command that stops those of some robots that do not brake yet."""
    robots = going(now.state).intersection(link.twin.uid for link in links)
    return [StopRobots(tuple(sorted(robots)), Cancellation(cause, why))] if robots else ()
