"""Tables of what a kernel tells: a row for each tick in which anything has changed, a column for each value."""

from __future__ import annotations

import csv
import heapq
import io
import json
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO, Protocol

from virtualrobot._wire.services import Services
from virtualrobot._wire.signal_values import value_of
from virtualrobot.recording import topics
from virtualrobot.recording.joints import Robots
from virtualrobot.v1 import robot_pb2, signal_pb2

Cell = float | int | bool | str | None

_LATE_SECONDS = 1.0
"""Simulation time (s) that rows are held back, since what two watches tell of a tick comes one after the other."""

_POSE = (("x", "m"), ("y", "m"), ("z", "m"), ("qx", ""), ("qy", ""), ("qz", ""), ("qw", ""))
_FLUSHED_SECONDS = 1.0


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table.

    Attributes:
        name: such as `arm/joint_1/position`.
        unit: such as `rad`; empty for what has none.
        type: of its values: float, int, bool or str.
    """

    name: str
    unit: str
    type: type


TIME, TICK = Column("time", "s", float), Column("tick", "", int)


class RowFile(Protocol):
    """File of rows that is being written."""

    def write(self, row: Sequence[Cell]) -> None:
        """Add a row."""
        ...

    def close(self, about: Mapping[str, str]) -> None:
        """Make the file whole; `about` is kept where the format has a place for it."""
        ...


class CsvFile:
    """A CSV file; its first line has the names of the columns with their units."""

    def __init__(self, stream: BinaryIO, columns: Sequence[Column]) -> None:
        """Begin a file in `stream`."""
        self._text = io.TextIOWrapper(stream, "utf-8", newline="")
        self._rows = csv.writer(self._text, lineterminator="\n")
        self._rows.writerow(f"{one.name} [{one.unit}]" if one.unit else one.name for one in columns)
        self._flushed = time.monotonic()

    def write(self, row: Sequence[Cell]) -> None:
        """Add a row; numbers are written so that reading them gives the same."""
        self._rows.writerow(str(cell).lower() if isinstance(cell, bool) else cell for cell in row)
        if time.monotonic() - self._flushed > _FLUSHED_SECONDS:
            self._flushed = time.monotonic()
            self._text.flush()

    def close(self, about: Mapping[str, str]) -> None:
        """Write what is left; a CSV file has no place for more."""
        self._text.flush()
        self._text.detach()


MakeFile = Callable[[Sequence[Column]], RowFile]


class Spool:
    """Rows that wait in a temporary file until all columns are known."""

    def __init__(self, columns: Sequence[Column], make: MakeFile) -> None:
        """Keep rows for the file that `make` makes of the columns, which may become more until it is closed."""
        self._columns, self._make = columns, make
        self._text = tempfile.TemporaryFile("w+", encoding="utf-8")

    def write(self, row: Sequence[Cell]) -> None:
        """Keep a row; columns that it has not are empty."""
        self._text.write(json.dumps(row) + "\n")

    def close(self, about: Mapping[str, str]) -> None:
        """Write the file."""
        with self._text as text:
            text.seek(0)
            file = self._make(self._columns)
            for line in text:
                row = json.loads(line)
                file.write(row + [None] * (len(self._columns) - len(row)))
            file.close(about)


class TableOutput:
    """A recording as a table. Its methods take what watches tell.

    Attributes:
        counts: how many rows and columns there are.
        columns: the columns, the time (s) and the tick first.
        known: the names of all columns that there could be, and their topics.
    """

    watches = frozenset({"robots", "signals"})
    idle = True

    def __init__(self, services: Services, selection: topics.Selection) -> None:
        """Take the columns from what there is now; `begin` gives the file."""
        self.counts: Counter[str] = Counter()
        self._late: list[str] = []
        self._selection = selection
        self._robots = Robots(services)
        self._places: dict[str, int] = {}
        self.known: list[str] = []
        self.columns = [TIME, TICK]
        states = services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest())
        for state in states.robots:
            for column, topic, _ in self._of_robot(state, states):
                self._add(column, topic)
        for signal in services.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals:
            self._add(self._of_signal(signal, type(_cell(signal))), topics.signal(signal.name))
        self._row: list[Cell] = [None] * len(self.columns)
        self._file: RowFile | None = None
        self._grows = False
        self._lock = threading.Lock()
        self._waiting: list[tuple[int, int, float, list[tuple[int, Cell]]]] = []
        self._taken = 0
        self._newest = 0.0

    def begin(self, make: MakeFile, grows: bool) -> None:
        """Write to the file that `make` makes of the columns: now, or, if the table `grows`, at its end."""
        self._grows = grows
        self._file = Spool(self.columns, make) if grows else make(self.columns)

    def _add(self, column: Column, topic: str) -> None:
        self.known += [topic, column.name]
        if topic in self._selection or column.name in self._selection:
            self._places[column.name] = len(self.columns)
            self.columns.append(column)

    def _of_robot(
        self,
        state: robot_pb2.RobotState,
        message: robot_pb2.WatchRobotStatesResponse | robot_pb2.GetRobotStatesResponse,
    ) -> Iterator[tuple[Column, str, float]]:
        """Yield the columns of a robot with their topics and what they are in a state."""
        topic = topics.joint_states(state.name)
        for one, position in zip(self._robots.coordinates(state, message.stamp), state.positions, strict=False):
            name = f"{state.name}/{one.name}"
            yield Column(f"{name}/position", one.unit, float), topic, position
            if one.velocity is not None:
                yield Column(f"{name}/velocity", f"{one.unit}/s", float), topic, state.velocities[one.velocity]
        p, q = state.world_t_tcp.position, state.world_t_tcp.orientation
        for (name, unit), value in zip(_POSE, (p.x, p.y, p.z, q.x, q.y, q.z, q.w), strict=True):
            yield Column(f"{state.name}/tcp/{name}", unit, float), topics.tool_center_point(state.name), value

    def take(self, watch: str, message: Any) -> None:  # noqa: ANN401 what the watch tells
        """Take what one of the watches tells, each of which has a thread of its own."""
        with self._lock:
            getattr(self, watch)(message)

    def robots(self, message: robot_pb2.WatchRobotStatesResponse) -> None:
        """Take states of robots; what is gone has no values any more."""
        cells: list[tuple[int, Cell]] = [
            (place, value)
            for state in message.robots
            for column, topic, value in self._of_robot(state, message)
            if (place := self._place(column, topic)) is not None
        ]
        for gone in message.removed_names:
            cells += [(place, None) for name, place in self._places.items() if name.startswith(f"{gone}/")]
        self._take(message, cells)

    def signals(self, message: signal_pb2.WatchSignalsResponse) -> None:
        """Take signals."""
        cells: list[tuple[int, Cell]] = [
            (place, cell)
            for one in message.signals
            for cell in [_cell(one)]
            if (place := self._place(self._of_signal(one, type(cell)), topics.signal(one.name))) is not None
        ]
        cells += [
            (self._places[name], None) for gone in message.removed_names if (name := f"signals/{gone}") in self._places
        ]
        self._take(message, cells)

    def _of_signal(self, signal: signal_pb2.Signal, kind: type) -> Column:
        """Return the column of a signal; one that was removed and came again with another type has another one."""
        name = f"signals/{signal.name}"
        known = self._places.get(name)
        other = known is not None and self.columns[known].type is not kind
        return Column(f"{name} ({kind.__name__})" if other else name, signal.unit, kind)

    def _place(self, column: Column, topic: str) -> int | None:
        """Return the place of a column; None where it is not wanted, or came too late."""
        if column.name not in self._places and (topic in self._selection or column.name in self._selection):
            if self._grows:
                self._add(column, topic)
                self._row.append(None)
            elif (note := f"{topic} came when the table had its columns already") not in self._late:
                self._late.append(note)
        return self._places.get(column.name)

    def _take(
        self,
        message: robot_pb2.WatchRobotStatesResponse | signal_pb2.WatchSignalsResponse,
        cells: list[tuple[int, Cell]],
    ) -> None:
        if not cells:
            return
        seconds = message.stamp.simulation_time_seconds
        self._taken += 1
        heapq.heappush(self._waiting, (message.stamp.tick, self._taken, seconds, cells))
        self._newest = max(self._newest, seconds)
        self._write(self._newest - _LATE_SECONDS)

    def _write(self, until: float) -> None:
        """Write the rows of all ticks before a time."""
        assert self._file is not None
        while self._waiting and self._waiting[0][2] < until:
            tick, _, seconds, cells = heapq.heappop(self._waiting)
            while self._waiting and self._waiting[0][0] == tick:
                cells = cells + heapq.heappop(self._waiting)[3]
            self._row[:2] = seconds, tick
            for place, value in cells:
                self._row[place] = value
            self._file.write(self._row)
            self.counts["rows"] += 1

    @property
    def notes(self) -> Sequence[str]:
        """Columns that are not in the table though they were asked for."""
        return [*self._selection.unmet(), *self._late]

    def close(self, about: Mapping[str, str]) -> None:
        """Write what is left."""
        assert self._file is not None
        with self._lock:
            self._write(float("inf"))
            self.counts["columns"] = len(self.columns)
            self._file.close(about)


def _cell(signal: signal_pb2.Signal) -> Any:  # noqa: ANN401 a Cell, whose type is the column's
    """Return a signal's value as a table has it; of a group, a letter for each: `0110`."""
    value = value_of(signal.value)
    return "".join("01"[one] for one in value) if isinstance(value, tuple) else value
