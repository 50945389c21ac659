"""Memory that the kernel and the hosts of its drivers share: one block for the cell, and one ring of ticks per robot.

Both are files that are mapped: the same on all systems, and a stop needs nothing but a file. Times are nanoseconds of
CLOCK_MONOTONIC, which is one for all processes of a machine. A ring has one writer, the kernel's world thread, and one
reader, the robot's host; reports go the other way. A reader never waits: what is torn is told as gone.
"""

from __future__ import annotations

import mmap
import os
import struct
import tempfile
import time
import zlib
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path

import numpy as np

from virtualrobot_sdk.drivers.driver import Mode, Safety
from virtualrobot_sdk.kinematics import Floats

NEVER = 2**63 - 1
"""Time at which nothing happens."""
SLOTS = 128
"""Number of ticks that a ring keeps."""
BRAKE_ROWS = 1024
"""Greatest number of rows of a brake that a ring keeps; a longer one counts as none."""
CELL_FILE = "cell"
"""Name of the cell's file in the kernel's folder."""

_I64 = struct.Struct("<q")
_CELL_MAGIC, _RING_MAGIC = 0x5652_4345_4C4C_0001, 0x5652_5249_4E47_0001
_CELL_BYTES = 4096
_BEAT, _STOP, _RAMP, _NEWEST, _BRAKED = 8, 16, 24, 32, 40
_JOINTS, _ROWS, _REPORT, _TICKS = 8, 16, 64, 8192
_ATTEMPTS = 4
_MOST_JOINTS = 64
_MODES, _SAFETIES = tuple(Mode), tuple(Safety)


class HostState(IntEnum):
    """State of a connection, as its host reports it."""

    DISCONNECTED = 0
    CONNECTING = 1
    INACTIVE = 2
    """Readings come; nothing is sent."""
    BEGINNING = 3
    ACTIVE = 4
    """The robot is played."""
    STOPPING = 5
    """The robot comes to rest: the cell was stopped, or there is no newer tick."""
    ERROR = 6


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """One tick of a robot's twin.

    Attributes:
        tick: its number.
        play_ns: when the robot does it.
        q, v: (k,) joints and their velocities, rad or m, per s.
        outputs: digital outputs, the first in the lowest bit.
        brake: (m, k) joints a tick apart while all brakes from here, the first row this tick's own; None: not known.
    """

    tick: int
    play_ns: int
    q: Floats
    v: Floats
    outputs: int
    brake: Floats | None


def _nothing() -> Floats:
    return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """What a host tells each cycle; k joints in the ring's order, rad or m, per s: NaN while there are none.

    Attributes:
        state: state of the connection.
        tick: the tick that is played, the latest one that was when nothing is; -1 before the first. Of a brake it goes
            on counting.
        rate: of the clock that the robot is played by: 1, less while it slows, 0 when it stands.
        braking: whether the newest tick's brake is, or has been, played, since there was no newer one in time.
        positions, velocities: (k,), as measured.
        played: (k,) where the robot was told to be.
        mode, safety: as the controller says.
        inputs: digital inputs, the first in the lowest bit.
        speed_scaling: share of the speed that it was told at which the controller goes.
        cycles, skipped: number of cycles since the process began, and of those that were left out.
        lateness: of the latest cycle (s).
        fault: number of the newest fault, counted from 1; 0 before the first. Its words come by the control channel.
        at_ns: when this was written.
    """

    state: HostState = HostState.DISCONNECTED
    tick: int = -1
    rate: float = 0.0
    braking: bool = False
    positions: Floats = field(default_factory=_nothing)
    velocities: Floats = field(default_factory=_nothing)
    played: Floats = field(default_factory=_nothing)
    mode: Mode = Mode.OFF
    safety: Safety = Safety.NORMAL
    inputs: int = 0
    speed_scaling: float = 1.0
    cycles: int = 0
    skipped: int = 0
    lateness: float = 0.0
    fault: int = 0
    at_ns: int = 0

    @property
    def active(self) -> bool:
        """Whether the robot is played, or comes to rest from it."""
        return self.state in (HostState.ACTIVE, HostState.STOPPING)

    @property
    def faulty(self) -> bool:
        """Whether the host is in ERROR."""
        return self.state is HostState.ERROR


def shared_folder() -> Path:
    """Make a new folder that nobody else of the machine can read, in memory where there is such a place; return it."""
    memory = Path("/dev/shm")
    place = memory if os.access(memory, os.W_OK) else None
    return Path(tempfile.mkdtemp(prefix="virtualrobot-", dir=place))


def stop_cell(folder: Path) -> None:
    """Stop all robots of the kernel whose folder this is, by the file alone; raises OSError where there is no cell."""
    cell = CellBlock.attach(folder / CELL_FILE)
    try:
        cell.stop()
    finally:
        cell.close()


