"""Commands of the history: what was played is noted, a world goes on after a restart, and goes back to what it was."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_kernel.world.records import Values
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Node


@dataclass(frozen=True, slots=True)
class RestartWorld:
    """Command of a kernel that goes on from where another one ended: all is at rest, motions are aborted."""


@dataclass(frozen=True, slots=True, eq=False)
class RestoreRecords:
    """Command to set what undo covers to other values, where it still has those of `found`; all or nothing.

    undoes: the step of the journal that this takes back.
    """

    found: Values
    restored: Values
    undoes: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class RestoreWorld:
    """Command to put the world back to how it was at a checkpoint: these nodes, in the order of their rows, and state.

    Motions end, all stands still, time goes on, and what only grows goes on growing: uids, names of motions, epoch.
    """

    checkpoint: str
    nodes: tuple[Node, ...]
    state: State


@dataclass(frozen=True, slots=True)
class PlayedTicks:
    """Note that a real robot has played what its twin did from one tick to another; it changes nothing.

    robot: a uid. check: how these ticks were known to be good, in words.
    """

    robot: int
    first: int
    last: int
    check: str
