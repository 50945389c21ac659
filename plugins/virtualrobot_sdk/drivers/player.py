"""Player of ticks: from a time to the setpoint that is due then. Pure but for the memory that it reads.

One rule: ticks are played in order up to the newest one whose brake is there; past it, that brake is played to its end,
and nothing newer is taken. So a kernel that is late, freezes or dies is one case. A stop slows the clock by which ticks
are played, at once; where the ticks end before it stands, it slows no further and the brake is played at the rate that
it has by then: so what the slowing takes and what the brake takes of the joints' acceleration don't add up.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import sqrt

import numpy as np

from virtualrobot_sdk.drivers.shared import NEVER, CellBlock, Floats, Record, TickRing


class Play(Enum):
    """State of a player."""

    WAITING = "WAITING"
    """No tick is due yet."""
    PLAYING = "PLAYING"
    STOPPING = "STOPPING"
    """The play clock slows, or has slowed and the brake is played."""
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


class Player:
    """Player of one robot's ring, from `begin` on; asked with times (ns, CLOCK_MONOTONIC) that grow.

    Attributes:
        state: where it is.
        tick: the tick that is played, with its fraction; -1 before the first one.
        rate: of the play clock.
        torn: number of records that could not be read, and were read again.
        on_brake: whether a brake is played.
    """

    def __init__(self, ring: TickRing, cell: CellBlock, tick_ns: int) -> None:
        """Play this ring by the clock of this cell, whose ticks are so long (ns)."""
        self._ring, self._cell, self._tick_ns = ring, cell, tick_ns
        self.state = Play.WAITING
        self.tick = -1.0
        self.rate = 1.0
        self.torn = 0
        self.on_brake = False
        self._ticks: dict[int, Record] = {}
        self._taken = -1
        self._base: Record | None = None
        self._anchor = 0
        self._stop: _Slowing | None = None
        self._last_ns = 0

    def step(self, ns: int) -> Setpoint | None:
        """Return the setpoint that is due at a time; None before the first one."""
        self._take()
        if self.state is Play.WAITING and not self._begins(ns):
            return None
        base = self._base
        assert base is not None
        stop_ns = self._cell.stop_ns
        if stop_ns != NEVER and self._stop is None and not self.on_brake:
            # What was played already stays so: a stop in the past begins now.
            begin = max(stop_ns, self._last_ns)
            self._stop = _Slowing.of(begin, self._at(begin), base.tick, self._cell.ramp_ns / self._tick_ns)
            self.state = Play.STOPPING
        self._last_ns = ns
        if self._stop is not None:
            self.tick, self.rate = self._stop.at((ns - self._stop.begin_ns) / self._tick_ns)
            if self.rate == 0.0:
                self.state = Play.RESTS
        else:
            self.tick = self._at(ns)
        if self.tick >= base.tick:
            return self._on_brake(base)
        return self._between(int(self.tick), self.tick % 1.0)

    def _at(self, ns: int) -> float:
        """Return the tick that is due at a time, by the clock that does not slow."""
        return (ns - self._anchor) / self._tick_ns

    def _begins(self, ns: int) -> bool:
        """Begin at the oldest tick when it is due and there is a brake."""
        if self._base is None:
            return False
        first = self._ticks[min(self._ticks)]
        if ns < first.play_ns:
            return False
        self._anchor = first.play_ns - first.tick * self._tick_ns
        self.state = Play.PLAYING
        return True

    def _take(self) -> None:
        """Take the ticks that are new, up to the newest one that all robots have with its brake."""
        committed = self._cell.committed
        if self._stop is not None or (committed >= 0 and self._base is not None and self._base.tick >= committed):
            return
        newest = self._cell.newest_braked if committed < 0 else committed
        for tick in range(self._first(newest), newest + 1):
            record = self._ring.get(tick)
            if record is None:
                self.torn += 1
                return  # it is read again in the next cycle; till then, what is there is played
            self._ticks[tick], self._taken = record, tick
            if record.brake is not None:
                self._base = record
        for old in [tick for tick in self._ticks if tick < self.tick - 2.0]:
            del self._ticks[old]

    def _first(self, newest: int) -> int:
        """Return the first tick to take: the next one, or when there is none yet, the newest."""
        return self._taken + 1 if self._taken >= 0 else max(newest, 0)

    def _on_brake(self, base: Record) -> Setpoint:
        """Return the setpoint on the brake of the base; nothing newer is taken from now on."""
        rows = base.brake
        assert rows is not None
        if not self.on_brake:
            committed = self._cell.commit(base.tick)
            if committed < base.tick and (other := self._ticks.get(committed)) is not None and other.brake is not None:
                # Another robot was the first; both go on from the tick that it had.
                self._base = base = other
                rows = other.brake
            self.on_brake = True
            if self.state is Play.PLAYING:
                self.state = Play.STARVED
        after = self.tick - base.tick
        place, share = int(after), after % 1.0
        if place >= len(rows) - 1:
            self.state, self.rate = Play.RESTS, 0.0
            return Setpoint(rows[-1].copy(), np.zeros_like(rows[-1]), base.outputs)
        seconds = self._tick_ns * 1e-9
        begin = base.v if place == 0 else (rows[place + 1] - rows[place - 1]) / (2.0 * seconds)
        end = (rows[min(place + 2, len(rows) - 1)] - rows[place]) / (2.0 * seconds)
        q, v = _hermite(rows[place], begin, rows[place + 1], end, share, seconds)
        return Setpoint(q, v * self.rate, base.outputs)

    def _between(self, tick: int, share: float) -> Setpoint:
        """Return the setpoint between a tick and the next one."""
        one, other = self._ticks[tick], self._ticks[tick + 1]
        q, v = _hermite(one.q, one.v, other.q, other.v, share, self._tick_ns * 1e-9)
        return Setpoint(q, v * self.rate, one.outputs)


@dataclass(frozen=True, slots=True)
class _Slowing:
    """Slowing of the play clock, in ticks: from `start` on, in `length`, its rate falls from 1 to `rest`.

    By a smoothstep, whose steepest slope is that of the whole ramp from 1 to 0, or less.
    """

    begin_ns: int
    start: float
    length: float
    rest: float

    @classmethod
    def of(cls, begin_ns: int, start: float, base: float, ramp: float) -> _Slowing:
        """Return the slowing from tick `start` on that comes to rest, or to the tick `base` with the rate that is left.

        ramp: how long the whole way from 1 to 0 takes. The clock goes ramp (1 - rest²) / 2 ticks until it has the rate
        `rest`.
        """
        left = max(base - start, 0.0)
        rest = sqrt(1.0 - 2.0 * left / ramp) if 2.0 * left < ramp else 0.0
        return cls(begin_ns, start, ramp * (1.0 - rest), rest)

    def at(self, ticks: float) -> tuple[float, float]:
        """Return the tick and the rate so many ticks' time after the begin."""
        if ticks <= 0.0:
            return self.start + ticks, 1.0
        fall = 1.0 - self.rest
        if ticks >= self.length:
            return self.start + self.length * (1.0 - fall / 2.0) + (ticks - self.length) * self.rest, self.rest
        share = ticks / self.length
        # The rate is 1 - fall (3 s² - 2 s³), and this its integral.
        went = self.length * (share - fall * (share**3 - share**4 / 2.0))
        return self.start + went, 1.0 - fall * share * share * (3.0 - 2.0 * share)


def _hermite(a: Floats, va: Floats, b: Floats, vb: Floats, share: float, seconds: float) -> tuple[Floats, Floats]:
    """Return place and velocity at a share of the cubic from a with va to b with vb, which takes so many seconds."""
    s, t = share, 1.0 - share
    q = (1.0 + 2.0 * s) * t * t * a + s * t * t * seconds * va + s * s * (3.0 - 2.0 * s) * b - s * s * t * seconds * vb
    slope = 6.0 * s * t / seconds * (b - a) + t * (1.0 - 3.0 * s) * va + s * (3.0 * s - 2.0) * vb
    return q, slope
