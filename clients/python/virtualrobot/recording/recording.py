"""A recording of a running kernel: its watches are read by threads, and what they tell goes to a file."""

from __future__ import annotations

import math
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Protocol

from virtualrobot._wire import interruptions
from virtualrobot._wire.arguments import Count, checked
from virtualrobot._wire.messages import whole
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import KernelGoneError, VirtualRobotError, WrongStateError
from virtualrobot.recording.gathered import Gathered
from virtualrobot.recording.seen import Seen
from virtualrobot.v1 import (
    collision_pb2,
    geometry_pb2,
    kernel_pb2,
    motion_pb2,
    robot_pb2,
    scene_pb2,
    sensor_pb2,
    signal_pb2,
)

if TYPE_CHECKING:
    from virtualrobot._wire.transport import Stream

AT_ONCE_HERTZ = 1e6
"""Rate of messages at which a watch tells what happens at once; what happens meanwhile comes together."""

_CLOCK_HERTZ = 20.0
_MOTIONS_SECONDS = 0.05
"""Time (s) from one question for motions to the next."""

_WAIT_SECONDS = 0.1
"""Waited for in small steps: Ctrl-C would not get through on Windows."""
_IDLE_SECONDS = 0.001


class Output(Protocol):
    """File that is being written.

    Attributes:
        watches: the watches that it wants.
        counts: how many there are of what it holds, by name.
    """

    watches: frozenset[str]
    counts: Counter[str]

    @property
    def notes(self) -> Sequence[str]:
        """Topics and columns that it leaves out though they were asked for, in words."""
        ...

    @property
    def idle(self) -> bool:
        """True while nothing is on its way to the file."""
        ...

    def take(self, watch: str, message: Any) -> None:  # noqa: ANN401 what the watch tells
        """Take what one of the watches tells."""
        ...

    def close(self, about: Mapping[str, str]) -> None:
        """Make the file whole; `about` is kept where the format has a place for it."""
        ...


@shown
@dataclass(frozen=True, slots=True)
class Recorded:
    """Content of a recording.

    Attributes:
        path: the file.
        start: simulation time of its begin (s).
        end: simulation time of its end (s).
        counts: number of messages by topic, or of rows and columns of a table.
        missed_ticks: number of ticks that were not told while a robot moved, since the kernel or this program was busy;
            of a recording at a rate of its own none are counted.
        missed_readings: number of readings of sensors that were not told.
        end_reason: what ended it, in words, where that was not this program: the kernel has gone.
        notes: what is not in the file though it was asked for, in words.
    """

    path: Path
    start: float
    end: float
    counts: Mapping[str, int]
    missed_ticks: int
    missed_readings: int
    end_reason: str
    notes: tuple[str, ...] = ()


