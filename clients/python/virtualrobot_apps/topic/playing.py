"""Recordings played in a world: its robots are put where they were, and its signals are as they were."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.recording.topics import Selection

from virtualrobot_apps.topic.recorded import Cell, Row, rows

PERIOD = 0.02
"""Least time (s) from one moment to the next that is played: what changes between two comes with the later one."""


@dataclass(frozen=True, slots=True)
class Played:
    """Record of what was played: how many moments, how many seconds of the recording, and which robots and signals."""

    rows: int
    seconds: float
    names: tuple[str, ...]


def play(client: Client, file: Path, patterns: Iterable[str] = (), speed: float = 1.0) -> Played:
    """Play a recording at a speed: in simulation time where that runs, else as fast as it goes, a step for each moment.

    Raises:
        InvalidArgumentError: when the file is none, or has nothing that this world has.
        WrongStateError: when robots are not to be put elsewhere, such as those that a driver moves.
    """
    selection = Selection(patterns)
    joints = {robot.name: set(robot.coordinates) for robot in client.robots()}
    signals = set(client.signals)
    begin, first, last, count = client.clock.simulation_time, None, 0.0, 0
    names: dict[str, None] = {}
    for row in _moments(rows(file)):
        positions, values = _known(row, selection, joints, signals)
        if not positions and not values:
            continue
        first = row.time if first is None else first
        _wait(client, begin + (row.time - first) / speed)
        with client.scene.batch() as batch:
            for robot, of in positions.items():
                batch.set_joint_positions(robot, of)
            for name, value in values.items():
                batch.set_signal(name, value)
        names |= dict.fromkeys((*positions, *values))
        last, count = row.time, count + 1
    if first is None:
        raise InvalidArgumentError(f"{file} has nothing of the robots and signals of this world, or of those chosen")
    return Played(count, last - first, tuple(names))


def _wait(client: Client, due: float) -> None:
    """Wait until some simulation time; where only steps let time go on, step there."""
    now = client.clock.read()
    left = due - now.stamp.simulation_time
    if now.mode == "realtime":
        time.sleep(max(0.0, left / now.speed_factor))
    elif (ticks := round(left / now.tick_length)) > 0:
        client.clock.step(ticks)


def _moments(all_rows: Iterable[Row]) -> Iterator[Row]:
    """Yield rows, those that come less than PERIOD after the first of them as one, with the time of the last."""
    cells: dict[str, Cell] = {}
    begin = end = 0.0
    for row in all_rows:
        if cells and row.time - begin >= PERIOD:
            yield Row(end, cells)
            cells = {}
        if not cells:
            begin = row.time
        cells, end = {**cells, **row.cells}, row.time
    if cells:
        yield Row(end, cells)


def _known(
    row: Row, selection: Selection, joints: dict[str, set[str]], signals: set[str]
) -> tuple[dict[str, dict[str, float]], dict[str, Cell]]:
    """Return what a row says of the robots and signals of a world."""
    positions: dict[str, dict[str, float]] = {}
    values: dict[str, Cell] = {}
    for name, value in row.cells.items():
        if name not in selection:
            continue
        if name.startswith("signals/") and name.removeprefix("signals/") in signals:
            values[name.removeprefix("signals/")] = value
        elif name.endswith("/position"):
            coordinate = name.removesuffix("/position")
            for robot, known in joints.items():
                if coordinate.startswith(f"{robot}/") and coordinate.removeprefix(f"{robot}/") in known:
                    positions.setdefault(robot, {})[coordinate.removeprefix(f"{robot}/")] = float(value)
    return positions, values
