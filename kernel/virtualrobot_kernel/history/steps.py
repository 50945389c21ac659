"""Steps that were done, as they are listed, watched, taken back and done again."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, takewhile
from typing import Protocol

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.step import Step, StepKind, drawn_out, step_of
from virtualrobot_kernel.world.apply_records import Conflict
from virtualrobot_kernel.world.history_commands import RestoreRecords
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.records import EVERYWHERE

MOST_AUTHORS = 100
"""Greatest number of authors whose newest edits may go on as drags."""

log = logging.getLogger(__name__)
Mine = Callable[[str], bool]
"""Test of an author: whether it is the one who asks."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Filter of steps: those for which all that is given holds; times in seconds since 1970, `until` not included.

    `uids` are nodes of which it changed one, or else one that was called `node`; `author` is a part of its name.
    `about` are nodes of which it changed one, or else it was a restore, which changes them all.
    """

    node: str = ""
    uids: frozenset[int] = frozenset()
    author: str = ""
    mine: Mine | None = None
    since: float | None = None
    until: float | None = None
    kinds: frozenset[StepKind] = frozenset()
    about: frozenset[int] = frozenset()

    def has(self, step: Step) -> bool:
        """Return whether a step is wanted."""
        return (
            (not self.node or not self.uids.isdisjoint(step.touched) or step.has(self.node))
            and self.author.casefold() in step.author.casefold()
            and (self.mine is None or self.mine(step.author))
            and (self.since is None or step.wall_time >= self.since)
            and (self.until is None or step.wall_time < self.until)
            and (not self.kinds or step.kind in self.kinds)
            and (not self.about or not self.about.isdisjoint(step.touched) or step.kind is StepKind.RESTORE)
        )


class StepStore(Protocol):
    """Store of steps by number; one thread at a time writes, any may read."""

    def append(self, step: Step, replaced: Step | None) -> None:
        """Keep a step after all others, in place of one that it has drawn out (None: of none)."""
        ...

    def get(self, number: int) -> Step | None:
        """Return the step of an entry, None when it is not kept."""
        ...

    def find(self, wanted: Wanted, before: int | None = None, whole: bool = True) -> Iterator[Step]:
        """Yield steps that are wanted, newest first, with smaller numbers than `before`; `whole` with differences."""
        ...

    @property
    def last(self) -> int:
        """Number of the newest step that was ever kept; 0: none was."""
        ...

    @property
    def forgotten(self) -> int:
        """Number of the newest step that is not kept any more; 0: all are."""
        ...


class Steps:
    """Steps of a world: a keeper of the journal, which makes them, and what undo and redo ask."""

    def __init__(self, store: StepStore) -> None:
        """Begin with the steps of a store."""
        self.store = store
        self._last = 0
        self._listeners: Listeners[[Sequence[Step]]] = Listeners()
        self._undone: dict[int, int] = {}
        self._newest: dict[str, Step] = {}
        for step in reversed(
            list(self.store.find(Wanted(kinds=frozenset({StepKind.UNDO, StepKind.REDO})), whole=False))
        ):
            self._note(step)

    def keep(self, told: Sequence[Told]) -> None:
        """Make steps of entries, and tell those who watch; entries that could not be written at first come again."""
        made: list[Step] = []
        for one in told:
            if one.number <= self._last:
                continue
            self._last = one.number
            try:
                if (step := self._kept(one)) is not None:
                    made.append(step)
            except Exception:  # the world goes on: what is kept of it doesn't hang on what is told of it
                log.exception("entry %d became no step", one.number)
        if made:
            self._listeners.tell(made)

    def _kept(self, told: Told) -> Step | None:
        step = step_of(told, self.store.get)
        if step is None:
            return None
        before = self._newest.get(step.author)
        drawn = drawn_out(before, step) if before is not None else None
        if step.kind is StepKind.EDIT:
            if len(self._newest) > MOST_AUTHORS:
                self._newest.clear()
            self._newest[step.author] = drawn or step
        self.store.append(drawn or step, before if drawn else None)
        self._note(step)
        return drawn or step

    def _note(self, step: Step) -> None:
        """Note what an undo has taken back, and a redo made stand again."""
        if step.kind is StepKind.UNDO:
            self._undone[step.undoes] = step.number
        elif step.kind is StepKind.REDO and (undo := self.store.get(step.undoes)) is not None:
            self._undone[undo.number] = step.number
            self._undone.pop(undo.undoes, None)

    def since(self, number: int) -> list[Step]:
        """Return the steps from a number on, oldest first."""
        return [*takewhile(lambda step: step.number >= number, self.store.find(Wanted(), whole=False))][::-1]

    def subscribe(self, listener: Callable[[Sequence[Step]], None]) -> Callable[[], None]:
        """Call `listener` with steps as they come, in any thread, until the returned function is called."""
        return self._listeners.add(listener)

    @property
    def is_watched(self) -> bool:
        """True when anybody listens."""
        return bool(self._listeners)

    def is_undone(self, step: Step) -> bool:
        """Return whether a step has been taken back, and that not again."""
        return step.number in self._undone

    def taken_back_by(self, number: int) -> Step:
        """Return the step that took a step back last; there must be one."""
        found = self.store.get(self._undone[number])
        assert found is not None
        return found

    def to_undo(self, number: int | None = None, mine: Mine | None = None) -> Step:
        """Return the edit of this number, or the newest one that stands; raise KernelError when there is none."""
        if number is None:
            whose = "of yours " if mine else ""
            for one in self.store.find(Wanted(kinds=frozenset({StepKind.EDIT, StepKind.RESTORE}))):
                if one.kind is StepKind.RESTORE:
                    raise _stopped_by(one, f"there is nothing {whose}to undo")
                if (mine is None or mine(one.author)) and not self.is_undone(one):
                    return one
            raise KernelError(f"there is nothing {whose}to undo", reason=Reason.WRONG_STATE)
        step = self._edit_of(self._known(number, mine, "undone"))
        if self.is_undone(step):
            raise KernelError(
                f"step {step.number} ({step.label}) is undone already, by step {self._undone[step.number]}",
                reason=Reason.WRONG_STATE,
                step=step.number,
            )
        return step

    def to_redo(self, number: int | None = None, mine: Mine | None = None) -> Step:
        """Return the undo of this number, or of the step of this number, or the newest one that may be taken back."""
        if number is None:
            whose = " by you" if mine else ""
            kinds = frozenset({StepKind.EDIT, StepKind.UNDO, StepKind.RESTORE})
            for step in self.store.find(Wanted(kinds=kinds)):
                if step.kind is StepKind.RESTORE:
                    raise _stopped_by(step, f"there is nothing to redo{whose}")
                if mine is not None and not mine(step.author):
                    continue
                if step.kind is StepKind.UNDO and not self.is_undone(step):
                    return step
                if step.kind is StepKind.EDIT:
                    break  # what was undone before it would be done again on top of it
            raise KernelError(
                f"there is nothing to redo: nothing was undone{whose} since the last change; "
                "an older undo is taken back by its number",
                reason=Reason.WRONG_STATE,
            )
        edit = self._edit_of(self._known(number, mine, "redone"))
        undo = self.store.get(self._undone.get(edit.number, 0))
        if undo is None:
            raise KernelError(
                f"step {edit.number} ({edit.label}) is not undone", reason=Reason.WRONG_STATE, step=edit.number
            )
        return undo

    def _edit_of(self, step: Step) -> Step:
        """Return the edit that an undo or redo is about, or the edit itself; raise KernelError for other steps."""
        at: Step | None = step
        while at is not None and at.kind in (StepKind.UNDO, StepKind.REDO):
            at = self.store.get(at.undoes)
        if at is None or at.kind is not StepKind.EDIT:
            why = {
                StepKind.RESTORE: "go back to a checkpoint instead, such as the one that was made before it",
                StepKind.MOTION: "motion is not undone; go back to a checkpoint instead",
            }.get(step.kind, "it changed nothing that undo covers")
            raise KernelError(
                f"step {step.number} ({step.label}) cannot be undone: {why}",
                reason=Reason.WRONG_STATE,
                step=step.number,
            )
        return at

    def _known(self, number: int, mine: Mine | None, what: str) -> Step:
        step = self.store.get(number) if number <= self.store.last else None
        if step is None:
            if number < 1:
                raise KernelError(
                    f"step {number} is no step of this history; they are numbered from 1 on",
                    reason=Reason.WRONG_STATE,
                    step=number,
                )
            gone = "is not kept any more" if number <= self.store.forgotten else "is no step of this history"
            raise KernelError(f"step {number} {gone}", reason=Reason.WRONG_STATE, step=number)
        if mine is not None and not mine(step.author):
            raise KernelError(
                f"step {step.number} ({step.label}) is of {step.author}, and only yours shall be {what}",
                reason=Reason.WRONG_STATE,
                step=step.number,
                author=step.author,
            )
        return step

    def conflict(self, step: Step, error: Conflict) -> KernelError:
        """Return why a step can't be taken back, with who stands in the way where that is known."""
        keys = {(error.table, error.key), ("nodes", error.key)}
        uids = error.key if isinstance(error.key, tuple) else (error.key,)
        about = frozenset(uid for uid in uids if isinstance(uid, int) and uid != EVERYWHERE)
        since = takewhile(lambda one: one.number > step.number, self.store.find(Wanted(about=about)))
        stands = (one for one in since if one.kind is StepKind.RESTORE or not keys.isdisjoint(one.difference.keys))
        other = next(stands, None)
        who = f", by step {other.number} of {other.author}: {other.label}" if other else ""
        told = {"step": other.number, "author": other.author, "label": other.label} if other else {}
        about = f"cannot take back step {step.number} ({step.label})"
        return KernelError(f"{about}: {error}{who}", reason=Reason.CONFLICT, **error.metadata, **told)


def _stopped_by(restore: Step, what: str) -> KernelError:
    """Return the error of who asks for a step before the newest restore, which changed the whole world."""
    return KernelError(
        f"{what} since step {restore.number} ({restore.label}), which stands in between; to take that back, go back "
        f"to the checkpoint 'before step {restore.number}'",
        reason=Reason.WRONG_STATE,
        step=restore.number,
    )


def taking_back(step: Step) -> RestoreRecords:
    """Return the command that takes a step back."""
    return RestoreRecords(step.difference.new, step.difference.old, step.number)


def page(found: Iterable[Step], size: int) -> tuple[list[Step], bool]:
    """Return the first steps, and whether there are more."""
    steps = list(islice(found, size + 1))
    return steps[:size], len(steps) > size
