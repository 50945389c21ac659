"""Streams of states of which only the newest count: a slow reader skips what has become old."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Hashable, Iterable
from typing import Any, TypeVar

from virtualrobot._wire import interruptions
from virtualrobot._wire.transport import Stream

Part = TypeVar("Part")

_WAIT_SECONDS = 0.2
"""Waited for in small steps: Ctrl-C would not get through on Windows."""


def newest(stream: Stream[Any], parts: Callable[[Any], Iterable[tuple[Hashable, Part]]]) -> Generator[Part, None, None]:
    """Yield what the messages of a stream hold, of each key the newest that has come, those first that wait longest.

    The stream is read by a thread of its own: gRPC keeps what is not read yet, of small messages some dozens, and a
    reader who takes his time would get all of these first. The stream is cancelled when the iterator is closed or
    forgotten; what ends it is raised after all that came before it.

    Args:
        stream: the messages.
        parts: yields the parts of a message, each with the key of what it tells of.
    """
    waiting: dict[Hashable, Part] = {}
    fault: list[BaseException] = []
    changed = threading.Condition()

    def read() -> None:
        end: BaseException = StopIteration()
        try:
            for message in stream:
                with changed:
                    waiting.update(parts(message))
                    changed.notify()
        except Exception as error:
            end = error
        with changed:
            fault.append(end)
            changed.notify()

    with stream:
        threading.Thread(target=read, name="newest", daemon=True).start()
        while True:
            with changed:
                while not waiting and not fault:
                    interruptions.wait(changed, _WAIT_SECONDS)
                if not waiting:
                    break
                part = waiting.pop(next(iter(waiting)))
            yield part
    if not isinstance(fault[0], StopIteration):
        raise fault[0]
