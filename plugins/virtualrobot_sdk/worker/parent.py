"""The parent's side: starts a worker process, lets it load plugins and make a component, and calls the component."""

from __future__ import annotations

import atexit
import threading
import weakref
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import EntryPoint
from types import TracebackType
from typing import Any

from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.worker.answers import unpack
from virtualrobot_sdk.worker.description import Description
from virtualrobot_sdk.worker.frames import NotAFrame, read_frame, write_frame
from virtualrobot_sdk.worker.guard import Guard
from virtualrobot_sdk.worker.process import Process
from virtualrobot_sdk.worker.sent import Sent

MEMORY_GROWTH_BYTES = 512 << 20
"""Bytes by which a component's process may grow after the component was made."""
LOADING_GROWTH_BYTES = 4 << 30
"""Bytes by which it may grow while a plugin is imported and a component made: whole libraries come in."""
LOADING_SECONDS = 60.0
"""The deadline for importing a plugin and for making a component, unless the caller says another."""
START_SECONDS = 60.0
"""Longest time (s) for the start of Python itself; no component's fault, so it is not part of a deadline."""
CLOSING_SECONDS = 1.0
"""Longest time (s) for a process to end by itself."""


class Worker:
    """Owns a process that runs one component; starts it when first asked something.

    Every method that asks raises:
        ArgumentError, FilesNeeded, PluginError: the component or its plugin raised it.
        ComponentFault: it raised anything else or gave nonsense, and can be asked again; or it did not answer in time,
            its process died or grew too much, and each further call raises this fault again.

    Calls of several threads wait for each other; a deadline counts from the moment that the process is asked.
    """

    def __init__(self, name: str, *, memory_limit_bytes: int = MEMORY_GROWTH_BYTES) -> None:
        """Make ready; `name` is for people: it stands before what the process prints, in the log."""
        self.name = name
        self._memory_limit = memory_limit_bytes
        self._asking = threading.Lock()
        self._running: tuple[Process, Guard] | None = None
        self._fault: ComponentFault | None = None
        self._number = 0
        self._sent = Sent()
        self._closing = False
        with _opening:
            _open.add(self)

    @property
    def pid(self) -> int | None:
        """Return the number of the process, or None while there is none."""
        running = self._running
        return running[0].pid if running else None

    @property
    def fault(self) -> ComponentFault | None:
        """Return what ended the process, if anything did; a fault that nobody met yet may still be unknown."""
        return self._fault

    @property
    def death(self) -> ComponentFault | None:
        """Fault of a process that has ended though nobody asks it anything just now; None: it lives, or never did."""
        if (running := self._running) is None:
            return None
        process, guard = running
        if ended := process.has_ended():
            return guard.fault or ComponentFault(FaultKind.DIED, f"its process {ended}", process.last_lines())
        return None

    def describe(self, entry_point: EntryPoint, *, deadline_seconds: float = LOADING_SECONDS) -> Description:
        """Import the plugin in the process and return what it registers."""
        with self._asking:
            self._limit_memory(LOADING_GROWTH_BYTES)
            return self._ask("describe", _plain(entry_point), f"importing {entry_point.value}", deadline_seconds)

    def make(
        self,
        entry_point: EntryPoint,
        kind: ComponentKind,
        component: str,
        settings: Mapping[str, Any],
        *arguments: object,
        deadline_seconds: float = LOADING_SECONDS,
    ) -> None:
        """Make the `component` of this name with plain `settings`; one made before is gone, whatever comes."""
        with self._asking:
            self._limit_memory(LOADING_GROWTH_BYTES)
            asked = (*_plain(entry_point), kind, component, dict(settings), arguments)
            self._ask("make", asked, f"making {component}", deadline_seconds)
            self._limit_memory(self._memory_limit)

    def make_from(self, path: str, *arguments: object, deadline_seconds: float = LOADING_SECONDS) -> None:
        """Make the component by calling the factory at `path`, `module:attribute`, with `arguments`."""
        with self._asking:
            self._limit_memory(LOADING_GROWTH_BYTES)
            self._ask("make_from", (path, arguments), f"making {path}", deadline_seconds)
            self._limit_memory(self._memory_limit)

    def call(self, method: str, *arguments: object, deadline_seconds: float) -> Any:  # noqa: ANN401  the method's own
        """Return what the component's method returns, or its attribute of this name."""
        with self._asking:
            return self._ask("call", (method, arguments), method, deadline_seconds)

    def close(self) -> None:
        """End the process; a call under way in another thread ends with a fault. May be called again."""
        grace = CLOSING_SECONDS
        self._closing = True
        if not self._asking.acquire(blocking=False):
            if running := self._running:
                running[1].condemn(self._closed())
            grace = 0.0
            self._asking.acquire()
        try:
            self._end(grace)
            self._fault = self._fault or self._closed()
        finally:
            self._asking.release()
        with _opening:
            _open.discard(self)

    def __enter__(self) -> Worker:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _closed(self) -> ComponentFault:
        return ComponentFault(FaultKind.DIED, f"worker {self.name!r} was closed")

    def _started(self) -> tuple[Process, Guard]:
        """Return the process and its guard, started now if there is none; raise the fault if there was one."""
        if self._fault is not None:
            raise _again(self._fault)
        if self._running is None:
            try:
                process = Process(self.name)
            except OSError as error:
                raise ComponentFault(FaultKind.DIED, f"its process cannot be started: {error}") from error
            self._running = process, Guard(process)
            if self._closing:
                # Who closes it may have come too early to see the process.
                raise _again(self._condemn(self._closed()))
            # Its first frame says that it is there.
            self._exchange(0, b"", "starting", START_SECONDS)
        return self._running

    def _limit_memory(self, growth_bytes: int) -> None:
        _, guard = self._started()
        guard.limit_memory(growth_bytes)

    def _ask(self, operation: str, arguments: tuple[object, ...], asked: str, seconds: float) -> Any:  # noqa: ANN401
        content = self._sent.pack((operation, seconds, arguments))
        self._started()
        self._number += 1
        try:
            return self._exchange(self._number, content, asked, seconds)
        except ComponentFault:
            self._sent.doubt()
            raise

    def _exchange(self, number: int, content: bytes, asked: str, seconds: float) -> Any:  # noqa: ANN401
        """Send the question, if there is one, and return the answer of this number."""
        process, guard = self._started()
        fault: ComponentFault | None = None
        frame = None
        try:
            guard.begin(asked, seconds)
            if content:
                write_frame(process.requests, number, content)
            frame = read_frame(process.answers)
        except (NotAFrame, MemoryError) as error:
            fault = ComponentFault(FaultKind.NONSENSE, f"{asked} gave no answer that can be read: {error}")
        except OSError:
            pass  # Nobody reads what is asked: as when nobody answers.
        except BaseException:
            # Ctrl-C in the middle of a frame: what would be read next belongs to this call.
            self._condemn(ComponentFault(FaultKind.DIED, f"{asked} was interrupted"))
            raise
        fault = guard.end() or fault
        if fault is None and frame is None:
            ended = process.how_it_ended()
            fault = ComponentFault(FaultKind.DIED, f"its process {ended} in {asked}", process.last_lines())
        if fault is None and frame is not None:
            try:
                if frame[0] != number:
                    raise NotAFrame(f"it is for call {frame[0]}, and this is call {number}")
                return unpack(frame[1], asked)
            except NotAFrame as error:
                fault = ComponentFault(FaultKind.NONSENSE, f"{asked} gave no answer that can be read: {error}")
        assert fault is not None
        raise _again(self._condemn(fault))

    def _condemn(self, fault: ComponentFault) -> ComponentFault:
        """End the process for this fault, or for one that was there before; return the one that counts."""
        if self._running is not None:
            fault = self._running[1].condemn(fault)
        self._fault = fault
        self._end(0.0)
        return fault

    def _end(self, grace_seconds: float) -> None:
        running, self._running = self._running, None
        if running is not None:
            process, guard = running
            guard.close()
            process.end(grace_seconds)


def _again(fault: ComponentFault) -> ComponentFault:
    """Return an equal fault to raise: one that is raised twice would gather tracebacks."""
    return ComponentFault(fault.kind, fault.reason, fault.details)


def _plain(entry_point: EntryPoint) -> tuple[str, str, str]:
    return entry_point.name, entry_point.value, entry_point.group


_open: weakref.WeakSet[Worker] = weakref.WeakSet()
_opening = threading.Lock()


def close_all() -> None:
    """Close all workers of this program at the same time, those too that are in the middle of a call."""
    with _opening:
        workers = list(_open)
    if workers:
        with ThreadPoolExecutor(len(workers)) as pool:
            list(pool.map(Worker.close, workers))


@atexit.register
def _close_forgotten() -> None:
    # One after the other: no more threads can be started now.
    for worker in list(_open):
        worker.close()
