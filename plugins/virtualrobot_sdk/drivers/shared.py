"""Memory that the kernel shares with the processes of its drivers: the cell's block, and a ring of ticks per robot.

Both are files that are mapped, so that they are the same on every system, and a stop needs nothing but a file. Words
are 64 bits wide and aligned: a processor writes each as a whole. Everything else has a sequence number that is odd
while it is written, then a checksum of all that follows.

The kernel writes each tick for each robot: what it does here is counted in microseconds (`benchmarks/driver_ticks.py`).
"""

from __future__ import annotations

import mmap
import os
import struct
import tempfile
import time
import zlib
from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from virtualrobot_sdk.drivers.driver import Mode, Safety

Floats = NDArray[np.float64]
Values = Floats | tuple[float, ...]
"""Numbers of the joints. What each tick reads is a tuple: an array costs a thread that has slept several times that."""

NEVER = 2**63 - 1
"""Time (ns) of a stop that nobody has asked for."""

SLOTS = 128
"""Number of ticks in a ring."""

RESTS = 4
"""Number of rests that a ring knows beside its ticks."""

BRAKE_ROWS = 512
"""Greatest number of rows of a brake; a tick whose brake is longer has none."""

CELL, RING = "cell", "ring-{}"
"""Names of the files in a kernel's folder."""

_MAGIC, _VERSION = 0x56_52_44, 3
_CELL_WORDS = 512
_HEADER_WORDS = 32
_CHECKED = 2
"""Words before those that are in the checksum: the sequence number and the checksum."""
_TICK = struct.Struct("@2qQq")
"""Tick, time to play it, outputs, rows of its brake; q, v and the brake follow."""
_REPORT = struct.Struct("@9qQ2q2d")
"""Numbers of a report; q, v and error follow."""
_SLOT_WORDS, _REPORT_WORDS = _CHECKED + _TICK.size // 8, _CHECKED + _REPORT.size // 8
_READS = 8
"""Number of times that a reader tries again when it meets a writer."""


class State(IntEnum):
    """State of a driver's connection."""

    DISCONNECTED = 0
    CONNECTING = 1
    INACTIVE = 2
    """It reads; the robot doesn't follow."""
    BEGINNING = 3
    ACTIVE = 4
    """The robot plays what its twin did."""
    STOPPING = 5
    """The robot comes to rest, by its brake."""
    ERROR = 6


STATES, MODES, SAFETIES = tuple(State), tuple(Mode), tuple(Safety)


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """Tick of a ring.

    Attributes:
        tick: its number.
        play_ns: when it is to be played (ns, CLOCK_MONOTONIC).
        q, v: (k,) joints, in the order that the driver was given, rad and m, per s.
        outputs: digital outputs, the first in the lowest bit.
        brake: (m, k) the way from there to rest, a tick apart, the first row q; None where it has none.
    """

    tick: int
    play_ns: int
    q: Floats
    v: Floats
    outputs: int
    brake: Floats | None


@dataclass(slots=True, eq=False)  # not frozen, which would take the kernel's ticks a microsecond more each
class Report:
    """Report of a host in one cycle; nobody changes one.

    Attributes:
        ns: when (CLOCK_MONOTONIC).
        state: of the connection.
        cycles: number of cycles since it connected; one that stays means that the host hangs.
        skipped: number of cycles that were left out, since the process came too late.
        lateness_ns: how late the newest cycle was.
        tick: the newest tick that was played; -1 for none.
        on_brake: whether it plays a brake since no newer tick came in time, or did when it was let go last.
        mode, safety: of the controller.
        inputs: its digital inputs.
        words: number of the newest words, which `DriverProcess.words` tells; 0 for none.
        rate: rate of the play clock, 1 or less.
        speed_scaling: share of the speed that it was told at which the controller goes.
        q, v: (k,) measured, rad and m, per s.
        error: (k,) measured minus what was played, rad and m; 0 where nothing is played. A robot that goes to points in
            its own time is measured against its way, wherever on it.
        is_faulty: whether a fault was met and told while the robot still brakes; it ends in ERROR.
    """

    ns: int
    state: State
    cycles: int
    skipped: int
    lateness_ns: int
    tick: int
    on_brake: bool
    mode: Mode
    safety: Safety
    inputs: int
    words: int
    rate: float
    speed_scaling: float
    q: Values
    v: Values
    error: Values
    is_faulty: bool = False


