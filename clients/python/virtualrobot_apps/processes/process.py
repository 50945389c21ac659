"""Processes: what each one makes of its part of a file, and how it is found by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path

from virtualrobot import Client, Program

from virtualrobot_apps.cell_io.yaml_file import Item, nearest, read_file

GROUP = "virtualrobot.processes"
"""Entry points of processes: the name in files, and the function that plans it."""


@dataclass(frozen=True, slots=True, eq=False)
class PlannedProcess:
    """Process that is planned in the cell as it is.

    Attributes:
        program: its motion, from where the robot stands now.
        measures: what it comes to, in words: a line each.
    """

    program: Program
    measures: tuple[str, ...]


Plan = Callable[[Client, Item], PlannedProcess]
"""The plan of a process in a client's cell, by a file; what the file says wrong is told by `Item.error`."""


def plan_file(client: Client, file: str | Path) -> PlannedProcess:
    """Return the plan of the process that a file describes. Nothing moves.

    Raises:
        MissingFileError: when it can't be read.
        MalformedFileError: for what it says wrong, with file and line.
        VirtualRobotError: for what can't be done in this cell.
    """
    item = read_file(file)
    fields = item.mapping("fields")
    if "process" not in fields:
        raise item.error(f"the field 'process' is missing; there are {', '.join(known())}")
    name = fields["process"].text()
    found = {one.name: one for one in entry_points(group=GROUP)}
    if name not in found:
        raise fields["process"].error(f"{name!r} is not known{nearest(name, found)} there are {', '.join(known())}")
    plan: Plan = found[name].load()
    return plan(client, item)


def known() -> list[str]:
    """Return the names of all processes that are installed."""
    return sorted(one.name for one in entry_points(group=GROUP))
