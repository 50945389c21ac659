"""Steps of the history and checkpoints, as the kernel tells them."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

from virtualrobot._wire.showing import shown
from virtualrobot.v1 import history_pb2

_KIND = "STEP_KIND_"

KINDS = tuple(name.removeprefix(_KIND).lower() for name in history_pb2.StepKind.keys()[1:])
"""Kinds of steps."""


def kind_name(kind: str) -> str:
    """Return the name of a kind in the contract."""
    return _KIND + kind.upper()


@shown
@dataclass(frozen=True, slots=True)
class Step:
    """One change of the world.

    Attributes:
        number: its number; later steps have greater ones.
        kind: `edit`, `undo`, `redo`, `motion`, `signal`, `restore` or `other`. Edits can be undone.
        label: what was done: `moved 'table' by 0.10 m`.
        author: who did it: the name that a client gives itself, and its address.
        mine: whether it is of this client.
        time: when, by the kernel's wall clock.
        tick: the number of ticks before it.
        nodes: the nodes that it changed, by their present names.
        undone: whether it has been taken back, and that not again.
        undoes: for an undo or redo: the number of the step that it took back; else 0.
        first_number: the number of its first change; the same, but for what was dragged.
    """

    number: int
    kind: str
    label: str
    author: str
    mine: bool
    time: datetime
    tick: int
    nodes: tuple[str, ...]
    undone: bool
    undoes: int
    first_number: int

    @staticmethod
    def of(message: history_pb2.Step) -> Step:
        """Return what a message tells."""
        return Step(
            message.number,
            history_pb2.StepKind.Name(message.kind).removeprefix(_KIND).lower(),
            message.label,
            message.author,
            message.mine,
            message.time.ToDatetime(UTC),
            message.tick,
            tuple(message.nodes),
            message.undone,
            message.undoes,
            message.first_number,
        )


@shown
@dataclass(frozen=True, slots=True)
class Checkpoint:
    """The world as it was, under a name.

    Attributes:
        name: its name.
        author: who made it.
        time: when, by the kernel's wall clock.
        tick: at which tick.
        node_count: how many nodes the world had, its root included.
        automatic: whether the kernel made it, before it went back to another one.
    """

    name: str
    author: str
    time: datetime
    tick: int
    node_count: int
    automatic: bool

    @staticmethod
    def of(message: history_pb2.Checkpoint) -> Checkpoint:
        """Return what a message tells."""
        return Checkpoint(
            message.name,
            message.author,
            message.time.ToDatetime(UTC),
            message.tick,
            message.node_count,
            message.automatic,
        )