def make_folder() -> Path:
    """Return a new private folder for the files of one kernel, in memory where the system has a place for that."""
    memory = Path("/dev/shm")
    place = memory if memory.is_dir() and os.access(memory, os.W_OK) else None
    return Path(tempfile.mkdtemp(prefix="virtualrobot-cell-", dir=place))


def stop_cell(folder: Path) -> None:
    """Stop all robots of a kernel by its folder, whatever the kernel does; for any process of the same user."""
    block = CellBlock.attach(folder / CELL)
    block.stop()
    block.close()


class _Mapped:
    """File that is mapped, as words."""

    def __init__(self, path: Path, words: int, *, create: bool) -> None:
        self.path = path
        flags = os.O_RDWR | (os.O_CREAT | os.O_EXCL if create else 0) | getattr(os, "O_BINARY", 0)
        number = os.open(path, flags, 0o600)
        try:
            if create:
                os.ftruncate(number, words * 8)
            elif os.fstat(number).st_size != words * 8:
                raise ValueError(f"{path} has {os.fstat(number).st_size} bytes; {words * 8} are expected")
            self._map = mmap.mmap(number, words * 8)
        finally:
            os.close(number)
        self._bytes = memoryview(self._map)
        self._words = self._bytes.cast("q")
        self._doubles = self._bytes.cast("d")
        self._floats: Floats = np.frombuffer(self._map, np.float64)
        if create:
            self._words[1] = words
            self._words[0] = _MAGIC << 8 | _VERSION
        elif self._words[0] != _MAGIC << 8 | _VERSION:
            raise ValueError(f"{path} is of another version, {self._words[0]:x}")

    def close(self) -> None:
        """Let the file go; nothing else may be asked for after that."""
        # Views of the map keep it open until they are gone.
        self._words.release()
        self._doubles.release()
        self._bytes.release()
        self._floats = np.empty(0)
        try:
            self._map.close()
        except BufferError:
            pass  # somebody still has a view, with which it goes


class CellBlock(_Mapped):
    """Block of a cell: by which clock all its robots are played, and up to which tick all have what they need."""

    _STOP, _NEWEST, _BRAKED, _COMMITTED = range(2, 6)

    @classmethod
    def create(cls, path: Path) -> CellBlock:
        """Make the block: nobody has stopped, and there is no tick."""
        block = cls(path, _CELL_WORDS, create=True)
        block.release()
        return block

    @classmethod
    def attach(cls, path: Path) -> CellBlock:
        """Use the block of another process; raises OSError without one, ValueError where it is of another version."""
        return cls(path, _CELL_WORDS, create=False)

    def complete(self, tick: int, braked: bool) -> None:
        """Say that all rings have this tick, and with it a brake where `braked`."""
        if braked:
            self._words[self._BRAKED] = tick
        self._words[self._NEWEST] = tick

    @property
    def newest(self) -> int:
        """Newest tick that all rings have; -1 without one."""
        return self._words[self._NEWEST]

    @property
    def newest_braked(self) -> int:
        """Newest tick that all rings have with a brake; -1 without one."""
        return self._words[self._BRAKED]

    def stop(self, at_ns: int | None = None) -> None:
        """Have all robots brake from a time on (ns, CLOCK_MONOTONIC; None: now); a stop that was asked for stays."""
        if self._words[self._STOP] == NEVER:
            self._words[self._STOP] = time.monotonic_ns() if at_ns is None else at_ns

    @property
    def stop_ns(self) -> int:
        """Time (ns) from which the robots brake; NEVER while nobody has stopped them."""
        return self._words[self._STOP]

    def commit(self, tick: int) -> int:
        """Have all robots go on by the brake of this tick, where none has another one yet; return that which counts."""
        if self._words[self._COMMITTED] < 0:
            self._words[self._COMMITTED] = tick
        return self._words[self._COMMITTED]

    @property
    def committed(self) -> int:
        """Tick whose brake the robots go on by; -1 while they play ticks."""
        return self._words[self._COMMITTED]

    def release(self) -> None:
        """End a stop, and forget all ticks; for the kernel alone, while no robot is played."""
        for place in (self._NEWEST, self._BRAKED, self._COMMITTED):
            self._words[place] = -1
        self._words[self._STOP] = NEVER


