"""Tells the API's event loop that the world thread has published: watchers wait here, at no cost.

Whatever a call waits for it waits for here, so that the end of the kernel reaches every call at once.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World

BACKLOG = 10_000
"""How many signal changes a reader may be late."""

FASTEST_PAUSE_HERTZ = 1000.0
"""Event loops do not wait for less than a millisecond: from this rate on every snapshot that comes is told."""


class Publications:
    """Belongs to one event loop; `published` alone is called from the world thread."""

    def __init__(self, world: World, loop: asyncio.AbstractEventLoop) -> None:
        """Listen to `world` on behalf of coroutines in `loop`."""
        self._world = world
        self._loop = loop
        self._open: set[asyncio.Future[None]] = set()
        self._waiters: list[asyncio.Future[None]] = []
        self._wanted = False
        self.closed = False
        world.listen(self.published)

    def close(self) -> None:
        """Raise SHUTTING_DOWN in everybody who waits here, or ever will."""
        self.closed = True
        for future in tuple(self._open):
            if not future.done():
                future.set_exception(ending())

    def published(self) -> None:
        """Wake the waiters; called by the world thread after each snapshot."""
        if self._wanted and not self._loop.is_closed():
            self._wanted = False
            self._loop.call_soon_threadsafe(self._wake)

    def _wake(self) -> None:
        waiters, self._waiters = self._waiters, []
        for waiter in waiters:
            resolve(waiter)

    def future(self) -> asyncio.Future[None]:
        """Return a future to wait for, that the end of the kernel ends too."""
        if self.closed:
            raise ending()
        future: asyncio.Future[None] = self._loop.create_future()
        self._open.add(future)
        future.add_done_callback(self._open.discard)
        return future

    async def pause(self, seconds: float) -> None:
        """Wait for some seconds of the wall clock."""
        future = self.future()
        timer = self._loop.call_later(seconds, resolve, future)
        try:
            await future
        finally:
            timer.cancel()

    async def newer_than(self, seen: Snapshot) -> Snapshot:
        """Return the latest snapshot as soon as it is another one than `seen`."""
        while self._world.snapshot is seen:
            waiter = self.future()
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
            if max_rate_hertz < FASTEST_PAUSE_HERTZ:
                await self.pause(1.0 / max_rate_hertz)
            snapshot = await self.newer_than(snapshot)

    async def every_signal_change(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot and then each one whose signals differ from the one before, none left out.

        Raise KernelError when the reader is more than `BACKLOG` changes late.
        """
        changes: deque[Snapshot] = deque()
        waiter: asyncio.Future[None] | None = None
        last = self._world.snapshot

        def arrived(snapshot: Snapshot) -> None:
            changes.append(snapshot)
            if waiter is not None:
                resolve(waiter)

        def published() -> None:
            nonlocal last
            snapshot = self._world.snapshot
            if snapshot.state.signals is not last.state.signals:
                last = snapshot
                self._loop.call_soon_threadsafe(arrived, snapshot)

        self._world.listen(published)
        try:
            first = self._world.snapshot
            yield first
            while True:
                while not changes:
                    waiter = self.future()
                    await waiter
                if len(changes) > BACKLOG:
                    raise KernelError(f"the reader of this watch is more than {BACKLOG} changes late; watch again")
                snapshot = changes.popleft()
                if snapshot.revision > first.revision:  # others came between listening and looking
                    yield snapshot
        finally:
            self._world.unlisten(published)

    async def each(self, subscribe: Callable[[Callable[[object], None]], Callable[[], None]]) -> AsyncIterator[None]:
        """Yield at once, and again after calls of a listener.

        `subscribe` takes the listener and returns what ends it.
        """
        changed = True
        waiter: asyncio.Future[None] | None = None

        def wake() -> None:
            nonlocal changed
            changed = True
            if waiter is not None:
                resolve(waiter)

        def listener(_: object) -> None:
            self._loop.call_soon_threadsafe(wake)

        end = subscribe(listener)
        try:
            while True:
                while not changed:
                    waiter = self.future()
                    await waiter
                changed = False
                yield
        finally:
            end()


def ending() -> KernelError:
    """Return what calls are told when the kernel ends."""
    return KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)


def resolve(future: asyncio.Future[None]) -> None:
    """Let whoever waits for the future go on."""
    if not future.done():
        future.set_result(None)
