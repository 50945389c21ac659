"""Watches a worker process while it works: its deadline and its memory."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import psutil

from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.worker.process import Process

_TICK_SECONDS = 0.1
_TICKS_AFTER_A_CALL = 3
_MIB = 1 << 20


class Guard:
    """Owns the thread that kills a process which does not answer in time or takes too much memory."""

    def __init__(self, process: Process) -> None:
        """Watch `process`; nothing is due yet, and memory is free."""
        self._process = process
        self._lock = threading.Lock()
        self._fault: ComponentFault | None = None
        self._doing = ""
        self._seconds = 0.0
        self._due: float | None = None
        self._waited: float | None = None
        self._memory_before = 0
        self._memory_limit: int | None = None
        self._awake = threading.Event()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, name=f"worker-guard-{process.name}", daemon=True)
        self._thread.start()

    def begin(self, doing: str, seconds: float) -> None:
        """Kill the process unless `end` is called within `seconds`."""
        with self._lock:
            self._doing, self._seconds, self._due = doing, seconds, time.monotonic() + seconds
            self._waited = None  # looked at by the thread: most calls are over before
        if not self._awake.is_set():
            self._awake.set()

    def end(self) -> ComponentFault | None:
        """Return why the process was killed meanwhile, if it was."""
        with self._lock:
            self._due = None
            return self._fault

    @property
    def fault(self) -> ComponentFault | None:
        """Fault for which the process was killed, or is about to be; None: it was not."""
        return self._fault

    def limit_memory(self, growth_bytes: int) -> None:
        """Let the process grow by so much from what it has now."""
        with self._lock:
            self._memory_before, self._memory_limit = self._memory() or 0, growth_bytes

    def condemn(self, fault: ComponentFault) -> ComponentFault:
        """Kill the process for `fault`, if it was not killed for another one before; return the first."""
        with self._lock:
            self._fault = self._fault or fault
        self._process.kill()
        return self._fault

    def close(self) -> None:
        """Stop watching."""
        self._over.set()
        self._awake.set()
        self._thread.join()

    def _watch(self) -> None:
        idle = 0
        while self._awake.wait() and not self._over.is_set():
            with self._lock:
                due = self._due
            before = time.monotonic()
            pause = _TICK_SECONDS if due is None else min(_TICK_SECONDS, max(due - before, 0.0))
            if self._over.wait(pause):
                return
            late = time.monotonic() - before - pause
            fault = self._check(late)
            if fault is not None:
                self._execute(fault)
                return
            idle = idle + 1 if due is None else 0
            if idle >= _TICKS_AFTER_A_CALL:
                self._sleep()

    def _sleep(self) -> None:
        """Sleep until the next call."""
        self._awake.clear()
        with self._lock:
            if self._due is not None:
                self._awake.set()
        if self._over.is_set():
            self._awake.set()

    def _check(self, late: float) -> ComponentFault | None:
        """Return what is wrong and make it the fault; `late` is how long this process kept the thread from running."""
        memory = self._memory()
        waited = _waited_for_a_core(self._process.pid)
        with self._lock:
            if self._due is not None:
                # A stall of the parent is not the component's: its answer may be waiting in the pipe. Nor is the time
                # for which others had the cores.
                self._due += max(late, waited - (waited if self._waited is None else self._waited))
                self._waited = waited
                if time.monotonic() >= self._due:
                    self._fault = ComponentFault(
                        FaultKind.HUNG, f"{self._doing} gave no answer within {self._seconds:g} s"
                    )
            if self._fault is None and memory is not None and self._memory_limit is not None:
                grown = memory - self._memory_before
                if grown > self._memory_limit:
                    self._fault = ComponentFault(
                        FaultKind.GREW,
                        f"its process grew by {grown / _MIB:.0f} MiB to {memory / _MIB:.0f} MiB; it may grow by "
                        f"{self._memory_limit / _MIB:.0f} MiB",
                    )
            return self._fault

    def _execute(self, fault: ComponentFault) -> None:
        if fault.kind is FaultKind.HUNG:
            self._process.ask_where()
        # The fault may have been raised already; what comes now is for those who ask again.
        fault.details = fault.details or self._process.last_lines()
        self._process.kill()

    def _memory(self) -> int | None:
        try:
            return psutil.Process(self._process.pid).memory_info().rss
        except psutil.Error:
            return None


def _waited_for_a_core(pid: int) -> float:
    """Return for how long a process has been ready to run and has not run (s); 0 where the system doesn't tell."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text().split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0
