"""Requests to a thread: what others ask of it, done between two of its own rounds."""

from __future__ import annotations

import queue
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any


class Requests:
    """Queue of what other threads ask one thread to do."""

    def __init__(self) -> None:
        """Begin with nothing asked."""
        self._waiting: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()

    def ask(self, work: Callable[[], Any]) -> Any:  # noqa: ANN401 what the work returns
        """Have the thread do some work; return what it returns, or raise what it raises."""
        done: Future[Any] = Future()
        self._waiting.put((work, done))
        return done.result()

    def do(self, seconds: float = 0.0) -> None:
        """Do all that is asked; wait so long (s) for the first. For the thread alone."""
        while True:
            try:
                work, done = self._waiting.get(timeout=seconds) if seconds else self._waiting.get_nowait()
            except queue.Empty:
                return
            seconds = 0.0
            try:
                done.set_result(work())
            except BaseException as error:
                done.set_exception(error)
