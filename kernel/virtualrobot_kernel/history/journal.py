"""Journal of the kernel: a thread that hands what was applied to those who keep it, and then answers."""

from __future__ import annotations

import contextlib
import logging
import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    EndSetpoints,
    PauseMotion,
    SetMeasuredJoints,
    SetSpeedFactor,
    StopMotions,
    StopRobots,
)
from virtualrobot_kernel.world.journal import Answer, Entry
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure

RETRY_SECONDS = 1.0
"""Time (s) after which it is tried again to keep what could not be."""

MOST_UNKEPT = 100_000
"""Greatest number of entries that are tried again; with more of them nothing is kept until the kernel starts anew."""

STOPPING = (StopMotions, StopRobots, CancelMotion, PauseMotion, SetSpeedFactor, EndSetpoints, SetMeasuredJoints)
"""Commands that stop, slow, pause or end motions, or tell where robots are: done though nothing can be kept."""

MOST_AT_ONCE = 256
"""Greatest number of entries that are kept together: those who wait for the first one wait for all of them."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """Entry as the world thread tells it: its number, from 1, and the immutable worlds before and after it."""

    number: int
    entry: Entry
    before: Change
    after: Change


class Keeper(Protocol):
    """Keeper of entries; the journal's thread alone calls it."""

    def keep(self, told: Sequence[Told]) -> None:
        """Keep entries, in order, all or none: what it raises is the answer to all of them.

        They are told again, with those that have come since, until they are kept.
        """
        ...


Ticked = Callable[[int, Structure, State], None]
"""Listener to ticks, called in the world thread: the number of the last entry before, and the world after it."""


class Journal:
    """Journal whose thread has each entry kept by all keepers, one after another, and then answers.

    So the world thread pays for a queue alone: what is encoded, compared and written is so in this one.
    """

    def __init__(
        self, keepers: Sequence[Keeper], last_number: int = 0, ticked: Ticked = lambda number, structure, state: None
    ) -> None:
        """Go on after the entry with this number; nothing is kept before `start`."""
        self._keepers = keepers
        self._number = last_number
        self._ticked = ticked
        self._unkept: list[Told] = []
        self._given_up = False
        self._retry_at = 0.0
        self._queue: queue.SimpleQueue[Told | Answer | None] = queue.SimpleQueue()
        self._failed: KernelError | None = None
        self._thread = threading.Thread(target=self._run, name="history", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """Keep what has been told, and end the thread."""
        self._queue.put(None)
        if self._thread.is_alive():
            self._thread.join(10.0)

    def admit(self, commands: Sequence[Command]) -> None:
        """Raise KernelError while an entry can't be kept: the world must not go further from what is.

        What stops robots is admitted, and is kept with the rest once that goes again.
        """
        if self._failed is not None and not _stops(commands):
            raise self._failed

    def append(self, entry: Entry, before: Change, after: Change) -> None:
        """Have an entry kept, in the journal's thread."""
        self._number += 1
        self._queue.put(Told(self._number, entry, before, after))

    def answer(self, answer: Answer) -> None:
        """Have `answer` called in the journal's thread once all entries so far are kept."""
        self._queue.put(answer)

    def ticked(self, structure: Structure, state: State) -> None:
        """Tell who listens that a tick was made."""
        self._ticked(self._number, structure, state)

    def _run(self) -> None:
        failed: KernelError | None = None
        while True:
            items = self._waiting()
            self._keep([one for one in items if isinstance(one, Told)])
            for one in items:
                if one is None:
                    return
                if not isinstance(one, Told):
                    one(failed)
                    failed = None
                elif not _stops(one.entry.commands):
                    failed = self._failed

    def _waiting(self) -> list[Told | Answer | None]:
        """Return what waits, up to the end, once there is something; nothing when it is time to try again."""
        found: list[Told | Answer | None] = []
        with contextlib.suppress(queue.Empty):
            found.append(self._queue.get(timeout=RETRY_SECONDS if self._unkept else None))
            while found[-1] is not None and len(found) < MOST_AT_ONCE:
                found.append(self._queue.get_nowait())
        return found

    def _keep(self, told: Sequence[Told]) -> None:
        """Have entries kept, with those that could not be before."""
        if self._given_up or not (told or self._unkept):
            return
        together = [*self._unkept, *told]
        if self._unkept and time.monotonic() < self._retry_at:
            self._unkept = together
            return
        try:
            for keeper in self._keepers:
                keeper.keep(together)
        except Exception as error:
            if self._failed is None:
                log.error(
                    "entry %d can't be kept; the world takes no more changes until it is: %s",
                    together[0].number,
                    error,
                    exc_info=log.isEnabledFor(logging.DEBUG),
                )
            self._unkept, self._retry_at = together, time.monotonic() + RETRY_SECONDS
            if len(together) > MOST_UNKEPT:
                self._unkept, self._given_up = [], True
            self._failed = KernelError(
                f"the journal can't be written: {error}. All that was answered is kept; nothing can be changed "
                "until it can be written again, only robots can be stopped. What was refused so and what has moved "
                "since is lost if the kernel ends before. Make room on its disk, or mend its folder",
                reason=Reason.WRONG_STATE,
            )
            return
        if self._failed is not None:
            log.warning("the journal can be written again; %d entries were kept late", len(together))
        self._unkept, self._failed = [], None


def _stops(commands: Sequence[Command]) -> bool:
    return all(isinstance(one, STOPPING) for one in commands)
