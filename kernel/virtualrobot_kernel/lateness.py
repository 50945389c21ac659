"""Answers that may be late: the world thread waits for one no longer than a moment, and serves others meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from queue import SimpleQueue
from typing import Any, TypeVar

PATIENCE_SECONDS = 0.02
"""Longest time (s) for which the world thread waits for one answer, so that a stop waits no longer either."""

Answer = TypeVar("Answer")


class Late(BaseException):
    """Answer that a tick needs and that is not there yet: the tick is begun anew once it is.

    Like `KeyboardInterrupt` no fault of whom it passes through, so that `except Exception` lets it pass.
    """

    def __init__(self, answer: Future[Any]) -> None:
        """Tell which answer is awaited."""
        super().__init__("an answer is late")
        self.answer = answer


_own = threading.local()


def patiently(ask: Callable[..., Answer], *about: object) -> Answer:
    """Return what `ask(*about)` returns, in which calls of components may raise `Late` instead of waiting."""
    _own.may_be_late = True
    try:
        return ask(*about)
    finally:
        _own.may_be_late = False


def may_be_late() -> bool:
    """Return whether this thread is within `patiently`."""
    return getattr(_own, "may_be_late", False)


def awaited(answer: Future[Answer]) -> Answer:
    """Return an answer, or raise its error; raises Late where it does not come at once."""
    try:
        return answer.result(PATIENCE_SECONDS)
    except TimeoutError:
        if not answer.done():
            raise Late(answer) from None
        return answer.result()  # it has come by now, or the work itself has raised this


class Aside:
    """Thread of its own that does one thing after another; the process ends without waiting for it."""

    def __init__(self, name: str) -> None:
        """Start the thread, by a name for people."""
        self._asked: SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None] = SimpleQueue()
        threading.Thread(target=_work, args=(self._asked,), name=name, daemon=True).start()

    def ask(self, work: Callable[[], Answer]) -> Future[Answer]:
        """Have work done after all that was asked before."""
        answer: Future[Answer] = Future()
        self._asked.put((answer, work))
        return answer

    def close(self) -> None:
        """End the thread once it has done what was asked."""
        self._asked.put(None)


def _work(asked: SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None]) -> None:
    while (item := asked.get()) is not None:
        answer, work = item
        try:
            answer.set_result(work())
        except BaseException as error:
            answer.set_exception(error)
        del item, answer, work  # the thread keeps nothing alive while it waits
