"""Limit of calls that wait for components: a few at a time for each robot or ray caster; one holds up no other."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import TypeVar
from weakref import WeakValueDictionary

AT_ONCE = 4
"""Number of calls for one robot or ray caster that have a thread; the others wait without one."""

THREADS = 64
"""Greatest number of threads: most wait for a component in another process, which may take as long as its deadline."""

Result = TypeVar("Result")

IsGone = Callable[[], bool]
"""True once nobody waits for some work any more."""


class KeyedLimiter:
    """Limiter of calls by their keys, with the threads that solve; asked from the API's thread only."""

    def __init__(self) -> None:
        """Start no thread before it is needed."""
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="solver")
        self._gates: WeakValueDictionary[int | str, asyncio.Semaphore] = WeakValueDictionary()

    async def run(self, whom: Iterable[int | str], function: Callable[[], Result]) -> Result:
        """Return what `function` returns in a thread that counts for these robots (uids) or ray casters (names).

        It counts until it is done, also when the caller has gone away meanwhile: a thread cannot be taken back.
        """
        gates: list[asyncio.Semaphore] = []
        try:
            for one in sorted(set(whom), key=str):
                gate = self._gates.setdefault(one, asyncio.Semaphore(AT_ONCE))
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
        try:
            return await asyncio.wrap_future(work)
        finally:
            # What it raised has this frame in its traceback: together they would keep each other, and the component
            # that was asked, until the garbage is collected.
            del work

    async def run_while_wanted(self, whom: Iterable[int | str], work: Callable[[IsGone], Result]) -> Result:
        """Return what `work` returns as `run` does; it may ask whether the call was cancelled meanwhile."""
        gone = threading.Event()
        try:
            return await self.run(whom, lambda: work(gone.is_set))
        finally:
            gone.set()

    def close(self) -> None:
        """Begin nothing more; what has begun goes on."""
        self._threads.shutdown(wait=False, cancel_futures=True)
