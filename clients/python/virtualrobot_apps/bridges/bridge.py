"""A bridge that runs: signals of a kernel go out to a peer and come in from it, as a mapping says."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Mapping

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError, WrongStateError
from virtualrobot.signals import SignalChange

from virtualrobot_apps.bridges.mapping import BridgeMapping, Entry, Value
from virtualrobot_apps.bridges.peer import Peer, PeerError
from virtualrobot_apps.bridges.words import BadValueError, Raw, to_raw, to_signal

AGAIN_SECONDS = 1.0
LOOK_SECONDS = 0.1


class Bridge:
    """Signals of a kernel and a peer, each told the other's changes; it reconnects by itself and says so.

    Changes of signals go out in their order, none is left out while the peer answers. While it does not, the newest
    value of each waits; `connected` is off, and signals that have a `lost` take it.

    Example:
        >>> Bridge(client, mapping, ModbusClient(mapping, "tcp://plc:502")).run()
    """

    def __init__(self, client: Client, mapping: BridgeMapping, peer: Peer, say: Callable[[str], None] = print) -> None:
        """Check a mapping against a kernel; nothing is opened yet.

        Raises:
            MalformedFileError: for a signal that is not there or of another type, with its line.
        """
        self._client, self._mapping, self._peer, self._say = client, mapping, peer, say
        values = {one.name: one.value for one in client.signals.read()}
        mapping.check_signals(values)
        self._kinds = {name: type(value) for name, value in values.items()}
        self._in = [entry for entry in mapping.entries if entry.incoming]
        self._out = {entry.signal: entry for entry in mapping.entries if not entry.incoming}
        self._world: dict[str, Value] = values
        self._told: dict[str, Value] = {}
        self._bad: dict[str, str] = {}
        self._missed = 0
        self._open = False

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Go on until it is interrupted or `until` is true, which is asked ten times a second.

        Raises:
            KernelGoneError: when the kernel ends.
            WrongStateError: when a signal that is mapped is removed.
        """
        asyncio.run(self._run(until))

    async def _run(self, until: Callable[[], bool]) -> None:
        self._changes: asyncio.Queue[SignalChange | VirtualRobotError] = asyncio.Queue()
        loop = asyncio.get_running_loop()
        watch = self._client.signals.follow([entry.signal for entry in self._mapping.entries])
        changes = iter(watch)
        # The first tells all signals, which are no changes.
        self._world.update((await asyncio.to_thread(next, changes)).values)
        ended = False

        def follow() -> None:
            try:
                for change in changes:
                    loop.call_soon_threadsafe(self._changes.put_nowait, change)
            except VirtualRobotError as error:
                if not ended:
                    loop.call_soon_threadsafe(self._changes.put_nowait, error)

        thread = threading.Thread(target=follow, name="signals", daemon=True)
        thread.start()
        main = asyncio.create_task(self._sessions())
        try:
            while not until() and not main.done():
                await asyncio.wait({main}, timeout=LOOK_SECONDS)
            if main.done():
                await main
        finally:
            ended = True
            await _end({main})
            watch.close()
            await asyncio.to_thread(thread.join)

    async def _sessions(self) -> None:
        words = ""
        while True:
            try:
                await self._peer.open()
                self._say(f"{self._peer.name}: connected{self._missed_words()}")
                words = ""
                self._open = True
                await self._set({self._mapping.connected: True} if self._mapping.connected else {})
                await self._talk()
            except PeerError as error:
                if self._open:
                    self._say(f"{self._peer.name}: lost: {error}; it is tried again each {AGAIN_SECONDS:g} s")
                elif str(error) != words:
                    self._say(f"{self._peer.name}: {error}; it is tried again each {AGAIN_SECONDS:g} s")
                words = str(error)
            finally:
                self._open = False
                await self._peer.close()
                self._told.clear()
                await self._set(self._lost())
            await self._wait()

    async def _talk(self) -> None:
        """Read and write until one of them fails."""
        await self._write(dict(self._world), forced=True)
        tasks = {asyncio.create_task(self._reading()), asyncio.create_task(self._writing())}
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            await _end(tasks)

    async def _reading(self) -> None:
        while True:
            values: dict[str, Value] = {}
            for entry, raw in (await self._peer.read()).items():
                try:
                    value = to_signal(entry, raw, self._kinds[entry.signal])
                except BadValueError as error:
                    self._tell_bad(entry, str(error))
                    continue
                self._tell_good(entry)
                if self._differs(entry, self._told.get(entry.signal), value):
                    values[entry.signal] = self._told[entry.signal] = value
            await self._set(values)

    async def _writing(self) -> None:
        while True:
            values: dict[str, Value] = {}
            change = await self._next()
            while change is not None:
                # What changes twice goes out twice.
                if values.keys() & change.values.keys():
                    await self._write(values)
                    values = {}
                values.update(change.values)
                change = None if self._changes.empty() else await self._next()
            await self._write(values)

    async def _wait(self) -> None:
        """Wait until the peer is tried again, and hear of signals meanwhile."""
        end = asyncio.get_running_loop().time() + AGAIN_SECONDS
        while (left := end - asyncio.get_running_loop().time()) > 0:
            try:
                async with asyncio.timeout(left):
                    change = await self._next()
            except TimeoutError:
                return
            self._missed += sum(name in self._out for name in change.values)

    async def _next(self) -> SignalChange:
        change = await self._changes.get()
        if isinstance(change, VirtualRobotError):
            raise change
        if change.removed:
            raise WrongStateError(f"signals that are mapped are gone: {', '.join(map(repr, change.removed))}")
        self._world.update(change.values)
        return change

    async def _write(self, values: Mapping[str, Value], forced: bool = False) -> None:
        raws: dict[Entry, Raw] = {}
        for name, value in values.items():
            entry = self._out.get(name)
            if entry is None or isinstance(value, tuple):
                continue
            if not forced and not self._differs(entry, self._told.get(name), value):
                continue
            try:
                raws[entry] = to_raw(entry, value)
            except BadValueError as error:
                self._tell_bad(entry, str(error))
                continue
            self._tell_good(entry)
            self._told[name] = value
        if raws:
            await self._peer.write(raws)

    async def _set(self, values: Mapping[str, Value]) -> None:
        if not values:
            return
        try:
            await asyncio.to_thread(self._client.signals.set, values)
        except ConnectionError:
            raise
        except VirtualRobotError as error:
            for name in values:
                self._told.pop(name, None)
                if self._bad.get(name) != str(error):
                    self._bad[name] = str(error)
                    self._say(f"{self._peer.name}: {name!r} cannot be set: {error}")

    def _lost(self) -> dict[str, Value]:
        values: dict[str, Value] = {entry.signal: entry.lost for entry in self._in if entry.lost is not None}
        return values | ({self._mapping.connected: False} if self._mapping.connected else {})

    def _differs(self, entry: Entry, before: Value | None, value: Value) -> bool:
        if before is None or not entry.deadband or isinstance(before, str | tuple) or isinstance(value, str | tuple):
            return before is None or value != before
        return abs(value - before) > entry.deadband

    def _tell_bad(self, entry: Entry, words: str) -> None:
        if entry.signal not in self._bad:
            way = "is not taken" if entry.incoming else "is not sent"
            self._say(f"{self._peer.name}: {entry.signal!r} ({entry.place}) {way}: {words}")
        self._bad[entry.signal] = words

    def _tell_good(self, entry: Entry) -> None:
        if self._bad.pop(entry.signal, None) is not None:
            self._say(f"{self._peer.name}: {entry.signal!r} ({entry.place}) is fine again")

    def _missed_words(self) -> str:
        missed, self._missed = self._missed, 0
        return f"; {missed} changes were not told meanwhile, the newest values are" if missed else ""


async def _end(tasks: set[asyncio.Task[None]]) -> None:
    """Cancel tasks until they have ended: libraries, and asyncio.wait_for before Python 3.12, may swallow it."""
    while waiting := {task for task in tasks if not task.done()}:
        for task in waiting:
            task.cancel()
        await asyncio.wait(waiting, timeout=LOOK_SECONDS)
    await asyncio.gather(*tasks, return_exceptions=True)
