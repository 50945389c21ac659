"""Step: one change of the world as people see it, made of an entry of the journal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

from virtualrobot_kernel.history.journal import EACH_TICK, Told
from virtualrobot_kernel.history.labels import Done, distance, label
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.difference import alike, difference
from virtualrobot_kernel.world.history_commands import RestoreRecords
from virtualrobot_kernel.world.records import EVERYWHERE, Difference
from virtualrobot_kernel.world.structure import Structure

DRAG_SECONDS = 0.5
"""Longest time (s, of the wall clock) between changes of the same things that are one step, as a drag gives them."""


MOST_NAMED = 100
"""Greatest number of nodes whose names a step tells."""


class StepKind(Enum):
    """Kind of a step; the names equal those of `StepKind` in the contract."""

    EDIT = "edit"
    UNDO = "undo"
    REDO = "redo"
    MOTION = "motion"
    SIGNAL = "signal"
    OTHER = "other"
    RESTORE = "restore"


KINDS: dict[type, StepKind] = {
    commands.SetJointPositions: StepKind.MOTION,
    commands.SetToolState: StepKind.MOTION,
    commands.StartMotion: StepKind.MOTION,
    commands.AppendMotion: StepKind.MOTION,
    commands.GoOn: StepKind.MOTION,
    commands.StepMotion: StepKind.MOTION,
    commands.StartSetpointMotion: StepKind.MOTION,
    commands.SetSetpoint: StepKind.MOTION,
    commands.EndSetpoints: StepKind.MOTION,
    commands.SetMeasuredJoints: StepKind.MOTION,
    commands.SetDynamics: StepKind.MOTION,
    commands.SetJointEfforts: StepKind.MOTION,
    commands.SetParts: StepKind.MOTION,
    commands.SetContacts: StepKind.MOTION,
    commands.PauseMotion: StepKind.MOTION,
    commands.ResumeMotion: StepKind.MOTION,
    commands.CancelMotion: StepKind.MOTION,
    commands.StopMotions: StepKind.MOTION,
    commands.StopRobots: StepKind.MOTION,
    commands.StopCell: StepKind.MOTION,
    commands.ReleaseCell: StepKind.OTHER,
    commands.SetSignal: StepKind.SIGNAL,
    commands.RunSensors: StepKind.OTHER,
    commands.SetPhysics: StepKind.OTHER,
    commands.PlayedTicks: StepKind.OTHER,
    commands.RestartWorld: StepKind.OTHER,
    commands.RestoreWorld: StepKind.RESTORE,
}
"""Kind of the commands that change nothing which undo covers; all others are edits."""


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Change of the world: one entry of the journal, or several that changed the same things right one after the other.

    Attributes:
        number: of its last entry.
        first_number: of its first one.
        tick: how many were before it.
        wall_time: when, in seconds since 1970.
        author: who did it.
        kind: what it is.
        label: what was done, for people.
        difference: what has changed of what undo covers.
        touched: nodes (uids) that it has changed.
        names: of the first hundred of these (uid, name), before and after it.
        undoes: number of the step that it took back; 0 for none.
    """

    number: int
    first_number: int
    tick: int
    wall_time: float
    author: str
    kind: StepKind
    label: str
    difference: Difference = field(default_factory=Difference)
    touched: frozenset[int] = frozenset()
    names: tuple[tuple[int, str], ...] = ()
    undoes: int = 0

    def has(self, name: str) -> bool:
        """Return whether it changed a node that was called so."""
        return any(called == name for _, called in self.names)


def step_of(told: Told, undone: Callable[[int], Step | None]) -> Step | None:
    """Return the step of an entry, None for one that is none; `undone` gives the step of a number."""
    entry = told.entry
    batch = entry.commands
    if EACH_TICK.issuperset(map(type, batch)):
        return None
    edited = any(type(command) not in KINDS for command in batch)
    changed = difference(told.before, told.after) if edited else Difference()
    kind = _kind(batch, changed)
    undoes = next((command.undoes for command in batch if isinstance(command, RestoreRecords)), 0)
    text = ""
    if undoes:
        taken_back = undone(undoes)
        was_undo = taken_back is not None and taken_back.kind is StepKind.UNDO
        kind = StepKind.REDO if was_undo else StepKind.UNDO
        original = undone(taken_back.undoes) if taken_back and was_undo else taken_back
        what = original.label if original else f"step {undoes}"
        text = f"{'did again' if was_undo else 'took back'}: {what}"
    touched = frozenset(_touched(changed))
    return Step(
        number=told.number,
        first_number=told.number,
        tick=entry.tick,
        wall_time=entry.wall_time,
        author=entry.author,
        kind=kind,
        label=text or label(batch, Done(told.before, told.after, changed)),
        difference=changed,
        touched=touched,
        names=_names(touched, told.before.structure, told.after.structure),
        undoes=undoes,
    )


def drawn_out(before: Step, step: Step) -> Step | None:
    """Return two steps of one author as one, as of a drag; None when they are not.

    They are one when the second one changed the very same things soon after, from what the first one made of them.
    """
    one, other = before.difference, step.difference
    soon = 0.0 <= step.wall_time - before.wall_time < DRAG_SECONDS
    if not (soon and before.kind is step.kind is StepKind.EDIT and before.author == step.author):
        return None
    if one.keys != other.keys or other.new.nodes:
        return None
    if not all(alike(table, getattr(one.new, table)[key], old) for table, key, old in other.old.items()):
        return None
    text = step.label
    if other.keys == {("poses", uid) for uid in step.touched} and len(step.touched) == 1:
        (uid,) = step.touched
        text = f"moved {dict(step.names)[uid]!r}{distance(one.old.poses[uid], other.new.poses[uid])}"
    return replace(step, first_number=before.first_number, label=text, difference=Difference(one.old, other.new))


def _kind(batch: Sequence[Command], changed: Difference) -> StepKind:
    kinds = {KINDS.get(type(command), StepKind.EDIT) for command in batch}
    if StepKind.RESTORE in kinds:
        return StepKind.RESTORE
    # What a program does in the world is part of its motion.
    if changed and not any(isinstance(command, commands.GoOn) for command in batch):
        return StepKind.EDIT
    return next((kind for kind in (StepKind.MOTION, StepKind.SIGNAL) if kind in kinds), StepKind.OTHER)


def _touched(changed: Difference) -> Iterator[int]:
    """Yield the nodes (uids) that a change is about."""
    for table, key, value in changed.new.items():
        if table == "signals":
            signals = value, changed.old.signals[str(key)]
            yield from (signal.owner for signal in signals if signal is not None and signal.owner)  # pyright: ignore
        else:
            yield from (uid for uid in (key if isinstance(key, tuple) else [key]) if uid != EVERYWHERE)  # pyright: ignore


def _names(touched: frozenset[int], before: Structure, after: Structure) -> tuple[tuple[int, str], ...]:
    found = (structure.nodes.get(uid) for uid in sorted(touched)[:MOST_NAMED] for structure in (before, after))
    return tuple(dict.fromkeys((node.uid, node.name) for node in found if node is not None))
