"""Thread of one sensor: makes its reader, and a reading whenever one is due or asked for."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from virtualrobot_kernel.background import give_way
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.sensing.cpu_slots import CpuSlots
from virtualrobot_kernel.sensing.reading import Content, Moment, Reader, Reading, SensorState
from virtualrobot_kernel.sensing.schedule import Instant, Schedule
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

MAKE_SECONDS = 60.0
"""Longest time (s) until a sensor is ready: two components may have to be started in processes of their own."""

QUICK_SECONDS = 0.02
"""Longest mean time (s) of readings that are quick: such sensors wait behind each other, and behind no picture."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class _Ask:
    instant: Instant
    number: int
    kinds: object | None
    done: Future[Reading] = field(default_factory=Future)


class _Due:
    """Says in the queue that a reading is due."""


class SensorWorker:
    """Owns the thread and the reader of one sensor, from its start (or the first single reading) to its end.

    `tick`, `settle` and `end` are called by the world thread, `ask` by anybody. No lock is held while it reads.
    """

    def __init__(
        self,
        node: Node,
        make: Callable[[], Reader],
        tell: Callable[[Reading], None],
        now: Callable[[], Snapshot],
        turns: tuple[CpuSlots, CpuSlots],
        waited_for: Callable[[], bool],
        schedule: Schedule | None,
        before: SensorWorker | None = None,
        first: int = 0,
    ) -> None:
        """Prepare; `start` begins.

        Args:
            node: the sensor as it is set.
            make: makes its reader, in the sensor's thread.
            tell: is called with each reading that was due, and with a fault; it must return at once.
            now: returns the world as it is.
            turns: those of sensors that compute in this process: while their readings are quick, and of others.
            waited_for: tells whether time waits for readings; else its thread gives way to ticks and calls, from the
                first reading on that nobody waits for.
            schedule: when readings are due; None: only those that are asked for are made.
            before: the worker whose readings go on to be counted here.
            first: without one, how many readings count as made: those of a kernel that has ended.
        """
        self.node = node
        self.schedule = schedule
        self.fault = ""
        self.reader: Reader | None = None
        self.number = before.number if before else first
        self.missed = before.missed if before else 0
        self._timed = before._timed if before else 0
        self._seconds = before._seconds if before else 0.0
        self._make, self._tell, self._now, self._turns = make, tell, now, turns
        self._waited_for = waited_for
        self._give_back: Callable[[], None] = lambda: None
        self._cause: Exception | None = None
        self._queue: queue.SimpleQueue[_Ask | type[_Due] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._due: tuple[Instant, int] | None = None
        self._busy_since: float | None = None
        self._ended = False
        self._ready = threading.Event()
        self._settled = threading.Event()
        self._settled.set()
        self._thread = threading.Thread(target=self._run, name=f"sensor {node.name}"[:60], daemon=True)

    @property
    def ended(self) -> bool:
        """Return whether it makes no more readings."""
        return self._ended

    @property
    def history_seconds(self) -> float | None:
        """Return how much of the past its reader needs; None while that is not known."""
        if self._ended:
            return 0.0
        return self.reader.history_seconds if self.reader is not None else None

    @property
    def mean_seconds(self) -> float:
        """Return the mean time of a reading; 0 before the first."""
        return self._seconds / self._timed if self._timed else 0.0

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def tick(self, instant: Instant) -> None:
        """Have a reading made where one is due; one that was not begun yet is left out for it, and counted."""
        if self.schedule is None or not (count := self.schedule.due(instant.snapshot.state.tick)) or self._ended:
            return
        reader = self.reader
        if reader is not None and self.is_late():
            self.give_up(self._too_late(reader))
            return
        with self._lock:
            waiting = self._due is not None
            self.missed += count if waiting else count - 1
            self._due = instant, self.schedule.count
            self._settled.clear()
        if not waiting:
            self._queue.put(_Due)

    def settle(self) -> None:
        """Wait until it is ready and all that was due is made; past its deadline it has a fault."""
        if not self._ready.wait(MAKE_SECONDS):
            self.give_up(f"it was not ready within {MAKE_SECONDS:g} s")
        reader = self.reader
        if reader is not None and not self._settled.wait(reader.deadline_seconds):
            self.give_up(self._too_late(reader))

    @property
    def patience_seconds(self) -> float:
        """Return how long to wait for a reading that was asked for before `is_late` is asked."""
        return MAKE_SECONDS if self.reader is None else self.reader.deadline_seconds

    def is_late(self) -> bool:
        """Return whether the reading that it makes takes longer than it may; what waits its turn is not late."""
        since, reader = self._busy_since, self.reader
        return since is not None and reader is not None and time.monotonic() - since > reader.deadline_seconds

    def ask(self, instant: Instant, number: int, kinds: object | None) -> Future[Reading]:
        """Have one reading made; it is not told to anybody else, nor counted among those that were due."""
        ask = _Ask(instant, number, kinds)
        with self._lock:
            if not self._ended:
                self._queue.put(ask)
                return ask.done
        ask.done.set_exception(self._refusal())
        return ask.done

    def end(self) -> None:
        """Make no more readings; what was asked for before is answered still."""
        with self._lock:
            self._ended = True
        self._settled.set()
        self._ready.set()
        self._queue.put(None)

    def give_up(self, fault: str, cause: Exception | None = None) -> None:
        """End with a fault, even if a component never returns: then its thread is left to itself."""
        now = self._now()
        with self._lock:
            if self._ended:
                return
            self._ended, self.fault, self._cause = True, fault, cause
            if self.schedule is not None:
                self._tell(self.silent(now, SensorState.FAULT, fault))
        self._give_back()
        self._settled.set()
        self._ready.set()
        self._refuse_asks()
        self._queue.put(None)

    def silent(self, snapshot: Snapshot, state: SensorState, fault: str = "") -> Reading:
        """Return a reading that says nothing but how the sensor is."""
        return self._reading(snapshot, self.number, self.missed, None, state, 0.0, fault)

    def join(self, seconds: float) -> None:
        """Wait for the end of its thread."""
        if self._thread.is_alive():
            self._thread.join(seconds)

    @staticmethod
    def _too_late(reader: Reader) -> str:
        return f"a reading was not made within {reader.deadline_seconds:g} s"

    def _run(self) -> None:
        if self._ended:
            self._refuse_asks()
            return
        try:
            reader = self._make()
        except Exception as error:
            self._failed(error)
            self._refuse_asks()  # it may have been ended before, by a change
            return
        self.reader = reader
        self._ready.set()
        gives_way = False
        try:
            while (item := self._queue.get()) is not None:
                if not (gives_way or self._waited_for()):
                    # Not before: processes of components that the reader starts would give way too.
                    give_way()
                    gives_way = True
                if isinstance(item, _Ask):
                    self._read_asked(reader, item)
                else:
                    self._read_due(reader)
        finally:
            reader.close()

    def _read_due(self, reader: Reader) -> None:
        with self._lock:
            due, self._due = self._due, None
            if due is None or self._ended:
                return
            self.number += 1
            number, missed = self.number, self.missed
        self._take_turn(reader)
        began = time.monotonic()
        try:
            content = reader.read(self._moment(*due, reader))
        except Exception as error:
            self._failed(error)
            return
        finally:
            self._end_turn()
        seconds = time.monotonic() - began
        with self._lock:
            self._seconds += seconds
            self._timed += 1
            if not self._ended:
                self._tell(self._reading(due[0].snapshot, number, missed, content, SensorState.RUNNING, seconds))
            if self._due is None:
                self._settled.set()

    def _read_asked(self, reader: Reader, ask: _Ask) -> None:
        if not ask.done.set_running_or_notify_cancel():
            return
        self._take_turn(reader)
        began = time.monotonic()
        try:
            content = reader.read(self._moment(ask.instant, ask.number, reader), ask.kinds)
        except Exception as error:
            if not isinstance(error, KernelError) or error.reason is Reason.PLUGIN_FAILED:
                self._failed(error)  # before the answer: who asks again then gets another worker
            ask.done.set_exception(error)
            return
        finally:
            self._end_turn()
        state = SensorState.STOPPED if self.schedule is None else SensorState.RUNNING
        seconds = time.monotonic() - began
        ask.done.set_result(self._reading(ask.instant.snapshot, ask.number, self.missed, content, state, seconds))

    def _take_turn(self, reader: Reader) -> None:
        if reader.takes_turns:
            quick = self._timed > 0 and self.mean_seconds <= QUICK_SECONDS
            self._give_back = self._turns[0 if quick else 1].take()
        self._busy_since = time.monotonic()

    def _end_turn(self) -> None:
        self._busy_since = None
        self._give_back()

    def _moment(self, instant: Instant, number: int, reader: Reader) -> Moment:
        seed: Any = getattr(self.node.data, "seed", 0)  # contact sensors have no noise
        return instant.moment(number, reader.history_seconds, seed, self.schedule)

    def _failed(self, error: Exception) -> None:
        """Take what a reader raised for the sensor's fault."""
        fault = str(error)
        if not isinstance(error, KernelError):
            log.error("the sensor %r failed inside the kernel", self.node.name, exc_info=error)
            fault = f"it failed inside the kernel: {type(error).__name__}: {error}"
        self.give_up(fault, error)

    def _reading(
        self,
        snapshot: Snapshot,
        number: int,
        missed: int,
        content: Content,
        state: SensorState,
        seconds: float,
        fault: str = "",
    ) -> Reading:
        uid = self.node.uid
        node = snapshot.structure.nodes.get(uid)
        pose = snapshot.world_t(uid) if node else np.eye(4)
        name = node.name if node else self.node.name
        return Reading(snapshot, uid, name, state, fault, number, missed, pose, content, seconds)

    def _refuse_asks(self) -> None:
        while True:
            try:
                item = self._queue.get_nowait()
            except queue.Empty:
                return
            if isinstance(item, _Ask) and item.done.set_running_or_notify_cancel():
                item.done.set_exception(self._refusal())

    def _refusal(self) -> KernelError:
        name, cause = self.node.name, self._cause
        if isinstance(cause, KernelError):
            refusal = KernelError(str(cause), reason=cause.reason)
            refusal.metadata.update(cause.metadata)
            return refusal
        if self.fault:
            return KernelError(
                f"the sensor {name!r} cannot read: {self.fault}", reason=Reason.PLUGIN_FAILED, sensor=name
            )
        return KernelError(
            f"the sensor {name!r} was changed or removed meanwhile; ask again", reason=Reason.WRONG_STATE, sensor=name
        )