class _Mapped:
    """A file that is mapped; the process that made it takes it away as it closes."""

    def __init__(self, path: Path, size: int, magic: int) -> None:
        """Make the file with `size` bytes of zeros, or map the one that is there where `size` is 0."""
        self.path, self._made = path, size > 0
        flags = os.O_RDWR | getattr(os, "O_BINARY", 0) | (os.O_CREAT | os.O_EXCL if self._made else 0)
        descriptor = os.open(path, flags, 0o600)
        try:
            if self._made:
                os.ftruncate(descriptor, size)
            elif os.fstat(descriptor).st_size < _CELL_BYTES:
                raise OSError(f"{path} is not memory of a cell: it is too short")
            self._map = mmap.mmap(descriptor, 0)
        finally:
            os.close(descriptor)
        if self._made:
            self._set(0, magic)
        elif self._get(0) != magic:
            self._map.close()
            raise OSError(f"{path} is not what it should be: it begins with another number")

    def close(self) -> None:
        """Give the memory back; harmless more than once."""
        if not self._map.closed:
            self._map.close()
        if self._made:
            self._made = False
            self.path.unlink(missing_ok=True)

    def _get(self, at: int) -> int:
        return _I64.unpack_from(self._map, at)[0]

    def _set(self, at: int, value: int) -> None:
        _I64.pack_into(self._map, at, value)


class CellBlock(_Mapped):
    """What all robots of a kernel share: that it lives, which tick is complete, and the stop."""

    @classmethod
    def create(cls, path: Path) -> CellBlock:
        """Make the block at `path`; nothing is stopped, and no tick is there."""
        self = cls(path, _CELL_BYTES, _CELL_MAGIC)
        self._set(_STOP, NEVER)
        self._set(_NEWEST, -1)
        self._set(_BRAKED, -1)
        return self

    @classmethod
    def attach(cls, path: Path) -> CellBlock:
        """Open the block at `path`; raises OSError where there is none."""
        return cls(path, 0, _CELL_MAGIC)

    def beat(self, ns: int) -> None:
        """Say that the kernel lives."""
        self._set(_BEAT, ns)

    @property
    def beaten_ns(self) -> int:
        """When the kernel said last that it lives; 0: never."""
        return self._get(_BEAT)

    def complete(self, tick: int, braked: bool = True) -> None:
        """Say that all rings hold `tick`, and whether with its brake."""
        if braked:
            self._set(_BRAKED, tick)
        self._set(_NEWEST, tick)

    @property
    def newest(self) -> int:
        """The newest tick that all rings hold; -1: none."""
        return self._get(_NEWEST)

    @property
    def newest_braked(self) -> int:
        """The newest tick that all rings hold with its brake; -1: none."""
        return self._get(_BRAKED)

    def stop(self, at_ns: int | None = None) -> None:
        """Stop all robots from `at_ns` on (now); anybody may, at any time. The earliest time holds."""
        self._set(_STOP, min(self._get(_STOP), time.monotonic_ns() if at_ns is None else at_ns))

    @property
    def stop_ns(self) -> int:
        """From when on all robots stop; NEVER: they don't."""
        return self._get(_STOP)

    @property
    def stopped(self) -> bool:
        """Whether anybody has stopped the cell."""
        return self._get(_STOP) != NEVER

    def release(self) -> None:
        """End the stop; the kernel alone does that, when no robot is played."""
        self._set(_STOP, NEVER)

    @property
    def ramp_ns(self) -> int:
        """Duration (ns) of the brake from the newest tick, which the kernel writes: so long a stop takes."""
        return self._get(_RAMP)

    @ramp_ns.setter
    def ramp_ns(self, ns: int) -> None:
        self._set(_RAMP, ns)


