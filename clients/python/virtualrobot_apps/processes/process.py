"""Processes: what each one makes of its part of a file, and how it is found by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import entry_points
from importlib.util import find_spec
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, Program
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.cell_io.yaml_file import Item, nearest, read_file

if TYPE_CHECKING:
    from virtualrobot_apps.processes.showing import Showing

GROUP = "virtualrobot.processes"
"""Entry points of processes: the name in files, and the function that plans it."""

FREE, TOUCHES, UNREACHED = "free", "touches", "unreached"
"""States of a place on a way: the tool gets there, only so that something touches, or not at all."""


@dataclass(frozen=True, slots=True, eq=False)
class PlannedProcess:
    """Process that is planned in the cell as it is.

    Attributes:
        program: its motion, from where the robot stands now.
        measures: what it comes to, in words: a line each.
        shown: puts bare coats on the parts and returns what lets them grow while it runs; None where nothing is seen.
    """

    program: Program
    measures: tuple[str, ...]
    shown: Callable[[], Showing] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Way of a process that was looked along.

    Attributes:
        name: what it is called, such as `seam 1`.
        points: (n, 3) places on it, in the world's frame (m).
        at: (n,) how far along it they are (m).
        states: how it is at each of them: FREE, TOUCHES or UNREACHED.
        why: in words for each of them, empty where it is free.
    """

    name: str
    points: NDArray[np.float64]
    at: NDArray[np.float64]
    states: tuple[str, ...]
    why: tuple[str, ...]

    @property
    def is_free(self) -> bool:
        """True where the tool gets to all places."""
        return all(state == FREE for state in self.states)

    def lines(self) -> list[tuple[str, str]]:
        """Return states and lines about it: one, or one for each stretch that is not free."""
        length = f"{self.name}: {1e3 * self.at[-1]:.1f} mm"
        if self.is_free:
            return [(FREE, f"{length}, reached at {len(self.at)} places without touching anything")]
        said = list[tuple[str, str]]()
        # Reasons have the measures of their places: a stretch is told by that of its first one.
        key = [(state, why if state == TOUCHES else "") for state, why in zip(self.states, self.why, strict=True)]
        for (state, _), rows in groupby(range(len(key)), key=key.__getitem__):
            if state != FREE:
                stretch = list(rows)
                first, last = (1e3 * self.at[row] for row in (stretch[0], stretch[-1]))
                where = f"at {first:.0f} mm" if first == last else f"from {first:.0f} to {last:.0f} mm"
                what = "out of reach" if state == UNREACHED else "in reach, but not free"
                said.append((state, f"{length}: {where} {what}: {self.why[stretch[0]]}"))
        return said


Plan = Callable[[Client, Item], PlannedProcess]
"""The plan of a process in a client's cell, by a file; what the file says wrong is told by `Item.error`."""


@runtime_checkable
class Looking(Protocol):
    """Plan of a process whose ways can be looked along before."""

    def look(self, client: Client, item: Item) -> tuple[Look, ...]:
        """Return how it is along each way in the cell as it is."""
        ...


def plan_file(client: Client, file: str | Path) -> PlannedProcess:
    """Return the plan of the process that a file describes. Nothing moves.

    Raises:
        MissingFileError: when it can't be read.
        MalformedFileError: for what it says wrong, with file and line.
        WrongStateError: where a package is missing that processes need.
        VirtualRobotError: for what can't be done in this cell.
    """
    check_packages()
    item = read_file(file)
    return _plan_of(item)(client, item)


def look_file(client: Client, file: str | Path) -> tuple[Look, ...]:
    """Return how it is along the ways of a process that a file describes, before it is planned; raises as `plan_file`.

    Raises WrongStateError, too, for a process that has no ways.
    """
    check_packages()
    item = read_file(file)
    plan = _plan_of(item)
    if not isinstance(plan, Looking):
        raise WrongStateError(f"{item.mapping()['process'].text()} has no ways to look along: plan it")
    return plan.look(client, item)


def check_packages() -> None:
    """Raise WrongStateError where a package is missing that processes need."""
    if missing := [name for name in ("numba", "scipy", "trimesh") if find_spec(name) is None]:
        raise WrongStateError(f"processes need {' and '.join(missing)}: pip install 'virtualrobot[processes]'")


def known() -> list[str]:
    """Return the names of all processes that are installed."""
    return sorted(one.name for one in entry_points(group=GROUP))


def _plan_of(item: Item) -> Plan:
    """Return the plan that a file names; raises MalformedFileError where there is no such process."""
    fields = item.mapping("fields")
    if "process" not in fields:
        raise item.error(f"the field 'process' is missing; there are {', '.join(known())}")
    name = fields["process"].text()
    found = {one.name: one for one in entry_points(group=GROUP)}
    if name not in found:
        raise fields["process"].error(f"{name!r} is not known{nearest(name, found)} there are {', '.join(known())}")
    return found[name].load()
