"""Calls that wait for the components of robots: a few at a time for each robot, so that one robot holds up no other."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import TypeVar
from weakref import WeakValueDictionary

AT_ONCE = 4
"""How many calls for one robot have a thread; the others wait without one."""

THREADS = 64
"""Most of them wait for a component in another process, which may take as long as its deadline."""

Result = TypeVar("Result")


class Turns:
    """Owns the threads that solve; asked from the API's thread only."""

    def __init__(self) -> None:
        """Start no thread before it is needed."""
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="solver")
        self._gates: WeakValueDictionary[int, asyncio.Semaphore] = WeakValueDictionary()

    async def run(self, robots: Iterable[int], function: Callable[[], Result]) -> Result:
        """Return what `function` returns in a thread that counts for these robots (uids) until it is done.

        It counts too when the caller has gone away meanwhile: a thread cannot be taken back.
        """
        gates: list[asyncio.Semaphore] = []
        try:
            for uid in sorted(set(robots)):
                gate = self._gates.setdefault(uid, asyncio.Semaphore(AT_ONCE))
                await gate.acquire()
                gates.append(gate)
            work = self._threads.submit(function)
        except BaseException:
            for gate in gates:
                gate.release()
            raise
        loop = asyncio.get_running_loop()

        def done(_: Future[Result]) -> None:
            with suppress(RuntimeError):  # the loop has ended, and with it whoever waits for a turn
                loop.call_soon_threadsafe(release)

        def release() -> None:
            for gate in gates:
                gate.release()

        work.add_done_callback(done)
        return await asyncio.wrap_future(work)

    def close(self) -> None:
        """Begin nothing more; what has begun goes on."""
        self._threads.shutdown(wait=False, cancel_futures=True)
