"""A slow reader of a stream gets the newest of each key, and in the end what ended it."""

from __future__ import annotations

import queue
import threading
import time
from contextlib import closing
from typing import Any, cast

import pytest
from virtualrobot._wire.newest import newest
from virtualrobot._wire.transport import Stream
from virtualrobot.errors import KernelGoneError


class Told:
    """Stands for a stream: gives what is put, raises what is an exception, ends with None."""

    def __init__(self) -> None:
        """Begin with nothing told."""
        self.queue: queue.Queue[Any] = queue.Queue()
        self.taken = threading.Semaphore(0)
        self.cancelled = threading.Event()

    def put(self, *messages: object) -> None:
        """Tell, and wait until all of it is read."""
        for message in messages:
            self.queue.put(message)
        for _ in messages:
            assert self.taken.acquire(timeout=10.0)

    def __iter__(self) -> Told:
        """Return itself."""
        return self

    def __next__(self) -> list[tuple[str, int]]:
        """Wait for what is put."""
        message = self.queue.get()
        if isinstance(message, list):
            self.taken.release()
            return message
        raise message or StopIteration

    def __enter__(self) -> Told:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        self.cancelled.set()
        self.queue.put(None)


def reader(told: Told) -> Any:  # noqa: ANN401 a generator
    return newest(cast("Stream[Any]", told), lambda message: message)


def settled(told: Told, *messages: object) -> None:
    """Tell messages, and wait until the reader's thread waits for more, which is when all of them are kept."""
    told.put(*messages, [])


def test_a_slow_reader_skips_what_has_become_old() -> None:
    told = Told()
    found = reader(told)
    told.queue.put([("a", 1)])
    assert next(found) == 1
    settled(told, *([("a", number)] for number in range(2, 500)))
    assert next(found) == 499
    # Of several keys each has its newest, first that which waits longest, so that none is left behind for ever.
    settled(told, [("a", 500), ("b", 1)], [("c", 1)], [("a", 501)], [("b", 2)])
    assert [next(found) for _ in range(3)] == [501, 2, 1]
    found.close()
    assert told.cancelled.is_set()


def test_what_ends_the_stream_comes_after_all_else() -> None:
    told = Told()
    found = reader(told)
    told.queue.put([("a", 1)])
    told.queue.put(KernelGoneError("it is gone"))
    assert next(found) == 1
    with pytest.raises(KernelGoneError, match="it is gone"):
        next(found)
    assert told.cancelled.is_set()


def test_a_stream_that_ends_ends() -> None:
    told = Told()
    told.queue.put([("a", 1), ("b", 2)])
    told.queue.put(None)
    assert list(reader(told)) == [1, 2]


def test_who_forgets_it_cancels_it() -> None:
    told = Told()
    with closing(reader(told)) as found:
        told.queue.put([("a", 1)])
        assert next(found) == 1
    assert told.cancelled.is_set()
    before = time.monotonic()
    while any(thread.name == "newest" for thread in threading.enumerate()):
        assert time.monotonic() - before < 10.0, "its thread ends with it"
        time.sleep(0.01)
