"""Flow of parts through a line of stations, by discrete events: buffers between them, blocking, breakdowns, scrap.

Only ends of work are events: a machine breaks down while it works and at no other time, so how long a part keeps it is
known as it begins (operation-dependent failures; John Buzacott, "Automatic transfer lines with buffer stocks", 1967).
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import NamedTuple

import numpy as np

from virtualrobot_apps.studies.parameters import Law

WORK, DOWN, BLOCKED = "work", "down", "blocked"
STATES = (WORK, DOWN, BLOCKED)
"""States of a machine besides waiting for a part."""
SOURCE = "source"

Time = float | Law
"""Time (s), always the same or drawn from a law."""

_DRAWN_AT_ONCE = 256


@dataclass(frozen=True)
class Failures:
    """Breakdowns of a machine: how long it works in between, and how long it is then repaired (s)."""

    between: Time
    repair: Time


@dataclass(frozen=True)
class Station:
    """Machines side by side that do the same.

    Attributes:
        name: of the station.
        cycle: time (s) that a part takes on one of the machines.
        buffer: number of places for parts that wait before it; inf for as many as come.
        machines: their number.
        failures: of each machine; None where it never breaks down.
        scrap: share of the parts that leave the line after it as waste.
    """

    name: str
    cycle: Time
    buffer: float = 0
    machines: int = 1
    failures: Failures | None = None
    scrap: float = 0.0


class Spell(NamedTuple):
    """Time, from `begin` to `end` (s), that a machine of a station spends in a state, with which part."""

    station: str
    machine: int
    state: str
    begin: float
    end: float
    part: int


@dataclass
class Flow:
    """Work of a line in a time that begins when it has warmed up.

    Attributes:
        seconds: the time.
        finished, scrapped: numbers of parts that have left it.
        lead_times: time (s) of each finished part in the line: since the source gave it or, without a source, since the
            first station has begun with it.
        inside: mean number of parts in the line.
        shares: by station, which share of the time of its machines is spent in each of STATES; they wait in the rest.
        spells: of all machines, from the beginning on, as far as they were asked for.
    """

    seconds: float
    finished: int = 0
    scrapped: int = 0
    lead_times: list[float] = field(default_factory=list)
    inside: float = 0.0
    shares: dict[str, dict[str, float]] = field(default_factory=dict)
    spells: list[Spell] = field(default_factory=list)

    @property
    def throughput(self) -> float:
        """Parts that are finished in an hour."""
        return 3600.0 * self.finished / self.seconds

    @property
    def waste(self) -> float:
        """Parts that leave it as waste in an hour."""
        return 3600.0 * self.scrapped / self.seconds

    @property
    def bottleneck(self) -> str:
        """Station whose machines work or are repaired for the greatest share of the time: it limits the others."""
        names = [name for name in self.shares if name != SOURCE]
        return max(names, key=lambda name: self.shares[name][WORK] + self.shares[name][DOWN])


def flow(
    stations: Sequence[Station],
    rng: np.random.Generator,
    seconds: float,
    warm_up: float = 0.0,
    source: Time | None = None,
    kept: float = 0.0,
) -> Flow:
    """Return what a line does in a time (s) that begins when it has warmed up (s), from empty.

    Parts come at times that `source` tells, the next one when the one before has found a place; without it there is
    always one for the first station. A part that is done waits on its machine while the next station has no place
    (blocking after service). What leaves the last station is finished. Spells that begin before `kept` (s) are told.

    Raises:
        ValueError: when a law gives a time that is not above 0, or below 0 for repairs.
    """
    return _Line(stations, rng, source, warm_up, warm_up + seconds, kept).run()


def drawing(what: str, time: Time, rng: np.random.Generator, least: float = math.ulp(0.0)) -> Callable[[], float]:
    """Return the function that gives one time (s) after the other; it raises ValueError for one below `least`."""
    if isinstance(time, float | int):
        return lambda: float(time)
    drawn: deque[float] = deque()

    def following() -> float:
        if not drawn:
            # Strictly between 0 and 1, where every law is finite.
            shares = (rng.integers(0, 2**52, _DRAWN_AT_ONCE) + 0.5) / 2**52
            drawn.extend(float(one) for one in time.quantiles(shares))
        if not drawn[0] >= least:
            raise ValueError(
                f"the law {time.law!r} gives {drawn[0]:g} s for {what}: take one that gives times above 0 alone, such "
                "as lognorm, gamma or a range"
            )
        return drawn.popleft()

    return following


def generators(rng: np.random.Generator, number: int) -> list[np.random.Generator]:
    """Return so many generators, one for each station: what happens at one changes no number of another."""
    return [np.random.default_rng(int(seed)) for seed in rng.integers(0, 2**63, number)]


class _Line:
    """Line at work: parts, machines and what ends when."""

    def __init__(
        self,
        stations: Sequence[Station],
        rng: np.random.Generator,
        source: Time | None,
        begin: float,
        end: float,
        kept: float,
    ) -> None:
        """Begin empty, at time 0; what happens from `begin` to `end` (s) counts."""
        self._stations = [*([] if source is None else [Station(SOURCE, source)]), *stations]
        self._entry = len(self._stations) - len(stations)
        self._begin, self._end, self._kept = begin, end, kept
        self._flow = Flow(end - begin)
        self._busy: dict[str, dict[str, float]] = {one.name: dict.fromkeys(STATES, 0.0) for one in self._stations}
        self._draws = [
            _Draws(one, its) for one, its in zip(self._stations, generators(rng, len(self._stations)), strict=True)
        ]
        self._queues = [deque[int]() for _ in self._stations]
        self._idle = [list(reversed(range(one.machines))) for one in self._stations]
        self._blocked = [deque[tuple[int, int, float]]() for _ in self._stations]
        self._events: list[tuple[float, int, int, int, int]] = []
        self._order, self._parts, self._entered = count(), count(), dict[int, float]()

    def run(self) -> Flow:
        """Do it all."""
        self._start(0, 0.0)
        while self._events and self._events[0][0] <= self._end:
            now, _, station, machine, part = heapq.heappop(self._events)
            self._done(station, machine, part, now)
        for station, waiting in enumerate(self._blocked):
            for machine, part, since in waiting:
                self._spell(station, machine, BLOCKED, since, self._end, part)
        for entered in self._entered.values():
            self._count_inside(entered, self._end)
        for one in self._stations:
            whole = self._flow.seconds * one.machines
            self._flow.shares[one.name] = {state: busy / whole for state, busy in self._busy[one.name].items()}
        return self._flow

    def _start(self, station: int, now: float) -> None:
        """Let machines that wait begin with parts that wait, and those before them fill the places."""
        while self._idle[station] and (station == 0 or self._queues[station]):
            if station:
                part = self._queues[station].popleft()
            else:
                part = next(self._parts)
                if self._entry == 0:
                    self._entered[part] = now
            machine = self._idle[station].pop()
            end = now
            for state, seconds in self._draws[station].work(machine):
                self._spell(station, machine, state, end, end + seconds, part)
                end += seconds
            heapq.heappush(self._events, (end, next(self._order), station, machine, part))
        if station:
            self._unblock(station - 1, now)

    def _done(self, station: int, machine: int, part: int, now: float) -> None:
        """Let a part go on, or wait on its machine; or it is waste."""
        if self._draws[station].is_scrap():
            if now >= self._begin:
                self._flow.scrapped += 1
            self._count_inside(self._entered.pop(part), now)
            self._idle[station].append(machine)
            self._start(station, now)
        elif self._has_room(station + 1):
            self._move(station, machine, part, now)
        else:
            self._blocked[station].append((machine, part, now))

    def _move(self, station: int, machine: int, part: int, now: float) -> None:
        """Give a part to the next station, or out of the line, and let its machine begin with another one."""
        following = station + 1
        self._idle[station].append(machine)
        if following == len(self._stations):
            entered = self._entered.pop(part)
            self._count_inside(entered, now)
            if now >= self._begin:
                self._flow.finished += 1
                self._flow.lead_times.append(now - entered)
        else:
            if following == self._entry:
                self._entered[part] = now
            self._queues[following].append(part)
            self._start(following, now)
        self._start(station, now)

    def _unblock(self, station: int, now: float) -> None:
        """Let parts go on that wait on their machines, as far as there is room again."""
        while self._blocked[station] and self._has_room(station + 1):
            machine, part, since = self._blocked[station].popleft()
            self._spell(station, machine, BLOCKED, since, now, part)
            self._move(station, machine, part, now)

    def _has_room(self, station: int) -> bool:
        if station == len(self._stations):
            return True
        return len(self._queues[station]) < self._stations[station].buffer + len(self._idle[station])

    def _spell(self, station: int, machine: int, state: str, begin: float, end: float, part: int) -> None:
        name = self._stations[station].name
        self._busy[name][state] += max(0.0, min(end, self._end) - max(begin, self._begin))
        if begin < self._kept:
            self._flow.spells.append(Spell(name, machine, state, begin, end, part))

    def _count_inside(self, begin: float, end: float) -> None:
        self._flow.inside += max(0.0, end - max(begin, self._begin)) / self._flow.seconds


class _Draws:
    """Random numbers of a station."""

    def __init__(self, station: Station, rng: np.random.Generator) -> None:
        """Begin with machines as after a repair."""
        self._rng, self._scrap = rng, station.scrap
        self._cycle = drawing(f"the cycle of {station.name!r}", station.cycle, rng)
        self._between = self._repair = None
        if failures := station.failures:
            own = generators(rng, 2)
            self._between = drawing(f"what {station.name!r} works between failures", failures.between, own[0])
            self._repair = drawing(f"a repair of {station.name!r}", failures.repair, own[1], 0.0)
            self._left = [self._between() for _ in range(station.machines)]

    def work(self, machine: int) -> list[tuple[str, float]]:
        """Return the states of a machine while it has the next part, each with its time (s)."""
        left = self._cycle()
        if self._between is None or self._repair is None:
            return [(WORK, left)]
        found = list[tuple[str, float]]()
        while left >= self._left[machine]:
            found += [(WORK, self._left[machine]), (DOWN, self._repair())]
            left -= self._left[machine]
            self._left[machine] = self._between()
        self._left[machine] -= left
        return [*found, (WORK, left)]

    def is_scrap(self) -> bool:
        """Return whether the next part that is done is waste."""
        return self._scrap > 0.0 and self._rng.random() < self._scrap
