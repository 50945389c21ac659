"""Player of ticks: from a time to the setpoint that is due then. Pure but for the memory that it reads.

Ticks are played in order up to the newest one whose brake is there; past it, that brake is played to its end, and
nothing newer is taken. So a kernel that is late, freezes or dies is one case.

A stop brakes at once: between two ticks the robot goes the mean of their brakes, weighted by the time. It begins where
the robot is, as fast as it is, and is no harder than they are. (A clock that slows until the ticks end comes to rest no
sooner, and its slowing and what the ticks themselves take of the joints' acceleration add up.) All robots read the same
time of the stop: they brake from the same two ticks, in which all brakes were checked together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from virtualrobot_sdk.drivers.shared import CellBlock, Floats, Record, TickRing

SLACK_SECONDS = 0.2
"""Time (s) by which a robot whose controller goes slower than it was told may be later than its twin's lead."""


class Play(Enum):
    """State of a player."""

    WAITING = "WAITING"
    """No tick is due yet."""
    PLAYING = "PLAYING"
    STOPPING = "STOPPING"
    """The cell was stopped, or this robot alone halted: a brake is played."""
    STARVED = "STARVED"
    """No newer tick has come, and the brake of the newest one is played."""
    RESTS = "RESTS"
    """It has come to rest, and stays."""


@dataclass(frozen=True, slots=True, eq=False)
class Setpoint:
    """Setpoint that is due: joints q and v (k,) in rad and m, per s, and digital outputs."""

    q: Floats
    v: Floats
    outputs: int


@dataclass(frozen=True, slots=True, eq=False)
class _Brake:
    """Brake under way: the mean of records' brakes, by their weights, `shift` (k,) away, from a time on.

    `starved`: whether it is played since no newer tick came.
    """

    parts: tuple[tuple[float, Record], ...]
    shift: Floats
    start_ns: int
    starved: bool

    @property
    def length(self) -> int:
        """Duration in ticks."""
        return max(len(_rows(record)) - 1 for _, record in self.parts)

    def at(self, ticks: float, seconds: float) -> Setpoint:
        """Return the setpoint so many ticks, of so many seconds, after its start."""
        q, v = self.shift, np.zeros_like(self.shift)
        for weight, record in self.parts:
            own_q, own_v = _along(_rows(record), record.v, ticks, seconds)
            q, v = q + weight * own_q, v + weight * own_v
        return Setpoint(q, v, self.parts[0][1].outputs)


