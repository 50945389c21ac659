"""Journal of the kernel: what was applied goes into a tail, which survives the process, and later to keepers."""

from __future__ import annotations

import contextlib
import logging
import queue
import secrets
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from virtualrobot_kernel.background import let_others_go_on
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.rows import Row
from virtualrobot_kernel.history.tail import Tail
from virtualrobot_kernel.history.upkeep import Moment
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    EndSetpoints,
    PauseMotion,
    SetMeasuredJoints,
    SetSetpoint,
    SetSpeedFactor,
    StopCell,
    StopMotions,
    StopRobots,
)
from virtualrobot_kernel.world.history_commands import PlayedTicks
from virtualrobot_kernel.world.journal import Answer, Entry
from virtualrobot_kernel.world.physics_commands import SetContacts, SetDynamics, SetParts
from virtualrobot_kernel.world.state import State, empty_state
from virtualrobot_kernel.world.structure import Structure

RETRY_SECONDS = 1.0
"""Time (s) after which it is tried again to keep what could not be."""

MOST_UNKEPT = 100_000
"""Greatest number of entries that are tried again; with more of them nothing is kept until the kernel starts anew."""

STOPPING = frozenset(
    {
        *(StopMotions, StopRobots, StopCell, CancelMotion, PauseMotion, SetSpeedFactor, EndSetpoints),
        *(SetMeasuredJoints, SetDynamics, SetParts, SetContacts),
    }
)
"""Commands that stop, slow, pause or end motions, or tell where robots are: done though nothing can be kept."""

EACH_TICK = frozenset({SetSetpoint, SetMeasuredJoints, SetDynamics, SetParts, SetContacts, PlayedTicks})
"""Commands that come as often as ticks: they are in the journal, and no steps."""

MOST_AT_ONCE = 32
"""Greatest number of entries that are kept together, and freed: with the worlds of one that takes up to 40 us."""

MANY = 256
"""Number of entries from which they are kept soon."""

