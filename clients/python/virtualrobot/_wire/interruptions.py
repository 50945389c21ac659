"""Orders that others may take back while they wait: a task of asyncio, whose thread no Ctrl-C reaches.

A thread that works for somebody runs in an `Interruption`. Who waits in this library, for an answer or for another
thread, lets it be woken; then KeyboardInterrupt is raised there, once, so that all is left as Ctrl-C leaves it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar, copy_context
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
Result = TypeVar("Result")


class Interrupted(KeyboardInterrupt):
    """Raised in the thread of an order that was taken back."""


class Interruption:
    """One order, from the thread that it runs in to whoever may take it back."""

    def __init__(self) -> None:
        """Begin with an order that nobody has taken back."""
        self._changing = threading.Lock()
        self._taken_back = False
        self._wakers: list[Callable[[], object]] = []

    def run(self, function: Callable[P, Result], *arguments: P.args, **options: P.kwargs) -> Result:
        """Run a function in this thread as this order.

        Raises:
            Interrupted: when it is taken back meanwhile, unless the function gets over it.
        """

        def work() -> Result:
            _PRESENT.set(self)
            return function(*arguments, **options)

        return copy_context().run(work)

    def take_back(self) -> None:
        """Raise `Interrupted` where the order waits, or when it waits next; any thread may."""
        with self._changing:
            self._taken_back = True
            wakers = list(self._wakers)
        for wake in wakers:
            wake()

    def check(self) -> None:
        """Raise `Interrupted` when the order was taken back; the next one only when that is done again."""
        with self._changing:
            taken_back, self._taken_back = self._taken_back, False
        if taken_back:
            raise Interrupted("the task that waited for it was cancelled")

    @contextmanager
    def woken_by(self, wake: Callable[[], object]) -> Iterator[None]:
        """Let `wake` end what the block waits for when the order is taken back; then the block raises `Interrupted`."""
        with self._changing:
            self._wakers.append(wake)
        try:
            self.check()
            yield
        finally:
            with self._changing:
                self._wakers.remove(wake)
            self.check()


_PRESENT: ContextVar[Interruption | None] = ContextVar("present interruption", default=None)


def check() -> None:
    """Raise `Interrupted` when this thread's order was taken back."""
    if (present := _PRESENT.get()) is not None:
        present.check()


def wait(changed: threading.Condition, seconds: float | None = None) -> bool:
    """Wait as `changed.wait` does, in its lock; raises `Interrupted` when this thread's order is taken back."""
    if (present := _PRESENT.get()) is None:
        return changed.wait(seconds)

    def wake() -> None:
        with changed:
            changed.notify_all()

    with present.woken_by(wake):
        return changed.wait(seconds)


def wait_for(changed: threading.Condition, done: Callable[[], bool], seconds: float | None = None) -> bool:
    """Wait as `changed.wait_for` does; raises `Interrupted`, as `wait` does."""
    end = None if seconds is None else time.monotonic() + seconds
    while not (found := done()) and (end is None or time.monotonic() < end):
        wait(changed, None if end is None else end - time.monotonic())
    return found


def answer(call: Any, request: object, **options: Any) -> Any:  # noqa: ANN401 as the generated stubs call it
    """Return the one answer of a call; raises `Interrupted` when this thread's order is taken back."""
    if (present := _PRESENT.get()) is None:
        return call(request, **options)
    running = call.future(request, **options)
    with present.woken_by(running.cancel):
        return running.result()


def waited_for(call: Any) -> Any:  # noqa: ANN401 as grpcio has it: no type for a running call
    """Return a context that waits for a running call; it raises `Interrupted`, as `answer` does."""
    present = _PRESENT.get()
    return nullcontext() if present is None else present.woken_by(call.cancel)