@checked
class Recording:
    """A recording that goes on while the program does; `finish` or `cancel` ends it. `Client.start_recording` makes it.

    As a context manager it is finished at the end of its block, and cancelled where that is left by an exception.
    """

    def __init__(
        self,
        services: Services,
        path: Path,
        stream: BinaryIO,
        output: Output,
        *,
        rate: float | None,
        duration: float | None,
    ) -> None:
        """Record every state, or at most `rate` a second; so much simulation time (s), or until it is ended."""
        self._services, self._stream, self._output = services, stream, output
        self.path = path
        stamp = services.kernel.GetClock(kernel_pb2.GetClockRequest()).stamp
        self._tick_seconds = stamp.tick_nanoseconds / 1e9
        self._first = self._last = stamp.tick
        self._until = math.inf if duration is None else stamp.tick + round(duration / self._tick_seconds)
        self._seen = Seen(services, counts_gaps=rate is None, wants_readings="readings" in output.watches)
        self._gathered: Gathered | None = None
        self._fault: Exception | None = None
        self._recorded: Recorded | None = None
        self._ended = threading.Event()
        watches = _watches(services, rate)
        self._streams = {name: watches[name]() for name in ("clock", *sorted(output.watches & watches.keys()))}
        self._threads = [
            threading.Thread(target=self._read, args=(name, stream), name=f"recording {name}", daemon=True)
            for name, stream in self._streams.items()
        ]
        if "motions" in output.watches:
            self._threads.append(threading.Thread(target=self._ask_motions, name="recording motions", daemon=True))
        for thread in self._threads:
            thread.start()
        self._seen.wait_for_begin(self._streams.keys() - {"readings"})
        # What the scene looks like at the begin is asked for before anything is changed.
        self._await_idle()

    @property
    def simulation_time(self) -> float:
        """Simulation time that is recorded so far (s)."""
        return (self._last - self._first) * self._tick_seconds

    @property
    def running(self) -> bool:
        """True until its duration is over, the kernel has gone or the file cannot be written any more."""
        return not self._ended.is_set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it has come to its end by itself, or `timeout` seconds are over; return whether it has ended."""
        begun = time.monotonic()
        while not self._ended.wait(_WAIT_SECONDS if timeout is None else min(_WAIT_SECONDS, timeout)):
            interruptions.check()
            if timeout is not None and time.monotonic() - begun >= timeout:
                return False
        return True

    def step(self, ticks: Count = 1, *, every: Count = 1) -> None:
        """Let time go on by some ticks and record each of them, or one of `every` so many and the last: none is missed.

        Signals, readings of sensors and motions are recorded as they come in any case.

        Raises:
            WrongStateError: when time follows the wall clock.
        """
        left, stride = whole(ticks, "ticks"), whole(every, "every")
        self._seen.counts_gaps = stride == 1
        self._gathered = Gathered() if stride > 1 else None
        try:
            while left > 0 and self.running:
                self._step(min(left, stride))
                left -= stride
        finally:
            self._gathered = None

    def _step(self, ticks: int) -> None:
        request = kernel_pb2.StepClockRequest(ticks=ticks)
        step = self._services.kernel.StepClock(request, timeout=LONG_TIMEOUT_SECONDS)
        self._seen.catch_up(step)
        if self._counts(step.stamp) and self._gathered is not None:
            for watch, message in self._gathered.taken(step.stamp).items():
                self._output.take(watch, message)
        self._await_idle()

    def finish(self) -> Recorded:
        """Record what has happened so far, make the file whole, and return what is in it.

        Raises:
            WrongStateError: when the file could not be written any more; what was written before can be read.
        """
        if self._recorded is None and self._fault is None:
            try:
                now = self._services.kernel.GetClock(kernel_pb2.GetClockRequest()).stamp.tick
                self._until = min(self._until, now)
                self._seen.catch_up()
                if "motions" in self._output.watches:
                    self._take_motions()
                self._await_idle()
            except VirtualRobotError as error:
                self._end(error)
        return self.cancel()

    def cancel(self) -> Recorded:
        """End it with what is written; the file is whole. As `finish` without waiting for what is on its way."""
        if self._recorded is None:
            self._recorded = self._close()
        if self._fault is not None and not isinstance(self._fault, KernelGoneError):
            raise self._failed(self._fault)
        return self._recorded

    def _close(self) -> Recorded:
        self._ended.set()
        for stream in self._streams.values():
            stream.cancel()
        for thread in self._threads:
            thread.join()
        gone = isinstance(self._fault, KernelGoneError)
        about = {
            "start_seconds": f"{self._first * self._tick_seconds:.9f}",
            "end_seconds": f"{self._last * self._tick_seconds:.9f}",
            "missed_ticks": str(self._seen.missed_ticks),
            "missed_readings": str(self._seen.missed_readings),
            "end_reason": str(self._fault) if gone else "",
        }
        try:
            with self._stream:
                self._output.close(about)
        except OSError as error:
            self._fault = error if gone or self._fault is None else self._fault
        return Recorded(
            self.path,
            self._first * self._tick_seconds,
            self._last * self._tick_seconds,
            dict(self._output.counts),
            self._seen.missed_ticks,
            self._seen.missed_readings,
            about["end_reason"],
            tuple(self._output.notes),
        )

    def _failed(self, fault: Exception) -> Exception:
        if not isinstance(fault, OSError):
            return fault
        why = fault.strerror or str(fault)
        return WrongStateError(
            f"{self.path} could not be written after {self._last * self._tick_seconds:.3f} s: {why}; what was written "
            "before is there"
        )

    # What watches tell.

    def _read(self, name: str, stream: Stream[Any]) -> None:
        try:
            for told in stream:
                for message in told.ticks if name in ("robots", "scene") and told.ticks else (told,):
                    self._take(name, message)
            self._end(None)
        except Exception as error:
            self._end(error)

    def _take(self, name: str, message: Any) -> None:  # noqa: ANN401 a message of the contract
        """Take what a watch has told of one instant."""
        if name == "readings":
            self._take_readings(message)
        elif self._counts(message.stamp) and name != "clock" and _has_news(name, message):
            if (gathered := self._gathered) is not None and name in ("robots", "scene"):
                gathered.add(name, message)
            else:
                self._output.take(name, message)
        self._seen.take(name, message)

    def _counts(self, stamp: geometry_pb2.Stamp) -> bool:
        """Return whether a state belongs to the recording; end this where none will that comes later."""
        if stamp.tick >= self._until:
            self._last = int(self._until)
            self._ended.set()
        if not self._first <= stamp.tick <= self._until:
            return False
        self._last = max(self._last, stamp.tick)
        return True

    def _take_readings(self, message: sensor_pb2.WatchReadingsResponse) -> None:
        for reading in message.readings:
            # The first message has the latest readings, which may be older than the recording.
            if reading.WhichOneof("reading") and self._counts(reading.stamp):
                self._output.take("readings", reading)

    def _ask_motions(self) -> None:
        """Ask again and again: a watch would keep motions going whose client has gone."""
        try:
            while not self._ended.wait(_MOTIONS_SECONDS):
                self._take_motions()
        except Exception as error:
            self._end(error)

    def _take_motions(self) -> None:
        answer = self._services.motion.ListMotions(motion_pb2.ListMotionsRequest())
        if self._counts(answer.stamp):
            self._output.take("motions", answer)

    def _end(self, fault: Exception | None) -> None:
        self._fault = self._fault or fault
        self._ended.set()
        self._seen.end()

    def _await_idle(self) -> None:
        while not self._output.idle and self._fault is None:
            time.sleep(_IDLE_SECONDS)

    def __enter__(self) -> Recording:
        """Return itself."""
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        """Finish or cancel it."""
        if error is None:
            self.finish()
        else:
            self._recorded = self._recorded or self._close()

    def __repr__(self) -> str:
        """Return a line for people."""
        state = "going on" if self.running else "ended"
        return f"<Recording {str(self.path)!r}: {self.simulation_time:.3f} s, {state}>"


def _has_news(name: str, message: Any) -> bool:  # noqa: ANN401 a message of the contract
    """Return whether a message of a watch tells anything but that a tick has gone by."""
    if name == "robots":
        return bool(message.robots or message.removed_names)
    if name == "scene":
        return bool(message.nodes or message.removed_uids or message.moved_uids)
    return True


def _watches(services: Services, rate: float | None) -> dict[str, Callable[[], Stream[Any]]]:
    """Return what begins each watch; states are told at most `rate` times a second, or else of every tick."""
    told = sensor_pb2.ReadingOptions(points=True, intensities=True)
    every, hertz = rate is None, AT_ONCE_HERTZ if rate is None else rate
    robots = robot_pb2.WatchRobotStatesRequest(max_rate_hertz=hertz, every_tick=every)
    scene = scene_pb2.WatchSceneRequest(max_rate_hertz=hertz, every_tick=every)
    readings = sensor_pb2.WatchReadingsRequest(options=told, every_reading=True)
    return {
        "clock": lambda: services.kernel.WatchClock(kernel_pb2.WatchClockRequest(max_rate_hertz=_CLOCK_HERTZ)),
        "robots": lambda: services.robot.WatchRobotStates(robots),
        "scene": lambda: services.scene.WatchScene(scene),
        "signals": lambda: services.signal.WatchSignals(signal_pb2.WatchSignalsRequest()),
        "readings": lambda: services.sensor.WatchReadings(readings),
        "collisions": lambda: services.collision.WatchCollisions(collision_pb2.WatchCollisionsRequest()),
    }