MOST_WAITING = 10_000
"""Number of entries that wait, from which answers wait, too, so that those who ask don't outrun those who keep."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """Entry as the world thread tells it: its number, from 1, and the immutable worlds before and after it.

    Of what comes with every tick (`EACH_TICK`) these are left out: whole worlds of a second would take up the
    processor's caches. `encoded` are the commands as the tail has them; empty where there is none.
    """

    number: int
    entry: Entry
    before: Change
    after: Change
    encoded: bytes = b""


class Keeper(Protocol):
    """Keeper of entries, called by one thread at a time."""

    def keep(self, told: Sequence[Told]) -> None:
        """Keep entries, in order, all or none; what it raises ends all changes until they are kept.

        They are told again, with those that have come since, until they are.
        """
        ...


Ticked = Callable[[Structure, State], None]
"""Listener to ticks, called in the world thread with the world after each."""

_LEFT_OUT = Change(index.empty(), empty_state())


class Journal:
    """Journal that answers an entry once the tail has it, which takes a copy in memory.

    What else becomes of it (a label, what it has changed, rows of a database) is made later by the keepers, in the
    thread that calls `settle`.
    """

    def __init__(
        self,
        keepers: Sequence[Keeper],
        begin: Moment | None = None,
        ticked: Ticked = lambda structure, state: None,
        tail: Tail | None = None,
        encode: Callable[[object], bytes] = lambda commands: b"",
        note_life: Callable[[int], None] = lambda life: None,
        power: bool = False,
        waiting: Sequence[Told] = (),
        hurry: Callable[[], None] = lambda: None,
        watched: Callable[[], bool] = lambda: False,
        settled: Callable[[Moment], None] = lambda now: None,
    ) -> None:
        """Go on from a moment.

        Args:
            keepers: those who keep entries, one after another.
            begin: the world, with the number of the last entry; None: there is nothing yet.
            ticked: listens to ticks.
            tail: where entries are until they are kept; None: they are lost if the process ends before.
            encode: makes the bytes of an entry's commands.
            note_life: writes down the number of this kernel, before the tail has anything.
            power: whether an answer waits until the tail is safe from a loss of power.
            waiting: entries that the tail of the kernel before has left; the last ones before `begin`.
            hurry: is called from the world thread when `settle` shall be called soon.
            watched: whether anybody waits for what keepers make of entries.
            settled: is told a moment whose entries are all kept.
        """
        self._keepers = keepers
        self._now = begin or Moment(0, _LEFT_OUT.structure, _LEFT_OUT.state)
        self._ticked = ticked
        self._tail, self._encode, self._note_life = tail, encode, note_life
        self._hurry, self._watched, self._settled = hurry, watched, settled
        self._waiting = list(waiting)
        self._unkept: list[Told] = []
        self._late: list[Answer] = []
        self._given_up = False
        self._retry_at = 0.0
        self._failed: KernelError | None = None
        self._only_stops = True
        self._changing, self._settling, self._inside = threading.Lock(), threading.RLock(), False
        self._answers: queue.SimpleQueue[tuple[Answer, bool] | None] | None = queue.SimpleQueue() if power else None
        self._thread = threading.Thread(target=self._answer_once_safe, name="history", daemon=True)

    def start(self) -> None:
        """Have what is left of the kernel before kept, and begin."""
        self.settle()
        if self._answers is not None:
            self._thread.start()

    def close(self) -> None:
        """Answer what has been told, have it kept, and end."""
        if self._answers is not None:
            self._answers.put(None)
            if self._thread.is_alive():
                self._thread.join(10.0)
        self._retry_at = 0.0
        self.settle()
        if self._tail is not None:
            is_all = self._failed is None and not self._given_up
            if is_all:
                with contextlib.suppress(sqlite3.Error):
                    self._note_life(0)
            self._tail.close(remove=is_all)

    def admit(self, commands: Sequence[Command]) -> None:
        """Raise KernelError while entries can't be kept: the world must not go further from what is.

        What stops robots is admitted, and is kept with the rest once that goes again.
        """
        if self._failed is not None and not _stops(commands):
            raise self._failed

    def append(self, entry: Entry, before: Change, after: Change) -> None:
        """Have an entry kept; raise KernelError, and leave all as it is, when the tail can't have it.

        What stops robots is kept later then.
        """
        number, stops = self._now.number + 1, _stops(entry.commands)
        encoded = self._encode(entry.commands) if self._tail is not None else b""
        with self._changing:
            if self._tail is not None:
                try:
                    self._tail.append(Row(number, entry.tick, entry.wall_time, entry.author, encoded))
                except OSError as error:
                    self._fail(number, error)
                    if not stops and self._failed is not None:
                        raise self._failed from error
            if EACH_TICK.issuperset(map(type, entry.commands)):
                told = Told(number, entry, _LEFT_OUT, _LEFT_OUT, encoded)
            else:
                told = Told(number, entry, before, after, encoded)
            if not self._given_up:
                self._waiting.append(told)
            self._now = Moment(number, after.structure, after.state)
        self._only_stops = self._only_stops and stops
        if len(self._waiting) >= MANY or self._watched():
            self._hurry()

    def answer(self, answer: Answer) -> None:
        """Have `answer` called once all entries so far survive."""
        only_stops, self._only_stops = self._only_stops, True
        if self._answers is not None:
            self._answers.put((answer, only_stops))
            return
        with self._changing:
            if len(self._waiting) > MOST_WAITING:
                self._late.append(answer)
                return
        answer(None)

    def ticked(self, structure: Structure, state: State) -> None:
        """Tell who listens that a tick was made."""
        self._now = Moment(self._now.number, structure, state)
        self._ticked(structure, state)

    def settle(self) -> None:
        """Have the keepers keep all entries so far, in the calling thread, which holds no lock of theirs.

        What they can't keep is tried again at most once a second.
        """
        with self._settling:
            if self._inside:
                return
            self._inside = True
            try:
                self._settle()
            finally:
                self._inside = False

    def _settle(self) -> None:
        if self._given_up or (self._failed is not None and time.monotonic() < self._retry_at):
            return
        with self._changing:
            told, self._waiting = deque([*self._unkept, *self._waiting]), []
            now = self._now
            late, self._late = self._late, []
            if self._tail is not None:
                self._tail.turn()
        count, some = len(told), list[Told]()
        self._unkept = []
        try:
            while told:
                some = [told.popleft() for _ in range(min(MOST_AT_ONCE, len(told)))]
                for keeper in self._keepers:
                    keeper.keep(some)
                some = []
                if told:
                    let_others_go_on()
            with self._changing:
                if self._tail is not None and not self._tail.is_begun:
                    self._tail.begin(self._new_life)
                elif self._tail is not None:
                    self._tail.free()
        except Exception as error:
            self._unkept = [*some, *told]
            if len(self._unkept) > MOST_UNKEPT:
                self._unkept, self._waiting, self._given_up = [], [], True
            self._fail(some[0].number if some else now.number + 1, error)
        else:
            self._settled(now)
            if self._failed is not None:
                log.warning("the journal can be written again; %d entries were kept late", count)
            self._failed = None
        for answer in late:
            answer(None)

    def _new_life(self) -> int:
        life = secrets.randbits(32) | 1
        self._note_life(life)
        return life

    def _fail(self, number: int, error: Exception) -> None:
        """Note that entries from a number on can't be kept."""
        if self._failed is None:
            log.error(
                "entry %d can't be kept; the world takes no more changes until it is: %s",
                number,
                error,
                exc_info=error if log.isEnabledFor(logging.DEBUG) else None,
            )
        self._retry_at = time.monotonic() + RETRY_SECONDS
        self._failed = KernelError(
            f"the journal can't be written: {error}. All that was answered is kept; nothing can be changed "
            "until it can be written again, only robots can be stopped. What has moved since is lost if the kernel "
            "ends before. Make room on its disk, or mend its folder",
            reason=Reason.WRONG_STATE,
        )

    def _answer_once_safe(self) -> None:
        """Answer once the tail is safe from a loss of power, all who wait at once."""
        assert self._answers is not None
        going_on = True
        while going_on:
            items = [self._answers.get()]
            with contextlib.suppress(queue.Empty):
                while items[-1] is not None:
                    items.append(self._answers.get_nowait())
            going_on = items[-1] is not None
            failed: KernelError | None = None
            try:
                if self._tail is not None:
                    self._tail.sync()
            except OSError as error:
                self._fail(self._now.number, error)
                failed = self._failed
            for item in items:
                if item is not None:
                    answer, only_stops = item
                    answer(None if only_stops else failed)


def _stops(commands: Sequence[Command]) -> bool:
    return STOPPING.issuperset(map(type, commands))