class TickRing(_Mapped):
    """The latest ticks of one robot with k joints, each with its brake, and the report of its host.

    A slot has a sequence number, which is odd while it is written, and a CRC-32 of all of it.
    """

    def __init__(self, path: Path, size: int, magic: int) -> None:
        """Map the file; use `create` and `attach`."""
        super().__init__(path, size, magic)
        self.joints, self.rows = self._get(_JOINTS), self._get(_ROWS)
        self._reports = 0

    def _lay_out(self) -> TickRing:
        k = self.joints
        # Sequence, tick, time of play, outputs, rows, CRC-32; then q and v, and then the brake.
        self._head = struct.Struct("<qqqQqQ")
        self._body = 2 * 8 * k
        self._slot = -(-(self._head.size + self._body + self.rows * k * 8) // 64) * 64
        # Sequence, then what `report` writes, then positions, velocities and what was played.
        self._back = struct.Struct("<qqqqqqqQqqdddqQ")
        return self

    @classmethod
    def create(cls, path: Path, joints: int, rows: int = BRAKE_ROWS) -> TickRing:
        """Make the ring at `path` for a robot with so many joints; it holds no tick."""
        if not 1 <= joints <= _MOST_JOINTS:
            raise ValueError(f"a ring has 1 to {_MOST_JOINTS} joints, not {joints}")
        slot = -(-(struct.calcsize("<qqqQqQ") + 16 * joints + rows * joints * 8) // 64) * 64
        self = cls(path, _TICKS + SLOTS * slot, _RING_MAGIC)
        self._set(_JOINTS, joints)
        self._set(_ROWS, rows)
        self.joints, self.rows = joints, rows
        return self._lay_out()

    @classmethod
    def attach(cls, path: Path) -> TickRing:
        """Open the ring at `path`; raises OSError where there is none."""
        return cls(path, 0, _RING_MAGIC)._lay_out()

    def put(self, tick: int, play_ns: int, q: Floats, v: Floats, outputs: int, brake: Floats | None) -> bool:
        """Keep a tick, over the one that is SLOTS older; return whether with its brake.

        Attributes are those of `Record`. A brake with more than `rows` rows is left out.
        """
        if len(q) != self.joints or len(v) != self.joints or (brake is not None and brake.shape[1] != self.joints):
            raise ValueError(f"this ring is of {self.joints} joints; q has {len(q)}, v has {len(v)}")
        rows = 0 if brake is None or len(brake) > self.rows else len(brake)
        content = np.concatenate((q, v)).astype("<f8", copy=False).tobytes()
        if brake is not None and rows:
            content += brake.astype("<f8", copy=False).tobytes()
        at = _TICKS + tick % SLOTS * self._slot
        self._set(at, 2 * tick + 1)
        start = at + self._head.size
        self._map[start : start + len(content)] = content
        crc = _crc(tick, play_ns, outputs, rows, content)
        self._head.pack_into(self._map, at, 2 * tick + 1, tick, play_ns, outputs, rows, crc)
        self._set(at, 2 * tick + 2)
        return rows > 0

    def get(self, tick: int) -> Record | None:
        """Return a tick; None where it is torn or gone, or not there yet."""
        if tick < 0:
            return None
        at = _TICKS + tick % SLOTS * self._slot
        sequence, found, play_ns, outputs, rows, crc = self._head.unpack_from(self._map, at)
        if sequence != 2 * tick + 2 or found != tick or not 0 <= rows <= self.rows:
            return None
        start = at + self._head.size
        content = self._map[start : start + self._body + rows * self.joints * 8]
        if self._get(at) != sequence or _crc(tick, play_ns, outputs, rows, content) != crc:
            return None
        values = np.frombuffer(content, "<f8").astype(np.float64, copy=False).reshape(-1, self.joints)
        return Record(tick, play_ns, values[0], values[1], outputs, values[2:] if rows else None)

    def report(self, report: Report) -> None:
        """Tell the kernel how it stands; the host alone does that, once each cycle."""
        self._reports += 2
        nothing = np.full(self.joints, np.nan)
        arrays = (report.positions, report.velocities, report.played)
        content = np.concatenate([values if len(values) else nothing for values in arrays]).astype("<f8").tobytes()
        self._set(_REPORT, self._reports - 1)
        start = _REPORT + self._back.size
        self._map[start : start + len(content)] = content
        numbers = (
            *(report.at_ns, int(report.state), report.tick, int(report.braking), _MODES.index(report.mode)),
            *(_SAFETIES.index(report.safety), report.inputs, report.cycles, report.skipped),
            *(report.rate, report.speed_scaling, report.lateness, report.fault),
        )
        crc = zlib.crc32(content, zlib.crc32(repr(numbers).encode()))
        self._back.pack_into(self._map, _REPORT, self._reports - 1, *numbers, crc)
        self._set(_REPORT, self._reports)

    def reported(self) -> Report | None:
        """Return the newest report; None before the first, and where it is being written whenever one looks."""
        for _ in range(_ATTEMPTS):
            sequence, *numbers, crc = self._back.unpack_from(self._map, _REPORT)
            start = _REPORT + self._back.size
            content = self._map[start : start + 3 * 8 * self.joints]
            if sequence == 0:
                return None
            if sequence & 1 or zlib.crc32(content, zlib.crc32(repr(tuple(numbers)).encode())) != crc:
                continue
            at_ns, state, tick, braking, mode, safety, inputs, cycles, skipped, rate, scaling, late, fault = numbers
            values = np.frombuffer(content, "<f8").astype(np.float64, copy=False).reshape(3, self.joints)
            return Report(
                *(HostState(state), tick, rate, bool(braking), values[0], values[1], values[2]),
                *(_MODES[mode], _SAFETIES[safety], inputs, scaling, cycles, skipped, late, fault, at_ns),
            )
        return None


def _crc(tick: int, play_ns: int, outputs: int, rows: int, content: bytes) -> int:
    return zlib.crc32(content, zlib.crc32(struct.pack("<qqQq", tick, play_ns, outputs, rows)))
