"""Kernel in the tests' own process, reached over TCP like any other: its journal can be read, its code be watched."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest import mock

from virtualrobot_kernel.api.server import Address
from virtualrobot_kernel.compiling import compile_code
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.history.journal import Journal, Keeper, Told
from virtualrobot_kernel.kernel import Kernel, Settings
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.journal import Answer, Entry


class LateJournal(Journal):
    """Journal that answers late, as one does that waits for a disk: after keepers of the test have every entry."""

    def __init__(self, late: tuple[Keeper, ...], *args: Any, **named: Any) -> None:  # noqa: ANN401 as they come
        """Make the kernel's own, with keepers of the test."""
        super().__init__(*args, **named)
        self._told: queue.SimpleQueue[Told | Answer | None] = queue.SimpleQueue()
        self._keepers_of_test = late
        self._answering = threading.Thread(target=self._answer_late, daemon=True)

    def start(self) -> None:
        super().start()
        self._answering.start()

    def close(self) -> None:
        self._told.put(None)
        super().close()

    def append(self, entry: Entry, before: Change, after: Change) -> None:
        super().append(entry, before, after)
        self._told.put(Told(self._now.number, entry, before, after))

    def answer(self, answer: Answer) -> None:
        super().answer(lambda failed: self._told.put(lambda _: answer(failed)))

    def _answer_late(self) -> None:
        while (one := self._told.get()) is not None:
            if not isinstance(one, Told):
                one(None)
                continue
            for keeper in self._keepers_of_test:
                keeper.keep([one])


@contextmanager
def kernel_inside(*keepers: Keeper) -> Iterator[tuple[Kernel, str]]:
    """Give a stepped kernel and its address; all that it journals goes to `keepers` too, before it is answered."""

    def journal(*args: Any, **named: Any) -> Journal:  # noqa: ANN401 as they come
        return LateJournal(keepers, *args, **named) if keepers else Journal(*args, **named)

    compile_code()
    with mock.patch("virtualrobot_kernel.history.history.Journal", journal):
        kernel = Kernel(Settings(Address("127.0.0.1", 0, ""), Mode.STEPPED), Catalog(), lambda: None)
    try:
        yield kernel, f"127.0.0.1:{kernel.start()}"
    finally:
        kernel.close()
