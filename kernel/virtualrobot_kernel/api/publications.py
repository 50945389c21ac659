"""Tells the API's event loop that the world thread has published: watchers wait here, at no cost."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World


class Publications:
    """Belongs to one event loop; `published` alone is called from the world thread."""

    def __init__(self, world: World, loop: asyncio.AbstractEventLoop) -> None:
        """Listen to `world` on behalf of coroutines in `loop`."""
        self._world = world
        self._loop = loop
        self._waiters: list[asyncio.Future[None]] = []
        self._wanted = False
        world.listen(self.published)

    def published(self) -> None:
        """Wake the waiters; called by the world thread after each snapshot."""
        if self._wanted and not self._loop.is_closed():
            self._wanted = False
            self._loop.call_soon_threadsafe(self._wake)

    def _wake(self) -> None:
        waiters, self._waiters = self._waiters, []
        for waiter in waiters:
            if not waiter.done():
                waiter.set_result(None)

    async def newer_than(self, seen: Snapshot) -> Snapshot:
        """Return the latest snapshot as soon as it is another one than `seen`."""
        while self._world.snapshot is seen:
            waiter = self._loop.create_future()
            self._waiters.append(waiter)
            self._wanted = True
            if self._world.snapshot is not seen:
                break
            await waiter
        return self._world.snapshot

    async def snapshots(self, max_rate_hertz: float) -> AsyncIterator[Snapshot]:
        """Yield the latest snapshot, then later ones at most this often; a slow reader skips states."""
        snapshot = self._world.snapshot
        while True:
            yield snapshot
            await asyncio.sleep(1.0 / max_rate_hertz)
            snapshot = await self.newer_than(snapshot)

    async def every_signal_change(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot and then each one whose signals differ from the one before, none left out.

        Raise KernelError when the reader is more than `BACKLOG` changes late.
        """
        queue: asyncio.Queue[Snapshot] = asyncio.Queue()
        last = first = self._world.snapshot

        def published() -> None:
            nonlocal last
            snapshot = self._world.snapshot
            if snapshot.state.signals is not last.state.signals:
                last = snapshot
                self._loop.call_soon_threadsafe(queue.put_nowait, snapshot)

        self._world.listen(published)
        try:
            if first.state.signals is not self._world.snapshot.state.signals:
                published()
            yield first
            while True:
                yield await queue.get()
                if queue.qsize() > BACKLOG:
                    raise KernelError(f"the reader of this watch is more than {BACKLOG} changes late; watch again")
        finally:
            self._world.unlisten(published)


BACKLOG = 10_000
"""How many signal changes a reader may be late."""
