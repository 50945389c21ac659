"""Journal of the kernel: a thread that hands what was applied to those who keep it, and then answers."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.journal import Answer, Entry

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
        """Keep entries, in order, all or none: what it raises is the answer to all of them."""
        ...


class Journal:
    """Journal whose thread has each entry kept by all keepers, one after another, and then answers.

    So the world thread pays for a queue alone: what is encoded, compared and written is so in this one.
    """

    def __init__(self, keepers: Sequence[Keeper], last_number: int = 0) -> None:
        """Go on after the entry with this number; nothing is kept before `start`."""
        self._keepers = keepers
        self._number = last_number
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
        """Raise KernelError once an entry could not be kept: the world must not go further from what is."""
        if self._failed is not None:
            raise self._failed

    def append(self, entry: Entry, before: Change, after: Change) -> None:
        """Have an entry kept, in the journal's thread."""
        self._number += 1
        self._queue.put(Told(self._number, entry, before, after))

    def answer(self, answer: Answer) -> None:
        """Have `answer` called in the journal's thread once all entries so far are kept."""
        self._queue.put(answer)

    def _run(self) -> None:
        while (first := self._queue.get()) is not None:
            items = [first, *self._waiting()]
            failed = self._kept([one for one in items if isinstance(one, Told)])
            for one in items:
                if one is None:
                    return
                if not isinstance(one, Told):
                    one(failed)

    def _waiting(self) -> Iterator[Told | Answer | None]:
        """Yield what waits behind the first one, up to the end."""
        for _ in range(MOST_AT_ONCE):
            try:
                one = self._queue.get_nowait()
            except queue.Empty:
                return
            yield one
            if one is None:
                return

    def _kept(self, told: Sequence[Told]) -> KernelError | None:
        """Have entries kept, unless some could not be before; return why not."""
        if told and self._failed is None:
            try:
                for keeper in self._keepers:
                    keeper.keep(told)
            except Exception as error:
                log.exception("entry %d could not be kept; the world takes no more changes", told[0].number)
                reason = f"the journal could not be written: {error}; the world takes no more changes"
                self._failed = KernelError(reason, reason=Reason.INTERNAL)
        return self._failed
