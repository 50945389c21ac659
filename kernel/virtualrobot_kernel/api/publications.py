"""Publications of the world thread for the API's event loop: watchers wait here, at no cost.

Whatever a call waits for it waits for here, so that the end of the kernel reaches every call at once.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Sequence
from typing import Any, TypeVar

from virtualrobot_kernel.api.backlog import Backlog
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.values import not_negative
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.state import Motion, Snapshot
from virtualrobot_kernel.world.store import World

T = TypeVar("T")

BACKLOG = 10_000
"""Greatest number of signal changes, or of steps, that a reader may be late."""

PROGRESS_SECONDS = 0.25
"""Period (s) at which a call tells how far long work is."""

SHORTEST_PAUSE_SECONDS = 0.001
"""Shortest pause (s) of an event loop: a watch with a shorter one is told every snapshot that comes."""

DEFAULT_RATE_HERTZ = 30.0

MOST_TOGETHER = 500
"""Greatest number of ticks or readings that are told at once: others are answered between two parts."""


def pause_seconds(max_rate_hertz: float, default: float = DEFAULT_RATE_HERTZ) -> float:
    """Return the pause between messages of a watch by its rate (0: the default); raise KernelError for nonsense."""
    return 1.0 / (not_negative(max_rate_hertz, "max_rate_hertz") or default)


class Publications:
    """Publications for one event loop; `published` alone is called from the world thread."""

    def __init__(self, world: World, loop: asyncio.AbstractEventLoop) -> None:
        """Listen to `world` on behalf of coroutines in `loop`."""
        self._world = world
        self._loop = loop
        # Who waits takes itself out again: a callback of each future would cost more than the rest of the waiting.
        self._readers: set[asyncio.Future[None]] = set()
        self._motion_watchers: set[asyncio.Future[None]] = set()
        self._others: set[asyncio.Future[None]] = set()
        self._wanted = False
        self._last_ended = _last_ended(world.snapshot)
        self.closed = False
        world.listen(self.published)

    def close(self) -> None:
        """Raise SHUTTING_DOWN in everybody who waits here, or ever will."""
        self.closed = True
        for waiter in (*self._readers, *self._motion_watchers, *self._others):
            if not waiter.done():
                waiter.set_exception(ending())

    def published(self) -> None:
        """Wake who waits for this snapshot; called by the world thread after each one."""
        if self._loop.is_closed():
            return
        if self._wanted:
            self._wanted = False
            self._loop.call_soon_threadsafe(self._wake_readers)
        ended = _last_ended(self._world.snapshot)
        if ended is not self._last_ended:
            self._last_ended = ended
            self._loop.call_soon_threadsafe(self._wake_motion_watchers)

    def _wake_readers(self) -> None:
        readers, self._readers = self._readers, set()
        for reader in readers:
            resolve(reader)

    def _wake_motion_watchers(self) -> None:
        for watcher in self._motion_watchers:
            resolve(watcher)

    def _waiter(self) -> asyncio.Future[None]:
        """Return a future to wait for; who waits for it keeps it where `close` finds it."""
        if self.closed:
            raise ending()
        return self._loop.create_future()

    async def _wait(self, waiter: asyncio.Future[None], among: set[asyncio.Future[None]]) -> None:
        among.add(waiter)
        try:
            await waiter
        finally:
            among.discard(waiter)

    async def _sleep(self, seconds: float, among: set[asyncio.Future[None]]) -> None:
        waiter = self._waiter()
        timer = self._loop.call_later(seconds, resolve, waiter)
        try:
            await self._wait(waiter, among)
        finally:
            timer.cancel()

    async def pause(self, seconds: float) -> None:
        """Wait for some seconds of the wall clock."""
        await self._sleep(seconds, self._others)

    async def is_done(self, work: asyncio.Future[Any]) -> bool:
        """Wait for some work until it is time to tell how far it is, and return whether it is done."""
        waiter = self._waiter()
        self._others.add(waiter)
        try:
            await asyncio.wait({work, waiter}, timeout=PROGRESS_SECONDS, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._others.discard(waiter)
        if waiter.done():
            waiter.result()  # raises that the kernel is ending
        return work.done()

    async def end_of_motion(self, id: str, seconds: float) -> None:
        """Wait until a motion has ended, but no longer than some seconds of the wall clock; no tick wakes who waits."""
        due = self._loop.time() + seconds
        while (left := due - self._loop.time()) >= SHORTEST_PAUSE_SECONDS and _runs(self._world.snapshot, id):
            await self._sleep(left, self._motion_watchers)

    async def newer_than(self, seen: Snapshot) -> Snapshot:
        """Return the latest snapshot as soon as it is another one than `seen`."""
        while self._world.snapshot is seen:
            reader = self._waiter()
            self._readers.add(reader)
            try:
                self._wanted = True
                if self._world.snapshot is seen:  # else it came before anybody wanted it
                    await reader
            finally:
                self._readers.discard(reader)
        return self._world.snapshot

    async def snapshots(self, max_rate_hertz: float, default: float = DEFAULT_RATE_HERTZ) -> AsyncIterator[Snapshot]:
        """Yield the latest snapshot, then later ones at most this often (0: the default); slow readers skip states."""
        pause = pause_seconds(max_rate_hertz, default)
        snapshot = self._world.snapshot
        while True:
            yield snapshot
            if pause > SHORTEST_PAUSE_SECONDS:
                await self.pause(pause)
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

        end = self._world.listen(published)
        try:
            first = self._world.snapshot
            yield first
            while True:
                while not changes:
                    waiter = self._waiter()
                    await self._wait(waiter, self._others)
                if len(changes) > BACKLOG:
                    raise KernelError(f"the reader of this watch is more than {BACKLOG} changes late; watch again")
                snapshot = changes.popleft()
                if snapshot.revision > first.revision:  # others came between listening and looking
                    yield snapshot
        finally:
            end()

    async def every_tick(self, max_rate_hertz: float) -> AsyncGenerator[list[tuple[int, Snapshot]], None]:
        """Yield the latest snapshot, and then every tick since, some together, none left out.

        Each comes with how many ticks before it were lost: the reader is farther behind than a `Backlog` lets him.
        At most so many times a second (0: the default). Where time is stepped, changes between two ticks are told, too.
        """
        pause = pause_seconds(max_rate_hertz)
        backlog: Backlog[Snapshot] = Backlog(_snapshot_bytes)
        parts = self._kept(backlog, self._listen_states)
        try:
            await anext(parts)
            last = self._world.snapshot
            yield [(0, last)]
            async for came in parts:
                told = []
                for snapshot in came:
                    if snapshot.revision > last.revision:  # else it came between listening and looking
                        told.append((_lost(last, snapshot), snapshot))
                        last = snapshot
                if told:
                    yield told
                if pause > SHORTEST_PAUSE_SECONDS:
                    await self.pause(pause)
        finally:
            await parts.aclose()

    def _listen_states(self, listener: Callable[[Snapshot], None]) -> Callable[[], None]:
        """Have a listener told each tick, and each change between two where time is stepped; return what ends it."""
        world, told = self._world, -1

        def ticked(snapshot: Snapshot) -> None:
            nonlocal told
            if snapshot.revision > told:
                told = snapshot.revision
                listener(snapshot)

        def published() -> None:
            if world.clock.mode is Mode.STEPPED:
                ticked(world.snapshot)

        ends = world.listen_ticks(ticked), world.listen(published)

        def end() -> None:
            for one in ends:
                one()

        return end

    async def every_one(
        self, subscribe: Callable[[Callable[[T], None]], Callable[[], None]], size_of: Callable[[T], int]
    ) -> AsyncGenerator[list[T], None]:
        """Yield nothing at once, and then all that a listener is told, in order, as far as a `Backlog` has kept it.

        `subscribe` takes the listener, which any thread may call, one at a time, and returns what ends it.
        """
        parts = self._kept(Backlog(size_of), subscribe)
        try:
            async for part in parts:
                yield part
        finally:
            await parts.aclose()

    async def _kept(
        self, backlog: Backlog[T], subscribe: Callable[[Callable[[T], None]], Callable[[], None]]
    ) -> AsyncGenerator[list[T], None]:
        """Yield nothing at once, and then what a listener is told and a backlog has kept."""
        waits = False
        waiter: asyncio.Future[None] | None = None

        def wake() -> None:
            if waiter is not None:
                resolve(waiter)

        def listener(told: T) -> None:
            nonlocal waits
            backlog.put(told)
            if waits and not self._loop.is_closed():  # a reader who is busy looks by himself
                waits = False
                self._loop.call_soon_threadsafe(wake)

        end = subscribe(listener)
        try:
            yield []
            while True:
                while not (came := backlog.take(MOST_TOGETHER)):
                    waiter = self._waiter()
                    waits = True
                    if not backlog:  # else it came before anybody waited
                        await self._wait(waiter, self._others)
                    waits = False
                yield came
        finally:
            end()

    async def every(
        self, subscribe: Callable[[Callable[[Sequence[T]], None]], Callable[[], None]]
    ) -> AsyncGenerator[Sequence[T], None]:
        """Yield nothing at once, and then all that a listener is told, in order, nothing left out.

        `subscribe` takes the listener, which any thread may call, and returns what ends it. Raise KernelError when the
        reader is more than `BACKLOG` late.
        """
        waiting: deque[T] = deque()
        waiter: asyncio.Future[None] | None = None

        def arrived(told: Sequence[T]) -> None:
            waiting.extend(told)
            if waiter is not None:
                resolve(waiter)

        def listener(told: Sequence[T]) -> None:
            if not self._loop.is_closed():
                self._loop.call_soon_threadsafe(arrived, told)

        end = subscribe(listener)
        try:
            yield ()
            while True:
                while not waiting:
                    waiter = self._waiter()
                    await self._wait(waiter, self._others)
                if len(waiting) > BACKLOG:
                    raise KernelError(f"the reader of this watch is more than {BACKLOG} late; watch again")
                told = tuple(waiting)
                waiting.clear()
                yield told
        finally:
            end()

    async def each(
        self, subscribe: Callable[[Callable[[object], None]], Callable[[], None]]
    ) -> AsyncGenerator[None, None]:
        """Yield at once, and again after calls of a listener.

        `subscribe` takes the listener and returns what ends it.
        """
        changed, posted = True, False
        waiter: asyncio.Future[None] | None = None

        def wake() -> None:
            nonlocal changed, posted
            changed, posted = True, False
            if waiter is not None:
                resolve(waiter)

        def listener(_: object) -> None:
            nonlocal posted
            if not posted:  # a loop that is behind is not told twice
                posted = True
                self._loop.call_soon_threadsafe(wake)

        end = subscribe(listener)
        try:
            while True:
                while not changed:
                    waiter = self._waiter()
                    await self._wait(waiter, self._others)
                changed = False
                yield
        finally:
            end()


def _snapshot_bytes(snapshot: Snapshot) -> int:
    return snapshot.world_t_node.nbytes + 4 * snapshot.state.q.nbytes


def _lost(before: Snapshot, after: Snapshot) -> int:
    """Return how many ticks there were between two that are told one after the other."""
    if before.state.epoch != after.state.epoch:
        return 0
    return max(after.state.tick - before.state.tick - 1, 0)


def _runs(snapshot: Snapshot, id: str) -> bool:
    return any(motion.id == id for motion in snapshot.state.motions)


def _last_ended(snapshot: Snapshot) -> Motion | None:
    """Return the motion that ended last: each end makes it another object."""
    return snapshot.state.ended[-1] if snapshot.state.ended else None


def ending() -> KernelError:
    """Return the error of calls when the kernel ends."""
    return KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)


def resolve(future: asyncio.Future[None]) -> None:
    """Wake whoever waits for the future."""
    if not future.done():
        future.set_result(None)
