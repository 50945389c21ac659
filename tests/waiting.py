"""Waits of tests for what comes by itself, by looking again and again, and what goes on meanwhile."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PATIENCE_SECONDS = 60.0
"""Time (s) after which a test fails that waits for what should come."""


def until(is_so: Callable[[], object]) -> None:
    """Wait until something is so; fail when it never comes to be."""
    end = time.monotonic() + PATIENCE_SECONDS
    while not is_so():
        assert time.monotonic() < end, "it never came to be so"
        time.sleep(0.005)


@contextmanager
def repeated(call: Callable[[], object], seconds: float = 0.005) -> Iterator[None]:
    """Call something again and again, in a thread and so many seconds apart, for the length of a block."""
    over = threading.Event()

    def repeat() -> None:
        while not over.wait(seconds):
            call()

    thread = threading.Thread(target=repeat)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