class Player:
    """Player of one robot's ring; asked with times (ns, CLOCK_MONOTONIC) that grow.

    Attributes:
        state: where it is.
        tick: the tick that is played, with its fraction; of a brake, the one that it begins from. -1 before the first.
        rate: of the play clock: 1, less where the controller is slow; of a brake, the share of it that is left.
        late: whether a slow controller has made the robot later than SLACK_SECONDS allow.
        torn: number of records that could not be read, and were read again.
        on_brake: whether the brake is, or was, played since no newer tick came.
    """

    def __init__(self, ring: TickRing, cell: CellBlock, tick_ns: int) -> None:
        """Play this ring by the clock of this cell, whose ticks are so long (ns)."""
        self._ring, self._cell, self._tick_ns = ring, cell, tick_ns
        self.state = Play.WAITING
        self.tick = -1.0
        self.rate = 1.0
        self.late = False
        self.torn = 0
        self._ticks: dict[int, Record] = {}
        self._taken = -1
        self._brake: _Brake | None = None
        self._until: int | None = None
        self._anchor = self._lag = self._last_ns = 0
        self._before = self._newest = -1.0

    @property
    def on_brake(self) -> bool:
        """True while the brake is, or was, played since no newer tick came."""
        return self._brake is not None and self._brake.starved

    def step(self, ns: int, speed_scaling: float = 1.0) -> Setpoint | None:
        """Return the setpoint that is due at a time; None before the first one.

        speed_scaling: share of the speed that it was told at which the controller goes.
        """
        if self._brake is None:
            self._take()
            if self.state is Play.WAITING and not self._begins(ns):
                return None
            self._lag += round((1.0 - speed_scaling) * (ns - self._last_ns))
            self.late = self._lag > SLACK_SECONDS * 1e9
            stop_ns = self._cell.stop_ns
            stops = stop_ns <= ns
            if stops and self._until is None:
                # What was played already stays so: a stop in the past begins now.
                self._stop(max(stop_ns, self._last_ns))
            limit = self._limit()
            if self._brake is None and self._due(ns) >= limit:
                self._commit(limit, starved=not stops)
        brake, self._last_ns = self._brake, ns
        if brake is None:
            self._before = self._newest
            self.tick, self.rate = max(self.tick, self._due(ns)), speed_scaling
            self._newest = self.tick
            setpoint = self._between(self.tick)
            return Setpoint(setpoint.q, setpoint.v * speed_scaling, setpoint.outputs)
        ticks = (ns - brake.start_ns) / self._tick_ns
        self.tick = min(max(self.tick, brake.parts[0][1].tick), float(brake.parts[-1][1].tick))
        self.rate = max(0.0, 1.0 - ticks / brake.length) if brake.length else 0.0
        self.state = (Play.STARVED if brake.starved else Play.STOPPING) if self.rate else Play.RESTS
        return brake.at(ticks, self._seconds)

    def halt(self, ns: int) -> bool:
        """Refuse the newest setpoint and brake from the one before, by its tick's brake; return whether it has one.

        It brakes as if that setpoint had been due at `ns`. The next step, which is later, tells what to send instead.
        """
        tick = self._before
        record = self._ticks.get(math.floor(tick))
        if self._brake is not None or record is None or record.brake is None:
            return False
        share = tick - record.tick
        start_ns = ns - round(share * self._tick_ns)
        brake = _Brake(((1.0, record),), np.zeros_like(record.q), start_ns, starved=False)
        there = self._between(tick).q - brake.at(share, self._seconds).q
        self._brake = _Brake(brake.parts, there, start_ns, starved=False)
        return True

    @property
    def _seconds(self) -> float:
        return self._tick_ns * 1e-9

    def _due(self, ns: int) -> float:
        """Return the tick that is due at a time."""
        return (ns - self._lag - self._anchor) / self._tick_ns

    def _begins(self, ns: int) -> bool:
        """Begin at the oldest tick when it is due and there is a brake."""
        if not self._braked():
            return False
        first = self._ticks[min(self._ticks)]
        if ns < first.play_ns:
            return False
        self._anchor, self._last_ns = first.play_ns - first.tick * self._tick_ns, ns
        self.tick, self.state = float(first.tick), Play.PLAYING
        return True

    def _take(self) -> None:
        """Take the ticks that are new, up to the newest one that all robots have with its brake."""
        newest = self._cell.newest_braked
        for tick in range(self._taken + 1 if self._taken >= 0 else max(newest, 0), newest + 1):
            record = self._ring.get(tick)
            if record is None:
                self.torn += 1
                break  # it is read again in the next cycle; till then, what is there is played
            self._ticks[tick], self._taken = record, tick
        for old in [tick for tick in self._ticks if tick < self.tick - 2.0]:
            del self._ticks[old]

    def _braked(self) -> list[int]:
        return [tick for tick, record in self._ticks.items() if record.brake is not None]

    def _limit(self) -> int:
        """Return the tick whose brake ends the play: the one to stop at, another robot's, or the newest with one."""
        braked, committed = self._braked(), self._cell.committed
        if self._until is not None:
            return self._until
        return committed if committed in braked and committed >= self.tick else max(braked)

    def _commit(self, tick: int, starved: bool) -> None:
        """Play the brake of a tick from its own time on; nothing newer is taken, by no robot of the cell."""
        committed = self._cell.commit(tick)
        if self.tick <= committed < tick and committed in self._braked():
            tick = committed  # another robot was the first
        record = self._ticks[tick]
        start_ns = tick * self._tick_ns + self._anchor + self._lag
        self._brake = _Brake(((1.0, record),), np.zeros_like(record.q), start_ns, starved)

    def _stop(self, ns: int) -> None:
        """Brake from a time on where the ticks before and after it have brakes; else after the next one that has."""
        at = max(self.tick, self._due(ns))
        before, braked = math.floor(at), self._braked()
        if before not in braked or math.ceil(at) not in braked:
            later = [tick for tick in braked if tick >= at]
            if later:
                committed = self._cell.commit(min(later))
                self._until = committed if committed in later else min(later)
            return
        share = at - before
        parts = [(1.0 - share, self._ticks[before])]
        if share:
            parts.append((share, self._ticks[before + 1]))
        middle = sum((weight * _rows(record)[0] for weight, record in parts), np.zeros_like(parts[0][1].q))
        self._brake = _Brake(tuple(parts), self._between(at).q - middle, ns, starved=False)

    def _between(self, at: float) -> Setpoint:
        """Return the setpoint between a tick and the next one."""
        tick = math.floor(at)
        one, other = self._ticks[tick], self._ticks.get(tick + 1)
        if at == tick or other is None:
            return Setpoint(one.q, one.v, one.outputs)
        q, v = _hermite(one.q, one.v, other.q, other.v, at - tick, self._seconds)
        return Setpoint(q, v, one.outputs)


def _rows(record: Record) -> Floats:
    """Return the brake of a record that has one."""
    if record.brake is None:
        raise ValueError(f"tick {record.tick} has no brake")
    return record.brake


def _along(rows: Floats, v: Floats, ticks: float, seconds: float) -> tuple[Floats, Floats]:
    """Return place and velocity so many ticks after the first row of a brake (m, k) that begins with the velocity v."""
    if ticks >= len(rows) - 1:
        return rows[-1], np.zeros_like(v)
    place = math.floor(ticks)
    begin = v if place == 0 else (rows[place + 1] - rows[place - 1]) / (2.0 * seconds)
    end = np.zeros_like(v) if place + 2 == len(rows) else (rows[place + 2] - rows[place]) / (2.0 * seconds)
    return _hermite(rows[place], begin, rows[place + 1], end, ticks - place, seconds)


def _hermite(a: Floats, va: Floats, b: Floats, vb: Floats, share: float, seconds: float) -> tuple[Floats, Floats]:
    """Return place and velocity at a share of the cubic from a with va to b with vb, which takes so many seconds."""
    s, t = share, 1.0 - share
    q = (1.0 + 2.0 * s) * t * t * a + s * t * t * seconds * va + s * s * (3.0 - 2.0 * s) * b - s * s * t * seconds * vb
    slope = 6.0 * s * t / seconds * (b - a) + t * (1.0 - 3.0 * s) * va + s * (3.0 * s - 2.0) * vb
    return q, slope