class TickRing(_Mapped):
    """Ring of the newest ticks of one robot of k joints, written by the kernel, and what its host reports.

    Ticks of a robot that stands are told once: they are as that one until another is written. What of the reports each
    tick of the kernel looks at stands in words of its own, beside them.
    """

    _CYCLES, _NEWS, _ERROR, _PLAYED = range(2, 6)
    """Words: cycles of the newest report, how often more than a cycle was new in one, its greatest error, and the
    newest tick that any has told to be played."""
    _RESTS = tuple(range(6, 6 + 3 * RESTS, 3))
    """Words, three for each rest: the tick that those after it are as (-1: none), the last of these, and the time (ns)
    between two."""

    def __init__(self, path: Path, joints: int, *, create: bool) -> None:
        """Make or use the ring; see `create` and `attach`."""
        self.joints = joints
        self._report = struct.Struct(f"{_REPORT.format}{3 * joints}d")
        self._slot = _SLOT_WORDS + joints * (2 + BRAKE_ROWS)
        self._ring_at = _HEADER_WORDS + _REPORT_WORDS + 3 * joints
        super().__init__(path, self._ring_at + (SLOTS + RESTS) * self._slot, create=create)
        self._rest, self._rests_end = -1, [-SLOTS] * RESTS
        self._reports = 0
        self._last: tuple[int, Report | None] = (0, None)
        self._told: tuple[object, ...] = ()
        if create:
            self.clear()

    @classmethod
    def create(cls, path: Path, joints: int) -> TickRing:
        """Make the ring of a robot with this number of joints."""
        return cls(path, joints, create=True)

    @classmethod
    def attach(cls, path: Path, joints: int) -> TickRing:
        """Use the ring of another process; raises OSError without one, ValueError where it is another one."""
        return cls(path, joints, create=False)

    def clear(self) -> None:
        """Forget all ticks; for the kernel, while the robot isn't played."""
        self._words[self._PLAYED] = -1
        for word in self._RESTS:
            self._words[word] = -1
        self._rest, self._rests_end = -1, [-SLOTS] * RESTS
        for slot in range(SLOTS):
            self._words[self._ring_at + slot * self._slot] = 0

    def put(self, tick: int, play_ns: int, q: Floats, v: Floats, outputs: int = 0, brake: Floats | None = None) -> bool:
        """Write a tick; return whether its brake is in it, which is not so for one of more than `BRAKE_ROWS` rows."""
        return self.put_joints(tick, play_ns, outputs, self.joints_of(q, v, brake))

    def joints_of(self, q: Floats, v: Floats, brake: Floats | None) -> bytes:
        """Return what a tick says of the joints, for `put_joints`; of a robot at rest that is the same in each."""
        rows = b"" if brake is None or len(brake) > BRAKE_ROWS else brake.tobytes()
        return q.tobytes() + v.tobytes() + rows

    def put_joints(self, tick: int, play_ns: int, outputs: int, joints: bytes) -> bool:
        """Write a tick as `put` does, with what `joints_of` has returned."""
        self.end_rest(tick)
        return self._put(tick % SLOTS, tick, play_ns, outputs, joints)

    def end_rest(self, tick: int) -> None:
        """Say that this tick is not as those before it, which `put_joints` says, too."""
        if self._rest >= 0:
            self._words[self._RESTS[self._rest] + 1] = self._rests_end[self._rest] = tick - 1
            self._rest = -1

    @property
    def slots(self) -> NDArray[np.int64]:
        """Words (SLOTS, n) of the ticks, for who writes them by himself; they are there as long as this view is."""
        words = self._floats.view(np.int64)[self._ring_at : self._ring_at + SLOTS * self._slot]
        return words.reshape(SLOTS, self._slot)

    def rest(self, tick: int, play_ns: int, outputs: int, joints: bytes, period_ns: int) -> bool:
        """Write a tick that those after it are as, `period_ns` apart, until another one is written.

        Return whether that could be told: each rest is known for as long as ticks are.
        """
        place = min(range(RESTS), key=self._rests_end.__getitem__)
        if tick - self._rests_end[place] < SLOTS:
            return False
        words, first = self._words, self._RESTS[place]
        words[first] = -1
        self._put(SLOTS + place, tick, play_ns, outputs, joints)
        words[first + 1], words[first + 2] = NEVER, period_ns
        words[first] = tick
        self._rest, self._rests_end[place] = place, NEVER
        return True

    def _put(self, slot: int, tick: int, play_ns: int, outputs: int, joints: bytes) -> bool:
        at, words = self._ring_at + slot * self._slot, self._words
        rows = len(joints) // (8 * self.joints) - 2
        content = _TICK.pack(tick, play_ns, outputs, rows) + joints
        begin = 8 * (at + _CHECKED)
        words[at] = 2 * tick + 1
        self._bytes[begin : begin + len(content)] = content
        words[at + 1] = zlib.crc32(content)
        words[at] = 2 * tick + 2
        return rows > 0

    def get(self, tick: int) -> Record | None:
        """Return a tick; None where it isn't there, or not any more, or is being written or damaged.

        One of a rest is there though it is to come yet: the cell's block says which ticks there are.
        """
        words = self._words
        for place, word in enumerate(self._RESTS):
            first = words[word]
            if 0 <= first <= tick <= words[word + 1]:
                period, one = words[word + 2], self._get(SLOTS + place, first)
                if one is None or words[word] != first:
                    return None
                return replace(one, tick=tick, play_ns=one.play_ns + (tick - first) * period)
        return self._get(tick % SLOTS, tick)

    def _get(self, slot: int, tick: int) -> Record | None:
        at, words = self._ring_at + slot * self._slot, self._words
        sequence, crc, rows = words[at], words[at + 1], words[at + _SLOT_WORDS - 1]
        if sequence != 2 * tick + 2 or not 0 <= rows <= BRAKE_ROWS:
            return None
        content = bytes(self._bytes[8 * (at + _CHECKED) : 8 * (at + _SLOT_WORDS + (2 + rows) * self.joints)])
        if words[at] != sequence or zlib.crc32(content) != crc:
            return None
        own, play_ns, outputs, _ = _TICK.unpack_from(content)
        if own != tick:
            return None
        table = np.ndarray((2 + rows, self.joints), np.float64, content, _TICK.size)
        return Record(tick, play_ns, table[0], table[1], outputs, table[2:] if rows else None)

    def report(self, said: Report) -> None:
        """Write what the host reports; for the host alone."""
        at, k = _HEADER_WORDS, self.joints
        words, floats, body = self._words, self._floats, at + _REPORT_WORDS
        self._reports += 2
        words[at] = self._reports - 1
        _REPORT.pack_into(
            self._bytes,
            8 * (at + _CHECKED),
            *(said.ns, said.state, said.cycles, said.skipped, said.lateness_ns, said.tick, said.on_brake),
            *(MODES.index(said.mode), SAFETIES.index(said.safety), said.inputs, said.words, said.is_faulty),
            *(said.rate, said.speed_scaling),
        )
        floats[body : body + k] = said.q
        floats[body + k : body + 2 * k] = said.v
        floats[body + 2 * k : body + 3 * k] = said.error
        words[at + 1] = zlib.crc32(self._bytes[8 * (at + _CHECKED) : 8 * (body + 3 * k)])
        words[at] = self._reports
        if said.tick >= 0:
            words[self._PLAYED] = said.tick
        self._doubles[self._ERROR] = float(np.abs(said.error).max())
        words[self._CYCLES] = said.cycles
        told = (
            *(said.state, said.on_brake, said.mode, said.safety, said.inputs, said.words, said.is_faulty),
            *(said.rate, said.speed_scaling),
        )
        if told != self._told:
            self._told = told
            words[self._NEWS] += 1

    def pulse(self) -> tuple[int, int, float]:
        """Return of the newest report its cycles and its greatest error (rad, m), and between them, of all, the news.

        The news counts reports that told more than another cycle: while it stays, the report before has the rest.
        """
        return self._words[self._CYCLES], self._words[self._NEWS], self._doubles[self._ERROR]

    @property
    def played(self) -> int:
        """Newest tick that the host has told to be played since the ring was cleared; -1 without one."""
        return self._words[self._PLAYED]

    def reported(self) -> Report | None:
        """Return what the host reported last; None before it has, and where it died as it wrote.

        While it reports nothing new, this is the same object again.
        """
        at, words = _HEADER_WORDS, self._words
        for _ in range(_READS):
            sequence, crc = words[at], words[at + 1]
            number, last = self._last
            if sequence == number:
                return last
            content = bytes(self._bytes[8 * (at + _CHECKED) : 8 * self._ring_at])
            if sequence & 1 or words[at] != sequence or zlib.crc32(content) != crc:
                continue
            ns, state, cycles, skipped, late, tick, on_brake, mode, safety, inputs, said, faulty, rate, scaling, *of = (
                self._report.unpack(content)
            )
            k = self.joints
            report = Report(
                *(ns, STATES[state], cycles, skipped, late, tick, bool(on_brake)),
                *(MODES[mode], SAFETIES[safety], inputs, said, rate, scaling),
                *(tuple(of[:k]), tuple(of[k : 2 * k]), tuple(of[2 * k :]), bool(faulty)),
            )
            self._last = (sequence, report)
            return report
        return None
